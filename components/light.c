#include "components/light.h"

#include <math.h>

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

static struct kd_gl_vec4 row(kd_vec3 v, float w)
{
    return (struct kd_gl_vec4){v.x, v.y, v.z, w};
}

/* Turn cone angles into scale and offset of the cosine. Source  KHR_lights_punctual */
static void fill_cone(struct kd_light_params *p, const kd_light *light)
{
    float inner = cosf(light->inner_cone), outer = cosf(light->outer_cone);
    p->color.w = 1 / fmaxf(inner - outer, 1e-3f);
    p->shadow.w = -outer * p->color.w;
}

struct kd_light_params kd_light_params_make(const kd_light *light, const kd_mat4 *world)
{
    kd_vec3 position = {world->m[12], world->m[13], world->m[14]};
    kd_vec3 forward =
        kd_vec3_normalize((kd_vec3){-world->m[8], -world->m[9], -world->m[10]}, (kd_vec3){0, 0, -1});
    struct kd_light_params p = {
        .position_ws = row(position, light->type == KD_DIRECTIONAL ? 0 : light->range),
        .direction_ws = row(forward, (float)light->type),
        .color = row(kd_vec3_scale(light->color, light->intensity), 0),
        .shadow = {-1, 0, 0, 0},
    };
    if (light->type == KD_SPOT)
        fill_cone(&p, light);
    return p;
}
