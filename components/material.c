#include "components/material.h"

#include "shaders/shared/bindings.h"

#include <math.h>

enum { MAP_COUNT = 5 };

/* KHR_texture_transform: offset + rotation * scale, counter-clockwise in an image whose v points down. */
static void write_uv_transform(const kd_texture_ref *ref, struct kd_gl_vec4 rows[2])
{
    float c = cosf(ref->rotation), s = sinf(ref->rotation);
    rows[0] = (struct kd_gl_vec4){c * ref->scale.x, s * ref->scale.y, ref->offset.x, 0};
    rows[1] = (struct kd_gl_vec4){-s * ref->scale.x, c * ref->scale.y, ref->offset.y, 0};
}

/* What lets most of the light through leaves no voxels. */
static float alpha_cutoff(const kd_material_desc *desc)
{
    if (desc->transmission > 0)
        return desc->transmission > 0.5f ? 1e9f : desc->alpha_ignored ? -1 : 0.5f;
    switch (desc->alpha_mode) {
    case KD_ALPHA_MASK: return desc->alpha_cutoff;
    case KD_ALPHA_BLEND: return 0.5f;
    case KD_ALPHA_OPAQUE: break;
    }
    return -1;
}

/* Source  KHR_materials_ior, KHR_materials_specular */
static struct kd_gl_vec4 specular_of(const kd_material_desc *d)
{
    float r = d->ior > 0 ? (d->ior - 1) / (d->ior + 1) : 1, f0 = r * r;
    const kd_vec3 *c = &d->specular_color;
    return (struct kd_gl_vec4){fminf(f0 * c->x, 1) * d->specular, fminf(f0 * c->y, 1) * d->specular,
                               fminf(f0 * c->z, 1) * d->specular, d->specular};
}

bool kd_material_has_lobes(const kd_material_desc *d)
{
    const kd_vec3 *c = &d->specular_color;
    bool plain = d->ior == 1.5f && d->specular == 1 && c->x == 1 && c->y == 1 && c->z == 1;
    return !d->unlit && (!plain || d->clearcoat > 0 || d->transmission > 0);
}

struct kd_material_params kd_material_params_make(const kd_store_material *material)
{
    const kd_material_desc *d = &material->desc;
    const kd_texture_ref *refs[MAP_COUNT] = {&d->base_color_map, &d->metallic_roughness_map, &d->normal_map,
                                             &d->emissive_map, &d->occlusion_map};
    struct kd_material_params p = {
        .base_color = {d->base_color.x, d->base_color.y, d->base_color.z, d->base_color.w},
        .emissive = {d->emissive.x, d->emissive.y, d->emissive.z, alpha_cutoff(d)},
        .surface = {d->metallic, d->roughness, d->normal_scale, d->unlit ? 1.0f : 0.0f},
        .maps = {.z = d->double_sided ? 1 : 0, .w = d->alpha_ignored ? 1 : 0},
        .specular = specular_of(d),
        .lobes = {d->clearcoat, d->clearcoat_roughness, d->transmission, 0},
    };
    for (uint32_t i = 0; i < MAP_COUNT; i++) {
        write_uv_transform(refs[i], &p.uv_transform[i * 2]);
        if (material->maps[i].id == 0)
            continue;
        p.maps.x |= 1u << i;
        p.maps.y |= refs[i]->uv_set == 1 ? 1u << i : 0;
    }
    return p;
}

void kd_material_bind(kd_gpu *gpu, const kd_store_material *material)
{
    struct kd_material_params params = kd_material_params_make(material);
    kd_gpu_bind_uniform(gpu, KD_BIND_MATERIAL, &params, sizeof params);
    for (uint32_t i = 0; i < 5; i++)
        if (material->maps[i].id)
            kd_gpu_bind_texture(gpu, KD_UNIT_BASE_COLOR + i, material->maps[i]);
}
