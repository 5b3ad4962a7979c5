/* System draw_list: everything visible as one sorted list, one draw and one object for each primitive of each
 * entity. The order is a function of the scene alone: opaque, mask, blend; then material, mirrored, entity,
 * primitive. The list stands from frame to frame: what moved is emitted again where it is, and all of it is
 * made anew when an entity came, went or draws something else (draw_follow.c). The working arrays grow to the
 * largest frame and stay. */

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "components/deform.h"
#include "components/transform.h"
#include "runtime/core/log.h"
#include "systems/scene/internal.h"

static void release(kd_draw_list *list)
{
    scene_draws *d = list->internal;
    void *const arrays[] = {d->items, d->sorted, d->draws, d->batches,   d->objects, d->args,
                            d->next,  d->dirty,  d->shown, d->deforming, d->modes,   d};
    kd_box_tree_fini(&d->tree);
    for (size_t i = 0; i < sizeof arrays / sizeof *arrays; i++)
        free(arrays[i]);
    *list = (kd_draw_list){0};
}

scene_draws *scene_draws_get(kd_draw_list *list)
{
    if (list && !list->internal) {
        list->internal = calloc(1, sizeof(scene_draws));
        list->release = list->internal ? release : NULL;
    }
    return list ? list->internal : NULL;
}

void scene_mark_dirty(scene_draws *d, uint32_t number)
{
    d->changed = true;
    d->dirty[number / SCENE_DIRTY_DRAWS / 64] |= 1ull << (number / SCENE_DIRTY_DRAWS % 64);
}

static bool reserve_dirty(scene_draws *d, uint64_t draws)
{
    uint32_t before = d->dirty_capacity;
    if (!SCENE_RESERVE(d->dirty, d->dirty_capacity, draws / SCENE_DIRTY_DRAWS / 64 + 1))
        return false;
    memset(d->dirty + before, 0, (d->dirty_capacity - before) * sizeof *d->dirty);
    return true;
}

/* Grow all arrays together: one item may become one of each. */
static bool reserve(scene_draws *d, uint64_t needed)
{
    uint32_t c[8];
    for (int i = 0; i < 8; i++)
        c[i] = d->capacity;
    bool ok = SCENE_RESERVE(d->items, c[0], needed) && SCENE_RESERVE(d->sorted, c[1], needed) &&
              SCENE_RESERVE(d->draws, c[2], needed) && SCENE_RESERVE(d->batches, c[3], needed) &&
              SCENE_RESERVE(d->objects, c[4], needed) && SCENE_RESERVE(d->args, c[5], needed) &&
              SCENE_RESERVE(d->next, c[6], needed) && SCENE_RESERVE(d->deforming, c[7], needed) &&
              reserve_dirty(d, c[0]);
    if (ok)
        d->capacity = c[0];
    else if (!d->out_of_memory)
        kd_log(KD_LOG_ERROR, "out of memory for a list of %llu draws; the rest is left out",
               (unsigned long long)needed);
    d->out_of_memory = !ok;
    return ok;
}

static bool room_for(scene_draws *d, uint64_t needed)
{
    if (d->most && needed > d->most) {
        if (!d->said_most)
            kd_log(KD_LOG_WARNING,
                   "the scene has more than the %u draws that the driver has room for; the "
                   "rest is left out",
                   d->most);
        d->said_most = true;
        return false;
    }
    return needed <= d->capacity || reserve(d, needed);
}

static bool on_gpu(const kd_scene_store *store, const kd_mesh_instance *instance)
{
    const scene_internal *in = store->internal;
    const kd_store_mesh *mesh = &store->meshes[instance->mesh];
    return mesh->first_primitive + mesh->primitive_count <= store->uploaded_primitives &&
           instance->deformed <= in->uploaded_deformed &&
           (!instance->deformed || (!store->deformed[instance->deformed - 1].waiting &&
                                    store->deformed[instance->deformed - 1].mesh == instance->mesh));
}

/* An entity whose parts are not on the GPU yet is drawn later. */
static void collect_entity(scene_collector *c, const scene_item *entity)
{
    const kd_mesh_instance *instance = entity->instance;
    if (instance->hidden)
        return;
    if (instance->mesh >= c->store->mesh_count || !on_gpu(c->store, instance)) {
        c->draws->waiting = true;
        return;
    }
    const kd_store_mesh *mesh = &c->store->meshes[instance->mesh];
    if (!room_for(c->draws, c->count + (uint64_t)mesh->primitive_count))
        return;
    for (uint32_t i = 0; i < mesh->primitive_count; i++) {
        const kd_store_primitive *p = &c->store->primitives[mesh->first_primitive + i];
        if (!p->index_count)
            continue;
        scene_item *item = &c->draws->items[c->count++];
        *item = *entity;
        item->primitive = mesh->first_primitive + i;
        item->part = i;
        item->deformed = instance->deformed && scene_primitive_deforms(p, entity->skin != NULL);
        scene_item_finish(c, item);
    }
}

static void collect(scene_collector *c)
{
    scene_rows rows;
    c->draws->waiting = false;
    for (kd_iter it = kd_query_iter(c->draws->query); scene_rows_next(&it, &rows);)
        for (uint32_t i = 0; i < it.count; i++) {
            scene_item entity = scene_row(&rows, i);
            if (scene_show(c->draws, &entity))
                collect_entity(c, &entity);
            else
                c->draws->waiting = true; /* no memory: it is tried again */
        }
}

static bool before(const scene_item *a, const scene_item *b)
{
    return a->order != b->order ? a->order < b->order : a->entity_order < b->entity_order;
}

/* Merge sort, bottom up, between two arrays that stay allocated. Keys are unique, a list in order costs one
 * pass. */
static scene_item *sort_items(scene_item *items, scene_item *spare, uint32_t count)
{
    bool sorted = true;
    for (uint32_t i = 1; sorted && i < count; i++)
        sorted = before(&items[i - 1], &items[i]);
    for (uint32_t width = 1; !sorted && width < count; width *= 2) {
        for (uint32_t low = 0; low < count; low += 2 * width) {
            uint32_t middle = low + width < count ? low + width : count;
            uint32_t high = middle + width < count ? middle + width : count;
            for (uint32_t a = low, b = middle, out = low; out < high; out++)
                spare[out] =
                    a < middle && (b >= high || before(&items[a], &items[b])) ? items[a++] : items[b++];
        }
        scene_item *swap = items;
        items = spare;
        spare = swap;
    }
    return items;
}

static uint32_t emit_batches(const scene_collector *c, const scene_item *items)
{
    kd_draw_batch *batches = c->draws->batches;
    uint32_t count = 0;
    for (uint32_t i = 0; i < c->count; i++) {
        if (!i || items[i].order != items[i - 1].order)
            batches[count++] = (kd_draw_batch){.material = scene_item_material(c->store, &items[i]),
                                               .first_draw = i,
                                               .mirrored = items[i].mirrored};
        batches[count - 1].draw_count++;
        batches[count - 1].voxels |= !items[i].instance->no_voxels;
    }
    return count;
}

/* Chain the draws of each entity, list those that deform. */
static void link_draws(scene_draws *d, uint32_t count)
{
    d->deforming_count = 0;
    for (uint32_t i = count; i-- > 0;) {
        scene_shown *shown = &d->shown[d->current[i].entity.index];
        d->next[i] = shown->first;
        shown->first = i;
        if (d->current[i].deformed)
            d->deforming[d->deforming_count++] = i;
    }
}

static void make_list(kd_draw_list *list, scene_collector *c)
{
    scene_draws *d = c->draws;
    d->standing = false;
    collect(c);
    if (kd_box_tree_reserve(&d->tree, c->count) != KD_OK) {
        kd_log(KD_LOG_ERROR, "out of memory for a tree of %u draws; nothing is drawn", c->count);
        c->count = 0;
        kd_box_tree_reserve(&d->tree, 0);
        d->waiting = true;
    }
    d->current = sort_items(d->items, d->sorted, c->count);
    d->changed = true; /* also when nothing is left */
    for (uint32_t i = 0; i < c->count; i++)
        scene_emit_draw(c, &d->current[i], i);
    link_draws(d, c->count);
    kd_box_tree_build(&d->tree);
    d->standing = true;
    list->batch_count = emit_batches(c, d->current);
    list->draw_count = list->object_count = c->count;
    list->draws = d->draws;
    list->batches = d->batches;
    list->tree = &d->tree;
    list->deforming = d->deforming;
    list->deforming_count = d->deforming_count;
}

static void draw_list_run(kd_system_context *context)
{
    kd_draw_list *list = kd_singleton(context->world, kd_draw_list);
    scene_collector c = {.draws = scene_draws_get(list),
                         .world = context->world,
                         .store = kd_singleton(context->world, kd_scene_store),
                         .palette = kd_singleton(context->world, kd_joint_palette)};
    if (!c.draws || !c.store->internal)
        return;
    uint64_t version = kd_world_version(context->world);
    if (!scene_follow(&c))
        make_list(list, &c);
    c.draws->version = version;
    if (kd_box_tree_is_worn(&c.draws->tree))
        kd_box_tree_build(&c.draws->tree);
    kd_box all = kd_box_tree_all(&c.draws->tree);
    list->bounds_min_ws = list->draw_count ? all.low : (kd_vec3){0, 0, 0};
    list->bounds_max_ws = list->draw_count ? all.high : (kd_vec3){0, 0, 0};
}

static kd_status draw_list_init(kd_system_context *context)
{
    scene_draws *d = scene_draws_get(kd_singleton(context->world, kd_draw_list));
    if (d)
        d->query = kd_query_make(
            context->world,
            &(kd_query_desc){.terms = {KD_READ(kd_mesh_instance), KD_READ(kd_world_transform),
                                       KD_OPTIONAL(kd_skin_instance), KD_OPTIONAL(kd_morph_weights)},
                             .name = "draw_list"});
    return d && d->query ? KD_OK : kd_fail(KD_NO_MEMORY, "out of memory for the draw list");
}

static void draw_list_fini(kd_system_context *context)
{
    scene_draws *d = scene_draws_get(kd_singleton(context->world, kd_draw_list));
    if (d && d->query)
        kd_query_destroy(d->query);
    if (d)
        d->query = NULL;
}

kd_status scene_register_draw_list(kd_schedule *s)
{
    return kd_schedule_add(
        s, &(kd_system_desc){
               .name = "draw_list",
               .phase = KD_PHASE_CULL,
               .where = KD_ON_CPU,
               .components = {KD_CHANGES(kd_draw_list), KD_USES(kd_scene_store), KD_USES(kd_joint_palette),
                              KD_USES(kd_mesh_instance), KD_USES(kd_world_transform),
                              KD_USES(kd_skin_instance), KD_USES(kd_morph_weights)},
               .no_commands = true,
               .run = draw_list_run,
               .init = draw_list_init,
               .fini = draw_list_fini,
           });
}
