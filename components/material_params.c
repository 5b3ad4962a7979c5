#include "components/material_params.h"

#include <math.h>

#include "shaders/shared/bindings.h"

static void uv_rows(const kd_texture_ref *map, kd_gl_vec4 rows[2])
{
    float c = cosf(map->rotation), s = sinf(map->rotation);
    rows[0] = (kd_gl_vec4){c * map->scale.x, s * map->scale.y, map->offset.x, 0};
    rows[1] = (kd_gl_vec4){-s * map->scale.x, c * map->scale.y, map->offset.y, 0};
}

struct kd_material_params kd_material_params_of(const kd_store_material *material)
{
    const kd_material_desc *d = &material->desc;
    const kd_texture_ref *maps[5] = {&d->base_color_map, &d->metallic_roughness_map, &d->normal_map, &d->emissive_map,
                                     &d->occlusion_map};
    struct kd_material_params p = {
        .base_color = {d->base_color.x, d->base_color.y, d->base_color.z, d->base_color.w},
        .emissive = {d->emissive.x, d->emissive.y, d->emissive.z,
                     d->alpha_mode == KD_ALPHA_MASK    ? d->alpha_cutoff
                     : d->alpha_mode == KD_ALPHA_BLEND ? 0.5f
                                                       : -1.0f},
        .surface = {d->metallic, d->roughness, d->normal_scale, d->unlit ? 1.0f : 0.0f},
        .maps = {0, 0, d->double_sided, 0},
    };
    for (uint32_t i = 0; i < 5; i++) {
        uv_rows(maps[i], &p.uv_transform[2 * i]);
        if (material->maps[i].id)
            p.maps.x |= 1u << i;
        if (maps[i]->uv_set == 1)
            p.maps.y |= 1u << i;
    }
    return p;
}

void kd_material_bind(kd_gpu *gpu, const kd_store_material *material)
{
    struct kd_material_params params = kd_material_params_of(material);
    kd_gpu_bind_uniform(gpu, KD_BIND_MATERIAL, &params, sizeof params);
    for (uint32_t i = 0; i < 5; i++)
        if (material->maps[i].id)
            kd_gpu_bind_texture(gpu, KD_UNIT_BASE_COLOR + i, material->maps[i]);
}
