#include "runtime/asset/model_bounds.h"

#include <math.h>

typedef struct box { kd_vec3 low, high; } box;

static void box_add(box *b, kd_vec3 p)
{
    b->low = (kd_vec3){fminf(b->low.x, p.x), fminf(b->low.y, p.y), fminf(b->low.z, p.z)};
    b->high = (kd_vec3){fmaxf(b->high.x, p.x), fmaxf(b->high.y, p.y), fmaxf(b->high.z, p.z)};
}

static void add_corners(box *b, const kd_mat4 *world, const kd_primitive_desc *p)
{
    for (int i = 0; i < 8; i++) {
        kd_vec3 corner = {i & 1 ? p->bounds_max.x : p->bounds_min.x, i & 2 ? p->bounds_max.y : p->bounds_min.y,
                          i & 4 ? p->bounds_max.z : p->bounds_min.z};
        box_add(b, kd_mat4_point(world, corner));
    }
}

static void add_skinned(box *b, const kd_mat4 *joints, const kd_primitive_desc *p)
{
    for (uint32_t v = 0; v < p->vertex_count; v++) {
        float weights[4] = {p->weights[v].x, p->weights[v].y, p->weights[v].z, p->weights[v].w};
        kd_vec3 sum = {0, 0, 0};
        for (int k = 0; k < 4; k++)
            if (weights[k] > 0)
                sum = kd_vec3_add(sum, kd_vec3_scale(kd_mat4_point(&joints[p->joints[v][k]], p->positions[v]), weights[k]));
        box_add(b, sum);
    }
}

static bool add_node(const kd_model *m, const kd_mat4 *worlds, uint32_t index, kd_arena *scratch, box *b)
{
    const kd_node_desc *node = &m->nodes[index];
    const kd_mesh_desc *mesh = &m->meshes[node->mesh];
    kd_mat4 *joints = NULL;
    if (node->skin != KD_NONE) {
        const kd_skin_desc *skin = &m->skins[node->skin];
        joints = KD_ARENA_NEW(scratch, kd_mat4, skin->joint_count);
        if (!joints)
            return false;
        for (uint32_t i = 0; i < skin->joint_count; i++)
            joints[i] = kd_mat4_mul(&worlds[skin->joints[i]], &skin->inverse_bind[i]);
    }
    for (uint32_t i = 0; i < mesh->primitive_count; i++) {
        if (joints && mesh->primitives[i].joints)
            add_skinned(b, joints, &mesh->primitives[i]);
        else
            add_corners(b, &worlds[index], &mesh->primitives[i]);
    }
    return true;
}

static uint64_t mesh_triangles(const kd_mesh_desc *mesh)
{
    uint64_t count = 0;
    for (uint32_t i = 0; i < mesh->primitive_count; i++)
        count += mesh->primitives[i].index_count / 3;
    return count;
}

static void make_worlds(const kd_model *m, kd_mat4 *worlds)
{
    for (uint32_t i = 0; i < m->node_count; i++) {
        const kd_node_desc *n = &m->nodes[i];
        kd_mat4 local = n->has_matrix ? n->matrix : kd_mat4_from_trs(n->translation, n->rotation, n->scale);
        worlds[i] = n->parent == KD_NONE ? local : kd_mat4_mul(&worlds[n->parent], &local);
    }
}

bool model_measure(kd_model *model, kd_arena *scratch)
{
    kd_mat4 *worlds = KD_ARENA_NEW(scratch, kd_mat4, model->node_count + 1);
    if (!worlds)
        return false;
    make_worlds(model, worlds);
    for (uint32_t i = 0; i < model->node_count; i++)
        for (int k = 0; k < 16; k++)
            if (!isfinite(worlds[i].m[k]))
                return false;
    box b = {{INFINITY, INFINITY, INFINITY}, {-INFINITY, -INFINITY, -INFINITY}};
    for (uint32_t i = 0; i < model->node_count; i++) {
        if (model->nodes[i].mesh == KD_NONE)
            continue;
        model->triangle_count += mesh_triangles(&model->meshes[model->nodes[i].mesh]);
        if (!add_node(model, worlds, i, scratch, &b))
            return false;
    }
    if (!model->triangle_count)
        return true;
    model->bounds_min = b.low;
    model->bounds_max = b.high;
    return isfinite(b.low.x + b.low.y + b.low.z) && isfinite(b.high.x + b.high.y + b.high.z);
}
