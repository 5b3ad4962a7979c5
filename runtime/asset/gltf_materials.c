/* Materials, and the pictures they use: what no material uses is not decoded. */

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "runtime/asset/gltf_loader.h"
#include "runtime/asset/image.h"

enum { GL_NEAREST = 9728, GL_NEAREST_MIPMAP_NEAREST = 9984, GL_NEAREST_MIPMAP_LINEAR = 9986 };
enum { GL_CLAMP_TO_EDGE = 33071, GL_MIRRORED_REPEAT = 33648 };

static kd_status image_bytes(gltf_loader *l, size_t index, const char *where, const uint8_t **bytes,
                             size_t *size)
{
    const gltf_image *image = &l->doc.images[index];
    if (image->uri)
        return gltf_load_uri(l, image->uri, where, bytes, size);
    if (image->view < 0 || (size_t)image->view >= l->doc.view_count)
        return gltf_fail(l, KD_BAD_FORMAT, "its buffer view is not there (%s); export the model again",
                         where);
    const gltf_view *view = &l->doc.views[image->view];
    *bytes = gltf_view_bytes(l, view);
    if (!*bytes)
        return gltf_fail(l, KD_BAD_FORMAT,
                         "its buffer has neither a URI nor a binary chunk (%s); export the model again",
                         where);
    *size = (size_t)view->length;
    return KD_OK;
}

static kd_status load_image(gltf_loader *l, size_t index, kd_image *out)
{
    char where[48];
    const uint8_t *bytes = NULL;
    size_t size = 0;
    snprintf(where, sizeof where, "images[%zu]", index);
    kd_status status = image_bytes(l, index, where, &bytes, &size);
    if (status)
        return status;
    image_info info;
    const char *error = "";
    status = image_measure(bytes, size, &info, &error);
    if (status)
        return gltf_fail(l, status, "%s (%s)", error, where);
    uint8_t *rgba;
    status = gltf_alloc(l, &l->kept, (size_t)info.width * info.height, 4, &rgba);
    if (status)
        return status;
    status = image_decode(bytes, size, &info, rgba, &error);
    if (status)
        return gltf_fail(l, status, "%s (%s); export the picture again", error, where);
    *out = (kd_image){gltf_name(l, l->doc.images[index].name, "image", index), info.width, info.height, rgba};
    return KD_OK;
}

kd_status gltf_use_image(gltf_loader *l, size_t index, uint32_t *out)
{
    if (l->image_of[index] == KD_NONE) {
        kd_image *images = (kd_image *)l->model->images; /* made by this step, const for readers */
        kd_status status = load_image(l, index, &images[l->model->image_count]);
        if (status)
            return status;
        l->image_of[index] = l->model->image_count++;
    }
    *out = l->image_of[index];
    return KD_OK;
}

static kd_wrap_mode wrap_mode(int gl)
{
    return gl == GL_CLAMP_TO_EDGE     ? KD_WRAP_CLAMP
           : gl == GL_MIRRORED_REPEAT ? KD_WRAP_MIRROR
                                      : KD_WRAP_REPEAT;
}

static void set_sampler(kd_texture_ref *out, const gltf_sampler *sampler)
{
    out->wrap_s = wrap_mode(sampler->wrap_s);
    out->wrap_t = wrap_mode(sampler->wrap_t);
    out->nearest = sampler->mag_filter == GL_NEAREST ||
                   (sampler->mag_filter == -1 &&
                    (sampler->min_filter == GL_NEAREST || sampler->min_filter == GL_NEAREST_MIPMAP_NEAREST ||
                     sampler->min_filter == GL_NEAREST_MIPMAP_LINEAR));
}

static kd_status set_texture(gltf_loader *l, const gltf_texture_use *use, const char *where,
                             kd_texture_ref *out)
{
    const gltf_texture *texture = &l->doc.textures[use->texture];
    if (texture->sampler != -1) {
        if (texture->sampler < 0 || (size_t)texture->sampler >= l->doc.sampler_count)
            return gltf_fail(l, KD_BAD_FORMAT,
                             "there is no sampler %d (textures[%d]); export the model again",
                             texture->sampler, use->texture);
        set_sampler(out, &l->doc.samplers[texture->sampler]);
    }
    if (texture->source == -1) {
        gltf_warn(l, "%s: textures[%d] has no picture in a format that is read; left out", where,
                  use->texture);
        return KD_OK;
    }
    if (texture->source < 0 || (size_t)texture->source >= l->doc.image_count)
        return gltf_fail(l, KD_BAD_FORMAT, "there is no image %d (textures[%d]); export the model again",
                         texture->source, use->texture);
    return gltf_use_image(l, (size_t)texture->source, &out->image);
}

static kd_status load_texture(gltf_loader *l, const gltf_texture_use *use, size_t material, const char *map,
                              kd_texture_ref *out)
{
    char where[80];
    snprintf(where, sizeof where, "materials[%zu].%s", material, map);
    if (use->texture == -1)
        return KD_OK;
    if (use->texture < 0 || (size_t)use->texture >= l->doc.texture_count)
        return gltf_fail(l, KD_BAD_FORMAT, "there is no texture %d (%s); export the model again",
                         use->texture, where);
    float numbers[5];
    double from[5] = {use->offset[0], use->offset[1], use->scale[0], use->scale[1], use->rotation};
    if (!gltf_floats(from, 5, numbers))
        return gltf_fail(l, KD_BAD_FORMAT, "the texture transform is not finite (%s); export the model again",
                         where);
    if (use->uv_set < 0)
        return gltf_fail(l, KD_BAD_FORMAT,
                         "the texture coordinate set is negative (%s); export the model again", where);
    if (use->uv_set > 1) {
        gltf_warn(l, "%s: texture coordinate set %d is not read, only 0 and 1; the map is left out", where,
                  use->uv_set);
        return KD_OK;
    }
    out->uv_set = (uint32_t)use->uv_set;
    out->offset = (kd_vec2){numbers[0], numbers[1]};
    out->scale = (kd_vec2){numbers[2], numbers[3]};
    out->rotation = numbers[4];
    return set_texture(l, use, where, out);
}

float gltf_factor(gltf_loader *l, size_t material, const char *name, double value, float low, float high)
{
    float f = (float)value;
    if (f >= low && f <= high)
        return f;
    gltf_warn(l, "materials[%zu].%s: %g lies outside %g to %g and is clamped", material, name, value,
              (double)low, (double)high);
    return f > high ? high : low;
}

static kd_status load_maps(gltf_loader *l, const gltf_material *m, size_t index, kd_material_desc *out)
{
    kd_status status = load_texture(l, &m->base_color_map, index, "baseColorTexture", &out->base_color_map);
    if (!status)
        status = load_texture(l, &m->metallic_roughness_map, index, "metallicRoughnessTexture",
                              &out->metallic_roughness_map);
    if (!status)
        status = load_texture(l, &m->normal_map, index, "normalTexture", &out->normal_map);
    if (!status)
        status = load_texture(l, &m->occlusion_map, index, "occlusionTexture", &out->occlusion_map);
    if (!status)
        status = load_texture(l, &m->emissive_map, index, "emissiveTexture", &out->emissive_map);
    return status;
}

static kd_status load_alpha(gltf_loader *l, const gltf_material *m, size_t index, kd_material_desc *out)
{
    out->alpha_cutoff = gltf_factor(l, index, "alphaCutoff", m->alpha_cutoff, 0, 1e9f);
    if (strcmp(m->alpha_mode, "MASK") == 0)
        out->alpha_mode = KD_ALPHA_MASK;
    else if (strcmp(m->alpha_mode, "BLEND") == 0)
        out->alpha_mode = KD_ALPHA_BLEND;
    else if (strcmp(m->alpha_mode, "OPAQUE") != 0)
        return gltf_fail(l, KD_BAD_FORMAT,
                         "'%.40s' is no alpha mode (materials[%zu]); use OPAQUE, MASK or BLEND",
                         m->alpha_mode, index);
    return KD_OK;
}

static kd_status load_material(gltf_loader *l, size_t index, kd_material_desc *out)
{
    static const char *const channels[4] = {"baseColorFactor[0]", "baseColorFactor[1]", "baseColorFactor[2]",
                                            "baseColorFactor[3]"};
    const gltf_material *m = &l->doc.materials[index];
    *out = kd_material_default();
    out->name = gltf_name(l, m->name, "material", index);
    float color[4], emissive[3];
    for (int i = 0; i < 4; i++)
        color[i] = gltf_factor(l, index, channels[i], m->base_color[i], 0, 1);
    out->base_color = (kd_vec4){color[0], color[1], color[2], color[3]};
    out->metallic = gltf_factor(l, index, "metallicFactor", m->metallic, 0, 1);
    out->roughness = gltf_factor(l, index, "roughnessFactor", m->roughness, 0, 1);
    /* 1e9 times white outshines the sun's disc seen from space, and its products stay finite. */
    float strength = gltf_factor(l, index, "emissiveStrength", m->emissive_strength, 0, 1e9f);
    for (int i = 0; i < 3; i++)
        emissive[i] = strength * gltf_factor(l, index, "emissiveFactor", m->emissive[i], 0, 1);
    out->emissive = (kd_vec3){emissive[0], emissive[1], emissive[2]};
    out->normal_scale = gltf_factor(l, index, "normalTexture.scale", m->normal_map.strength, -1e6f, 1e6f);
    out->occlusion_strength =
        gltf_factor(l, index, "occlusionTexture.strength", m->occlusion_map.strength, 0, 1);
    out->double_sided = m->double_sided;
    out->unlit = m->unlit;
    kd_status status = load_alpha(l, m, index, out);
    if (!status)
        status = load_maps(l, m, index, out);
    return status ? status : gltf_load_lobes(l, m, index, out);
}

kd_status gltf_load_materials(gltf_loader *l)
{
    kd_material_desc *materials;
    kd_image *images;
    kd_status status = gltf_alloc(l, &l->kept, l->doc.material_count, sizeof *materials, &materials);
    if (!status)
        status = gltf_alloc(l, &l->kept, l->doc.image_count, sizeof *images, &images);
    if (status)
        return status;
    l->model->images = images;
    l->model->materials = materials;
    for (size_t i = 0; !status && i < l->doc.material_count; i++)
        status = load_material(l, i, &materials[i]);
    l->model->material_count = (uint32_t)l->doc.material_count;
    return status;
}
