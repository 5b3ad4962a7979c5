#ifndef KD_APP_VOXEL_BENCH_UNPACK_H
#define KD_APP_VOXEL_BENCH_UNPACK_H

/* The words of the tree and of voxels as numbers: the C side of shaders/include/half_pack.glsl,
 * tree_node.glsl, cell_attributes.glsl and voxel_pack.glsl. */

#include <math.h>
#include <stdint.h>

#include "shaders/shared/voxel.h"

static inline float unpack_snorm8(uint32_t word, int k)
{
    float v = (float)(int8_t)(uint8_t)(word >> (8 * k)) / 127.0f;
    return v < -1 ? -1 : v;
}

static inline void unpack_normal(uint32_t word, float out[3])
{
    for (int k = 0; k < 3; k++)
        out[k] = unpack_snorm8(word, k);
}

/* Normal of a leaf by its second word; of a thin one its axis, octahedral, towards the brighter side. */
static inline void unpack_leaf_normal(uint32_t word, float out[3])
{
    unpack_normal(word, out);
    if (!(word >> 31))
        return;
    float x = out[0], y = out[1], z = 1 - fabsf(x) - fabsf(y);
    out[0] = z < 0 ? copysignf(1 - fabsf(y), x) : x;
    out[1] = z < 0 ? copysignf(1 - fabsf(x), y) : y;
    out[2] = z;
    float length = sqrtf(out[0] * out[0] + out[1] * out[1] + z * z) * (word >> 16 & 1 ? -1.0f : 1.0f);
    for (int k = 0; k < 3; k++)
        out[k] /= length;
}

/* Light of a thin leaf's darker side over that of the brighter one; 1 of any other leaf. */
static inline float unpack_leaf_other(uint32_t word)
{
    float root = word >> 31 ? (float)(word >> 17 & 127) / 127 : 1;
    return root * root * root;
}

/* Radiance: 9 bits a channel and a shared power of two. */
static inline void unpack_rgb9e5(uint32_t word, float out[3])
{
    float scale = ldexpf(1, (int)(word >> 27) - 24);
    for (int k = 0; k < 3; k++)
        out[k] = (float)(word >> (9 * k) & 511u) * scale;
}

/* Depth of a leaf by its second word, of a sparse node by direction. */
static inline float unpack_leaf_depth(uint32_t word)
{
    return (float)(word >> 24 & 127u) * (float)(KD_FULL_DEPTH / 127);
}

static inline float unpack_node_depth(uint32_t word, int direction)
{
    return (float)(word >> (5 * direction) & 31u) * (float)(KD_FULL_DEPTH / 31);
}

/* Albedo, emission relative to the scene's brightest, and weight (256 covers the cell once) of a cell's 16
 * bytes. */
static inline void unpack_cell(const uint32_t w[4], float albedo[3], float emission[3], float *weight)
{
    for (int k = 0; k < 3; k++) {
        albedo[k] = (float)(w[0] >> (10 * k) & 1023u) / 1023.0f;
        emission[k] = ldexpf((float)(w[2] >> (9 * k) & 511u) / 511.0f, -(int)(w[2] >> 27));
    }
    *weight = (float)(((w[1] >> 24 & 127) * 512 + 127) / 254);
}

/* Albedo of a cached voxel: eight bits of its square root. */
static inline void unpack_color(uint32_t word, float out[3])
{
    for (int k = 0; k < 3; k++) {
        float root = (float)(word >> (8 * k) & 255u) / 255.0f;
        out[k] = root * root;
    }
}

#endif
