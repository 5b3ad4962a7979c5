#ifndef KD_COMPONENTS_DEFORM_H
#define KD_COMPONENTS_DEFORM_H

#include "runtime/core/math.h"
#include "runtime/ecs/world.h"
#include "runtime/gpu/gpu.h"

/* Singleton: the joint matrices of this frame, joint_world * inverse_bind, model to world space, as three
 * rows each: position' = (dot(row0, p1), dot(row1, p1), dot(row2, p1)) with p1 = (position, 1). Joint j of a
 * kd_skin_instance is entry first_matrix + j. Rows are written by system joint_palette; the buffer, resource
 * "scene.joints", by deform. */
typedef struct kd_joint_palette {
    uint32_t count;
    const kd_vec4 (*rows)[3]; /* [count] */
    kd_gpu_buffer matrices;   /* vec4[count * 3] */
    void *internal;
    void (*release)(struct kd_joint_palette *palette); /* frees the rows; set by joint_palette */
} kd_joint_palette;
KD_COMPONENT_DECLARE(kd_joint_palette);

/** Transform a point by the rows of one palette entry. */
static inline kd_vec3 kd_joint_point(const kd_vec4 rows[3], kd_vec3 p)
{
    return (kd_vec3){rows[0].x * p.x + rows[0].y * p.y + rows[0].z * p.z + rows[0].w,
                     rows[1].x * p.x + rows[1].y * p.y + rows[1].z * p.z + rows[1].w,
                     rows[2].x * p.x + rows[2].y * p.y + rows[2].z * p.z + rows[2].w};
}

#endif
