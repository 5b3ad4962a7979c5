#ifndef KD_REFERENCE_SAMPLER_H
#define KD_REFERENCE_SAMPLER_H

/* Points in 0 … 1, four dimensions at a time: Sobol's sequence, Owen-scrambled by a hash. Each group of four
 * has its own order and scrambling, so that any number of groups can be joined to one sample ("padding"). A
 * point is a function of pixel, group and index alone. Source  Burley 2020, Practical Hash-based Owen
 * Scrambling; Joe and Kuo 2008, direction numbers new-joe-kuo-6 */

#include <stdint.h>

typedef struct sampler_tables {
    uint32_t xor_of[4][4][256]; /* dimension, byte of the index, its value */
} sampler_tables;

void sampler_tables_make(sampler_tables *out);

typedef struct sampler {
    const sampler_tables *tables;
    uint32_t seed, index, group;
} sampler;

/** Start sample `index` of a pixel. */
sampler sampler_make(const sampler_tables *tables, uint32_t x, uint32_t y, uint32_t index, uint64_t seed);
/** Get the next four dimensions. */
void sampler_next(sampler *s, float out[4]);
/** Get a number that is the same for the whole sample, for choices that are made in any order. */
uint32_t sampler_number(const sampler *s);
/** Mix two words. */
uint32_t sampler_hash(uint32_t a, uint32_t b);

#endif
