/* Rows of bytes: neighbouring voxels share the high bytes of their words, which zstd finds when they stand
 * side by side. */
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
    return raw[i] | (uint32_t)raw[n + i] << 8 | (uint32_t)raw[2 * n + i] << 16 |
           (uint32_t)raw[3 * n + i] << 24;
}

static const uint8_t *unpack_words(const uint8_t *raw, uint32_t count, uint32_t stride, uint32_t *words)
{
    for (uint32_t i = 0; i < count; i++)
        words[(size_t)i * stride] = unpack_word(raw, count, i);
    return raw + (size_t)count * 4;
}

/* Bits 0, 1 and 2 of v to places 0, 3 and 6, and back. */
static uint32_t spread(uint32_t v)
{
    return (v & 1) | (v & 2) << 2 | (v & 4) << 4;
}

static uint32_t gather(uint32_t v)
{
    return (v & 1) | (v >> 2 & 2) | (v >> 4 & 4);
}

uint64_t voxel_cell_place(const uint32_t size[3], uint32_t cell)
{
    uint32_t at[3] = {cell & 1023, cell >> 10 & 1023, cell >> 20},
             blocks[2] = {(size[0] + 7) / 8, (size[1] + 7) / 8};
    uint64_t block = at[0] / 8 + (uint64_t)blocks[0] * (at[1] / 8 + (uint64_t)blocks[1] * (at[2] / 8));
    return block << 9 | spread(at[0] & 7) | spread(at[1] & 7) << 1 | spread(at[2] & 7) << 2;
}

bool voxel_place_cell(const uint32_t size[3], uint64_t place, uint32_t *cell)
{
    uint64_t block = place >> 9, blocks[2] = {(size[0] + 7) / 8, (size[1] + 7) / 8};
    uint32_t in = (uint32_t)(place & 511);
    uint64_t x = block % blocks[0] * 8 + gather(in), y = block / blocks[0] % blocks[1] * 8 + gather(in >> 1);
    uint64_t z = block / (blocks[0] * blocks[1]) * 8 + gather(in >> 2);
    *cell = (uint32_t)(x | y << 10 | z << 20);
    return x < size[0] && y < size[1] && z < size[2];
}

void voxel_pack(const kd_voxel_words *words, uint32_t count, const uint32_t size[3], uint8_t *raw)
{
    uint64_t last = 0;
    for (uint32_t i = 0; i < count; i++) {
        uint64_t place = voxel_cell_place(size, words->shape[2 * (size_t)i]);
        uint32_t difference = (uint32_t)(place - last);
        for (uint32_t row = 0; row < 4; row++)
            raw[(size_t)row * count + i] = (uint8_t)(difference >> (8 * row));
        last = place;
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
        uint64_t place = last + unpack_word(raw, count, i);
        if ((i && place == last) || !voxel_place_cell(size, place, &words->shape[2 * (size_t)i]))
            return false;
        last = place;
    }
    raw = unpack_words(raw + (size_t)count * 4, count, 2, words->shape + 1);
    raw = unpack_words(raw, count, 1, words->color);
    for (uint32_t k = 0; words->binding && k < 3; k++)
        raw = unpack_words(raw, count, 3, words->binding + k);
    return true;
}
