#ifndef KD_GPU_RANK_H
#define KD_GPU_RANK_H

#include "runtime/gpu/gpu.h"

/* Ranks of set bits: for each word of a bit mask the number of bits set before it. With it, the place of a
 * set bit in a compact array is rank[word] + bitCount(mask[word] & below), which depends on the mask alone
 * and on no thread order. */
typedef struct kd_gpu_rank {
    kd_gpu_program sum, scan, write;
    kd_gpu_buffer sums;
} kd_gpu_rank;

/** Compile the passes. Errors KD_GPU. */
kd_status kd_gpu_rank_init(kd_gpu *gpu, kd_gpu_rank *rank);
void kd_gpu_rank_fini(kd_gpu *gpu, kd_gpu_rank *rank);

/** Write ranks[first_rank + i] for the words mask[first_mask + i], i < words, and the total to
 * counters[counter]. The caller issues the barrier before (mask) and after (ranks, counters). Errors
 * KD_TOO_LARGE when a buffer is larger than the driver binds, KD_GPU: no ranks, the total is 0. Cost 2 reads
 * of the mask and 1 write of the ranks */
kd_status kd_gpu_rank_run(kd_gpu *gpu, kd_gpu_rank *rank, kd_gpu_buffer mask, uint32_t first_mask,
                          uint32_t words, kd_gpu_buffer ranks, uint32_t first_rank, kd_gpu_buffer counters,
                          uint32_t counter);

/** The total alone: cost 1 read of the mask. */
kd_status kd_gpu_rank_count(kd_gpu *gpu, kd_gpu_rank *rank, kd_gpu_buffer mask, uint32_t first_mask,
                            uint32_t words, kd_gpu_buffer counters, uint32_t counter);

/** Give back the room for sums; what ranks next makes it anew. */
void kd_gpu_rank_rest(kd_gpu *gpu, kd_gpu_rank *rank);

/* For masks of which few words have anything new: the caller adds up each block of KD_GPU_RANK_BLOCK words
 * itself, and a word's rank is what the scan leaves for its block plus the bits before it in the block. */
#define KD_GPU_RANK_BLOCK 32u

/** The sums of so many words' blocks, to be written. Errors KD_TOO_LARGE, KD_GPU: id 0 */
kd_gpu_buffer kd_gpu_rank_sums(kd_gpu *gpu, kd_gpu_rank *rank, uint32_t words);

/** Turn these sums into the number of bits before each block; the total goes to counters[counter]. Barriers
 * are the caller's, as above. */
void kd_gpu_rank_scan(kd_gpu *gpu, kd_gpu_rank *rank, uint32_t words, kd_gpu_buffer counters,
                      uint32_t counter);

#endif
