/* Which draws each shadow layer needs, on the CPU: those of the draw list's tree that touch it. The results
 * are indirect arguments in layer order and runs over them: one run for everything opaque, one for each
 * masked batch; first of casters that rest, then of those that move. Beside each argument stands what its
 * depth depends on, by which a frame that changes nothing is known. */

#include "systems/shadow/internal.h"

#include <stdlib.h>
#include <string.h>

#define XXH_INLINE_ALL
#include <xxhash.h>

#include "runtime/core/box_tree.h"

/* What is asked once of a draw, whatever the number of layers. */
typedef enum caster_kind { NO_CASTER, RESTING, MOVING } caster_kind;
typedef struct shadow_draw {
    caster_kind kind;
    uint32_t seen; /* shadow_state.cull_count of the frame that looked at it */
    shadow_caster caster;
} shadow_draw;

void *shadow_reserve(shadow_array *array, size_t bytes)
{
    if (bytes > array->capacity_bytes) {
        size_t capacity = bytes + bytes / 2;
        void *items = malloc(capacity);
        if (items == NULL)
            return NULL;
        free(array->items);
        *array = (shadow_array){items, capacity};
    }
    return array->items;
}

/* ---- poses ---- */

typedef struct culling {
    shadow_state *s;
    kd_world *w;
    const kd_draw_list *list;
    const kd_scene_store *store;
    const kd_joint_palette *palette;
    kd_component_id instance_id, transform_id, skin_id, weights_id;
} culling;

static uint64_t add_joints(const culling *c, const kd_skin_instance *skin, uint64_t sum)
{
    if (c->palette->rows == NULL || skin->skin >= c->store->skin_count)
        return sum;
    uint32_t joints = c->store->skins[skin->skin].joint_count;
    if (skin->first_matrix > c->palette->count || joints > c->palette->count - skin->first_matrix)
        return sum;
    return XXH3_64bits_withSeed(c->palette->rows[skin->first_matrix], joints * sizeof *c->palette->rows, sum);
}

/* Where the entity's vertices are: what the vertex shader and, before it, the deform pass reads. */
static uint64_t pose_checksum(const culling *c, kd_entity e, bool deforms)
{
    const kd_world_transform *world = kd_find_id(c->w, e, c->transform_id);
    uint64_t sum = world != NULL ? XXH3_64bits(&world->matrix, sizeof world->matrix) : 0;
    if (!deforms)
        return sum;
    const kd_skin_instance *skin = kd_find_id(c->w, e, c->skin_id);
    const kd_morph_weights *weights = kd_find_id(c->w, e, c->weights_id);
    if (skin != NULL)
        sum = add_joints(c, skin, sum);
    if (weights != NULL && weights->count <= KD_MAX_MORPH_TARGETS)
        sum = XXH3_64bits_withSeed(weights->weights, weights->count * sizeof *weights->weights, sum);
    return sum;
}

static bool reserve_poses(shadow_state *s, uint32_t index)
{
    if (index < s->pose_capacity)
        return true;
    uint32_t capacity = index + index / 2 + 64;
    shadow_pose *poses = realloc(s->poses, capacity * sizeof *poses);
    if (poses == NULL)
        return false;
    memset(poses + s->pose_capacity, 0, (capacity - s->pose_capacity) * sizeof *poses);
    s->poses = poses;
    s->pose_capacity = capacity;
    return true;
}

/* The entity's pose, taken once a frame though it may have many draws. NULL when memory is out. */
static const shadow_pose *take_pose(const culling *c, kd_entity e, bool deforms)
{
    if (!reserve_poses(c->s, e.index))
        return NULL;
    shadow_pose *pose = &c->s->poses[e.index];
    bool known = pose->generation == e.generation;
    if (known && pose->seen == c->s->cull_count)
        return pose;
    uint64_t checksum = pose_checksum(c, e, deforms);
    *pose = (shadow_pose){checksum, e.generation, c->s->cull_count,
                          known && (pose->moving || pose->checksum != checksum)};
    return pose;
}

/* ---- casters ---- */

/* How a batch casts: what is blended as a cut-out of the parts that are more than half opaque, as it enters
 * the tree too; KD_ALPHA_BLEND: it has no such part. */
static kd_alpha_mode casts_as(const kd_scene_store *store, const kd_draw_batch *batch)
{
    const kd_material_desc *m = &store->materials[batch->material].desc;
    bool clear = m->transmission > 0.5f || (m->base_color.w < 0.5f && !m->alpha_ignored);
    return m->alpha_mode == KD_ALPHA_BLEND && !clear ? KD_ALPHA_MASK : m->alpha_mode;
}

static uint64_t mask_checksum(const kd_store_material *material)
{
    struct kd_material_params params = kd_material_params_make(material);
    return XXH3_64bits_withSeed(&params, sizeof params, material->maps[0].id) | 1;
}

static bool find_caster(const culling *c, const kd_draw *draw, uint32_t material, uint64_t mask,
                        shadow_draw *out)
{
    const kd_mesh_instance *instance = kd_find_id(c->w, draw->entity, c->instance_id);
    out->kind = NO_CASTER;
    if (instance != NULL && instance->no_shadow)
        return true;
    const shadow_pose *pose = take_pose(c, draw->entity, instance != NULL && instance->deformed != 0);
    if (pose == NULL)
        return false;
    out->kind = pose->moving ? MOVING : RESTING;
    out->caster = (shadow_caster){.first_index = draw->args.first_index,
                                  .index_count = draw->args.index_count,
                                  .base_vertex = (uint32_t)draw->args.base_vertex,
                                  .material = material,
                                  .pose = pose->checksum,
                                  .mask = mask};
    return true;
}

/* The draw as a caster, looked at once a frame, when a layer first touches it. What was told to casts no
 * shadow. NULL when memory is out. */
static const shadow_draw *caster_of(const culling *c, uint32_t number, const kd_draw_batch *batch)
{
    shadow_draw *draw = (shadow_draw *)c->s->draws.items + number;
    if (draw->seen == c->s->cull_count)
        return draw;
    bool masked = casts_as(c->store, batch) == KD_ALPHA_MASK;
    uint64_t mask = masked ? mask_checksum(&c->store->materials[batch->material]) : 0;
    *draw = (shadow_draw){.kind = NO_CASTER, .seen = c->s->cull_count};
    if (casts_as(c->store, batch) != KD_ALPHA_BLEND &&
        !find_caster(c, &c->list->draws[number], masked ? batch->material : KD_NONE, mask, draw))
        return NULL;
    return draw;
}

/* ---- layers ---- */

static void close_run(shadow_state *s, uint32_t material, uint32_t first)
{
    if (s->arg_count > first)
        ((shadow_run *)s->runs.items)[s->run_count++] = (shadow_run){material, first, s->arg_count - first};
}

/* Append the casters of one kind and mode among the draws that touch the layer: in one run when they are
 * opaque, else in one for each batch. The numbers ascend, as the batches do. */
static bool append_kind(const culling *c, uint32_t count, caster_kind kind, kd_alpha_mode mode)
{
    shadow_state *s = c->s;
    const uint32_t *numbers = s->visible.items;
    const kd_draw_batch *batch = c->list->batches;
    uint32_t first = s->arg_count, material = KD_NONE;
    for (uint32_t i = 0; i < count; i++) {
        while (numbers[i] >= batch->first_draw + batch->draw_count)
            batch++;
        if (casts_as(c->store, batch) != mode)
            continue;
        if (mode == KD_ALPHA_MASK && batch->material != material) {
            close_run(s, material, first);
            first = s->arg_count;
            material = batch->material;
        }
        const shadow_draw *draw = caster_of(c, numbers[i], batch);
        if (!draw)
            return false;
        if (draw->kind != kind)
            continue;
        ((shadow_caster *)s->casters.items)[s->arg_count] = draw->caster;
        ((kd_draw_indexed *)s->args.items)[s->arg_count++] = c->list->draws[numbers[i]].args;
    }
    close_run(s, material, first);
    return true;
}

static bool cull_layer(const culling *c, shadow_layer *layer)
{
    shadow_state *s = c->s;
    kd_frustum frustum = kd_frustum_make(&layer->matrix, 0);
    uint32_t count = kd_box_tree_in_frustum(c->list->tree, &frustum, s->visible.items);
    layer->first_arg = s->arg_count;
    layer->first_run = s->run_count;
    if (!append_kind(c, count, RESTING, KD_ALPHA_OPAQUE) || !append_kind(c, count, RESTING, KD_ALPHA_MASK))
        return false;
    layer->resting = s->arg_count - layer->first_arg;
    layer->resting_runs = s->run_count - layer->first_run;
    if (!append_kind(c, count, MOVING, KD_ALPHA_OPAQUE) || !append_kind(c, count, MOVING, KD_ALPHA_MASK))
        return false;
    layer->moving = s->arg_count - layer->first_arg - layer->resting;
    layer->moving_runs = s->run_count - layer->first_run - layer->resting_runs;
    return true;
}

/* What was noted of draws is of this frame or of none. */
static bool reserve_draws(shadow_state *s, uint32_t draws)
{
    size_t before = s->draws.capacity_bytes;
    if (shadow_reserve(&s->draws, draws * sizeof(shadow_draw)) == NULL)
        return false;
    if (s->draws.capacity_bytes != before)
        memset(s->draws.items, 0, s->draws.capacity_bytes);
    return true;
}

static bool reserve_all(shadow_state *s, const kd_draw_list *list)
{
    size_t layers = s->layer_count, runs = layers * 2 * ((size_t)list->batch_count + 1);
    return reserve_draws(s, list->draw_count) &&
           shadow_reserve(&s->visible, 2 * (size_t)list->draw_count * sizeof(uint32_t)) != NULL &&
           shadow_reserve(&s->args, layers * list->draw_count * sizeof(kd_draw_indexed)) != NULL &&
           shadow_reserve(&s->casters, layers * list->draw_count * sizeof(shadow_caster)) != NULL &&
           shadow_reserve(&s->runs, runs * sizeof(shadow_run)) != NULL;
}

kd_status shadow_cull(shadow_state *s, kd_world *w, const kd_draw_list *list, const kd_scene_store *store)
{
    const culling c = {.s = s,
                       .w = w,
                       .list = list,
                       .store = store,
                       .palette = kd_singleton(w, kd_joint_palette),
                       .instance_id = KD_ID(w, kd_mesh_instance),
                       .transform_id = KD_ID(w, kd_world_transform),
                       .skin_id = KD_ID(w, kd_skin_instance),
                       .weights_id = KD_ID(w, kd_morph_weights)};
    s->arg_count = s->run_count = 0;
    if (s->layer_count == 0 || list->draw_count == 0)
        return KD_OK;
    bool fits = reserve_all(s, list);
    s->cull_count++;
    for (uint32_t i = 0; i < s->layer_count && fits; i++)
        fits = cull_layer(&c, &s->layers[i]);
    s->layer_count = fits ? s->layer_count : 0;
    return fits ? KD_OK : KD_NO_MEMORY;
}
