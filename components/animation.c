#include "components/animation.h"

static const kd_animation animation_default = {.speed = 1, .loop = true};
KD_COMPONENT_DEFINE_DEFAULT(
    kd_animation, "animation", &animation_default,
    KD_FIELD(kd_animation, clip, KD_U32, NULL, "clip of the scene store plus one; 0: none"),
    KD_FIELD_RANGE(kd_animation, time_s, KD_F32, "s", 0, 1e6, "time in the clip of the next pose"),
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
