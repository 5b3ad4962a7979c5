/* Clips laid over the one that an instance plays. */
#include <string.h>

#include "components/animation.h"
#include "runtime/core/log.h"
#include "systems/scene/internal.h"
#include "systems/scene/scene.h"

static kd_status find_node(const kd_model *model, const char *name, uint32_t *number)
{
    *number = 0;
    if (!name)
        return KD_OK;
    for (uint32_t i = 0; i < model->node_count && !*number; i++)
        if (model->nodes[i].name && strcmp(model->nodes[i].name, name) == 0)
            *number = i + 1;
    return *number
               ? KD_OK
               : kd_fail(KD_NOT_FOUND, "%s: no node '%s' for a layer; `kandil info` lists a model's nodes",
                         model->path ? model->path : "model", name);
}

/* Get the layers of the entity, made when it has none. */
static kd_animation_layers *ensure_layers(kd_world *w, kd_entity root)
{
    if (!kd_has(w, root, kd_animation_layers) && kd_add(w, root, kd_animation_layers) != KD_OK)
        return NULL;
    return kd_find_mut(w, root, kd_animation_layers);
}

kd_status kd_scene_play_layer(kd_world *w, kd_entity root, const kd_scene_layer *play)
{
    uint32_t clip = 0, from = 0, k = play->layer - 1;
    float length_s = 0;
    kd_status status = KD_OK;
    if (k >= KD_ANIMATION_LAYERS)
        return kd_fail(KD_OUT_OF_RANGE, "layer %u does not exist; choose 1 to %d", play->layer,
                       KD_ANIMATION_LAYERS);
    if (play->clip)
        status = kd_scene_find_clip(w, root, play->clip, &clip, &length_s);
    if (status == KD_OK && play->clip) {
        const kd_scene_store *s = scene_store_get(w);
        status = find_node(s->models[kd_find(w, root, kd_animation)->model - 1].model, play->from, &from);
    }
    kd_animation_layers *l = status == KD_OK ? ensure_layers(w, root) : NULL;
    if (!l)
        return status == KD_OK ? KD_NO_MEMORY : status;
    l->fade_s[k] = play->blend_s > 0 ? play->blend_s : 0;
    l->target[k] = play->clip ? play->weight : 0;
    if (!play->clip)
        return KD_OK;
    l->clip[k] = clip;
    l->from[k] = from;
    l->time_s[k] = play->speed < 0 ? length_s : 0;
    l->speed[k] = play->speed;
    l->loop[k] = play->loop;
    l->weight[k] = l->fade_s[k] > 0 ? 0 : play->weight;
    return KD_OK;
}
