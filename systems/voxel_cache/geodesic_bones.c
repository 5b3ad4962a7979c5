/* Bones of a skin in its bind pose. */
#include "systems/voxel_cache/geodesic.h"

#include <stdlib.h>

/* The number in the skin of the nearest joint above a node, or KD_NONE. */
static uint32_t joint_above(const kd_model *model, const uint32_t *joint_of_node, uint32_t node)
{
    for (node = model->nodes[node].parent; node != KD_NONE; node = model->nodes[node].parent)
        if (joint_of_node[node] != KD_NONE)
            return joint_of_node[node];
    return KD_NONE;
}

static kd_vec3 place_of(const kd_skin_desc *skin, uint32_t joint)
{
    kd_mat4 m = kd_mat4_inverse(&skin->inverse_bind[joint]);
    return (kd_vec3){m.m[12], m.m[13], m.m[14]};
}

/* From a joint to each that hangs on it. One on which none hangs goes on from the one above, as far as it is
 * to itself. */
static uint32_t bones_of(const kd_skin_desc *skin, const uint32_t *above, uint32_t joint, geodesic_bone *out)
{
    uint32_t n = 0;
    kd_vec3 at = place_of(skin, joint);
    for (uint32_t child = 0; child < skin->joint_count; child++)
        if (above[child] == joint)
            out[n++] = (geodesic_bone){at, place_of(skin, child), false};
    if (n)
        return n;
    kd_vec3 way =
        above[joint] == KD_NONE ? (kd_vec3){0, 0, 0} : kd_vec3_sub(at, place_of(skin, above[joint]));
    out[0] = (geodesic_bone){at, kd_vec3_add(at, kd_vec3_scale(way, 1.0f / 16)), true};
    return 1;
}

kd_status geodesic_bones(const kd_model *model, const kd_skin_desc *skin, uint32_t **first,
                         geodesic_bone **bones)
{
    const uint32_t n = skin->joint_count;
    uint32_t *of_node = malloc((model->node_count + 1u) * sizeof *of_node),
             *above = malloc((n + 1u) * sizeof *above);
    *first = calloc(n + 1u, sizeof **first);
    *bones = calloc(2u * n + 1, sizeof **bones);
    bool made = of_node && above && *first && *bones;
    for (uint32_t i = 0; made && i < model->node_count; i++)
        of_node[i] = KD_NONE;
    for (uint32_t j = 0; made && j < n; j++)
        of_node[skin->joints[j]] = j;
    for (uint32_t j = 0; made && j < n; j++)
        above[j] = joint_above(model, of_node, skin->joints[j]);
    for (uint32_t j = 0; made && j < n; j++)
        (*first)[j + 1] = (*first)[j] + bones_of(skin, above, j, *bones + (*first)[j]);
    free(of_node);
    free(above);
    if (made)
        return KD_OK;
    free(*first);
    free(*bones);
    *first = NULL;
    *bones = NULL;
    return KD_NO_MEMORY;
}
