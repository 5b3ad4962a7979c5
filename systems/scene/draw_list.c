/* System draw_list: everything visible as one sorted list, one draw and one object for each primitive of each
 * entity. The order is a function of the scene alone: opaque, mask, blend; then material, mirrored, entity,
 * primitive. The working arrays grow to the largest frame and stay. */

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
    void *const arrays[] = {d->items, d->sorted,        d->draws, d->batches, d->objects, d->previous_objects,
                            d->args,  d->previous_args, d};
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

/* Grow all arrays together: one item may become one of each. */
static bool reserve(scene_draws *d, uint64_t needed)
{
    uint32_t c[8];
    for (int i = 0; i < 8; i++)
        c[i] = d->capacity;
    bool ok = SCENE_RESERVE(d->items, c[0], needed) && SCENE_RESERVE(d->sorted, c[1], needed) &&
              SCENE_RESERVE(d->draws, c[2], needed) && SCENE_RESERVE(d->batches, c[3], needed) &&
              SCENE_RESERVE(d->objects, c[4], needed) && SCENE_RESERVE(d->previous_objects, c[5], needed) &&
              SCENE_RESERVE(d->args, c[6], needed) && SCENE_RESERVE(d->previous_args, c[7], needed);
    if (ok)
        d->capacity = c[0];
    else if (!d->out_of_memory)
        kd_log(KD_LOG_ERROR, "out of memory for a list of %llu draws; the rest is left out",
               (unsigned long long)needed);
    d->out_of_memory = !ok;
    return ok;
}

static float determinant(const kd_vec4 r[3])
{
    return r[0].x * (r[1].y * r[2].z - r[1].z * r[2].y) - r[0].y * (r[1].x * r[2].z - r[1].z * r[2].x) +
           r[0].z * (r[1].x * r[2].y - r[1].y * r[2].x);
}

static const kd_vec4 (*skin_rows(const kd_joint_palette *palette, const kd_scene_store *store,
                                 const kd_skin_instance *skin, uint32_t *count))[3]
{
    *count = 0;
    if (!skin || !palette->rows || skin->skin >= store->skin_count)
        return NULL;
    uint32_t joints = store->skins[skin->skin].joint_count;
    if (skin->first_matrix > palette->count || joints > palette->count - skin->first_matrix)
        return NULL;
    *count = joints;
    return joints ? palette->rows + skin->first_matrix : NULL;
}

static uint32_t material_of(const kd_scene_store *store, const scene_item *item)
{
    uint32_t own = store->primitives[item->primitive].material;
    uint32_t number = item->instance->material ? item->instance->material - 1 : own;
    return number < store->material_count ? number : 0;
}

typedef struct collector {
    scene_draws *draws;
    const kd_scene_store *store;
    const kd_joint_palette *palette;
    uint32_t count;
} collector;

static bool on_gpu(const kd_scene_store *store, const kd_mesh_instance *instance)
{
    const scene_internal *in = store->internal;
    const kd_store_mesh *mesh = &store->meshes[instance->mesh];
    return mesh->first_primitive + mesh->primitive_count <= store->uploaded_primitives &&
           instance->deformed <= in->uploaded_deformed &&
           (!instance->deformed || (!store->deformed[instance->deformed - 1].waiting &&
                                    store->deformed[instance->deformed - 1].mesh == instance->mesh));
}

static void finish_item(const collector *c, scene_item *item)
{
    kd_vec4 rows[3];
    uint32_t count;
    const kd_vec4(*palette)[3] = item->deformed ? skin_rows(c->palette, c->store, item->skin, &count) : NULL;
    scene_matrix_rows(item->world, rows);
    item->mirrored = determinant(palette ? palette[0] : (const kd_vec4 *)rows) < 0;
    uint32_t material = material_of(c->store, item);
    uint64_t mode = (uint64_t)c->store->materials[material].desc.alpha_mode;
    item->order = mode << 33 | (uint64_t)material << 1 | item->mirrored;
    item->entity_order = (uint64_t)item->entity.index << 32 | item->part;
}

static void collect_entity(collector *c, const scene_item *entity)
{
    const kd_mesh_instance *instance = entity->instance;
    if (instance->hidden || instance->mesh >= c->store->mesh_count || !on_gpu(c->store, instance))
        return;
    const kd_store_mesh *mesh = &c->store->meshes[instance->mesh];
    if (c->count + (uint64_t)mesh->primitive_count > c->draws->capacity &&
        !reserve(c->draws, c->count + (uint64_t)mesh->primitive_count))
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
        finish_item(c, item);
    }
}

static void collect(collector *c)
{
    for (kd_iter it = kd_query_iter(c->draws->query); kd_iter_next(&it);) {
        const kd_mesh_instance *instances = KD_COLUMN(&it, kd_mesh_instance, 0);
        const kd_world_transform *worlds = KD_COLUMN(&it, kd_world_transform, 1);
        const kd_skin_instance *skins = KD_COLUMN(&it, kd_skin_instance, 2);
        const kd_morph_weights *weights = KD_COLUMN(&it, kd_morph_weights, 3);
        for (uint32_t i = 0; i < it.count; i++)
            collect_entity(c, &(scene_item){.entity = it.entities[i],
                                            .instance = &instances[i],
                                            .world = &worlds[i].matrix,
                                            .skin = skins ? &skins[i] : NULL,
                                            .weights = weights ? &weights[i] : NULL});
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

/* Rows of the inverse transpose; of a singular matrix the cofactors, which still point the right way. */
static void normal_matrix(const kd_mat4 *m, struct kd_object *object)
{
    const kd_vec3 x = {m->m[0], m->m[1], m->m[2]}, y = {m->m[4], m->m[5], m->m[6]},
                  z = {m->m[8], m->m[9], m->m[10]};
    const kd_vec3 columns[3] = {kd_vec3_cross(y, z), kd_vec3_cross(z, x), kd_vec3_cross(x, y)};
    float det = kd_vec3_dot(x, columns[0]);
    float scale = fabsf(det) > 1e-30f ? 1 / det : 1;
    for (int r = 0; r < 3; r++) {
        const float row[3] = {(&columns[0].x)[r], (&columns[1].x)[r], (&columns[2].x)[r]};
        object->normal_ws[r].x = row[0] * scale;
        object->normal_ws[r].y = row[1] * scale;
        object->normal_ws[r].z = row[2] * scale;
        object->normal_ws[r].w = 0;
    }
}

static void emit_object(struct kd_object *object, const scene_item *item, bool skinned, uint32_t material)
{
    const kd_mat4 model = skinned ? KD_MAT4_IDENTITY : *item->world;
    memcpy(object->model_ws.m, model.m, sizeof model.m);
    normal_matrix(&model, object);
    object->info.x = material;
    object->info.y =
        (item->instance->no_shadow ? KD_OBJECT_NO_SHADOW : 0) | (item->mirrored ? KD_OBJECT_MIRRORED : 0);
    object->info.z = item->entity.index;
    object->info.w = 0;
}

static void emit_draw(const collector *c, const scene_item *item, uint32_t number)
{
    const kd_scene_store *store = c->store;
    const kd_store_mesh *mesh = &store->meshes[item->instance->mesh];
    uint32_t count = 0, primitive = item->primitive;
    const kd_store_primitive *p = &store->primitives[primitive];
    bool skinned = item->deformed && item->skin && p->first_skin_vertex != KD_NONE;
    const kd_vec4(*rows)[3] = skinned ? skin_rows(c->palette, store, item->skin, &count) : NULL;
    scene_box box = scene_primitive_bounds(store->internal, store, primitive, item->world, rows, count,
                                           item->deformed ? item->weights : NULL);
    if (item->deformed) {
        primitive = store->deformed[item->instance->deformed - 1].first_primitive +
                    (primitive - mesh->first_primitive);
        p = &store->deformed_primitives[primitive];
    }
    c->draws->args[number] = (kd_draw_indexed){.index_count = p->index_count,
                                               .instance_count = 1,
                                               .first_index = p->first_index,
                                               .base_vertex = (int32_t)p->base_vertex,
                                               .base_instance = number};
    c->draws->draws[number] = (kd_draw){.args = c->draws->args[number],
                                        .entity = item->entity,
                                        .primitive = primitive,
                                        .deformed = item->deformed,
                                        .bounds_min_ws = box.min,
                                        .bounds_max_ws = box.max};
    emit_object(&c->draws->objects[number], item, skinned, material_of(store, item));
}

static uint32_t emit_batches(const collector *c, const scene_item *items)
{
    kd_draw_batch *batches = c->draws->batches;
    uint32_t count = 0;
    for (uint32_t i = 0; i < c->count; i++) {
        if (!i || items[i].order != items[i - 1].order)
            batches[count++] = (kd_draw_batch){
                .material = material_of(c->store, &items[i]), .first_draw = i, .mirrored = items[i].mirrored};
        batches[count - 1].draw_count++;
    }
    return count;
}

static void publish(kd_draw_list *list, const collector *c, const scene_item *items)
{
    scene_draws *d = c->draws;
    scene_box all = SCENE_BOX_EMPTY;
    for (uint32_t i = 0; i < c->count; i++) {
        emit_draw(c, &items[i], i);
        scene_box_join(&all, &(scene_box){d->draws[i].bounds_min_ws, d->draws[i].bounds_max_ws});
    }
    list->batch_count = emit_batches(c, items);
    list->draw_count = list->object_count = c->count;
    list->draws = d->draws;
    list->batches = d->batches;
    list->bounds_min_ws = c->count ? all.min : (kd_vec3){0, 0, 0};
    list->bounds_max_ws = c->count ? all.max : (kd_vec3){0, 0, 0};
}

/* Keep what the GPU has in previous_*: equal frames upload nothing. A change that was not uploaded yet stays
 * one. */
static void compare(scene_draws *d, uint32_t count)
{
    d->changed |= count != d->previous_count ||
                  (count && (memcmp(d->objects, d->previous_objects, count * sizeof *d->objects) != 0 ||
                             memcmp(d->args, d->previous_args, count * sizeof *d->args) != 0));
    struct kd_object *objects = d->objects;
    kd_draw_indexed *args = d->args;
    d->objects = d->previous_objects;
    d->args = d->previous_args;
    d->previous_objects = objects;
    d->previous_args = args;
    d->previous_count = count;
}

static void draw_list_run(kd_system_context *context)
{
    kd_draw_list *list = kd_singleton(context->world, kd_draw_list);
    collector c = {.draws = scene_draws_get(list),
                   .store = kd_singleton(context->world, kd_scene_store),
                   .palette = kd_singleton(context->world, kd_joint_palette)};
    if (!c.draws || !c.store->internal)
        return;
    collect(&c);
    const scene_item *items = sort_items(c.draws->items, c.draws->sorted, c.count);
    publish(list, &c, items);
    compare(c.draws, c.count);
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
