#ifndef KD_ASSET_MESH_BUILD_H
#define KD_ASSET_MESH_BUILD_H

/* Geometry that a file leaves out: triangles from strips and fans, normals, tangents. Arrays are the
 * caller's. */

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "runtime/core/math.h"

typedef enum mesh_topology { MESH_LIST, MESH_STRIP, MESH_FAN } mesh_topology;

/** Upper bound of the indices that unrolling `count` of them gives. */
size_t mesh_unroll_bound(mesh_topology topology, size_t count);

/** Unroll to a triangle list, keeping the winding (glTF 2.0, section 3.7.2.1). Triangles of a strip or fan
 * that name one vertex twice only join others and are dropped. Returns the number of indices written */
size_t mesh_unroll(mesh_topology topology, const uint32_t *in, size_t count, uint32_t *out);

/** Give each corner its triangle's normal; corner i belongs to triangle i / 3. A triangle without area faces
 * +Y. */
void mesh_flat_normals(const kd_vec3 *positions, size_t corner_count, kd_vec3 *normals);

/** Bring normals to unit length, and give those without a direction the area-weighted mean of their
 * triangles. scratch  [vertex_count] Returns the number of normals that had to be made */
size_t mesh_mend_normals(const kd_vec3 *positions, const uint32_t *indices, size_t index_count,
                         kd_vec3 *normals, size_t vertex_count, kd_vec3 *scratch);

/** Make tangents along rising u, orthogonal to the normals; w turns cross(normal, tangent)
 *  towards falling v (glTF's pictures have row 0 on top, and their normal maps point up). Without uv, or
 * where uv has no area, any direction orthogonal to the normal. uv       NULL: none scratch  [vertex_count]
 * twice Source   Lengyel 2001, "Computing Tangent Space Basis Vectors for an Arbitrary Mesh" */
void mesh_make_tangents(const kd_vec3 *positions, const kd_vec3 *normals, const kd_vec2 *uv,
                        const uint32_t *indices, size_t index_count, kd_vec4 *tangents, size_t vertex_count,
                        kd_vec3 *scratch);

#endif
