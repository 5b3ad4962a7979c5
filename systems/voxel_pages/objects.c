#include "systems/voxel_pages/objects.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static uint32_t key_hash(kd_entity e, uint32_t primitive, kd_voxel_tile t, uint32_t cascades)
{
    uint64_t h = ((uint64_t)e.index << 32 | primitive) * 0x9E3779B97F4A7C15u;
    uint32_t place = ((uint32_t)t.x * 73856093u) ^ ((uint32_t)t.y * 19349663u) ^ ((uint32_t)t.z * 83492791u);
    return (uint32_t)(h >> 32) ^ e.generation * 0x85EBCA6Bu ^ (t.tiled ? place ^ cascades * 0x9E3779B1u : 0);
}

static bool same_tile(kd_voxel_tile a, kd_voxel_tile b)
{
    return a.tiled == b.tiled && (!a.tiled || (a.x == b.x && a.y == b.y && a.z == b.z && a.edge == b.edge));
}

static bool same_key(const kd_voxel_object *o, const voxel_sight *s)
{
    return o->alive && kd_entity_equal(o->entity, s->entity) && o->draw_primitive == s->draw_primitive &&
           same_tile(o->tile, s->tile) && (!o->tile.tiled || o->cascades == s->cascades);
}

static void insert_slot(voxel_objects *t, const kd_voxel_scene *scene, uint32_t object)
{
    const kd_voxel_object *o = &scene->objects[object];
    uint32_t at = key_hash(o->entity, o->draw_primitive, o->tile, o->cascades) & (t->slot_count - 1);
    while (t->slots[at])
        at = (at + 1) & (t->slot_count - 1);
    t->slots[at] = object + 1;
    t->used++;
}

static kd_status rehash(voxel_objects *t, const kd_voxel_scene *scene, uint32_t count)
{
    uint32_t *slots = calloc(count, sizeof *slots);
    if (!slots)
        return KD_NO_MEMORY;
    free(t->slots);
    t->slots = slots;
    t->slot_count = count;
    t->used = 0;
    for (uint32_t i = 0; i < scene->object_count; i++)
        if (scene->objects[i].alive)
            insert_slot(t, scene, i);
    return KD_OK;
}

static kd_voxel_object *find(const voxel_objects *t, kd_voxel_scene *scene, const voxel_sight *s)
{
    if (!t->slot_count)
        return NULL;
    uint32_t at = key_hash(s->entity, s->draw_primitive, s->tile, s->cascades) & (t->slot_count - 1);
    for (; t->slots[at]; at = (at + 1) & (t->slot_count - 1))
        if (same_key(&scene->objects[t->slots[at] - 1], s))
            return &scene->objects[t->slots[at] - 1];
    return NULL;
}

static kd_status reserve(voxel_objects *t, kd_voxel_scene *scene)
{
    if (t->used * 2 >= t->slot_count) { /* full, of what lives or of slots that departed objects left */
        uint32_t count = t->live * 4 > t->slot_count ? t->slot_count * 2 : t->slot_count;
        kd_status status = rehash(t, scene, count ? count : 64);
        if (status)
            return status;
    }
    if (scene->object_count < t->capacity || t->free_head)
        return KD_OK;
    uint32_t capacity = t->capacity ? t->capacity * 2 : 64;
    kd_voxel_object *grown = realloc(scene->objects, capacity * sizeof *grown);
    if (!grown)
        return KD_NO_MEMORY;
    scene->objects = grown;
    t->capacity = capacity;
    return KD_OK;
}

static kd_status add(voxel_objects *t, kd_voxel_scene *scene, const voxel_sight *s, kd_voxel_object **out)
{
    kd_status status = reserve(t, scene);
    if (status)
        return status;
    uint32_t index = t->free_head ? t->free_head - 1 : scene->object_count++;
    if (t->free_head)
        t->free_head = scene->objects[index].primitive;
    kd_voxel_object *o = &scene->objects[index];
    *o = (kd_voxel_object){.entity = s->entity,
                           .draw_primitive = s->draw_primitive,
                           .primitive = s->primitive,
                           .kind = s->kind,
                           .material = s->material,
                           .alive = true,
                           .model_ws = s->model_ws,
                           .cached_scale = s->scale,
                           .tile = s->tile,
                           .cascades = s->cascades,
                           .dynamic = s->kind != KD_VOXEL_RIGID || s->dynamic};
    t->live++;
    insert_slot(t, scene, index);
    *out = o;
    return KD_OK;
}

/* A cache serves while its voxels, brought to the world, are neither much larger nor much smaller than the
 * cascade's. What changes its scale gets steps of a quarter octave, so that a scaling object does not ask for
 * a cache a frame. */
static void follow_scale(kd_voxel_object *o, float scale)
{
    if (scale <= o->cached_scale * 1.1f && scale >= o->cached_scale * 0.6f)
        return;
    o->cached_scale = exp2f(ceilf(log2f(scale) * 4) / 4);
    memset(o->caches, 0, sizeof o->caches);
    o->recache = true;
}

/* Colour, masked parts and shares of emission are in the cache. */
static void follow_material(kd_voxel_object *o, uint32_t material)
{
    if (o->material == material)
        return;
    o->material = material;
    memset(o->caches, 0, sizeof o->caches);
    o->recache = true;
}

kd_status objects_see(voxel_objects *t, kd_voxel_scene *scene, const voxel_sight *s)
{
    kd_voxel_object *o = find(t, scene, s);
    if (!o) {
        kd_status status = add(t, scene, s, &o);
        if (status)
            return status;
    } else if (!o->dynamic && memcmp(&o->model_ws, &s->model_ws, sizeof o->model_ws) != 0) {
        o->becomes_dynamic = true;
    }
    follow_scale(o, s->scale > 0 ? s->scale : 1);
    follow_material(o, s->material);
    o->deformed = s->deformed;
    o->model_ws = s->model_ws;
    o->first_matrix = s->first_matrix;
    o->bounds_min_ws = s->bounds_min_ws;
    o->bounds_max_ws = s->bounds_max_ws;
    o->desc = s->desc;
    o->cascades = s->cascades;
    o->seen = true;
    return KD_OK;
}

/* The point of the world's lattice in model space: voxels of an object that only moves, scales uniformly or
 * turns by right angles then fall on whole cells. A singular matrix has no inverse; its object is flat and
 * may lie anywhere. */
static kd_vec3 lattice_phase(const kd_voxel_object *o, float span)
{
    if (o->kind != KD_VOXEL_RIGID || o->dynamic)
        return (kd_vec3){0, 0, 0};
    kd_mat4 inverse = kd_mat4_inverse(&o->model_ws);
    kd_vec3 p = kd_mat4_point(&inverse, (kd_vec3){0, 0, 0});
    if (!isfinite(p.x) || !isfinite(p.y) || !isfinite(p.z))
        return (kd_vec3){0, 0, 0};
    return (kd_vec3){p.x - floorf(p.x / span) * span, p.y - floorf(p.y / span) * span,
                     p.z - floorf(p.z / span) * span};
}

static bool near(float a, float b, float span)
{
    float d = fabsf(a - b);
    return d < span * (1.0f / 64) || d > span * (63.0f / 64);
}

static uint32_t find_cache(const kd_voxel_scene *scene, const kd_voxel_object *o, float span, kd_vec3 phase)
{
    bool aligned = o->kind == KD_VOXEL_RIGID && !o->dynamic;
    for (uint32_t i = scene->cache_count; i-- > 0;) {
        const kd_voxel_cache *c = &scene->caches[i];
        if (c->primitive == o->primitive && c->material == o->material && c->kind == o->kind &&
            fabsf(c->span - span) < span * 1e-3f && same_tile(c->tile, o->tile) &&
            (!aligned || (near(c->phase.x, phase.x, span) && near(c->phase.y, phase.y, span) &&
                          near(c->phase.z, phase.z, span))))
            return i + 1;
    }
    return 0;
}

/* Deforming meshes are not cut into tiles: where one is larger than this many cells, its voxels are coarser.
 */
#define DEFORMING_CELLS 2048

static float span_of(const kd_voxel_scene *scene, const kd_voxel_object *o, uint32_t c)
{
    float span = scene->span[c] / o->cached_scale;
    if (o->kind == KD_VOXEL_RIGID)
        return span;
    kd_vec3 size = kd_vec3_sub(o->desc->bounds_max, o->desc->bounds_min);
    return fmaxf(span, fmaxf(size.x, fmaxf(size.y, size.z)) / DEFORMING_CELLS);
}

kd_status objects_want_cache(voxel_objects *t, kd_voxel_scene *scene, kd_voxel_object *o,
                             const kd_primitive_desc *desc, uint32_t c)
{
    float span = span_of(scene, o, c);
    kd_vec3 phase = lattice_phase(o, span);
    o->caches[c] = find_cache(scene, o, span, phase);
    if (o->caches[c])
        return KD_OK;
    if (scene->cache_count == t->cache_capacity) {
        uint32_t capacity = t->cache_capacity ? t->cache_capacity * 2 : 64;
        kd_voxel_cache *grown = realloc(scene->caches, capacity * sizeof *grown);
        if (!grown)
            return KD_NO_MEMORY;
        scene->caches = grown;
        t->cache_capacity = capacity;
    }
    scene->caches[scene->cache_count++] = (kd_voxel_cache){.primitive = o->primitive,
                                                           .material = o->material,
                                                           .desc = desc,
                                                           .kind = o->kind,
                                                           .span = span,
                                                           .phase = phase,
                                                           .tile = o->tile};
    o->caches[c] = scene->cache_count;
    return KD_OK;
}

void objects_forget(voxel_objects *t, kd_voxel_scene *scene, uint32_t object)
{
    kd_voxel_object *o = &scene->objects[object];
    o->alive = false;
    o->primitive = t->free_head;
    t->free_head = object + 1;
    t->live--;
}

void objects_fini(voxel_objects *t, kd_voxel_scene *scene)
{
    free(t->slots);
    free(scene->objects);
    free(scene->caches);
    scene->objects = NULL;
    scene->caches = NULL;
    scene->object_count = scene->cache_count = 0;
    *t = (voxel_objects){0};
}
