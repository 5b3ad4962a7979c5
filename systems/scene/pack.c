/* Vertex streams as shaders/shared/scene.h describes them. */

#include <math.h>
#include <string.h>

#include "systems/scene/internal.h"

static uint32_t float_bits(float f)
{
    uint32_t u;
    memcpy(&u, &f, sizeof u);
    return u;
}

static uint32_t snorm16(float f)
{
    float clamped = f < -1 ? -1 : f > 1 ? 1 : f;
    return (uint32_t)(uint16_t)(int16_t)lrintf(clamped * 32767.0f);
}

static uint32_t unorm(float f, float scale)
{
    float clamped = f < 0 ? 0 : f > 1 ? 1 : f;
    return (uint32_t)lrintf(clamped * scale);
}

static void put_vec3(uint32_t *words, kd_vec3 v)
{
    words[0] = float_bits(v.x);
    words[1] = float_bits(v.y);
    words[2] = float_bits(v.z);
}

void scene_pack_geometry(const kd_primitive_desc *desc, uint32_t *words)
{
    for (uint32_t v = 0; v < desc->vertex_count; v++, words += KD_GEOMETRY_WORDS) {
        kd_vec3 n = desc->normals ? desc->normals[v] : (kd_vec3){0, 1, 0};
        kd_vec4 t = desc->tangents ? desc->tangents[v] : (kd_vec4){1, 0, 0, 1};
        put_vec3(words, desc->positions[v]);
        words[3] = snorm16(n.x) | snorm16(n.y) << 16;
        words[4] = snorm16(n.z);
        words[5] = snorm16(t.x) | snorm16(t.y) << 16;
        words[6] = snorm16(t.z) | snorm16(t.w) << 16;
        words[7] = 0;
    }
}

void scene_pack_attributes(const kd_primitive_desc *desc, uint32_t *words)
{
    for (uint32_t v = 0; v < desc->vertex_count; v++, words += KD_ATTRIBUTE_WORDS) {
        kd_vec2 uv0 = desc->uv0 ? desc->uv0[v] : (kd_vec2){0, 0};
        kd_vec2 uv1 = desc->uv1 ? desc->uv1[v] : uv0;
        kd_vec4 c = desc->colors ? desc->colors[v] : (kd_vec4){1, 1, 1, 1};
        words[0] = float_bits(uv0.x);
        words[1] = float_bits(uv0.y);
        words[2] = float_bits(uv1.x);
        words[3] = float_bits(uv1.y);
        words[4] = unorm(c.x, 255) | unorm(c.y, 255) << 8 | unorm(c.z, 255) << 16 | unorm(c.w, 255) << 24;
        words[5] = 0;
    }
}

/* Weights are rounded so that they sum to one exactly: what is missing goes to the largest. */
static void weights_unorm16(const kd_vec4 *weights, uint32_t out[4])
{
    const float w[4] = {weights->x, weights->y, weights->z, weights->w};
    int32_t sum = 0;
    int largest = 0;
    for (int k = 0; k < 4; k++) {
        out[k] = unorm(w[k], 65535);
        sum += (int32_t)out[k];
        if (w[k] > w[largest])
            largest = k;
    }
    out[largest] = (uint32_t)((int32_t)out[largest] + 65535 - sum);
}

void scene_pack_skin(const kd_primitive_desc *desc, uint32_t *words)
{
    for (uint32_t v = 0; v < desc->vertex_count; v++, words += KD_SKIN_WORDS) {
        const uint16_t *j = desc->joints[v];
        uint32_t w[4];
        weights_unorm16(&desc->weights[v], w);
        words[0] = (uint32_t)j[0] | (uint32_t)j[1] << 16;
        words[1] = (uint32_t)j[2] | (uint32_t)j[3] << 16;
        words[2] = w[0] | w[1] << 16;
        words[3] = w[2] | w[3] << 16;
    }
}

void scene_pack_morph(const kd_primitive_desc *desc, uint32_t target, uint32_t *words)
{
    const kd_vec3 *positions = desc->morph_positions ? desc->morph_positions[target] : NULL;
    const kd_vec3 *normals = desc->morph_normals ? desc->morph_normals[target] : NULL;
    for (uint32_t v = 0; v < desc->vertex_count; v++, words += KD_MORPH_WORDS) {
        put_vec3(words, positions ? positions[v] : (kd_vec3){0, 0, 0});
        put_vec3(words + 3, normals ? normals[v] : (kd_vec3){0, 0, 0});
    }
}
