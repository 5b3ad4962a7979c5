#ifndef KD_ASSET_DRACO_SHIM_H
#define KD_ASSET_DRACO_SHIM_H

/* Draco behind a C face: the bytes of KHR_draco_mesh_compression in, points and triangles out. */

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "runtime/core/status.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct draco_shim draco_shim;

/** Decode a mesh. Errors KD_BAD_FORMAT, KD_NO_MEMORY: `error` says why, no message is logged. Owns
 *  draco_shim_close frees it. */
kd_status draco_shim_open(const uint8_t *bytes, size_t size, draco_shim **out, char *error,
                          size_t error_size);
void draco_shim_close(draco_shim *mesh);

uint32_t draco_shim_points(const draco_shim *mesh);
uint32_t draco_shim_triangles(const draco_shim *mesh);

/** Shapes  out: [3 * triangles] */
void draco_shim_indices(const draco_shim *mesh, uint32_t *out);

/** Read the attribute with Draco's id `id` as values of a glTF component type (5120 … 5126).
 *
 *  Shapes  out: [points * width] of that type, tight
 *  Returns false when there is no such attribute or it cannot be had in that type and width
 */
bool draco_shim_attribute(const draco_shim *mesh, int id, int component, int width, void *out);

#ifdef __cplusplus
}
#endif

#endif
