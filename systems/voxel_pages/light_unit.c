/* How bright the scene is, for the numbers that the tree stores. */
#include "systems/voxel_pages/light_unit.h"

#include <math.h>

#include "components/light.h"
#include "components/sky.h"

float brightest_emission(const kd_scene_store *store, const kd_draw_list *drawn)
{
    float best = 0;
    for (uint32_t i = 0; i < drawn->batch_count; i++) {
        kd_vec3 e = store->materials[drawn->batches[i].material].desc.emissive;
        if (drawn->batches[i].voxels)
            best = fmaxf(best, fmaxf(e.x, fmaxf(e.y, e.z)));
    }
    return best;
}

/* Radiance that a white surface near to a light sends out. */
static float sent_out(const kd_light *light)
{
    const float near_m = 0.25f;
    float color = fmaxf(light->color.x, fmaxf(light->color.y, light->color.z));
    float e = light->intensity * color / (light->type == KD_DIRECTIONAL ? 1.0f : near_m * near_m);
    return e * (1 / 3.14159265f);
}

float stored_unit(kd_world *w, kd_query *lights, kd_query *skies, float emission)
{
    const float comfortable = 1024;
    float best = emission;
    kd_light sun;
    kd_mat4 at;
    for (kd_iter it = kd_query_iter(lights); kd_iter_next(&it);) {
        const kd_light *light = KD_COLUMN(&it, kd_light, 0);
        for (uint32_t i = 0; i < it.count; i++)
            best = fmaxf(best, sent_out(&light[i]));
    }
    if (kd_sky_sun_light(w, skies, &sun, &at))
        best = fmaxf(best, sent_out(&sun));
    return best > comfortable && isfinite(best) ? exp2f(ceilf(log2f(best / comfortable))) : 1.0f;
}
