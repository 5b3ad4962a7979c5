/* System animation: poses the nodes of every playing model. Poses are sampled by jobs, each instance into
 * scratch of its own, and written to the entities afterwards in order, so that any number of threads gives
 * the same world. A frame shows the time that kd_animation holds and then moves it on: a clip started by a
 * script is seen from its start. */

#include "systems/animation/animation.h"

#include <stdlib.h>
#include <string.h>

#include "components/animation.h"
#include "components/camera.h"
#include "components/frame.h"
#include "components/light.h"
#include "components/mesh_instance.h"
#include "components/scene_store.h"
#include "components/transform.h"
#include "runtime/core/arena.h"
#include "runtime/core/log.h"
#include "runtime/jobs/jobs.h"
#include "systems/animation/properties.h"
#include "systems/animation/sample.h"

enum { MOVES_POSITION = 1, MOVES_ROTATION = 2, MOVES_SCALE = 4 };

typedef struct node_pose {
    kd_transform pose;
    uint32_t moves; /* which parts the clips set; the others stay as they are on the entity */
} node_pose;

/* One playing instance of this frame. */
typedef struct player {
    kd_animation *animation;
    const kd_model *model;
    const kd_clip_desc *clip, *previous; /* previous may be NULL */
    float time_s, previous_time_s;
    float previous_weight;
    node_pose *nodes, *previous_nodes; /* [model->node_count]; the latter also serve the layers */
    kd_animation_layers *layers;       /* NULL: none */
    const kd_clip_desc *layer_clips[KD_ANIMATION_LAYERS];
} player;

typedef struct animation_state {
    kd_query *query;
} animation_state;

/* ---- sampling ---- */

static void rest_pose(const kd_model *model, node_pose *nodes)
{
    for (uint32_t i = 0; i < model->node_count; i++) {
        const kd_node_desc *n = &model->nodes[i];
        nodes[i] = (node_pose){.pose = {n->translation, n->rotation, n->scale}};
    }
}

static void sample_clip(const kd_clip_desc *clip, const kd_model *model, float time_s, node_pose *nodes)
{
    rest_pose(model, nodes);
    for (uint32_t i = 0; i < clip->channel_count; i++) {
        const kd_channel_desc *channel = &clip->channels[i];
        node_pose *node = &nodes[channel->node];
        float v[4] = {0};
        if (channel->path == KD_PATH_WEIGHTS)
            continue;
        animation_sample(channel, time_s, v, 4);
        if (channel->path == KD_PATH_TRANSLATION) {
            node->pose.position = (kd_vec3){v[0], v[1], v[2]};
            node->moves |= MOVES_POSITION;
        } else if (channel->path == KD_PATH_ROTATION) {
            node->pose.rotation = (kd_quat){v[0], v[1], v[2], v[3]};
            node->moves |= MOVES_ROTATION;
        } else {
            node->pose.scale = (kd_vec3){v[0], v[1], v[2]};
            node->moves |= MOVES_SCALE;
        }
    }
}

static kd_vec3 mix(kd_vec3 a, kd_vec3 b, float t)
{
    return kd_vec3_add(a, kd_vec3_scale(kd_vec3_sub(b, a), t));
}

/* What only one of the two clips moves fades from or to the rest pose. */
static void blend(node_pose *to, const node_pose *from, uint32_t count, float from_weight)
{
    for (uint32_t i = 0; i < count; i++) {
        to[i].moves |= from[i].moves;
        if (!to[i].moves || from_weight <= 0)
            continue;
        to[i].pose.position = mix(to[i].pose.position, from[i].pose.position, from_weight);
        to[i].pose.rotation = kd_quat_slerp(to[i].pose.rotation, from[i].pose.rotation, from_weight);
        to[i].pose.scale = mix(to[i].pose.scale, from[i].pose.scale, from_weight);
    }
}

/* Tell whether the node is `top` or hangs below it. */
static bool is_below(const kd_model *model, uint32_t node, uint32_t top)
{
    while (node != top && node != KD_NONE)
        node = model->nodes[node].parent;
    return node == top;
}

/* Mix what the layer's clip moves into the pose. */
static void lay_over(const player *p, uint32_t layer, const kd_clip_desc *clip)
{
    const kd_animation_layers *layers = p->layers;
    float weight = layers->weight[layer];
    const node_pose *from = p->previous_nodes;
    sample_clip(clip, p->model, layers->time_s[layer], p->previous_nodes);
    for (uint32_t i = 0; i < p->model->node_count; i++) {
        node_pose *to = &p->nodes[i];
        if (!from[i].moves || (layers->from[layer] && !is_below(p->model, i, layers->from[layer] - 1)))
            continue;
        if (from[i].moves & MOVES_POSITION)
            to->pose.position = mix(to->pose.position, from[i].pose.position, weight);
        if (from[i].moves & MOVES_ROTATION)
            to->pose.rotation = kd_quat_slerp(to->pose.rotation, from[i].pose.rotation, weight);
        if (from[i].moves & MOVES_SCALE)
            to->pose.scale = mix(to->pose.scale, from[i].pose.scale, weight);
        to->moves |= from[i].moves;
    }
}

static void sample_players(void *user, uint32_t begin, uint32_t end, uint32_t worker)
{
    (void)worker;
    for (uint32_t i = begin; i < end; i++) {
        player *p = (player *)user + i;
        if (p->clip)
            sample_clip(p->clip, p->model, p->time_s, p->nodes);
        else
            rest_pose(p->model, p->nodes);
        if (p->previous) {
            sample_clip(p->previous, p->model, p->previous_time_s, p->previous_nodes);
            blend(p->nodes, p->previous_nodes, p->model->node_count, p->previous_weight);
        }
        for (uint32_t k = 0; k < KD_ANIMATION_LAYERS && p->layers; k++)
            if (p->layer_clips[k])
                lay_over(p, k, p->layer_clips[k]);
    }
}

/* ---- writing to the entities ---- */

static void write_transforms(kd_world *w, const kd_entity *entities, const player *p)
{
    for (uint32_t i = 0; i < p->model->node_count; i++) {
        const node_pose *node = &p->nodes[i];
        const kd_transform *old = node->moves ? kd_find(w, entities[i], kd_transform) : NULL;
        if (!old)
            continue;
        kd_transform pose = *old;
        if (node->moves & MOVES_POSITION)
            pose.position = node->pose.position;
        if (node->moves & MOVES_ROTATION)
            pose.rotation = node->pose.rotation;
        if (node->moves & MOVES_SCALE)
            pose.scale = node->pose.scale;
        if (memcmp(&pose, old, sizeof pose) != 0) /* an equal pose must not count as a change */
            *kd_find_mut(w, entities[i], kd_transform) = pose;
    }
}

static const kd_channel_desc *weights_channel(const kd_clip_desc *clip, uint32_t node)
{
    for (uint32_t i = 0; i < clip->channel_count; i++)
        if (clip->channels[i].path == KD_PATH_WEIGHTS && clip->channels[i].node == node)
            return &clip->channels[i];
    return NULL;
}

/* Weights of a node by a channel; at rest when it is NULL. */
static void sample_weights(const kd_model *model, uint32_t node, const kd_channel_desc *channel, float time_s,
                           float *out)
{
    const kd_node_desc *n = &model->nodes[node];
    const kd_mesh_desc *mesh = n->mesh == KD_NONE ? NULL : &model->meshes[n->mesh];
    const float *rest = n->morph_weights ? n->morph_weights : mesh ? mesh->morph_weights : NULL;
    uint32_t count = n->morph_weights ? n->morph_count : mesh ? mesh->morph_count : 0;
    memset(out, 0, KD_MAX_MORPH_TARGETS * sizeof *out);
    if (channel)
        animation_sample(channel, time_s, out, KD_MAX_MORPH_TARGETS);
    else if (rest)
        memcpy(out, rest, (count < KD_MAX_MORPH_TARGETS ? count : KD_MAX_MORPH_TARGETS) * sizeof *out);
}

static void write_node_weights(kd_world *w, kd_entity e, const player *p, uint32_t node,
                               const kd_channel_desc *channel)
{
    float now[KD_MAX_MORPH_TARGETS], before[KD_MAX_MORPH_TARGETS];
    const kd_morph_weights *old = kd_find(w, e, kd_morph_weights);
    if (!old)
        return;
    sample_weights(p->model, node, channel, p->time_s, now);
    if (p->previous && p->previous_weight > 0) {
        const kd_channel_desc *left = weights_channel(p->previous, node);
        sample_weights(p->model, node, left, p->previous_time_s, before);
        for (uint32_t i = 0; i < KD_MAX_MORPH_TARGETS; i++)
            now[i] += (before[i] - now[i]) * p->previous_weight;
    }
    size_t bytes = (old->count < KD_MAX_MORPH_TARGETS ? old->count : KD_MAX_MORPH_TARGETS) * sizeof *now;
    if (memcmp(old->weights, now, bytes) != 0)
        memcpy(kd_find_mut(w, e, kd_morph_weights)->weights, now, bytes);
}

static void write_weights(kd_world *w, const kd_entity *entities, const player *p)
{
    if (!p->clip)
        return;
    for (uint32_t i = 0; i < p->clip->channel_count; i++) {
        const kd_channel_desc *channel = &p->clip->channels[i];
        if (channel->path == KD_PATH_WEIGHTS)
            write_node_weights(w, entities[channel->node], p, channel->node, channel);
    }
    for (uint32_t i = 0; p->previous && i < p->previous->channel_count; i++) {
        const kd_channel_desc *channel = &p->previous->channels[i];
        if (channel->path == KD_PATH_WEIGHTS && !weights_channel(p->clip, channel->node))
            write_node_weights(w, entities[channel->node], p, channel->node, NULL);
    }
}

static void write_properties(kd_world *w, const kd_entity *entities, const player *p)
{
    const animation_moment moment = {p->clip, p->previous, p->time_s, p->previous_time_s, p->previous_weight};
    bool any = (p->clip && p->clip->property_count) || (p->previous && p->previous->property_count);
    kd_scene_store *store = any ? kd_singleton(w, kd_scene_store) : NULL;
    if (store)
        animation_write_properties(w, store, &store->models[p->animation->model - 1], entities, &moment);
}

/* ---- time ---- */

static void advance_layer(kd_animation_layers *l, uint32_t k, const kd_clip_desc *clip, double dt_s)
{
    if (l->weight[k] <= 0 && l->target[k] <= 0) { /* its last traces have been written over */
        l->clip[k] = 0;
        return;
    }
    animation_advance(&l->time_s[k], &l->time_rest_s[k], dt_s * (double)l->speed[k], clip->duration,
                      l->loop[k]);
    float share = l->fade_s[k] > (float)dt_s ? (float)dt_s / l->fade_s[k] : 1;
    l->weight[k] += (l->target[k] - l->weight[k]) * share;
    l->fade_s[k] = l->fade_s[k] > (float)dt_s ? l->fade_s[k] - (float)dt_s : 0;
}

static void advance(player *p, double dt_s)
{
    kd_animation *a = p->animation;
    double dt = a->paused ? 0 : dt_s;
    for (uint32_t k = 0; k < KD_ANIMATION_LAYERS && p->layers; k++)
        if (p->layer_clips[k])
            advance_layer(p->layers, k, p->layer_clips[k], dt);
    if (!p->clip)
        return;
    a->time_s = p->time_s;
    animation_advance(&a->time_s, &a->time_rest_s, dt * (double)a->speed, p->clip->duration, a->loop);
    if (!a->previous_clip)
        return;
    if (!p->previous || p->previous_weight <= 0) { /* its last traces have been written over */
        a->previous_clip = 0;
        a->blend_s = a->blend_left_s = 0;
        return;
    }
    a->previous_time_s = animation_wrap((double)p->previous_time_s + dt * (double)a->previous_speed,
                                        p->previous->duration, a->previous_loop);
    a->blend_left_s = a->blend_left_s > (float)dt ? a->blend_left_s - (float)dt : 0;
}

static const kd_clip_desc *clip_of(const kd_scene_store *store, const kd_animation *a, uint32_t clip)
{
    bool valid = clip && clip <= store->clip_count && store->clips[clip - 1].model == a->model - 1;
    return valid ? store->clips[clip - 1].desc : NULL;
}

static bool find_layers(const kd_scene_store *store, const kd_animation *a, kd_animation_layers *layers,
                        player *p)
{
    bool any = false;
    for (uint32_t k = 0; k < KD_ANIMATION_LAYERS && layers; k++) {
        p->layer_clips[k] = clip_of(store, a, layers->clip[k]);
        any = any || p->layer_clips[k];
    }
    p->layers = any ? layers : NULL;
    return any;
}

static bool make_player(const kd_scene_store *store, kd_animation *a, kd_animation_layers *layers, player *p)
{
    player laid = {0};
    if (!a->model || a->model > store->model_count)
        return false;
    const kd_clip_desc *clip = clip_of(store, a, a->clip);
    if (!find_layers(store, a, layers, &laid) && !clip)
        return false;
    const kd_model *model = store->models[a->model - 1].model;
    if (a->first_node > store->node_entity_count ||
        model->node_count > store->node_entity_count - a->first_node)
        return false;
    *p = laid;
    p->animation = a;
    p->model = model;
    p->clip = clip;
    p->previous = clip ? clip_of(store, a, a->previous_clip) : NULL;
    p->time_s = clip ? animation_wrap((double)a->time_s, clip->duration, a->loop) : 0;
    if (p->previous) {
        p->previous_time_s =
            animation_wrap((double)a->previous_time_s, p->previous->duration, a->previous_loop);
        float weight = a->blend_s > 0 ? a->blend_left_s / a->blend_s : 0;
        p->previous_weight = weight > 1 ? 1 : weight > 0 ? weight : 0;
    }
    return true;
}

/* ---- the system ---- */

static uint32_t collect(const animation_state *state, const kd_scene_store *store, kd_arena *scratch,
                        player *players)
{
    uint32_t count = 0;
    for (kd_iter it = kd_query_iter(state->query); kd_iter_next(&it);) {
        kd_animation *animations = KD_COLUMN_MUT(&it, kd_animation, 0);
        kd_animation_layers *layers = it.columns[1] ? KD_COLUMN_MUT(&it, kd_animation_layers, 1) : NULL;
        for (uint32_t i = 0; i < it.count; i++) {
            player *p = &players[count];
            if (!make_player(store, &animations[i], layers ? &layers[i] : NULL, p))
                continue;
            p->nodes = KD_ARENA_NEW(scratch, node_pose, p->model->node_count);
            bool two = p->previous || p->layers;
            p->previous_nodes = two ? KD_ARENA_NEW(scratch, node_pose, p->model->node_count) : NULL;
            if (p->nodes && (!two || p->previous_nodes))
                count++;
        }
    }
    return count;
}

/* The schedule has the frame's step without its rounding. */
static double step_of(const kd_system_context *c, const kd_frame *frame)
{
    return (float)c->dt_s == frame->dt_s ? c->dt_s : (double)frame->dt_s;
}

static void animation_run(kd_system_context *c)
{
    const animation_state *state = c->user;
    const kd_scene_store *store = kd_singleton(c->world, kd_scene_store);
    const kd_frame *frame = kd_singleton(c->world, kd_frame);
    uint32_t limit = kd_query_count(state->query);
    player *players = limit ? KD_ARENA_NEW(c->scratch, player, limit) : NULL;
    if (!players)
        return;
    uint32_t count = collect(state, store, c->scratch, players);
    kd_jobs_parallel_for(c->jobs, count, 1, sample_players, players);
    for (uint32_t i = 0; i < count; i++) {
        const kd_entity *entities = store->node_entities + players[i].animation->first_node;
        write_transforms(c->world, entities, &players[i]);
        write_weights(c->world, entities, &players[i]);
        write_properties(c->world, entities, &players[i]);
        advance(&players[i], step_of(c, frame));
    }
}

static kd_status animation_init(kd_system_context *c)
{
    animation_state *state = c->user;
    state->query = kd_query_make(
        c->world, &(kd_query_desc){.terms = {KD_WRITE(kd_animation), KD_OPTIONAL_WRITE(kd_animation_layers)},
                                   .name = "animation"});
    return state->query ? KD_OK : kd_fail(KD_NO_MEMORY, "out of memory for the animation query");
}

static void animation_fini(kd_system_context *c)
{
    animation_state *state = c->user;
    kd_query_destroy(state->query);
    free(state);
}

kd_status kd_animation_import(kd_schedule *s)
{
    animation_state *state = calloc(1, sizeof *state);
    if (!state)
        return kd_fail(KD_NO_MEMORY, "out of memory for the animation system");
    kd_status status =
        kd_schedule_add(s, &(kd_system_desc){
                               .name = "animation",
                               .phase = KD_PHASE_ANIMATE,
                               .where = KD_ON_CPU,
                               .components = {KD_CHANGES(kd_animation), KD_CHANGES(kd_animation_layers),
                                              KD_CHANGES(kd_transform), KD_CHANGES(kd_morph_weights),
                                              KD_CHANGES(kd_light), KD_CHANGES(kd_camera),
                                              KD_CHANGES(kd_scene_store), KD_USES(kd_frame)},
                               .no_commands = true,
                               .run = animation_run,
                               .init = animation_init,
                               .fini = animation_fini,
                               .user = state,
                           });
    if (status != KD_OK)
        free(state);
    return status;
}
