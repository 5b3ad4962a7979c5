#ifndef KD_COMPONENTS_ANIMATION_H
#define KD_COMPONENTS_ANIMATION_H

#include <stdbool.h>

#include "runtime/ecs/world.h"

/* Plays one clip of the model that the entity is the root of. Time is a function of the simulation alone. */
typedef struct kd_animation {
    uint32_t clip; /* kd_scene_store.clips entry plus one; 0: none */
    float time_s;  /* in the clip, of the pose that comes next */
    float time_rest_s; /* what rounding took from it: added to it the sum of all steps */
    float speed;   /* 1 is as recorded; may be negative */
    bool loop;
    bool paused;
    uint32_t model;         /* kd_scene_store.models entry plus one, set at instantiation */
    uint32_t first_node;    /* kd_scene_store.node_entities: entity of each node of the model */
    uint32_t previous_clip; /* blended out; clip plus one, 0: none */
    float previous_time_s;
    float previous_speed;
    bool previous_loop;
    float blend_s, blend_left_s; /* length and rest of a running cross-fade */
} kd_animation;
KD_COMPONENT_DECLARE(kd_animation); /* default: speed 1, loop */

#define KD_ANIMATION_LAYERS 3
/* Clips laid over the one of kd_animation on the same root, in this order: each mixes what it moves into the
 * pose. */
typedef struct kd_animation_layers {
    uint32_t clip[KD_ANIMATION_LAYERS]; /* as in kd_animation; 0: none */
    float time_s[KD_ANIMATION_LAYERS];
    float time_rest_s[KD_ANIMATION_LAYERS];
    float speed[KD_ANIMATION_LAYERS];
    float weight[KD_ANIMATION_LAYERS]; /* 0 … 1, now */
    float target[KD_ANIMATION_LAYERS]; /* weight that it fades to; a layer that has faded to 0 ends */
    float fade_s[KD_ANIMATION_LAYERS]; /* rest of that fade */
    bool loop[KD_ANIMATION_LAYERS];
    uint32_t
        from[KD_ANIMATION_LAYERS]; /* node of the model, plus one, below which it moves it; 0: everywhere */
} kd_animation_layers;
KD_COMPONENT_DECLARE(kd_animation_layers); /* default: none */

#endif
