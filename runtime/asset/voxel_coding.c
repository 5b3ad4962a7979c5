/* Rows of bytes: neighbouring voxels share the high bytes of their words, which zstd finds when they stand side by side. */
#include "runtime/asset/voxel_layout.h"

/* One stream: count words, `stride` apart, as four rows of bytes. */
static uint8_t *pack_words(const uint32_t *words, uint32_t stride, uint32_t count, uint8_t *raw)
{
    for (uint32_t i = 0; i < count; i++)
        for (uint32_t row = 0; row < 4; row++)
            raw[(size_t)row * count + i] = (uint8_t)(words[(size_t)i * stride] >> (8 * row));
    return raw + (size_t)count * 4;
}

static uint32_t unpack_word(const uint8_t *raw, uint32_t count, uint32_t i)
{
    const size_t n = count;
    return raw[i] | (uint32_t)raw[n + i] << 8 | (uint32_t)raw[2 * n + i] << 16 | (uint32_t)raw[3 * n + i] << 24;
}

static const uint8_t *unpack_words(const uint8_t *raw, uint32_t count, uint32_t stride, uint32_t *words)
{
    for (uint32_t i = 0; i < count; i++)
        words[(size_t)i * stride] = unpack_word(raw, count, i);
    return raw + (size_t)count * 4;
}

void voxel_pack(const kd_voxel_words *words, uint32_t count, uint8_t *raw)
{
    uint32_t last = 0;
    for (uint32_t i = 0; i < count; i++) {
        uint32_t cell = words->shape[2 * (size_t)i], difference = cell - last;
        for (uint32_t row = 0; row < 4; row++)
            raw[(size_t)row * count + i] = (uint8_t)(difference >> (8 * row));
        last = cell;
    }
    raw = pack_words(words->shape + 1, 2, count, raw + (size_t)count * 4);
    raw = pack_words(words->color, 1, count, raw);
    for (uint32_t k = 0; words->binding && k < 3; k++)
        raw = pack_words(words->binding + k, 3, count, raw);
}

bool voxel_unpack(const uint8_t *raw, uint32_t count, const uint32_t size[3], const kd_voxel_words *words)
{
    uint64_t last = 0;
    for (uint32_t i = 0; i < count; i++) {
        uint64_t cell = last + unpack_word(raw, count, i);
        if ((i && cell == last) || cell >> 30 || (cell & 1023) >= size[0] || (cell >> 10 & 1023) >= size[1] ||
            cell >> 20 >= size[2])
            return false;
        words->shape[2 * (size_t)i] = (uint32_t)cell;
        last = cell;
    }
    raw = unpack_words(raw + (size_t)count * 4, count, 2, words->shape + 1);
    raw = unpack_words(raw, count, 1, words->color);
    for (uint32_t k = 0; words->binding && k < 3; k++)
        raw = unpack_words(raw, count, 3, words->binding + k);
    return true;
}
