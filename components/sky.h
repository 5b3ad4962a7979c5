#ifndef KD_COMPONENTS_SKY_H
#define KD_COMPONENTS_SKY_H

#include "components/light.h"
#include "components/sky_map.h"
#include "components/sky_sun.h"
#include "runtime/ecs/query.h"
#include "runtime/ecs/world.h"
#include "runtime/gpu/gpu.h"

/* What surrounds the scene: a gradient, or a picture, which stands as the entity is turned and is not touched
 * by the colours. It comes on top of the setting light.ambient. The one with the lowest entity index is used.
 */
typedef struct kd_sky {
    kd_vec3 zenith, horizon, ground; /* radiance, linear: straight up, level, straight down */
    float intensity;                 /* factor */
    uint32_t image;                  /* of kd_sky_images, plus one; 0: the gradient */
} kd_sky;
KD_COMPONENT_DECLARE(kd_sky); /* default: a clear day's blue, factor 1 */

/* Singleton: the pictures of skies. They stay while the world lives. */
typedef struct kd_sky_images {
    uint32_t count;
    kd_sky_map *maps;
    kd_sky_sun *suns; /* beside them; zero where none was looked for or found */
} kd_sky_images;
KD_COMPONENT_DECLARE(kd_sky_images);

/** Take a picture over (its texels are freed with free()). Returns its number plus one; 0 when memory is out,
 * and the texels are freed. */
uint32_t kd_sky_add_image(kd_world *w, kd_sky_map map);

/** Look for the sun of a picture, which then shines as a light (kd_sky_sun_light). */
void kd_sky_find_sun(kd_world *w, uint32_t image);

/** Get the sky that is used among those that a query of (kd_sky, kd_world_transform) finds. Returns false
 * when there is none. */
bool kd_sky_pick(kd_query *query, kd_sky *sky, kd_mat4 *world);
/** The sky's picture, or its gradient, drawn into `gradient` (3 floats for each texel of such a map). */
kd_sky_map kd_sky_map_of(kd_world *w, const kd_sky *sky, float *gradient);
/** The sun of the sky that is used as a directional light and its world transform. Returns false when it has
 * none or the setting light.sky_sun is off. */
bool kd_sky_sun_light(kd_world *w, kd_query *skies, kd_light *light, kd_mat4 *world);
/** The sun in the sky's picture, or NULL. */
const kd_sky_sun *kd_sky_sun_of(kd_world *w, const kd_sky *sky);
/** Rows of the rotation that takes directions of the world to the map's. */
void kd_sky_rows(const kd_mat4 *world, kd_vec3 rows[3]);

/* Singleton, resource "sky", system sky: what shaders/include/sky.glsl reads. */
typedef struct kd_sky_light {
    kd_gpu_buffer uniform; /* kd_sky_params, block KD_BIND_SKY */
    kd_gpu_texture map;    /* KD_UNIT_SKY_MAP */
    kd_gpu_texture cones;  /* KD_UNIT_SKY_CONES */
    uint32_t version;      /* another when it looks otherwise */
} kd_sky_light;
KD_COMPONENT_DECLARE(kd_sky_light);

/** Bind block and textures. Threading: GPU lane */
void kd_sky_bind(kd_gpu *gpu, const kd_sky_light *sky);

#endif
