#ifndef KD_SYSTEMS_VOXEL_CACHE_GEODESIC_H
#define KD_SYSTEMS_VOXEL_CACHE_GEODESIC_H

#include "runtime/asset/model.h"

/* Geodesic voxel binding: what a point moves with is decided by how far the bones are through the inside of
 * the body, not through the air. The body is a grid of cells of which a flood from outside reaches all but
 * the surface's own and those inside.
 *
 * Source: Dionne & de Lasa 2013, "Geodesic voxel binding for production character meshes" */

typedef struct geodesic_bone {
    kd_vec3 from, to; /* model space, bind pose */
    bool open_ended;  /* nothing follows on `to`: it goes on in its direction as far as the body does */
} geodesic_bone;

typedef struct geodesic_body {
    kd_vec3 origin; /* low corner of the grid, model space */
    float span;
    uint32_t size[3];
    uint32_t inside; /* cells inside, not counting the surface's */
    uint8_t *cells;  /* GEODESIC_* */
} geodesic_body;
enum { GEODESIC_OUTSIDE, GEODESIC_SURFACE, GEODESIC_INSIDE };

/** Make the body of a mesh at rest: all its primitives together.
 *
 *  span    edge of a cell; larger where the mesh is longer than GEODESIC_MOST_CELLS of them
 *  Errors  KD_NO_MEMORY
 *  Owns    cells: geodesic_body_fini
 */
kd_status geodesic_body_make(const kd_mesh_desc *mesh, float span, geodesic_body *body);
void geodesic_body_fini(geodesic_body *body);
#define GEODESIC_MOST_CELLS 160

/** The bones of a skin: from each joint to those that hang on it, in the bind pose. Joint j has the bones
 * first[j] … first[j + 1] - 1.
 *
 *  Shapes  first: [joint_count + 1]; bones: [joint_count * 2] at most
 *  Errors  KD_NO_MEMORY
 *  Owns    both: free
 */
kd_status geodesic_bones(const kd_model *model, const kd_skin_desc *skin, uint32_t **first,
                         geodesic_bone **bones);

/** Weights of the four joints that are nearest to each point through the inside, largest first, their sum 1.
 * A point that no bone reaches keeps weights of 0.
 *
 *  Shapes  points: [count] model space; joints, weights: [count][4]
 *  Errors  KD_NO_MEMORY
 *  Cost    a pass over the body for each bone
 */
kd_status geodesic_weights(const geodesic_body *body, const uint32_t *first, const geodesic_bone *bones,
                           uint32_t joint_count, const kd_vec3 *points, uint32_t count, uint16_t (*joints)[4],
                           float (*weights)[4]);

#endif
