#ifndef KD_ASSET_GLTF_CAGE_H
#define KD_ASSET_GLTF_CAGE_H

/* Subdivision cages: what `extras` say, checked, and the limit surface that takes the place of the
 * primitive's triangles. docs/subdivision.md describes the format. */

#include "runtime/asset/gltf_loader.h"
#include "runtime/asset/gltf_vertices.h"
#include "runtime/asset/subdiv_shim.h"

typedef struct gltf_cage_faces {
    subdiv_cage cage;  /* vertices numbered as in the file */
    const kd_vec2 *uv; /* [cage.uv_count]; NULL: those of the primitive's vertices, if any */
    uint32_t level;
} gltf_cage_faces;

/** Check a primitive's cage. vertex_count: elements of its POSITION. Errors KD_BAD_FORMAT, KD_TOO_LARGE with
 * a message */
kd_status gltf_check_cage(gltf_loader *l, const gltf_primitive *p, const char *where, uint32_t vertex_count,
                          gltf_cage_faces *out);

/** Cut the faces into triangles round their first corner. */
kd_status gltf_cage_triangles(gltf_loader *l, const gltf_cage_faces *faces, uint32_t **out, size_t *count);

/** Make the primitive, which was loaded from the cage's triangles, a limit surface that keeps the cage.
 *  selection: which of the file's vertices it holds. */
kd_status gltf_subdivide(gltf_loader *l, const char *where, gltf_cage_faces *faces,
                         const gltf_selection *selection, kd_primitive_desc *primitive);

#endif
