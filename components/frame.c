#include "components/frame.h"

static const char *const gi_names[] = {"cones", "none", NULL};
static const char *const view_names[] = {"final",  "direct", "indirect", "ao",     "specular",
                                         "albedo", "normal", "depth",    "octree", NULL};
_Static_assert(sizeof view_names / sizeof view_names[0] == KD_VIEW_MODE_COUNT + 1, "a view without a name");

#define SETTING_DEFAULT(type, group, name, default_, min, max, words, unit, doc) .group##_##name = (default_),
static const kd_frame frame_default = {
    .dt_s = 1.0f / 30, .width = 640, .height = 360, .settings = {KD_SETTINGS_LIST(SETTING_DEFAULT)}};
#undef SETTING_DEFAULT

KD_COMPONENT_DEFINE_DEFAULT(kd_frame, "frame", &frame_default,
                            KD_FIELD_RANGE(kd_frame, dt_s, KD_F32, "s", 1e-6, 10,
                                           "length of a simulation step"),
                            KD_FIELD_RANGE(kd_frame, width, KD_U32, "pixels", 1, 16384, "picture width"),
                            KD_FIELD_RANGE(kd_frame, height, KD_U32, "pixels", 1, 16384, "picture height"),
                            KD_FIELD_ENUM(kd_frame, gi, gi_names, "technique that gathers indirect light"),
                            KD_FIELD_ENUM(kd_frame, view, view_names, "what the picture shows"));

bool kd_frame_needs_voxels(kd_system_context *context)
{
    return kd_singleton(context->world, kd_frame)->gi != KD_GI_NONE;
}
