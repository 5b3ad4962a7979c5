#include "runtime/reference/sampler.h"

/* ---- tables ---- */

static void directions(uint32_t degree, uint32_t coefficients, const uint32_t *initial, uint32_t out[32])
{
    for (uint32_t i = 0; i < 32; i++) {
        if (i < degree) {
            out[i] = initial[i] << (31 - i);
            continue;
        }
        out[i] = out[i - degree] ^ out[i - degree] >> degree;
        for (uint32_t k = 1; k < degree; k++)
            if (coefficients >> (degree - 1 - k) & 1)
                out[i] ^= out[i - k];
    }
}

void sampler_tables_make(sampler_tables *out)
{
    static const uint32_t ones[3] = {1, 1, 1}, third[2] = {1, 3}, fourth[3] = {1, 3, 1};
    uint32_t numbers[4][32];
    for (uint32_t i = 0; i < 32; i++)
        numbers[0][i] = 1u << (31 - i);
    directions(1, 0, ones, numbers[1]);
    directions(2, 1, third, numbers[2]);
    directions(3, 1, fourth, numbers[3]);
    for (int d = 0; d < 4; d++)
        for (int byte = 0; byte < 4; byte++)
            for (uint32_t value = 0; value < 256; value++) {
                uint32_t x = 0;
                for (int bit = 0; bit < 8; bit++)
                    if (value >> bit & 1)
                        x ^= numbers[d][byte * 8 + bit];
                out->xor_of[d][byte][value] = x;
            }
}

static uint32_t sobol(const sampler_tables *t, int d, uint32_t index)
{
    return t->xor_of[d][0][index & 255] ^ t->xor_of[d][1][index >> 8 & 255] ^
           t->xor_of[d][2][index >> 16 & 255] ^ t->xor_of[d][3][index >> 24];
}

/* ---- scrambling ---- */

static uint32_t reverse(uint32_t x)
{
    x = __builtin_bswap32(x);
    x = (x & 0x0f0f0f0fu) << 4 | (x >> 4 & 0x0f0f0f0fu);
    x = (x & 0x33333333u) << 2 | (x >> 2 & 0x33333333u);
    return (x & 0x55555555u) << 1 | (x >> 1 & 0x55555555u);
}

/* Each bit flips by a hash of those below it. */
static uint32_t laine_karras(uint32_t x, uint32_t seed)
{
    x += seed;
    x ^= x * 0x6c50b47cu;
    x ^= x * 0xb82f1e52u;
    x ^= x * 0xc7afe638u;
    return x ^ x * 0x8d22f6e6u;
}

static uint32_t scramble(uint32_t x, uint32_t seed)
{
    return reverse(laine_karras(reverse(x), seed));
}

/* Source  Wellons 2018, Prospecting for Hash Functions: lowbias32 */
uint32_t sampler_hash(uint32_t a, uint32_t b)
{
    uint32_t x = a * 0x9e3779b9u ^ b;
    x ^= x >> 16;
    x *= 0x7feb352du;
    x ^= x >> 15;
    x *= 0x846ca68bu;
    return x ^ x >> 16;
}

sampler sampler_make(const sampler_tables *tables, uint32_t x, uint32_t y, uint32_t index, uint64_t seed)
{
    uint32_t h = sampler_hash(sampler_hash(x, y), sampler_hash((uint32_t)seed, (uint32_t)(seed >> 32)));
    return (sampler){tables, h, index, 0};
}

void sampler_next(sampler *s, float out[4])
{
    uint32_t seed = sampler_hash(s->seed, ++s->group);
    uint32_t index = scramble(s->index, seed);
    for (int d = 0; d < 4; d++) {
        uint32_t x = scramble(sobol(s->tables, d, index), sampler_hash(seed, (uint32_t)d + 1));
        out[d] = (float)(x >> 8) * (1.0f / 16777216.0f);
    }
}

uint32_t sampler_number(const sampler *s)
{
    return sampler_hash(s->seed ^ 0x55555555u, s->index);
}
