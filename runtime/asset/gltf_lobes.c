/* What the extensions of materials add to metallic-roughness: another refractive index, a weaker or tinted
 * reflection, a coat of varnish, light that passes through. Their textures stand for their mean.
 * Source  KHR_materials_ior, KHR_materials_specular, KHR_materials_clearcoat, KHR_materials_transmission,
 * KHR_materials_pbrSpecularGlossiness */

#include <stdio.h>

#include "runtime/asset/gltf_loader.h"
#include "runtime/core/color.h"

typedef struct lobe_map {
    const char *name;
    int texture;
    int channel; /* -1: three, in sRGB */
    float *factor;
} lobe_map;

static void multiply_by_mean(const kd_image *image, int channel, float *factor)
{
    size_t count = (size_t)image->width * image->height;
    double sum[3] = {0, 0, 0};
    for (size_t i = 0; i < count; i++)
        for (int k = 0; k < 3; k++)
            sum[k] += channel < 0 ? (double)kd_color_from_srgb8[image->rgba[i * 4 + (size_t)k]]
                                  : image->rgba[i * 4 + (size_t)channel] / 255.0;
    for (int k = 0; k < (channel < 0 ? 3 : 1); k++)
        factor[k] *= (float)(sum[k] / (double)count);
}

static kd_status apply_map(gltf_loader *l, size_t material, const lobe_map *map)
{
    if (map->texture == -1)
        return KD_OK;
    if (map->texture < 0 || (size_t)map->texture >= l->doc.texture_count)
        return gltf_fail(l, KD_BAD_FORMAT,
                         "there is no texture %d (materials[%zu].%s); export the model again", map->texture,
                         material, map->name);
    int source = l->doc.textures[map->texture].source;
    if (source == -1) {
        gltf_warn(l, "materials[%zu].%s: textures[%d] has no picture in a format that is read; left out",
                  material, map->name, map->texture);
        return KD_OK;
    }
    if (source < 0 || (size_t)source >= l->doc.image_count)
        return gltf_fail(l, KD_BAD_FORMAT, "there is no image %d (textures[%d]); export the model again",
                         source, map->texture);
    uint32_t image;
    kd_status status = gltf_use_image(l, (size_t)source, &image);
    if (status)
        return status;
    gltf_warn(l, "materials[%zu].%s: the picture's mean stands for it", material, map->name);
    multiply_by_mean(&l->model->images[image], map->channel, map->factor);
    return KD_OK;
}

static float refractive_index(gltf_loader *l, const gltf_material *m, size_t material)
{
    if (m->ior == 0) /* by the extension: reflects everything */
        return 0;
    return gltf_factor(l, material, "ior", m->ior, 1, 1e3f);
}

/* A mask cuts what is left of a material; what lets light through is blended. */
static void set_transmission(gltf_loader *l, size_t material, kd_material_desc *out)
{
    if (out->transmission <= 0)
        return;
    if (out->alpha_mode == KD_ALPHA_MASK) {
        gltf_warn(l, "materials[%zu].transmissionFactor: left out, since the material has a mask", material);
        out->transmission = 0;
        return;
    }
    out->alpha_ignored = out->alpha_mode == KD_ALPHA_OPAQUE;
    out->alpha_mode = KD_ALPHA_BLEND;
}

kd_status gltf_load_lobes(gltf_loader *l, const gltf_material *m, size_t material, kd_material_desc *out)
{
    static const char *const colors[3] = {"specularColorFactor[0]", "specularColorFactor[1]",
                                          "specularColorFactor[2]"};
    if (out->unlit)
        return KD_OK;
    float color[3];
    float glossiness =
        m->glossiness < 0 ? 0 : gltf_factor(l, material, "glossinessFactor", m->glossiness, 0, 1);
    out->ior = refractive_index(l, m, material);
    out->specular = gltf_factor(l, material, "specularFactor", m->specular, 0, 1);
    for (int i = 0; i < 3; i++)
        color[i] = gltf_factor(l, material, colors[i], m->specular_color[i], 0, 1e3f);
    out->clearcoat = gltf_factor(l, material, "clearcoatFactor", m->clearcoat, 0, 1);
    out->clearcoat_roughness =
        gltf_factor(l, material, "clearcoatRoughnessFactor", m->clearcoat_roughness, 0, 1);
    out->transmission = gltf_factor(l, material, "transmissionFactor", m->transmission, 0, 1);
    const lobe_map maps[] = {
        {"specularTexture", m->specular_texture, 3, &out->specular},
        {"specularColorTexture", m->specular_color_texture, -1, color},
        {"clearcoatTexture", m->clearcoat_texture, 0, &out->clearcoat},
        {"clearcoatRoughnessTexture", m->clearcoat_roughness_texture, 1, &out->clearcoat_roughness},
        {"transmissionTexture", m->transmission_texture, 0, &out->transmission},
        {"specularGlossinessTexture", m->glossiness_texture, 3, &glossiness},
    };
    kd_status status = KD_OK;
    for (size_t i = 0; !status && i < sizeof maps / sizeof *maps; i++)
        status = apply_map(l, material, &maps[i]);
    if (m->clearcoat_normal_texture != -1)
        gltf_warn(l,
                  "materials[%zu].clearcoatNormalTexture is not read; the coat follows the surface under it",
                  material);
    if (m->glossiness >= 0)
        out->roughness = 1 - glossiness;
    out->specular_color = (kd_vec3){color[0], color[1], color[2]};
    if (!status)
        set_transmission(l, material, out);
    return status;
}
