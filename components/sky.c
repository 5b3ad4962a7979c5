#include "components/sky.h"

#include <stdlib.h>

#include "components/frame.h"
#include "components/transform.h"
#include "shaders/shared/bindings.h"
#include "shaders/shared/sky.h"

static const kd_sky sky_default = {.zenith = {0.25f, 0.45f, 0.9f},
                                   .horizon = {0.75f, 0.85f, 1},
                                   .ground = {0.25f, 0.22f, 0.2f},
                                   .intensity = 1};
KD_COMPONENT_DEFINE_DEFAULT(
    kd_sky, "sky", &sky_default, KD_FIELD(kd_sky, zenith, KD_COLOR, "W/(sr m^2)", "radiance straight up"),
    KD_FIELD(kd_sky, horizon, KD_COLOR, "W/(sr m^2)", "radiance at the horizon"),
    KD_FIELD(kd_sky, ground, KD_COLOR, "W/(sr m^2)", "radiance straight down"),
    KD_FIELD_RANGE(kd_sky, intensity, KD_F32, NULL, 0, 1e6, "factor on gradient or picture"),
    KD_FIELD(kd_sky, image, KD_U32, NULL, "number of its picture plus one; 0: the gradient"));

static void release_images(void *value, void *user)
{
    kd_sky_images *images = value;
    (void)user;
    for (uint32_t i = 0; i < images->count; i++)
        free((void *)(uintptr_t)images->maps[i].rgb);
    free(images->maps);
    free(images->suns);
    *images = (kd_sky_images){0};
}

static const kd_field image_fields[] = {
    KD_FIELD(kd_sky_images, count, KD_U32, NULL, "pictures"),
};
const kd_component_desc kd_sky_images_desc = {.name = "sky_images",
                                              .size = (uint32_t)sizeof(kd_sky_images),
                                              .align = (uint32_t) _Alignof(kd_sky_images),
                                              .fields = image_fields,
                                              .field_count = 1,
                                              .on_remove = release_images};

KD_COMPONENT_DEFINE_FLAGS(kd_sky_light, "sky_light", KD_COMPONENT_TRANSIENT,
                          KD_FIELD(kd_sky_light, map.id, KD_U32, NULL, "texture of the whole sky"));

uint32_t kd_sky_add_image(kd_world *w, kd_sky_map map)
{
    kd_sky_images *images = kd_singleton(w, kd_sky_images);
    kd_sky_map *maps = realloc(images->maps, (images->count + 1) * sizeof *maps);
    images->maps = maps != NULL ? maps : images->maps;
    kd_sky_sun *suns = realloc(images->suns, (images->count + 1) * sizeof *suns);
    images->suns = suns != NULL ? suns : images->suns;
    if (maps == NULL || suns == NULL) {
        free((void *)(uintptr_t)map.rgb);
        return 0;
    }
    maps[images->count] = map;
    suns[images->count] = (kd_sky_sun){0};
    return ++images->count;
}

void kd_sky_find_sun(kd_world *w, uint32_t image)
{
    kd_sky_images *images = kd_singleton(w, kd_sky_images);
    if (image > 0 && image <= images->count)
        kd_sky_sun_find(&images->maps[image - 1], &images->suns[image - 1]);
}

const kd_sky_sun *kd_sky_sun_of(kd_world *w, const kd_sky *sky)
{
    const kd_sky_images *images = kd_singleton(w, kd_sky_images);
    if (sky->image == 0 || sky->image > images->count)
        return NULL;
    const kd_sky_sun *sun = &images->suns[sky->image - 1];
    return kd_vec3_dot(sun->direction, sun->direction) > 0 ? sun : NULL;
}

/* Lights shine along -Z: +Z looks at the sun. */
static kd_mat4 looking_along(kd_vec3 z)
{
    kd_vec3 hint = z.y * z.y < 0.8f ? (kd_vec3){0, 1, 0} : (kd_vec3){1, 0, 0};
    kd_vec3 x = kd_vec3_normalize(kd_vec3_cross(hint, z), (kd_vec3){1, 0, 0}), y = kd_vec3_cross(z, x);
    return (kd_mat4){{x.x, x.y, x.z, 0, y.x, y.y, y.z, 0, z.x, z.y, z.z, 0, 0, 0, 0, 1}};
}

bool kd_sky_sun_light(kd_world *w, kd_query *skies, kd_light *light, kd_mat4 *world)
{
    kd_sky sky;
    kd_mat4 turned;
    kd_vec3 rows[3];
    if (!kd_singleton(w, kd_frame)->settings.light_sky_sun || !kd_sky_pick(skies, &sky, &turned))
        return false;
    const kd_sky_sun *sun = kd_sky_sun_of(w, &sky);
    if (sun == NULL || !(sky.intensity > 0))
        return false;
    kd_sky_rows(&turned, rows);
    kd_vec3 d = sun->direction;
    *light = (kd_light){.type = KD_DIRECTIONAL, .color = sun->irradiance, .intensity = sky.intensity};
    *world = looking_along(
        kd_vec3_normalize(kd_vec3_add(kd_vec3_scale(rows[0], d.x),
                                      kd_vec3_add(kd_vec3_scale(rows[1], d.y), kd_vec3_scale(rows[2], d.z))),
                          (kd_vec3){0, 1, 0}));
    return true;
}

bool kd_sky_pick(kd_query *query, kd_sky *sky, kd_mat4 *world)
{
    uint32_t lowest = UINT32_MAX;
    for (kd_iter it = kd_query_iter(query); kd_iter_next(&it);) {
        const kd_sky *skies = KD_COLUMN(&it, kd_sky, 0);
        const kd_world_transform *worlds = KD_COLUMN(&it, kd_world_transform, 1);
        for (uint32_t i = 0; i < it.count; i++) {
            if (it.entities[i].index >= lowest)
                continue;
            lowest = it.entities[i].index;
            *sky = skies[i];
            *world = worlds[i].matrix;
        }
    }
    return lowest != UINT32_MAX;
}

kd_sky_map kd_sky_map_of(kd_world *w, const kd_sky *sky, float *gradient)
{
    const kd_sky_images *images = kd_singleton(w, kd_sky_images);
    if (sky->image > 0 && sky->image <= images->count)
        return images->maps[sky->image - 1];
    kd_sky_gradient(sky->zenith, sky->horizon, sky->ground, gradient);
    return (kd_sky_map){KD_SKY_GRADIENT_WIDTH, KD_SKY_GRADIENT_HEIGHT, gradient};
}

void kd_sky_rows(const kd_mat4 *world, kd_vec3 rows[3])
{
    static const kd_vec3 axes[3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    for (int i = 0; i < 3; i++) {
        const float *m = world->m + 4 * i;
        rows[i] = kd_vec3_normalize((kd_vec3){m[0], m[1], m[2]}, axes[i]);
    }
}

void kd_sky_bind(kd_gpu *gpu, const kd_sky_light *sky)
{
    kd_gpu_bind_uniform_buffer(gpu, KD_BIND_SKY, sky->uniform, 0, sizeof(struct kd_sky_params));
    kd_gpu_bind_texture(gpu, KD_UNIT_SKY_MAP, sky->map);
    kd_gpu_bind_texture(gpu, KD_UNIT_SKY_CONES, sky->cones);
}
