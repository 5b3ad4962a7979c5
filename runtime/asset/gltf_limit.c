/* From a cage to its limit surface at rest. What vertices of the cage carry is blended by the same weights as
 * their positions, so that whatever reads a mesh (drawing, bounds, voxels) finds one. */

#include <math.h>
#include <string.h>

#include "runtime/asset/gltf_cage.h"
#include "runtime/asset/subdiv_surface.h"

/* Joints that the vertices of one row can name: rows are as long as a ring of vertices. */
#define JOINTS_MAX 512

/* ---- numbers of the selection instead of the file's ---- */

static kd_status renumber(gltf_loader *l, gltf_cage_faces *faces, const gltf_selection *s)
{
    subdiv_cage *cage = &faces->cage;
    uint32_t *number;
    int *corners, *creases, *sharp;
    float *sharpness;
    kd_status status = gltf_alloc(l, &l->work, (size_t)cage->vertex_count, sizeof *number, &number);
    if (!status)
        status = gltf_alloc(l, &l->work, (size_t)cage->corner_count, sizeof *corners, &corners);
    if (!status)
        status = gltf_alloc(l, &l->work, (size_t)cage->crease_count * 2, sizeof *creases, &creases);
    if (!status)
        status = gltf_alloc(l, &l->work, (size_t)cage->sharp_corner_count, sizeof *sharp, &sharp);
    if (!status)
        status = gltf_alloc(l, &l->work, (size_t)cage->sharp_corner_count, sizeof *sharpness, &sharpness);
    if (status)
        return status;
    for (uint32_t v = 0; v < s->vertex_count; v++)
        number[s->vertices[v]] = v + 1;
    for (int i = 0; i < cage->corner_count; i++)
        corners[i] = (int)number[cage->corners[i]] - 1;
    for (int i = 0; i < cage->crease_count * 2; i++)
        creases[i] = (int)number[cage->creases[i]] - 1;
    int kept = 0;
    for (int i = 0; i < cage->sharp_corner_count; i++)
        if (number[cage->sharp_corners[i]]) { /* one that no face uses has nothing to sharpen */
            sharp[kept] = (int)number[cage->sharp_corners[i]] - 1;
            sharpness[kept++] = cage->corner_sharpness[i];
        }
    cage->corners = corners;
    cage->creases = creases;
    cage->sharp_corners = sharp;
    cage->corner_sharpness = sharpness;
    cage->sharp_corner_count = kept;
    cage->vertex_count = (int)s->vertex_count;
    return KD_OK;
}

/* ---- what vertices carry ---- */

/* Blend rows of `width` floats. *out stays NULL where the cage has none. */
static kd_status blend_floats(gltf_loader *l, const subdiv_surface *s, const void *from, uint32_t width,
                              void *out)
{
    float *to = NULL;
    const float *cage = from;
    memcpy(out, &to, sizeof to);
    if (!from)
        return KD_OK;
    kd_status status = gltf_alloc(l, &l->kept, (size_t)s->vertex_count * width, sizeof *to, &to);
    for (uint32_t v = 0; !status && v < s->vertex_count; v++)
        for (uint32_t i = s->rows[v].first; i < s->rows[v].first + s->rows[v].count; i++)
            for (uint32_t k = 0; k < width; k++)
                to[v * width + k] += s->stencils[i].weight * cage[s->stencils[i].vertex * width + k];
    memcpy(out, &to, sizeof to);
    return status;
}

typedef struct influences {
    uint32_t count;
    uint16_t joint[JOINTS_MAX];
    float weight[JOINTS_MAX];
} influences;

static void add_influence(influences *in, uint16_t joint, float weight)
{
    uint32_t i = 0;
    while (i < in->count && in->joint[i] != joint)
        i++;
    if (i == JOINTS_MAX || !(weight > 0))
        return;
    if (i == in->count) {
        in->joint[in->count] = joint;
        in->weight[in->count++] = 0;
    }
    in->weight[i] += weight;
}

static void take_four(influences *in, uint16_t joints[4], kd_vec4 *weights)
{
    float taken[4] = {0}, sum = 0;
    for (int k = 0; k < 4 && in->count; k++) {
        uint32_t best = 0;
        for (uint32_t i = 1; i < in->count; i++)
            best = in->weight[i] > in->weight[best] ? i : best;
        joints[k] = in->weight[best] > 0 ? in->joint[best] : 0;
        sum += taken[k] = in->weight[best];
        in->weight[best] = 0;
    }
    *weights = sum > 0 ? (kd_vec4){taken[0] / sum, taken[1] / sum, taken[2] / sum, taken[3] / sum}
                       : (kd_vec4){1, 0, 0, 0};
}

/* Four joints a vertex serve bounds and voxels; the surface itself follows the cage. */
static kd_status blend_joints(gltf_loader *l, const subdiv_surface *s, const kd_primitive_desc *cage,
                              kd_primitive_desc *out)
{
    uint16_t(*joints)[4];
    kd_vec4 *weights;
    influences *in;
    if (!cage->joints)
        return KD_OK;
    kd_status status = gltf_alloc(l, &l->kept, s->vertex_count, sizeof *joints, &joints);
    if (!status)
        status = gltf_alloc(l, &l->kept, s->vertex_count, sizeof *weights, &weights);
    if (!status)
        status = gltf_alloc(l, &l->work, 1, sizeof *in, &in);
    for (uint32_t v = 0; !status && v < s->vertex_count; v++) {
        in->count = 0;
        for (uint32_t i = s->rows[v].first; i < s->rows[v].first + s->rows[v].count; i++) {
            const kd_stencil *e = &s->stencils[i];
            const float *w = &cage->weights[e->vertex].x;
            for (int k = 0; k < 4; k++)
                add_influence(in, cage->joints[e->vertex][k], e->weight * w[k]);
        }
        take_four(in, joints[v], &weights[v]);
    }
    out->joints = (const uint16_t(*)[4])joints;
    out->weights = weights;
    return status;
}

/* Deltas of one target, and how the normals turn when it is fully there. */
static kd_status blend_target(gltf_loader *l, const subdiv_surface *s, const kd_primitive_desc *cage,
                              uint32_t target, const kd_primitive_desc *surface, const kd_vec3 **moves,
                              const kd_vec3 **turns)
{
    const kd_vec3 *deltas = cage->morph_positions[target];
    kd_vec3 *moved, *positions, *normals;
    kd_status status = blend_floats(l, s, deltas, 3, moves);
    if (status || !deltas)
        return status;
    status = gltf_alloc(l, &l->work, cage->vertex_count, sizeof *moved, &moved);
    if (!status)
        status = gltf_alloc(l, &l->work, s->vertex_count, sizeof *positions, &positions);
    if (!status)
        status = gltf_alloc(l, &l->kept, s->vertex_count, sizeof *normals, &normals);
    if (status)
        return status;
    for (uint32_t v = 0; v < cage->vertex_count; v++)
        moved[v] = kd_vec3_add(cage->positions[v], deltas[v]);
    memcpy(normals, surface->normals, s->vertex_count * sizeof *normals);
    kd_subdivision_evaluate(surface->subdivision, s->vertex_count, moved, positions, normals, NULL);
    for (uint32_t v = 0; v < s->vertex_count; v++)
        normals[v] = kd_vec3_sub(normals[v], surface->normals[v]);
    *turns = normals;
    return KD_OK;
}

static kd_status blend_targets(gltf_loader *l, const subdiv_surface *s, const kd_primitive_desc *cage,
                               kd_primitive_desc *out)
{
    const kd_vec3 **moves, **turns;
    kd_status status = gltf_alloc(l, &l->kept, cage->morph_count, sizeof *moves, &moves);
    if (!status)
        status = gltf_alloc(l, &l->kept, cage->morph_count, sizeof *turns, &turns);
    for (uint32_t t = 0; !status && t < cage->morph_count; t++)
        status = blend_target(l, s, cage, t, out, &moves[t], &turns[t]);
    out->morph_count = cage->morph_count;
    out->morph_positions = moves;
    out->morph_normals = turns;
    return status;
}

/* ---- the surface at rest ---- */

static void set_bounds(kd_primitive_desc *out)
{
    out->bounds_min = out->bounds_max = out->positions[0];
    for (uint32_t v = 1; v < out->vertex_count; v++) {
        kd_vec3 p = out->positions[v];
        out->bounds_min = (kd_vec3){fminf(out->bounds_min.x, p.x), fminf(out->bounds_min.y, p.y),
                                    fminf(out->bounds_min.z, p.z)};
        out->bounds_max = (kd_vec3){fmaxf(out->bounds_max.x, p.x), fmaxf(out->bounds_max.y, p.y),
                                    fmaxf(out->bounds_max.z, p.z)};
    }
}

static kd_status rest_pose(gltf_loader *l, const char *where, const subdiv_surface *s,
                           const kd_primitive_desc *cage, kd_primitive_desc *out)
{
    kd_vec3 *positions, *normals;
    kd_vec4 *tangents;
    kd_status status = gltf_alloc(l, &l->kept, s->vertex_count, sizeof *positions, &positions);
    if (!status)
        status = gltf_alloc(l, &l->kept, s->vertex_count, sizeof *normals, &normals);
    if (!status)
        status = gltf_alloc(l, &l->kept, s->vertex_count, sizeof *tangents, &tangents);
    if (status)
        return status;
    for (uint32_t v = 0; v < s->vertex_count; v++) {
        normals[v] = (kd_vec3){0, 1, 0};
        tangents[v] = (kd_vec4){1, 0, 0, s->handedness[v]};
    }
    kd_subdivision_evaluate(out->subdivision, s->vertex_count, cage->positions, positions, normals, tangents);
    for (uint32_t v = 0; v < s->vertex_count; v++)
        if (!isfinite(positions[v].x) || !isfinite(positions[v].y) || !isfinite(positions[v].z))
            return gltf_fail(l, KD_BAD_FORMAT,
                             "the limit surface leaves what numbers hold (%s); make the model smaller",
                             where);
    out->positions = positions;
    out->normals = normals;
    out->tangents = tangents;
    set_bounds(out);
    return KD_OK;
}

static kd_status carry(gltf_loader *l, const subdiv_surface *s, const kd_primitive_desc *cage,
                       kd_primitive_desc *out)
{
    out->uv0 = s->uv;
    kd_status status = blend_floats(l, s, cage->uv1, 2, &out->uv1);
    if (!status)
        status = blend_floats(l, s, cage->colors, 4, &out->colors);
    if (!status)
        status = blend_joints(l, s, cage, out);
    return status ? status : blend_targets(l, s, cage, out);
}

static kd_status make_surface(gltf_loader *l, const char *where, const gltf_cage_faces *faces,
                              const kd_primitive_desc *cage, subdiv_surface *surface)
{
    char error[256];
    subdiv_cage topology = faces->cage;
    const kd_vec2 *uv = faces->uv;
    if (!uv && cage->uv0) { /* one coordinate a vertex: no seams */
        uv = cage->uv0;
        topology.uv_count = topology.vertex_count;
        topology.uv_corners = topology.corners;
    }
    kd_status status = subdiv_surface_make(&topology, (int)faces->level, uv, &l->kept, &l->work, surface,
                                           error, sizeof error);
    return status ? gltf_fail(l, status, "%s (%s.extras); export the model again", error, where) : KD_OK;
}

kd_status gltf_subdivide(gltf_loader *l, const char *where, gltf_cage_faces *faces,
                         const gltf_selection *selection, kd_primitive_desc *primitive)
{
    subdiv_surface surface;
    kd_primitive_desc *cage;
    kd_subdivision *subdivision;
    kd_status status = renumber(l, faces, selection);
    if (!status)
        status = gltf_alloc(l, &l->kept, 1, sizeof *cage, &cage);
    if (!status)
        status = gltf_alloc(l, &l->kept, 1, sizeof *subdivision, &subdivision);
    if (!status)
        status = make_surface(l, where, faces, primitive, &surface);
    if (status)
        return status;
    *cage = *primitive;
    *subdivision =
        (kd_subdivision){faces->level, surface.stencil_count, surface.rows, surface.stencils, cage};
    *primitive = (kd_primitive_desc){.material = cage->material,
                                     .vertex_count = surface.vertex_count,
                                     .index_count = surface.index_count,
                                     .indices = surface.indices,
                                     .subdivision = subdivision};
    status = rest_pose(l, where, &surface, cage, primitive);
    return status ? status : carry(l, &surface, cage, primitive);
}
