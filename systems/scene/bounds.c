/* Conservative bounds of rigid, skinned and morphing primitives, from boxes computed once at registration: no
 * vertex is touched per frame. */

#include <math.h>

#include "systems/scene/internal.h"

void scene_box_add(scene_box *box, kd_vec3 p)
{
    box->min = (kd_vec3){fminf(box->min.x, p.x), fminf(box->min.y, p.y), fminf(box->min.z, p.z)};
    box->max = (kd_vec3){fmaxf(box->max.x, p.x), fmaxf(box->max.y, p.y), fmaxf(box->max.z, p.z)};
}

void scene_box_join(scene_box *box, const scene_box *other)
{
    scene_box_add(box, other->min);
    scene_box_add(box, other->max);
}

void scene_matrix_rows(const kd_mat4 *m, kd_vec4 rows[3])
{
    for (int r = 0; r < 3; r++)
        rows[r] = (kd_vec4){m->m[r], m->m[4 + r], m->m[8 + r], m->m[12 + r]};
}

scene_box scene_box_transform(const scene_box *box, const kd_vec4 rows[3])
{
    kd_vec3 center = kd_vec3_scale(kd_vec3_add(box->min, box->max), 0.5f);
    kd_vec3 half = kd_vec3_scale(kd_vec3_sub(box->max, box->min), 0.5f);
    float c[3], h[3];
    for (int r = 0; r < 3; r++) {
        c[r] = rows[r].x * center.x + rows[r].y * center.y + rows[r].z * center.z + rows[r].w;
        h[r] = fabsf(rows[r].x) * half.x + fabsf(rows[r].y) * half.y + fabsf(rows[r].z) * half.z;
    }
    return (scene_box){{c[0] - h[0], c[1] - h[1], c[2] - h[2]}, {c[0] + h[0], c[1] + h[1], c[2] + h[2]}};
}

static bool empty(const scene_box *box)
{
    return box->min.x > box->max.x;
}

static void joint_boxes(const kd_primitive_desc *desc, scene_box *boxes)
{
    for (uint32_t v = 0; v < desc->vertex_count; v++) {
        const float weights[4] = {desc->weights[v].x, desc->weights[v].y, desc->weights[v].z,
                                  desc->weights[v].w};
        for (int k = 0; k < 4; k++)
            if (weights[k] > 0)
                scene_box_add(&boxes[desc->joints[v][k]], desc->positions[v]);
    }
}

static void morph_box(const kd_primitive_desc *desc, uint32_t target, scene_box *box)
{
    const kd_vec3 *deltas = desc->morph_positions ? desc->morph_positions[target] : NULL;
    if (!deltas)
        scene_box_add(box, (kd_vec3){0, 0, 0});
    for (uint32_t v = 0; deltas && v < desc->vertex_count; v++)
        scene_box_add(box, deltas[v]);
}

static uint32_t joints_used(const kd_primitive_desc *desc)
{
    uint32_t count = 0;
    for (uint32_t v = 0; desc->joints && v < desc->vertex_count; v++)
        for (int k = 0; k < 4; k++)
            if (desc->joints[v][k] >= count)
                count = desc->joints[v][k] + 1u;
    return count;
}

kd_status scene_reach_add(scene_internal *in, const kd_primitive_desc *desc, uint32_t morph_count,
                          scene_reach *out)
{
    uint32_t joints = desc->weights ? joints_used(desc) : 0;
    if (!SCENE_RESERVE(in->boxes, in->box_capacity, (uint64_t)in->box_count + joints + morph_count))
        return KD_NO_MEMORY;
    *out = (scene_reach){in->box_count, joints, in->box_count + joints, morph_count};
    for (uint32_t i = 0; i < joints + morph_count; i++)
        in->boxes[in->box_count + i] = SCENE_BOX_EMPTY;
    if (joints)
        joint_boxes(desc, &in->boxes[out->first_joint_box]);
    for (uint32_t t = 0; t < morph_count; t++)
        morph_box(desc, t, &in->boxes[out->first_morph_box + t]);
    in->box_count += joints + morph_count;
    return KD_OK;
}

/* The box of all weighted deltas, by interval arithmetic over the targets. */
static scene_box morph_reach(const scene_internal *in, const scene_reach *reach,
                             const kd_morph_weights *weights)
{
    scene_box sum = {{0, 0, 0}, {0, 0, 0}};
    for (uint32_t t = 0; weights && t < reach->morph_box_count && t < weights->count; t++) {
        const scene_box *delta = &in->boxes[reach->first_morph_box + t];
        float w = weights->weights[t];
        sum.min = kd_vec3_add(sum.min, kd_vec3_scale(w < 0 ? delta->max : delta->min, w));
        sum.max = kd_vec3_add(sum.max, kd_vec3_scale(w < 0 ? delta->min : delta->max, w));
    }
    return sum;
}

static scene_box grow(scene_box box, const scene_box *by)
{
    return (scene_box){kd_vec3_add(box.min, by->min), kd_vec3_add(box.max, by->max)};
}

/* Weights are 16-bit and positions floats: a sum of four products may leave the hull by a few units in the
 * last place. */
static scene_box pad(scene_box box)
{
    float size = kd_vec3_length(kd_vec3_sub(box.max, box.min));
    float far = fmaxf(kd_vec3_length(box.min), kd_vec3_length(box.max));
    float margin = 1e-4f * size + 1e-6f * far;
    kd_vec3 d = {margin, margin, margin};
    return (scene_box){kd_vec3_sub(box.min, d), kd_vec3_add(box.max, d)};
}

scene_box scene_primitive_bounds(const scene_internal *in, const kd_scene_store *store, uint32_t primitive,
                                 const kd_mat4 *world, const kd_vec4 (*rows)[3], uint32_t row_count,
                                 const kd_morph_weights *weights)
{
    const scene_reach *reach = &in->reach[primitive];
    const kd_store_primitive *p = &store->primitives[primitive];
    scene_box morph = morph_reach(in, reach, weights);
    if (rows) {
        scene_box all = SCENE_BOX_EMPTY;
        for (uint32_t j = 0; j < reach->joint_box_count && j < row_count; j++) {
            scene_box box = in->boxes[reach->first_joint_box + j];
            if (empty(&box))
                continue;
            box = grow(box, &morph);
            box = scene_box_transform(&box, rows[j]);
            scene_box_join(&all, &box);
        }
        if (!empty(&all))
            return pad(all);
    }
    scene_box rest = grow((scene_box){p->bounds_min, p->bounds_max}, &morph);
    kd_vec4 world_rows[3];
    scene_matrix_rows(world, world_rows);
    rest = scene_box_transform(&rest, world_rows);
    return weights ? pad(rest) : rest;
}
