/* Rays from inside a model tell what it is. In a room they meet surfaces that face the viewer; inside a solid
 * they meet the backs of its surfaces. */
#include "runtime/app/model_survey.h"

#include <float.h>
#include <math.h>
#include <stdlib.h>

#include "runtime/core/log.h"

#define HALL_MIN_EXTENT_M 10   /* open above or on one side */
#define ROOM_MIN_EXTENT_M 2.5f /* closed all round */
#define ROOM_MIN_HEIGHT_M 2    /* lower ones are the insides of cars */
#define EYE_HEIGHT_M      1.7f
#define LEVEL             0.005f /* of the length */
#define FAN               12
#define FAR               FLT_MAX

typedef struct soup {
    kd_vec3 *corners; /* three a triangle, model space */
    bool *two_sided;  /* a triangle: it faces everybody */
    size_t triangle_count, two_sided_count;
} soup;

typedef struct hit {
    float distance;       /* FAR: none */
    bool front, faces_us; /* what has two sides faces everybody */
} hit;

/* ---- triangles ---- */

static bool shines(const kd_model *model, const kd_primitive_desc *p)
{
    return p->index_count >= 3 && p->material < model->material_count &&
           kd_vec3_length(model->materials[p->material].emissive) > 0;
}

static void append_primitive(soup *s, const kd_primitive_desc *p, const kd_mat4 *to_model, bool two_sided)
{
    for (uint32_t i = 0; i + 2 < p->index_count; i += 3) {
        kd_vec3 *corner = s->corners + s->triangle_count * 3;
        s->two_sided_count += two_sided;
        s->two_sided[s->triangle_count++] = two_sided;
        for (uint32_t k = 0; k < 3; k++)
            corner[k] = kd_mat4_point(to_model, p->positions[p->indices[i + k]]);
    }
}

static size_t count_triangles(const kd_model *model)
{
    size_t count = 0;
    for (uint32_t n = 0; n < model->node_count; n++) {
        if (model->nodes[n].mesh == KD_NONE)
            continue;
        const kd_mesh_desc *mesh = &model->meshes[model->nodes[n].mesh];
        for (uint32_t i = 0; i < mesh->primitive_count; i++)
            count += mesh->primitives[i].index_count / 3;
    }
    return count;
}

static bool has_emissive(const kd_model *model)
{
    for (uint32_t n = 0; n < model->node_count; n++) {
        if (model->nodes[n].mesh == KD_NONE)
            continue;
        const kd_mesh_desc *mesh = &model->meshes[model->nodes[n].mesh];
        for (uint32_t i = 0; i < mesh->primitive_count; i++)
            if (shines(model, &mesh->primitives[i]))
                return true;
    }
    return false;
}

static void append_mesh(soup *s, const kd_model *model, const kd_mesh_desc *mesh, const kd_mat4 *to_model)
{
    for (uint32_t i = 0; i < mesh->primitive_count; i++) {
        const kd_primitive_desc *p = &mesh->primitives[i];
        append_primitive(s, p, to_model,
                         p->material < model->material_count && model->materials[p->material].double_sided);
    }
}

static void release(soup *s)
{
    free(s->corners);
    free(s->two_sided);
    *s = (soup){0};
}

/* Gather all triangles. Errors NO_MEMORY; the caller releases them. */
static kd_status gather(const kd_model *model, soup *s)
{
    size_t count = count_triangles(model);
    kd_mat4 *matrices = malloc((model->node_count + 1) * sizeof *matrices);
    *s = (soup){.corners = malloc((count * 3 + 1) * sizeof *s->corners), .two_sided = malloc(count + 1)};
    if (!matrices || !s->corners || !s->two_sided) {
        free(matrices);
        release(s);
        return kd_fail(KD_NO_MEMORY, "%s: out of memory", model->path);
    }
    for (uint32_t n = 0; n < model->node_count; n++) {
        const kd_node_desc *node = &model->nodes[n];
        matrices[n] = node->has_matrix ? node->matrix
                                       : kd_mat4_from_trs(node->translation, node->rotation, node->scale);
        if (node->parent != KD_NONE)
            matrices[n] = kd_mat4_mul(&matrices[node->parent], &matrices[n]);
        if (node->mesh != KD_NONE)
            append_mesh(s, model, &model->meshes[node->mesh], &matrices[n]);
    }
    free(matrices);
    return KD_OK;
}

/* ---- rays; Source  Moeller and Trumbore 1997, Fast, Minimum Storage Ray/Triangle Intersection ---- */

/* Distance to triangle i along a ray, FAR where it misses; `front`: it is met from the front. */
static float meet(const soup *s, size_t i, kd_vec3 from, kd_vec3 along, bool *front)
{
    const kd_vec3 *c = s->corners + i * 3;
    kd_vec3 e1 = kd_vec3_sub(c[1], c[0]), e2 = kd_vec3_sub(c[2], c[0]), p = kd_vec3_cross(along, e2);
    float det = kd_vec3_dot(e1, p);
    if (det == 0)
        return FAR;
    kd_vec3 t = kd_vec3_sub(from, c[0]), q = kd_vec3_cross(t, e1);
    float u = kd_vec3_dot(t, p) / det, v = kd_vec3_dot(along, q) / det, distance = kd_vec3_dot(e2, q) / det;
    *front = det > 0;
    return u >= 0 && v >= 0 && u + v <= 1 ? distance : FAR;
}

static hit cast(const soup *s, kd_vec3 from, kd_vec3 along)
{
    hit nearest = {FAR, false, false};
    for (size_t i = 0; i < s->triangle_count; i++) {
        bool front = false;
        float distance = meet(s, i, from, along, &front);
        if (distance > 0 && distance < nearest.distance)
            nearest = (hit){distance, front, front || s->two_sided[i]};
    }
    return nearest;
}

/* ---- judgement ---- */

static const kd_vec3 axes[6] = {{1, 0, 0}, {-1, 0, 0}, {0, 0, 1}, {0, 0, -1}, {0, -1, 0}, {0, 1, 0}};

/* A box open on one of its four walls: the other five axis rays from its middle meet inner faces. */
static void look_for_open_box(const soup *s, kd_vec3 middle, app_survey *out)
{
    int open = -1, inner = 0;
    for (int i = 0; i < 6; i++) {
        /* off the middle by a little: a light or an edge may lie exactly on an axis */
        kd_vec3 extent = kd_vec3_sub(out->high, out->low);
        kd_vec3 from = kd_vec3_add(middle, (kd_vec3){extent.x * 0.013f, extent.y * 0.37f, extent.z * 0.017f});
        hit h = cast(s, from, axes[i]);
        if (h.distance < FAR && h.faces_us)
            inner++;
        else if (h.distance == FAR && i < 4)
            open = i;
    }
    out->open_box = inner == 5 && open >= 0;
    out->closed_box = inner == 6;
    out->open_side = open >= 0 ? axes[open] : axes[2];
}

static float free_way(hit h, float limit)
{
    return h.distance < limit ? h.distance : limit;
}

/* What one sees standing at a place: axis rays that meet inner faces, and whether one can walk about. */
typedef struct stand {
    int walls; /* of four */
    bool floor, ceiling;
    int level;    /* of FAN directions, half way to what is there: so many floors are equally high … */
    float ground; /* … at this y */
    int fronts;   /* of the two rays of each: surfaces met from the front */
} stand;

/* Which height most floors share, within `tolerance`. */
static void find_ground(const float floors[FAN], float tolerance, stand *out)
{
    for (int i = 0; i < FAN; i++) {
        int equal = 0;
        for (int k = 0; k < FAN; k++)
            equal += fabsf(floors[k] - floors[i]) < tolerance;
        if (equal > out->level) {
            out->level = equal;
            out->ground = floors[i];
        }
    }
}

static stand stand_at(const soup *s, kd_vec3 eye, float longest)
{
    float floors[FAN];
    stand out = {0};
    for (int i = 0; i < 6; i++) {
        hit h = cast(s, eye, axes[i]);
        bool inner = h.distance < FAR && h.faces_us;
        if (i < 4)
            out.walls += inner && h.distance > 0.01f * longest;
        else if (i == 4)
            out.floor = inner;
        else
            out.ceiling = inner;
    }
    for (int i = 0; i < FAN; i++) {
        float angle = ((float)i + 0.5f) * 6.2831853f / FAN;
        kd_vec3 along = {cosf(angle), 0, sinf(angle)};
        hit wall = cast(s, eye, along);
        hit floor = cast(s, kd_vec3_add(eye, kd_vec3_scale(along, free_way(wall, longest) / 2)), axes[4]);
        floors[i] = eye.y - floor.distance;
        out.fronts += wall.front + floor.front;
    }
    find_ground(floors, LEVEL * longest, &out);
    return out;
}

static void look_for_hall(const soup *s, app_survey *out)
{
    kd_vec3 extent = kd_vec3_sub(out->high, out->low),
            middle = kd_vec3_scale(kd_vec3_add(out->low, out->high), 0.5f);
    bool along_x = extent.x >= extent.z;
    float longest = along_x ? extent.x : extent.z, height = extent.y;
    if (longest <= ROOM_MIN_EXTENT_M || height < 0.05f * longest)
        return;
    float eye_height =
        height > 12 * EYE_HEIGHT_M ? height / 12 : EYE_HEIGHT_M; /* in a unit smaller than metres */
    if (eye_height > 0.6f * height)
        eye_height = 0.6f * height;
    hit floor = cast(s, middle, axes[4]);
    kd_vec3 eye = {middle.x, (floor.distance < FAR ? middle.y - floor.distance : out->low.y) + eye_height,
                   middle.z};
    stand here = stand_at(s, eye, longest);
    bool closed = here.walls == 4 && here.ceiling;
    /* All surfaces of a hollow solid turn their backs to who is inside; in a room things stand about. */
    if (!here.floor || here.walls < 3 || here.level < FAN / 2 ||
        (longest <= HALL_MIN_EXTENT_M && (!closed || height < ROOM_MIN_HEIGHT_M)) ||
        (s->two_sided_count * 2 > s->triangle_count && here.fronts < FAN / 4))
        return;
    eye.y = here.ground + eye_height; /* a table may stand in the middle */
    out->roof = closed ? free_way(cast(s, eye, axes[5]), height) : 0;
    kd_vec3 forth = along_x ? axes[0] : axes[2], back = along_x ? axes[1] : axes[3];
    float behind = free_way(cast(s, eye, back), longest);
    out->hall = true;
    out->eye_height = eye_height;
    out->target = kd_vec3_add(eye, kd_vec3_add(kd_vec3_scale(forth, free_way(cast(s, eye, forth), longest)),
                                               (kd_vec3){0, 0.1f * height, 0}));
    out->eye = kd_vec3_add(eye, kd_vec3_scale(back, behind * 0.85f));
}

bool app_survey_lit_by_itself(const app_survey *s)
{
    return s->has_emissive && (s->hall || s->open_box || s->closed_box);
}

kd_status app_survey_model(const kd_model *model, app_survey *out)
{
    soup s;
    *out = (app_survey){
        .low = model->bounds_min, .high = model->bounds_max, .has_animation = model->clip_count > 0};
    for (uint32_t n = 0; n < model->node_count; n++) {
        out->has_camera = out->has_camera || model->nodes[n].camera != KD_NONE;
        out->has_light = out->has_light || model->nodes[n].light != KD_NONE;
    }
    out->has_emissive = has_emissive(model);
    kd_status status = gather(model, &s);
    if (status != KD_OK)
        return status;
    look_for_hall(&s, out);
    if (!out->hall)
        look_for_open_box(&s, kd_vec3_scale(kd_vec3_add(out->low, out->high), 0.5f), out);
    release(&s);
    return KD_OK;
}
