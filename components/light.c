#include "components/light.h"

static const char *const light_types[] = {"directional", "point", "spot", NULL};
static const kd_light light_default = {
    .type = KD_DIRECTIONAL, .color = {1, 1, 1}, .intensity = 3, .outer_cone = 0.785398163f /* pi/4 */};
KD_COMPONENT_DEFINE_DEFAULT(
    kd_light, "light", &light_default, KD_FIELD_ENUM(kd_light, type, light_types, "kind of light"),
    KD_FIELD(kd_light, color, KD_COLOR, NULL, "linear colour"),
    KD_FIELD_RANGE(kd_light, intensity, KD_F32, "lx or cd", 0, 1e6,
                   "illuminance of directional lights, luminous intensity of point and spot lights"),
    KD_FIELD_RANGE(kd_light, range, KD_F32, "m", 0, 1e6, "distance at which it ends; 0: no limit"),
    KD_FIELD_RANGE(kd_light, inner_cone, KD_F32, "rad", 0, 1.5707964,
                   "half angle up to which a spot is full"),
    KD_FIELD_RANGE(kd_light, outer_cone, KD_F32, "rad", 0, 1.5707964, "half angle at which a spot ends"),
    KD_FIELD(kd_light, no_shadow, KD_BOOL, NULL, "shines through everything"));
