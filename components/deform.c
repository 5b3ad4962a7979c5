#include "components/deform.h"

static void release_palette(void *value, void *user)
{
    kd_joint_palette *palette = value;
    (void)user;
    if (palette->release)
        palette->release(palette);
}

static const kd_field palette_fields[] = {
    KD_FIELD(kd_joint_palette, count, KD_U32, NULL, "joint matrices of this frame"),
};
const kd_component_desc kd_joint_palette_desc = {.name = "joint_palette",
                                                 .size = (uint32_t)sizeof(kd_joint_palette),
                                                 .align = (uint32_t) _Alignof(kd_joint_palette),
                                                 .fields = palette_fields,
                                                 .field_count = 1,
                                                 .on_remove = release_palette};
