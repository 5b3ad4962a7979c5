#include "runtime/asset/model_bounds.h"

#include <math.h>

/* Vertices and joints that are measured one by one: about half a second. A model that instances more than
 * that is measured on with boxes. */
#define WORK_MAX (32u << 20)

typedef struct box {
    kd_vec3 low, high;
} box;

typedef struct measure {
    const kd_model *model;
    kd_mat4 *worlds; /* [node_count] */
    kd_mat4 *joints; /* [largest joint_count] */
    uint64_t work;   /* against WORK_MAX */
    box box;
} measure;

static void box_add(box *b, kd_vec3 p)
{
    b->low = (kd_vec3){fminf(b->low.x, p.x), fminf(b->low.y, p.y), fminf(b->low.z, p.z)};
    b->high = (kd_vec3){fmaxf(b->high.x, p.x), fmaxf(b->high.y, p.y), fmaxf(b->high.z, p.z)};
}

static void add_corners(box *b, const kd_mat4 *world, const kd_primitive_desc *p)
{
    for (int i = 0; i < 8; i++) {
        kd_vec3 corner = {i & 1 ? p->bounds_max.x : p->bounds_min.x,
                          i & 2 ? p->bounds_max.y : p->bounds_min.y,
                          i & 4 ? p->bounds_max.z : p->bounds_min.z};
        box_add(b, kd_mat4_point(world, corner));
    }
}

static void add_points(box *b, const kd_mat4 *world, const kd_primitive_desc *p)
{
    for (uint32_t v = 0; v < p->vertex_count; v++)
        box_add(b, kd_mat4_point(world, p->positions[v]));
}

static void add_skinned(box *b, const kd_mat4 *joints, const kd_primitive_desc *p)
{
    for (uint32_t v = 0; v < p->vertex_count; v++) {
        float weights[4] = {p->weights[v].x, p->weights[v].y, p->weights[v].z, p->weights[v].w};
        kd_vec3 sum = {0, 0, 0};
        for (int k = 0; k < 4; k++)
            if (weights[k] > 0)
                sum = kd_vec3_add(
                    sum, kd_vec3_scale(kd_mat4_point(&joints[p->joints[v][k]], p->positions[v]), weights[k]));
        box_add(b, sum);
    }
}

/* Whether `work` more steps stay within the budget. */
static bool afford(measure *m, uint64_t work)
{
    m->work += work;
    return m->work <= WORK_MAX;
}

/* The matrices of a skin in the rest pose; past the budget only the first, which stands for all. */
static void pose(measure *m, const kd_skin_desc *skin, bool whole)
{
    uint32_t count = whole ? skin->joint_count : 1;
    for (uint32_t i = 0; i < count; i++)
        m->joints[i] = kd_mat4_mul(&m->worlds[skin->joints[i]], &skin->inverse_bind[i]);
}

static void add_node(measure *m, uint32_t index)
{
    const kd_node_desc *node = &m->model->nodes[index];
    const kd_mesh_desc *mesh = &m->model->meshes[node->mesh];
    const kd_skin_desc *skin = node->skin == KD_NONE ? NULL : &m->model->skins[node->skin];
    uint64_t work = skin ? skin->joint_count : 0;
    for (uint32_t i = 0; i < mesh->primitive_count; i++)
        work += mesh->primitives[i].vertex_count;
    bool whole = afford(m, work);
    if (skin)
        pose(m, skin, whole);
    for (uint32_t i = 0; i < mesh->primitive_count; i++) {
        const kd_primitive_desc *p = &mesh->primitives[i];
        const kd_mat4 *place = skin && p->joints ? &m->joints[0] : &m->worlds[index];
        if (!whole)
            add_corners(&m->box, place, p);
        else if (skin && p->joints)
            add_skinned(&m->box, m->joints, p);
        else
            add_points(&m->box, place, p);
    }
}

static uint64_t mesh_triangles(const kd_mesh_desc *mesh)
{
    uint64_t count = 0;
    for (uint32_t i = 0; i < mesh->primitive_count; i++)
        count += mesh->primitives[i].index_count / 3;
    return count;
}

/* Returns false for a transform that is not finite. */
static bool make_worlds(const kd_model *m, kd_mat4 *worlds)
{
    for (uint32_t i = 0; i < m->node_count; i++) {
        const kd_node_desc *n = &m->nodes[i];
        kd_mat4 local = n->has_matrix ? n->matrix : kd_mat4_from_trs(n->translation, n->rotation, n->scale);
        worlds[i] = n->parent == KD_NONE ? local : kd_mat4_mul(&worlds[n->parent], &local);
        for (int k = 0; k < 16; k++)
            if (!isfinite(worlds[i].m[k]))
                return false;
    }
    return true;
}

bool model_measure(kd_model *model, kd_arena *scratch)
{
    uint32_t joints = 1;
    for (uint32_t i = 0; i < model->skin_count; i++)
        joints = model->skins[i].joint_count > joints ? model->skins[i].joint_count : joints;
    measure m = {.model = model, .box = {{INFINITY, INFINITY, INFINITY}, {-INFINITY, -INFINITY, -INFINITY}}};
    m.worlds = KD_ARENA_NEW(scratch, kd_mat4, model->node_count + 1);
    m.joints = KD_ARENA_NEW(scratch, kd_mat4, joints);
    if (!m.worlds || !m.joints || !make_worlds(model, m.worlds))
        return false;
    for (uint32_t i = 0; i < model->node_count; i++) {
        uint64_t triangles =
            model->nodes[i].mesh == KD_NONE ? 0 : mesh_triangles(&model->meshes[model->nodes[i].mesh]);
        model->triangle_count += triangles;
        if (triangles)
            add_node(&m, i);
    }
    if (!model->triangle_count)
        return true;
    model->bounds_min = m.box.low;
    model->bounds_max = m.box.high;
    kd_vec3 sum = kd_vec3_add(m.box.low, m.box.high);
    return isfinite(sum.x) && isfinite(sum.y) && isfinite(sum.z);
}
