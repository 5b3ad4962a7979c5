#ifndef KD_COMPONENTS_LIGHT_H
#define KD_COMPONENTS_LIGHT_H

#include <stdbool.h>

#include "runtime/core/math.h"
#include "runtime/ecs/world.h"
#include "shaders/shared/scene.h"

typedef enum kd_light_kind { KD_DIRECTIONAL, KD_POINT, KD_SPOT } kd_light_kind;

/* A light at the entity's world transform, shining along its -Z (KHR_lights_punctual). */
typedef struct kd_light {
    uint32_t type;    /* kd_light_kind */
    kd_vec3 color;    /* linear */
    float intensity;  /* lx (directional), cd (point, spot) */
    float range;      /* m; 0: no limit */
    float inner_cone; /* rad, half angle */
    float outer_cone; /* rad, half angle */
    bool no_shadow;
} kd_light;
KD_COMPONENT_DECLARE(kd_light); /* default: directional, white, 3 lx, cones 0 and pi/4 */

/* Nearer to a point or spot light, a source without extent has no meaning: of the scene's diagonal, and at
 * most, so that one thing far away does not dim all lamps [m]. */
#define KD_LAMP_SIZE      1e-4f
#define KD_LAMP_SIZE_MOST 0.05f

static inline float kd_lamp_size(float diagonal)
{
    float size = KD_LAMP_SIZE * diagonal;
    return size < KD_LAMP_SIZE_MOST ? size : KD_LAMP_SIZE_MOST;
}

/** Write a light at a world transform as shaders read it, without shadow maps (shadow.x is -1). */
struct kd_light_params kd_light_params_make(const kd_light *light, const kd_mat4 *world);

#endif
