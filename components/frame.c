#include "components/frame.h"

static const char *const gi_names[] = {"cones", "none", NULL};
static const char *const view_names[] = {"final",  "direct", "indirect", "ao",    "specular",
                                         "albedo", "normal", "depth",    "light", "caches",
                                         "pages",  "octree", "lookup",   "cost",  NULL};
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

bool kd_frame_shows_voxels(const kd_frame *frame)
{
    return frame->view >= KD_VIEW_CACHES && frame->view <= KD_VIEW_LOOKUP;
}

kd_view_channel kd_frame_channel(const kd_frame *frame)
{
    if (frame->settings.view_channel != KD_CHANNEL_AUTO)
        return (kd_view_channel)frame->settings.view_channel;
    return frame->view == KD_VIEW_CACHES || frame->view == KD_VIEW_PAGES ? KD_CHANNEL_ALBEDO
                                                                         : KD_CHANNEL_RADIANCE;
}

bool kd_frame_needs_voxels(kd_system_context *context)
{
    const kd_frame *frame = kd_singleton(context->world, kd_frame);
    return frame->gi != KD_GI_NONE || kd_frame_shows_voxels(frame);
}
