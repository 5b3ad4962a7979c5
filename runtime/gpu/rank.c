/* Three passes: sums of blocks of 32 words, one work group that scans the sums, ranks of the words. */
#include "runtime/gpu/rank.h"

#include "runtime/gpu/internal.h"

static uint32_t blocks_of(uint32_t words)
{
    return (words + KD_GPU_RANK_BLOCK - 1) / KD_GPU_RANK_BLOCK;
}

kd_status kd_gpu_rank_init(kd_gpu *gpu, kd_gpu_rank *rank)
{
    rank->sum = kd_gpu_make_program(gpu, &(kd_gpu_program_desc){.compute = "shaders/gpu/rank_sum.comp"});
    rank->scan = kd_gpu_make_program(gpu, &(kd_gpu_program_desc){.compute = "shaders/gpu/rank_scan.comp"});
    rank->write = kd_gpu_make_program(gpu, &(kd_gpu_program_desc){.compute = "shaders/gpu/rank_write.comp"});
    return rank->sum.id && rank->scan.id && rank->write.id ? KD_OK : KD_GPU;
}

void kd_gpu_rank_fini(kd_gpu *gpu, kd_gpu_rank *rank)
{
    kd_gpu_destroy_program(gpu, rank->sum);
    kd_gpu_destroy_program(gpu, rank->scan);
    kd_gpu_destroy_program(gpu, rank->write);
    kd_gpu_destroy_buffer(gpu, rank->sums);
    *rank = (kd_gpu_rank){0};
}

/* Complains about buffers that cannot be bound, before anything runs; makes room for the sums. */
static kd_status prepare(kd_gpu *gpu, kd_gpu_rank *rank, kd_gpu_buffer mask, kd_gpu_buffer ranks,
                         uint32_t blocks)
{
    size_t a = kd_gpu_buffer_size(gpu, mask), b = kd_gpu_buffer_size(gpu, ranks), largest = a > b ? a : b;
    if ((int64_t)largest > gpu->info.max_ssbo_bytes) {
        gpu_complain(gpu, "rank: %zu bytes of mask or ranks, the driver binds %lld; make them smaller",
                     largest, (long long)gpu->info.max_ssbo_bytes);
        return KD_TOO_LARGE;
    }
    return kd_gpu_ensure_buffer(gpu, &rank->sums, (size_t)blocks * 4, 0, "rank.sums");
}

/* Sums of blocks, scanned; the total. What is bound afterwards are the mask, the sums and the counters. */
static kd_status scan_blocks(kd_gpu *gpu, kd_gpu_rank *rank, kd_gpu_buffer mask, kd_gpu_buffer ranks,
                             const uint32_t pass[4], kd_gpu_buffer counters)
{
    uint32_t blocks = blocks_of(pass[1]);
    kd_status status = prepare(gpu, rank, mask, ranks, blocks);
    if (status) {
        kd_gpu_fill_buffer(gpu, counters, (size_t)pass[3] * 4, 4, 0);
        return status;
    }
    kd_gpu_bind_uniform(gpu, 0, pass, 16);
    kd_gpu_bind_storage(gpu, 0, mask);
    kd_gpu_bind_storage(gpu, 1, rank->sums);
    kd_gpu_bind_storage(gpu, 2, counters);
    kd_gpu_dispatch_linear(gpu, rank->sum, (blocks + 63) / 64);
    kd_gpu_barrier(gpu, KD_BARRIER_STORAGE);
    kd_gpu_dispatch(gpu, rank->scan, 1, 1, 1);
    return KD_OK;
}

kd_status kd_gpu_rank_run(kd_gpu *gpu, kd_gpu_rank *rank, kd_gpu_buffer mask, uint32_t first_mask,
                          uint32_t words, kd_gpu_buffer ranks, uint32_t first_rank, kd_gpu_buffer counters,
                          uint32_t counter)
{
    kd_status status =
        scan_blocks(gpu, rank, mask, ranks, (uint32_t[4]){first_mask, words, first_rank, counter}, counters);
    if (status)
        return status;
    kd_gpu_barrier(gpu, KD_BARRIER_STORAGE);
    kd_gpu_bind_storage(gpu, 3, ranks);
    kd_gpu_dispatch_linear(gpu, rank->write, (blocks_of(words) + 63) / 64);
    return KD_OK;
}

kd_status kd_gpu_rank_count(kd_gpu *gpu, kd_gpu_rank *rank, kd_gpu_buffer mask, uint32_t first_mask,
                            uint32_t words, kd_gpu_buffer counters, uint32_t counter)
{
    return scan_blocks(gpu, rank, mask, mask, (uint32_t[4]){first_mask, words, 0, counter}, counters);
}

void kd_gpu_rank_rest(kd_gpu *gpu, kd_gpu_rank *rank)
{
    kd_gpu_destroy_buffer(gpu, rank->sums);
    rank->sums = (kd_gpu_buffer){0};
}

kd_gpu_buffer kd_gpu_rank_sums(kd_gpu *gpu, kd_gpu_rank *rank, uint32_t words)
{
    kd_status status = kd_gpu_ensure_buffer(gpu, &rank->sums, (size_t)blocks_of(words) * 4, 0, "rank.sums");
    return status ? (kd_gpu_buffer){0} : rank->sums;
}

void kd_gpu_rank_scan(kd_gpu *gpu, kd_gpu_rank *rank, uint32_t words, kd_gpu_buffer counters,
                      uint32_t counter)
{
    uint32_t pass[4] = {0, words, 0, counter};
    kd_gpu_bind_uniform(gpu, 0, pass, sizeof pass);
    kd_gpu_bind_storage(gpu, 1, rank->sums);
    kd_gpu_bind_storage(gpu, 2, counters);
    kd_gpu_dispatch(gpu, rank->scan, 1, 1, 1);
}
