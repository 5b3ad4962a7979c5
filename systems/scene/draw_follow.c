/* What changed since the list was made: rows that the world has stamped. Whoever only moved is emitted again
 * where it stands; anything else that could change the list itself makes it anew. */

#include <stdlib.h>
#include <string.h>

#include "components/transform.h"
#include "systems/scene/internal.h"

bool scene_rows_next(kd_iter *it, scene_rows *rows)
{
    if (!kd_iter_next(it))
        return false;
    *rows =
        (scene_rows){it->entities, KD_COLUMN(it, kd_mesh_instance, 0), KD_COLUMN(it, kd_world_transform, 1),
                     KD_COLUMN(it, kd_skin_instance, 2), KD_COLUMN(it, kd_morph_weights, 3)};
    return true;
}

scene_item scene_row(const scene_rows *rows, uint32_t i)
{
    return (scene_item){.entity = rows->entities[i],
                        .instance = &rows->instances[i],
                        .world = &rows->worlds[i].matrix,
                        .skin = rows->skins ? &rows->skins[i] : NULL,
                        .weights = rows->weights ? &rows->weights[i] : NULL};
}

static bool reserve_shown(scene_draws *d, uint32_t index)
{
    uint32_t before = d->shown_capacity;
    if (!SCENE_RESERVE(d->shown, d->shown_capacity, index + 1ull))
        return false;
    memset(d->shown + before, 0, (d->shown_capacity - before) * sizeof *d->shown);
    return true;
}

/* Keep a row in mind; its draws are to be chained anew. */
bool scene_show(scene_draws *d, const scene_item *e)
{
    if (!reserve_shown(d, e->entity.index))
        return false;
    scene_shown *s = &d->shown[e->entity.index];
    bool known = s->generation == e->entity.generation;
    bool moves = known && s->first != KD_NONE && memcmp(&s->world, e->world, sizeof s->world) != 0;
    s->moved = known && (s->moved || moves);
    s->generation = e->entity.generation;
    s->first = KD_NONE;
    s->skinned = e->skin != NULL;
    s->morphing = e->weights != NULL;
    memcpy(&s->instance, e->instance, sizeof s->instance);
    memcpy(&s->world, e->world, sizeof s->world);
    return true;
}

/* Emit an entity's draw again. Returns false when it belongs elsewhere in the list. */
static bool emit_again(const scene_collector *c, uint32_t number, const scene_item *e)
{
    scene_item *item = &c->draws->current[number];
    uint64_t order = item->order;
    item->instance = e->instance;
    item->world = e->world;
    item->skin = e->skin;
    item->weights = e->weights;
    scene_item_finish(c, item);
    if (item->order != order)
        return false;
    scene_emit_draw(c, item, number);
    return true;
}

static bool follow_row(const scene_collector *c, const scene_item *e)
{
    scene_draws *d = c->draws;
    scene_shown *s = e->entity.index < d->shown_capacity ? &d->shown[e->entity.index] : NULL;
    if (!s || s->generation != e->entity.generation || s->skinned != (e->skin != NULL) ||
        s->morphing != (e->weights != NULL) || memcmp(&s->instance, e->instance, sizeof s->instance) != 0)
        return false;
    if (memcmp(&s->world, e->world, sizeof s->world) == 0)
        return true;
    memcpy(&s->world, e->world, sizeof s->world);
    s->moved |= s->first != KD_NONE;
    for (uint32_t n = s->first; n != KD_NONE; n = d->next[n])
        if (!emit_again(c, n, e))
            return false;
    return true;
}

static bool follow_rows(const scene_collector *c)
{
    scene_rows rows;
    kd_iter it = kd_query_iter(c->draws->query);
    it.changed_since = c->draws->version;
    while (scene_rows_next(&it, &rows))
        for (uint32_t i = 0; i < it.count; i++) {
            scene_item e = scene_row(&rows, i);
            if (!follow_row(c, &e))
                return false;
        }
    return true;
}

/* Joints move what no row of its own says. */
static bool follow_deforming(const scene_collector *c)
{
    const scene_draws *d = c->draws;
    for (uint32_t i = 0; i < d->deforming_count; i++) {
        kd_entity entity = d->current[d->deforming[i]].entity;
        const kd_world_transform *world = kd_find(c->world, entity, kd_world_transform);
        const scene_item e = {.instance = kd_find(c->world, entity, kd_mesh_instance),
                              .world = world ? &world->matrix : NULL,
                              .skin = kd_find(c->world, entity, kd_skin_instance),
                              .weights = kd_find(c->world, entity, kd_morph_weights)};
        if (!e.instance || !e.world || !emit_again(c, d->deforming[i], &e))
            return false;
    }
    return true;
}

/* The mode of each material decides the order. */
static bool same_modes(scene_draws *d, const kd_scene_store *store)
{
    bool same = d->mode_count == store->material_count;
    if (!SCENE_RESERVE(d->modes, d->mode_capacity, store->material_count))
        return false;
    for (uint32_t i = 0; i < store->material_count; i++) {
        uint8_t mode = (uint8_t)store->materials[i].desc.alpha_mode;
        same = same && d->modes[i] == mode;
        d->modes[i] = mode;
    }
    d->mode_count = store->material_count;
    return same;
}

bool scene_follow(const scene_collector *c)
{
    scene_draws *d = c->draws;
    uint32_t entities = kd_query_count(d->query);
    bool stands = same_modes(d, c->store) && d->standing && !d->waiting && !d->out_of_memory &&
                  d->entities == entities && d->revision == c->store->revision;
    d->entities = entities;
    d->revision = c->store->revision;
    return stands && follow_rows(c) && follow_deforming(c);
}
