/* The world's meshes as Embree sees them. A mesh that stands once is baked into world space; one that stands
 * several times keeps its model space and is instanced. Geometry numbers of the top scene are object numbers.
 */

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "components/deform.h"
#include "components/frame.h"
#include "components/transform.h"
#include "runtime/core/log.h"
#include "runtime/reference/internal.h"

typedef struct builder {
    reference_scene *scene;
    const kd_scene_store *store;
    const kd_joint_palette *palette;
    uint32_t *uses; /* rigid, by store mesh */
} builder;

typedef struct entity_parts {
    const kd_mesh_instance *instance;
    const kd_mat4 *world;
    const kd_skin_instance *skin;
    const kd_morph_weights *weights;
} entity_parts;

static kd_status no_memory(void)
{
    return kd_fail(KD_NO_MEMORY, "reference: out of memory for the scene; use a smaller one");
}

/* ---- transforms ---- */

static float determinant(const kd_vec3 rows[3])
{
    return kd_vec3_dot(rows[0], kd_vec3_cross(rows[1], rows[2]));
}

/* Rows of the cofactor matrix, turned so that mirrored objects keep the side their normals point to: a
 * positive multiple of the inverse transpose. */
static void set_transform(reference_object *o, const kd_mat4 *m)
{
    const kd_vec3 x = {m->m[0], m->m[1], m->m[2]}, y = {m->m[4], m->m[5], m->m[6]},
                  z = {m->m[8], m->m[9], m->m[10]};
    const kd_vec3 columns[3] = {kd_vec3_cross(y, z), kd_vec3_cross(z, x), kd_vec3_cross(x, y)};
    float side = kd_vec3_dot(x, columns[0]) < 0 ? -1.0f : 1.0f;
    o->to_world = *m;
    for (int r = 0; r < 3; r++)
        o->normal_rows[r] =
            (kd_vec3){side * (&columns[0].x)[r], side * (&columns[1].x)[r], side * (&columns[2].x)[r]};
    o->mirrored = side < 0;
}

static bool is_flat(const kd_mat4 *m)
{
    const kd_vec3 columns[3] = {
        {m->m[0], m->m[1], m->m[2]}, {m->m[4], m->m[5], m->m[6]}, {m->m[8], m->m[9], m->m[10]}};
    float size = kd_vec3_length(columns[0]) * kd_vec3_length(columns[1]) * kd_vec3_length(columns[2]);
    return !(fabsf(determinant(columns)) > 1e-6f * size);
}

static const kd_vec4 (*skin_rows(const builder *b, const kd_skin_instance *skin, uint32_t *count))[3]
{
    *count = 0;
    if (!skin || !b->palette->rows || skin->skin >= b->store->skin_count)
        return NULL;
    uint32_t joints = b->store->skins[skin->skin].joint_count;
    if (skin->first_matrix > b->palette->count || joints > b->palette->count - skin->first_matrix)
        return NULL;
    *count = joints;
    return joints ? b->palette->rows + skin->first_matrix : NULL;
}

/* ---- geometries ---- */

static RTCGeometry make_triangles(reference_scene *s, reference_mesh *mesh, const kd_vec3 *positions,
                                  const kd_mat4 *to_world)
{
    RTCGeometry g = rtcNewGeometry(s->device, RTC_GEOMETRY_TYPE_TRIANGLE);
    kd_vec3 *v = rtcSetNewGeometryBuffer(g, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, sizeof *v,
                                         mesh->vertex_count);
    uint32_t *i = rtcSetNewGeometryBuffer(g, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, 3 * sizeof *i,
                                          mesh->triangle_count);
    if (!v || !i) {
        rtcReleaseGeometry(g);
        return NULL;
    }
    for (uint32_t n = 0; n < mesh->vertex_count; n++)
        v[n] = to_world ? kd_mat4_point(to_world, positions[n]) : positions[n];
    memcpy(i, mesh->indices, (size_t)mesh->triangle_count * 3 * sizeof *i);
    mesh->positions = v;
    return g;
}

static RTCGeometry make_instance(reference_scene *s, const reference_object *o, RTCScene part)
{
    RTCGeometry g = rtcNewGeometry(s->device, RTC_GEOMETRY_TYPE_INSTANCE);
    rtcSetGeometryInstancedScene(g, part);
    rtcSetGeometryTransform(g, 0, RTC_FORMAT_FLOAT4X4_COLUMN_MAJOR, o->to_world.m);
    return g;
}

/* The scene of a store primitive, made when it is instanced for the first time. Filters are set by the
 * material of that time: objects of other materials ask their own, see rays.c. */
static RTCScene ensure_part(reference_scene *s, uint32_t primitive, reference_object *o,
                            const kd_vec3 *positions)
{
    RTCGeometry g;
    if (s->parts[primitive]) {
        o->mesh.positions =
            rtcGetGeometryBufferData(rtcGetGeometry(s->parts[primitive], 0), RTC_BUFFER_TYPE_VERTEX, 0);
        return s->parts[primitive];
    }
    g = make_triangles(s, &o->mesh, positions, NULL);
    if (!g)
        return NULL;
    RTCScene part = rtcNewScene(s->device);
    rtcSetSceneFlags(part, RTC_SCENE_FLAG_ROBUST | RTC_SCENE_FLAG_CONTEXT_FILTER_FUNCTION);
    reference_filters_set(g, s, NULL);
    rtcCommitGeometry(g);
    rtcAttachGeometry(part, g);
    rtcReleaseGeometry(g);
    rtcCommitScene(part);
    s->parts[primitive] = part;
    return part;
}

static reference_object *add_object(reference_scene *s)
{
    if (s->object_count == s->object_capacity) {
        uint32_t capacity = s->object_capacity ? s->object_capacity * 2 : 64;
        reference_object *grown = realloc(s->objects, capacity * sizeof *grown);
        if (!grown)
            return NULL;
        s->objects = grown;
        s->object_capacity = capacity;
    }
    reference_object *o = &s->objects[s->object_count];
    *o = (reference_object){.first_emitter = KD_NONE};
    return o;
}

static kd_status attach(reference_scene *s, reference_object *o, RTCGeometry g)
{
    if (!g)
        return no_memory();
    if (!o->instanced)
        reference_filters_set(g, s, o);
    rtcCommitGeometry(g);
    rtcAttachGeometryByID(s->rays, g, s->object_count);
    rtcReleaseGeometry(g);
    s->triangle_count += o->mesh.triangle_count;
    s->object_count++;
    return KD_OK;
}

static uint32_t material_of(const kd_scene_store *store, const kd_mesh_instance *instance, uint32_t primitive)
{
    uint32_t own = store->primitives[primitive].material;
    uint32_t number = instance->material ? instance->material - 1 : own;
    return number < store->material_count ? number : 0;
}

static void set_mesh(reference_mesh *mesh, const kd_primitive_desc *desc, const reference_pose *pose)
{
    *mesh = (reference_mesh){.triangle_count = desc->index_count / 3,
                             .vertex_count = desc->vertex_count,
                             .indices = desc->indices,
                             .normals = pose->normals,
                             .tangents = pose->tangents,
                             .uv = {desc->uv0, desc->uv1 ? desc->uv1 : desc->uv0},
                             .colors = desc->colors};
}

static kd_status add_primitive(builder *b, const entity_parts *e, uint32_t primitive,
                               const kd_primitive_desc *desc)
{
    reference_scene *s = b->scene;
    reference_object *o = add_object(s);
    if (!o)
        return no_memory();
    uint32_t row_count = 0;
    const kd_vec4(*rows)[3] =
        e->instance->deformed && desc->joints ? skin_rows(b, e->skin, &row_count) : NULL;
    bool morphs = e->instance->deformed && desc->morph_count && e->weights;
    reference_pose pose = {desc->positions, desc->normals, desc->tangents};
    kd_status status = rows || morphs ? reference_pose_make(&s->arena, desc, rows, row_count,
                                                            morphs ? e->weights : NULL, &pose)
                                      : KD_OK;
    if (status != KD_OK)
        return status;
    kd_mat4 identity = KD_MAT4_IDENTITY;
    set_mesh(&o->mesh, desc, &pose);
    set_transform(o, rows ? &identity : e->world);
    if (rows)
        o->mirrored = determinant((kd_vec3[3]){{rows[0][0].x, rows[0][0].y, rows[0][0].z},
                                               {rows[0][1].x, rows[0][1].y, rows[0][1].z},
                                               {rows[0][2].x, rows[0][2].y, rows[0][2].z}}) < 0;
    o->material = material_of(b->store, e->instance, primitive);
    o->no_shadow = e->instance->no_shadow;
    s->any_no_shadow |= o->no_shadow;
    o->instanced = !rows && !morphs && b->uses[e->instance->mesh] > 1 && !is_flat(e->world);
    if (!o->instanced)
        return attach(s, o, make_triangles(s, &o->mesh, pose.positions, rows ? NULL : e->world));
    RTCScene part = ensure_part(s, primitive, o, pose.positions);
    return part ? attach(s, o, make_instance(s, o, part)) : no_memory();
}

/* ---- entities ---- */

static bool is_shown(const builder *b, const kd_mesh_instance *instance)
{
    return !instance->hidden && instance->mesh < b->store->mesh_count;
}

static kd_status add_entity(builder *b, const entity_parts *e)
{
    const kd_store_mesh *mesh = &b->store->meshes[e->instance->mesh];
    kd_status status = KD_OK;
    for (uint32_t i = 0; status == KD_OK && i < mesh->primitive_count; i++)
        if (mesh->desc->primitives[i].index_count >= 3)
            status = add_primitive(b, e, mesh->first_primitive + i, &mesh->desc->primitives[i]);
    return status;
}

static kd_status add_entities(builder *b, kd_query *query)
{
    kd_status status = KD_OK;
    for (kd_iter it = kd_query_iter(query); kd_iter_next(&it);) {
        const kd_mesh_instance *instances = KD_COLUMN(&it, kd_mesh_instance, 0);
        for (uint32_t i = 0; i < it.count; i++)
            if (is_shown(b, &instances[i]))
                b->uses[instances[i].mesh] += !instances[i].deformed;
    }
    for (kd_iter it = kd_query_iter(query); status == KD_OK && kd_iter_next(&it);) {
        const kd_mesh_instance *instances = KD_COLUMN(&it, kd_mesh_instance, 0);
        const kd_world_transform *worlds = KD_COLUMN(&it, kd_world_transform, 1);
        const kd_skin_instance *skins = KD_COLUMN(&it, kd_skin_instance, 2);
        const kd_morph_weights *weights = KD_COLUMN(&it, kd_morph_weights, 3);
        for (uint32_t i = 0; status == KD_OK && i < it.count; i++)
            if (is_shown(b, &instances[i]))
                status =
                    add_entity(b, &(entity_parts){&instances[i], &worlds[i].matrix, skins ? &skins[i] : NULL,
                                                  weights ? &weights[i] : NULL});
    }
    return status;
}

static kd_status add_meshes(kd_world *w, builder *b)
{
    kd_query *query = kd_query_make(
        w, &(kd_query_desc){.terms = {KD_READ(kd_mesh_instance), KD_READ(kd_world_transform),
                                      KD_OPTIONAL(kd_skin_instance), KD_OPTIONAL(kd_morph_weights)},
                            .name = "reference"});
    if (!query)
        return no_memory();
    kd_status status = add_entities(b, query);
    kd_query_destroy(query);
    return status;
}

static kd_status add_materials(builder *b)
{
    reference_scene *s = b->scene;
    s->material_count = b->store->material_count;
    s->materials = KD_ARENA_NEW(&s->arena, reference_material, s->material_count + 1);
    s->part_count = b->store->primitive_count;
    s->parts = KD_ARENA_NEW(&s->arena, RTCScene, s->part_count + 1);
    b->uses = KD_ARENA_NEW(&s->arena, uint32_t, b->store->mesh_count + 1);
    if (!s->materials || !s->parts || !b->uses)
        return no_memory();
    for (uint32_t i = 0; i < s->material_count; i++)
        reference_material_make(b->store, i, s->lambert, &s->materials[i]);
    return KD_OK;
}

/* ---- the whole ---- */

static void say_error(void *user, enum RTCError code, const char *text)
{
    (void)user;
    kd_log(KD_LOG_ERROR, "reference: Embree failed (error %d: %s); use a smaller scene", (int)code,
           text ? text : "");
}

/* One thread builds: the tree, and so which of two surfaces in one place is hit, is the same every time. */
static kd_status open_device(reference_scene *s)
{
    s->device = rtcNewDevice("threads=1,set_affinity=0");
    if (!s->device)
        return kd_fail(KD_UNSUPPORTED,
                       "reference: Embree cannot start on this processor (error %d); use another machine",
                       (int)rtcGetDeviceError(NULL));
    rtcSetDeviceErrorFunction(s->device, say_error, NULL);
    s->rays = rtcNewScene(s->device);
    rtcSetSceneFlags(s->rays, RTC_SCENE_FLAG_ROBUST | RTC_SCENE_FLAG_CONTEXT_FILTER_FUNCTION);
    return KD_OK;
}

static kd_status commit(reference_scene *s)
{
    struct RTCBounds b;
    rtcCommitScene(s->rays);
    rtcGetSceneBounds(s->rays, &b);
    bool empty = !(b.lower_x <= b.upper_x);
    s->bounds_min = empty ? (kd_vec3){0, 0, 0} : (kd_vec3){b.lower_x, b.lower_y, b.lower_z};
    s->bounds_max = empty ? (kd_vec3){0, 0, 0} : (kd_vec3){b.upper_x, b.upper_y, b.upper_z};
    return rtcGetDeviceError(s->device) == RTC_ERROR_NONE ? KD_OK : KD_NO_MEMORY;
}

kd_status reference_scene_build(kd_world *w, bool lambert, reference_scene *s)
{
    builder b = {
        .scene = s, .store = kd_singleton(w, kd_scene_store), .palette = kd_singleton(w, kd_joint_palette)};
    *s = (reference_scene){
        .arena = {.block_bytes = 1 << 20}, .lambert = lambert, .view = *kd_singleton(w, kd_view)};
    float sky = kd_singleton(w, kd_frame)->settings.light_ambient;
    s->ambient = (kd_vec3){sky, sky, sky};
    kd_status status = open_device(s);
    if (status == KD_OK)
        status = add_materials(&b);
    if (status == KD_OK)
        status = add_meshes(w, &b);
    if (status == KD_OK)
        status = commit(s);
    if (status == KD_OK)
        status = reference_emitters_build(s);
    if (status == KD_OK)
        status = reference_lights_build(w, s);
    if (status == KD_OK)
        status = reference_sky_build(w, s);
    return status;
}

void reference_scene_fini(reference_scene *s)
{
    for (uint32_t i = 0; s->parts && i < s->part_count; i++)
        if (s->parts[i])
            rtcReleaseScene(s->parts[i]);
    if (s->rays)
        rtcReleaseScene(s->rays);
    if (s->device)
        rtcReleaseDevice(s->device);
    free(s->objects);
    kd_arena_fini(&s->arena);
    *s = (reference_scene){0};
}
