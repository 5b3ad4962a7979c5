#ifndef KD_ASSET_SUBDIV_SURFACE_H
#define KD_ASSET_SUBDIV_SURFACE_H

/* The limit surface of a cage as one mesh: patches welded where they are smooth, apart along infinitely sharp
 * edges and along seams of the texture, each vertex with its row of weights. */

#include "runtime/asset/model.h"
#include "runtime/asset/subdiv_shim.h"
#include "runtime/core/arena.h"

typedef struct subdiv_surface {
    uint32_t vertex_count, index_count, stencil_count;
    uint32_t *indices;
    kd_stencil_row *rows; /* [vertex_count] */
    kd_stencil *stencils; /* [stencil_count] */
    kd_vec2 *uv;          /* [vertex_count], NULL: none */
    float *handedness;    /* [vertex_count] w of the tangents */
} subdiv_surface;

/** Make the surface of `cage` at a level of at least 1.
 *
 *  uv      [cage->uv_count], read when the cage has texture coordinates
 *  kept    holds the result; what ends with the call is in `work`
 *  Errors  KD_NO_MEMORY, KD_UNSUPPORTED with `error` in words
 */
kd_status subdiv_surface_make(const subdiv_cage *cage, int level, const kd_vec2 *uv, kd_arena *kept,
                              kd_arena *work, subdiv_surface *out, char *error, size_t error_size);

#endif
