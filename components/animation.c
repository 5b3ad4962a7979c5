#include "components/animation.h"

static const kd_animation animation_default = {.speed = 1, .loop = true};
KD_COMPONENT_DEFINE_DEFAULT(
    kd_animation, "animation", &animation_default,
    KD_FIELD(kd_animation, clip, KD_U32, NULL, "clip of the scene store plus one; 0: none"),
    KD_FIELD_RANGE(kd_animation, time_s, KD_F32, "s", 0, 1e6, "time in the clip of the next pose"),
    KD_FIELD(kd_animation, time_rest_s, KD_F32, "s", "what rounding took from that time"),
    KD_FIELD_RANGE(kd_animation, speed, KD_F32, NULL, -1000, 1000,
                   "1 is as recorded; negative plays backwards"),
    KD_FIELD(kd_animation, loop, KD_BOOL, NULL, "start again at the end; otherwise the last pose is held"),
    KD_FIELD(kd_animation, paused, KD_BOOL, NULL, "hold the pose"),
    KD_FIELD(kd_animation, model, KD_U32, NULL, "model of the scene store plus one; 0: none"),
    KD_FIELD(kd_animation, first_node, KD_U32, NULL,
             "entry of the model's first node in the store's node entities"),
    KD_FIELD(kd_animation, previous_clip, KD_U32, NULL, "clip that is blended out, plus one; 0: none"),
    KD_FIELD_RANGE(kd_animation, previous_time_s, KD_F32, "s", 0, 1e6,
                   "time in the clip that is blended out"),
    KD_FIELD_RANGE(kd_animation, previous_speed, KD_F32, NULL, -1000, 1000,
                   "speed of the clip that is blended out"),
    KD_FIELD(kd_animation, previous_loop, KD_BOOL, NULL, "whether the clip that is blended out loops"),
    KD_FIELD_RANGE(kd_animation, blend_s, KD_F32, "s", 0, 1000, "length of the cross-fade"),
    KD_FIELD_RANGE(kd_animation, blend_left_s, KD_F32, "s", 0, 1000, "rest of the cross-fade"));

#define LAYER_FIELD(member, kind, unit, doc)                                                                 \
    KD_FIELD_ARRAY(kd_animation_layers, member, kind, KD_ANIMATION_LAYERS, unit, doc)

KD_COMPONENT_DEFINE(kd_animation_layers, "animation_layers",
                    LAYER_FIELD(clip, KD_U32, NULL, "clip of the scene store plus one; 0: none"),
                    LAYER_FIELD(time_s, KD_F32, "s", "time in the clip of the next pose"),
                    LAYER_FIELD(time_rest_s, KD_F32, "s", "what rounding took from that time"),
                    LAYER_FIELD(speed, KD_F32, NULL, "1 is as recorded; negative plays backwards"),
                    LAYER_FIELD(weight, KD_F32, NULL, "how much of the pose is the layer's, 0 to 1"),
                    LAYER_FIELD(target, KD_F32, NULL, "weight that it fades to; faded to 0 it ends"),
                    LAYER_FIELD(fade_s, KD_F32, "s", "rest of the fade"),
                    LAYER_FIELD(loop, KD_BOOL, NULL,
                                "start again at the end; otherwise the last pose is held"),
                    LAYER_FIELD(from, KD_U32, NULL,
                                "node of the model plus one below which it moves; 0: everywhere"));
