#include "systems/voxel_pages/objects.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static uint32_t key_hash(kd_entity e, uint32_t primitive, kd_voxel_tile t, uint32_t cascades)
{
    uint64_t h = ((uint64_t)e.index << 32 | primitive) * 0x9E3779B97F4A7C15u;
    return (uint32_t)(h >> 32) ^ e.generation * 0x85EBCA6Bu ^ caches_tile_hash(t) ^
           (t.tiled ? cascades * 0x9E3779B1u : 0);
}

static bool same_key(const kd_voxel_object *o, const voxel_sight *s)
{
    return o->alive && kd_entity_equal(o->entity, s->entity) && o->draw_primitive == s->draw_primitive &&
           caches_same_tile(o->tile, s->tile) && (!o->tile.tiled || o->cascades == s->cascades);
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
    free(t->near);
    free(scene->objects);
    scene->objects = NULL;
    scene->object_count = 0;
    caches_fini(&t->caches, scene);
    *t = (voxel_objects){0};
}
