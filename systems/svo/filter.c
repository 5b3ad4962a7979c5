/* Bottom-up filter: sparse levels, dense cells, cascades into each other, and the levels above the outermost
 * cascade. */
#include "systems/svo/internal.h"

static void bind_children(kd_gpu *gpu, const kd_svo *svo)
{
    kd_gpu_bind_storage(gpu, 0, svo->counters);
    kd_gpu_bind_storage(gpu, 1, svo->lists[svo->current]);
    kd_gpu_bind_storage(gpu, 2, svo->leaves);
    kd_gpu_bind_storage(gpu, 3, svo->nodes);
    kd_gpu_bind_storage(gpu, 4, svo->data);
}

/* Level 6 + l from its children: leaves, or the nodes of the next level. */
static void filter_level(kd_gpu *gpu, svo_state *state, const kd_svo *svo, uint32_t l)
{
    uint32_t cap = svo->node_capacity, levels = svo->leaf_level - KD_DENSE_LOG2;
    uint32_t pass[8] = {
        KD_COUNT_LEVEL + l, cap, l == 0 ? 0 : (l - 1) * cap, 0, l + 1 == levels, l * 8 * cap, l * cap, 0};
    bind_children(gpu, svo);
    kd_gpu_bind_uniform(gpu, 0, pass, sizeof pass);
    if (l == 0)
        kd_gpu_bind_image(gpu, 0, svo->atlas, 0, KD_IMAGE_WRITE, KD_RGBA16F);
    kd_gpu_dispatch_indirect(gpu, l == 0 ? state->filter_dense : state->filter_sparse, svo->counters,
                             (KD_ARGS_LEVEL + 3 * l) * 4);
    kd_gpu_barrier(gpu, l == 0 ? KD_BARRIER_IMAGE : KD_BARRIER_STORAGE);
}

static void clear_stale(kd_gpu *gpu, svo_state *state, const kd_svo *svo)
{
    uint32_t pass[4] = {KD_COUNT_PREVIOUS, svo->list_capacity[svo->current ^ 1], 0, 0};
    kd_gpu_bind_uniform(gpu, 0, pass, sizeof pass);
    kd_gpu_bind_storage(gpu, 0, svo->counters);
    kd_gpu_bind_storage(gpu, 1, svo->lists[svo->current ^ 1]);
    kd_gpu_bind_storage(gpu, 2, svo->level_masks);
    kd_gpu_bind_image(gpu, 0, svo->atlas, 0, KD_IMAGE_WRITE, KD_RGBA16F);
    kd_gpu_dispatch_indirect(gpu, state->clear_dense, svo->counters, KD_ARGS_PREVIOUS * 4);
}

/* One step upward; corners of blocks in the atlas, see filter_up.comp. */
typedef struct up_step {
    uint32_t edge, source_words, target_words, was;
    int32_t from[3], to[3], offset;
} up_step;

static void filter_up(kd_gpu *gpu, svo_state *state, const kd_svo *svo, const up_step *s)
{
    struct {
        uint32_t pass[4];
        int32_t from[4], to[4];
    } params = {{s->edge, s->source_words, s->target_words, s->was},
                {s->from[0], s->from[1], s->from[2], 0},
                {s->to[0], s->to[1], s->to[2], s->offset}};
    kd_gpu_bind_uniform(gpu, 0, &params, sizeof params);
    kd_gpu_bind_storage(gpu, 0, svo->occupancy);
    kd_gpu_bind_storage(gpu, 1, svo->was);
    kd_gpu_bind_image(gpu, 0, svo->atlas, 0, KD_IMAGE_READ_WRITE, KD_RGBA16F);
    kd_gpu_dispatch(gpu, state->filter_up, (s->edge * s->edge * s->edge + 63) / 64, 1, 1);
    kd_gpu_barrier(gpu, KD_BARRIER_IMAGE | KD_BARRIER_STORAGE);
}

/* Block of mip level m (1: 32 cells, 2: 16 …) beside the cascades; the same rule stands in
 * shaders/include/tree.glsl. */
static int32_t mip_y(int32_t m)
{
    return KD_DENSE - (2 * KD_DENSE >> m);
}

void svo_filter(kd_gpu *gpu, svo_state *state, const kd_svo *svo)
{
    uint32_t levels = svo->leaf_level - KD_DENSE_LOG2, dense_words = 1u << (3 * KD_DENSE_LOG2 - 5);
    clear_stale(gpu, state, svo);
    for (uint32_t l = levels; l-- > 0;)
        filter_level(gpu, state, svo, l);
    kd_gpu_copy_buffer(gpu, svo->level_masks, 0, svo->occupancy, 0, (size_t)svo->cascades * dense_words * 4);
    kd_gpu_fill_buffer(gpu, svo->occupancy, (size_t)svo->cascades * dense_words * 4, (size_t)dense_words * 4,
                       0);
    kd_gpu_barrier(gpu, KD_BARRIER_STORAGE);
    uint32_t was = 0;
    for (uint32_t c = 1; c < svo->cascades; c++, was += 32768) {
        up_step s = {.edge = KD_DENSE / 2,
                     .source_words = (c - 1) * dense_words,
                     .target_words = c * dense_words,
                     .was = was,
                     .from = {0, 0, (int32_t)(c - 1) * KD_DENSE},
                     .to = {0, 0, (int32_t)c * KD_DENSE},
                     .offset = KD_DENSE / 4};
        filter_up(gpu, state, svo, &s);
    }
    int32_t above = (int32_t)svo->cascades * KD_DENSE;
    uint32_t source = (svo->cascades - 1) * dense_words, target = svo->cascades * dense_words;
    for (int32_t m = 1; m <= KD_DENSE_MIPS; m++) {
        uint32_t edge = (uint32_t)KD_DENSE >> m;
        up_step s = {.edge = edge,
                     .source_words = source,
                     .target_words = target,
                     .was = was,
                     .from = {0, m == 1 ? 0 : mip_y(m - 1), m == 1 ? above - KD_DENSE : above},
                     .to = {0, mip_y(m), above}};
        filter_up(gpu, state, svo, &s);
        source = target;
        target += (edge * edge * edge + 31) / 32;
        was += edge * edge * edge;
    }
}
