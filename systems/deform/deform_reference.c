/* The deform pass in C: what tests hold the shader against. */

#include "systems/deform/deform_reference.h"

#include <math.h>
#include <string.h>

typedef struct vertex {
    kd_vec3 position, normal;
    kd_vec4 tangent;
} vertex;

static uint32_t word_of(float f)
{
    uint32_t word;
    memcpy(&word, &f, sizeof word);
    return word;
}

static uint32_t snorm_pair(float a, float b)
{
    const float in[2] = {a, b};
    uint32_t out = 0;
    for (int i = 0; i < 2; i++) {
        float clamped = in[i] < -1 ? -1 : in[i] > 1 ? 1 : in[i];
        out |= (uint32_t)(uint16_t)(int16_t)lrintf(clamped * 32767.0f) << (16 * i);
    }
    return out;
}

static vertex load(const uint32_t *w)
{
    return (vertex){
        {deform_float(w[0]), deform_float(w[1]), deform_float(w[2])},
        {deform_snorm(w[3], 0), deform_snorm(w[3], 1), deform_snorm(w[4], 0)},
        {deform_snorm(w[5], 0), deform_snorm(w[5], 1), deform_snorm(w[6], 0), deform_snorm(w[6], 1)}};
}

static void store(uint32_t *w, const vertex *v)
{
    w[0] = word_of(v->position.x);
    w[1] = word_of(v->position.y);
    w[2] = word_of(v->position.z);
    w[3] = snorm_pair(v->normal.x, v->normal.y);
    w[4] = snorm_pair(v->normal.z, 0);
    w[5] = snorm_pair(v->tangent.x, v->tangent.y);
    w[6] = snorm_pair(v->tangent.z, v->tangent.w);
    w[7] = 0;
}

static kd_vec3 unit(kd_vec3 v, kd_vec3 fallback)
{
    float largest = fmaxf(fabsf(v.x), fmaxf(fabsf(v.y), fabsf(v.z)));
    return largest > 1e-30f ? kd_vec3_normalize(kd_vec3_scale(v, 1 / largest), fallback) : fallback;
}

static void morph(const deform_streams *s, const struct kd_deform_item *item, uint32_t local, vertex *v)
{
    kd_vec3 normal = v->normal;
    for (uint32_t i = 0; i < item->morph.z; i++) {
        uint32_t target = s->words[item->morph.y + 2 * i];
        float weight = deform_float(s->words[item->morph.y + 2 * i + 1]);
        const uint32_t *d =
            s->morphs + (size_t)(item->morph.x + target * item->range.z + local) * KD_MORPH_WORDS;
        kd_vec3 dp = {deform_float(d[0]), deform_float(d[1]), deform_float(d[2])};
        kd_vec3 dn = {deform_float(d[3]), deform_float(d[4]), deform_float(d[5])};
        v->position = kd_vec3_add(v->position, kd_vec3_scale(dp, weight));
        normal = kd_vec3_add(normal, kd_vec3_scale(dn, weight));
    }
    v->normal = unit(normal, v->normal);
}

static kd_vec3 xyz(kd_vec4 v)
{
    return (kd_vec3){v.x, v.y, v.z};
}

static void blend_rows(const deform_streams *s, const struct kd_deform_item *item, uint32_t local,
                       kd_vec4 rows[3])
{
    const uint32_t *w = s->skins + (size_t)(item->range.w + local) * KD_SKIN_WORDS;
    memset(rows, 0, 3 * sizeof *rows);
    for (int k = 0; k < 4; k++) {
        uint32_t joint = w[k / 2] >> (16 * (k & 1)) & 0xffffu;
        float weight = (float)(w[2 + k / 2] >> (16 * (k & 1)) & 0xffffu) / 65535.0f;
        uint32_t last = item->skin.y - 1;
        const kd_vec4 *from = s->joints[item->skin.x + (joint < last ? joint : last)];
        for (int r = 0; r < 3; r++) {
            rows[r].x += weight * from[r].x;
            rows[r].y += weight * from[r].y;
            rows[r].z += weight * from[r].z;
            rows[r].w += weight * from[r].w;
        }
    }
}

static void skin(const deform_streams *s, const struct kd_deform_item *item, uint32_t local, vertex *v)
{
    kd_vec4 rows[3];
    blend_rows(s, item, local, rows);
    kd_vec3 x = xyz(rows[0]), y = xyz(rows[1]), z = xyz(rows[2]), p = v->position, n = v->normal,
            t = xyz(v->tangent);
    kd_vec3 cx = kd_vec3_cross(y, z), cy = kd_vec3_cross(z, x), cz = kd_vec3_cross(x, y);
    float side = kd_vec3_dot(x, cx) < 0 ? -1.0f : 1.0f;
    v->position = (kd_vec3){kd_vec3_dot(x, p) + rows[0].w, kd_vec3_dot(y, p) + rows[1].w,
                            kd_vec3_dot(z, p) + rows[2].w};
    kd_vec3 bent = {kd_vec3_dot(cx, n), kd_vec3_dot(cy, n), kd_vec3_dot(cz, n)};
    v->normal = unit(kd_vec3_scale(bent, side), n);
    t = unit((kd_vec3){kd_vec3_dot(x, t), kd_vec3_dot(y, t), kd_vec3_dot(z, t)}, t);
    v->tangent = (kd_vec4){t.x, t.y, t.z, v->tangent.w};
}

void deform_reference(const deform_streams *s, const struct kd_deform_item *item)
{
    for (uint32_t local = 0; local < item->range.z; local++) {
        vertex v = load(s->geometry + (size_t)(item->range.x + local) * KD_GEOMETRY_WORDS);
        if (item->morph.z)
            morph(s, item, local, &v);
        if (item->range.w != KD_DEFORM_NONE)
            skin(s, item, local, &v);
        store(s->geometry + (size_t)(item->range.y + local) * KD_GEOMETRY_WORDS, &v);
    }
}
