/* How bright the scene is, for the numbers that the tree stores. */
#include "systems/voxel_pages/light_unit.h"

#include <math.h>

#include "components/light.h"

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

float stored_unit(kd_query *lights, float emission)
{
    const float near_m = 0.25f, comfortable = 1024;
    float best = emission;
    for (kd_iter it = kd_query_iter(lights); kd_iter_next(&it);) {
        const kd_light *light = KD_COLUMN(&it, kd_light, 0);
        for (uint32_t i = 0; i < it.count; i++) {
            float color = fmaxf(light[i].color.x, fmaxf(light[i].color.y, light[i].color.z));
            float e = light[i].intensity * color / (light[i].type == KD_DIRECTIONAL ? 1.0f : near_m * near_m);
            best = fmaxf(best, e * (1 / 3.14159265f));
        }
    }
    return best > comfortable && isfinite(best) ? exp2f(ceilf(log2f(best / comfortable))) : 1.0f;
}
