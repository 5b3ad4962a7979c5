/* Materials read at a point, as shaders/include/material.glsl does, with bilinear maps at full resolution:
 * the mean over many samples does what mip levels do. */

#include "components/material.h"

#include <math.h>

#include "runtime/core/color.h"
#include "runtime/reference/internal.h"
#include "systems/scene/scene.h"

void reference_material_make(const kd_scene_store *store, uint32_t number, bool lambert,
                             reference_material *out)
{
    kd_store_material material = store->materials[number];
    const kd_material_desc *d = &material.desc;
    const kd_texture_ref *refs[5] = {&d->base_color_map, &d->metallic_roughness_map, &d->normal_map,
                                     &d->emissive_map, &d->occlusion_map};
    *out = (reference_material){.alpha_mode = d->alpha_mode};
    for (int i = 0; i < 5; i++) {
        const kd_image *image = kd_scene_image(store, refs[i]->image);
        out->maps[i] = (reference_map){
            image, refs[i]->wrap_s, refs[i]->wrap_t, refs[i]->nearest, i == 0 || i == 3, lambert};
        material.maps[i].id = image != NULL; /* present, whether or not a GPU has it */
    }
    out->params = kd_material_params_make(&material);
    out->emits = d->emissive.x > 0 || d->emissive.y > 0 || d->emissive.z > 0;
}

/* `i` is within two sizes of the map, see in_texels: no division is needed. */
static uint32_t wrapped(int32_t i, uint32_t size, kd_wrap_mode mode)
{
    int32_t n = (int32_t)size, period = 2 * n;
    if (mode == KD_WRAP_CLAMP)
        return (uint32_t)(i < 0 ? 0 : i >= n ? n - 1 : i);
    i = i < 0 ? i + period : i >= period ? i - period : i;
    if (i < n)
        return (uint32_t)i;
    return (uint32_t)(mode == KD_WRAP_MIRROR ? period - 1 - i : i - n);
}

static kd_vec4 texel(const reference_map *m, int32_t x, int32_t y)
{
    const kd_image *image = m->image;
    size_t row = wrapped(y, image->height, m->wrap_t), column = wrapped(x, image->width, m->wrap_s);
    const uint8_t *t = image->rgba + (row * image->width + column) * 4;
    if (m->srgb && !m->late_decode)
        return (kd_vec4){kd_color_from_srgb8[t[0]], kd_color_from_srgb8[t[1]], kd_color_from_srgb8[t[2]],
                         (float)t[3] / 255};
    return (kd_vec4){(float)t[0] / 255, (float)t[1] / 255, (float)t[2] / 255, (float)t[3] / 255};
}

static kd_vec4 mix(kd_vec4 a, kd_vec4 b, float t)
{
    return (kd_vec4){a.x + (b.x - a.x) * t, a.y + (b.y - a.y) * t, a.z + (b.z - a.z) * t,
                     a.w + (b.w - a.w) * t};
}

/* A coordinate in texels, 0 … twice the size: a mirrored map has a period of two. Far out a float has no
 * fraction left, and infinity has no texel. */
static float in_texels(float uv, uint32_t size)
{
    float x = (uv - floorf(uv * 0.5f) * 2) * (float)size;
    return x >= 0 && x <= 2 * (float)size ? x : 0;
}

static kd_vec4 sample(const reference_map *m, kd_vec2 uv)
{
    bool clamp_s = m->wrap_s == KD_WRAP_CLAMP, clamp_t = m->wrap_t == KD_WRAP_CLAMP;
    float x = in_texels(clamp_s ? fminf(fmaxf(uv.x, 0), 1) : uv.x, m->image->width);
    float y = in_texels(clamp_t ? fminf(fmaxf(uv.y, 0), 1) : uv.y, m->image->height);
    if (m->nearest)
        x = floorf(x) + 0.5f, y = floorf(y) + 0.5f;
    float left = floorf(x - 0.5f), top = floorf(y - 0.5f), fx = x - 0.5f - left, fy = y - 0.5f - top;
    int32_t x0 = (int32_t)left, y0 = (int32_t)top;
    kd_vec4 above = mix(texel(m, x0, y0), texel(m, x0 + 1, y0), fx);
    kd_vec4 below = mix(texel(m, x0, y0 + 1), texel(m, x0 + 1, y0 + 1), fx);
    kd_vec4 c = mix(above, below, fy);
    if (m->srgb && m->late_decode)
        return (kd_vec4){kd_color_srgb_decode(c.x), kd_color_srgb_decode(c.y), kd_color_srgb_decode(c.z),
                         c.w};
    return c;
}

/* White where the material has no such map. */
static kd_vec4 map(const reference_material *m, uint32_t index, const reference_attributes *a)
{
    if (!m->maps[index].image)
        return (kd_vec4){1, 1, 1, 1};
    kd_vec2 uv = a->uv[m->params.maps.y >> index & 1];
    const struct kd_gl_vec4 *r = &m->params.uv_transform[index * 2];
    return sample(&m->maps[index],
                  (kd_vec2){r[0].x * uv.x + r[0].y * uv.y + r[0].z, r[1].x * uv.x + r[1].y * uv.y + r[1].z});
}

kd_vec4 reference_base_color(const reference_material *m, const reference_attributes *a)
{
    kd_vec4 t = map(m, 0, a);
    const struct kd_gl_vec4 *c = &m->params.base_color;
    return (kd_vec4){c->x * a->color.x * t.x, c->y * a->color.y * t.y, c->z * a->color.z * t.z,
                     c->w * a->color.w * t.w};
}

kd_vec2 reference_metallic_roughness(const reference_material *m, const reference_attributes *a)
{
    kd_vec4 t = map(m, 1, a);
    return (kd_vec2){m->params.surface.x * t.z, m->params.surface.y * t.y};
}

bool reference_normal_map(const reference_material *m, const reference_attributes *a, kd_vec3 *n)
{
    if (!m->maps[2].image)
        return false;
    const float scale = 255.0f / 127, offset = 128.0f / 127; /* byte 128 is exactly 0 */
    kd_vec4 t = map(m, 2, a);
    *n = (kd_vec3){(t.x * scale - offset) * m->params.surface.z, (t.y * scale - offset) * m->params.surface.z,
                   t.z * scale - offset};
    return true;
}

kd_vec3 reference_emission(const reference_material *m, const reference_attributes *a)
{
    kd_vec4 t = m->emits ? map(m, 3, a) : (kd_vec4){0, 0, 0, 0};
    const struct kd_gl_vec4 *e = &m->params.emissive;
    return (kd_vec3){e->x * t.x, e->y * t.y, e->z * t.z};
}

static float clamp01(float x)
{
    return x > 0 ? (x < 1 ? x : 1) : 0;
}

void reference_material_at(const reference_material *m, const reference_attributes *a, reference_surface *out)
{
    const struct kd_material_params *p = &m->params;
    kd_vec4 base = reference_base_color(m, a);
    kd_vec2 mr = reference_metallic_roughness(m, a);
    out->albedo = (kd_vec3){clamp01(base.x), clamp01(base.y), clamp01(base.z)};
    out->opacity = reference_opacity(m, base.w);
    out->metallic = clamp01(mr.x);
    out->roughness = clamp01(mr.y);
    out->unlit = p->surface.w > 0.5f;
    out->shown = (kd_vec3){base.x, base.y, base.z};
    out->f0 = (kd_vec3){p->specular.x, p->specular.y, p->specular.z};
    out->f90 = p->specular.w;
    out->coat = p->lobes.x;
    out->coat_roughness = p->lobes.y;
    out->transmission = p->lobes.z;
}

float reference_opacity(const reference_material *m, float alpha)
{
    if (m->alpha_mode == KD_ALPHA_OPAQUE || m->params.maps.w)
        return 1;
    if (m->alpha_mode == KD_ALPHA_MASK)
        return alpha < m->params.emissive.w ? 0 : 1;
    return alpha > 0 ? (alpha < 1 ? alpha : 1) : 0;
}
