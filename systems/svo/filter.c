/* Bottom-up filter of what has changed: sparse levels, dense cells, cascades into each other, and the levels
 * above the outermost cascade. Each pass lists what the next one has to do. */
#include "shaders/shared/bindings.h"
#include "systems/svo/internal.h"

enum { LEAST_LIST = 1 << 18 }; /* words of the list of what is to be filtered */

static void bind_children(kd_gpu *gpu, const kd_svo *svo)
{
    kd_gpu_bind_storage(gpu, 0, svo->counters);
    kd_gpu_bind_storage(gpu, 1, svo->work);
    kd_gpu_bind_storage(gpu, 2, svo->leaves);
    kd_gpu_bind_storage(gpu, 3, svo->index);
    kd_gpu_bind_storage(gpu, 4, svo->nodes);
    kd_gpu_bind_storage(gpu, 5, svo->data);
    kd_gpu_bind_storage(gpu, 7, svo->book);
    kd_gpu_bind_image(gpu, 0, svo->atlas, 0, KD_IMAGE_READ_WRITE, KD_R32UI);
    kd_gpu_bind_image(gpu, 1, svo->depths, 0, KD_IMAGE_READ_WRITE, KD_R32UI);
}

static void empty_list(kd_gpu *gpu, const kd_svo *svo, uint32_t l)
{
    kd_gpu_barrier(gpu, KD_BARRIER_BUFFER_UPDATE);
    kd_gpu_fill_buffer(gpu, svo->counters, (KD_COUNT_CHANGED + l) * 4, 4, 0);
    kd_gpu_barrier(gpu, KD_BARRIER_STORAGE);
}

/* Run a pass over a list of `counter` entries. */
static void over_list(kd_gpu *gpu, const svo_state *state, const kd_svo *svo, svo_program program,
                      uint32_t counter, const uint32_t pass[8])
{
    svo_args(gpu, state, svo, counter, UINT32_MAX, 1, KD_ARGS_LIST);
    bind_children(gpu, svo);
    kd_gpu_bind_uniform(gpu, 0, pass, 32);
    kd_gpu_dispatch_indirect(gpu, state->programs[program], svo->counters, KD_ARGS_LIST * 4);
    kd_gpu_barrier(gpu, KD_BARRIER_STORAGE | KD_BARRIER_IMAGE);
}

/* Level 6 + l from its children: leaves, or the nodes of the next level. What is to be done is listed. */
static void filter_listed(kd_gpu *gpu, const svo_state *state, const kd_svo *svo, uint32_t l)
{
    uint32_t child = (&svo->places.child.x)[l], below = kd_svo_data_first(svo, l + 1);
    uint32_t pass[8] = {l, 0, kd_svo_data_first(svo, l), 0, l + 1 == svo_levels(svo), child, below, 0};
    over_list(gpu, state, svo, l == 0 ? SVO_FILTER_DENSE : SVO_FILTER_SPARSE, KD_COUNT_CHANGED + l, pass);
}

/* In rounds of as many numbers as the list has room for. */
static void filter_sparse(kd_gpu *gpu, const svo_state *state, const kd_svo *svo, uint32_t l)
{
    uint32_t words = svo->node_room[l] / 32, round = (uint32_t)(kd_gpu_buffer_size(gpu, svo->work) / 4 / 32);
    for (uint32_t first = 0; first < words; first += round) {
        uint32_t count = words - first < round ? words - first : round, pass[4] = {l, first, count, 0};
        empty_list(gpu, svo, l);
        kd_gpu_bind_uniform(gpu, 0, pass, sizeof pass);
        kd_gpu_bind_storage(gpu, 0, svo->counters);
        kd_gpu_bind_storage(gpu, 1, svo->work);
        kd_gpu_bind_storage(gpu, 7, svo->book);
        kd_gpu_dispatch_linear(gpu, state->programs[SVO_NODE_LIST], (count + 63) / 64);
        kd_gpu_barrier(gpu, KD_BARRIER_STORAGE);
        filter_listed(gpu, state, svo, l);
    }
}

static void list_dense(kd_gpu *gpu, const svo_state *state, const kd_svo *svo)
{
    uint32_t words = svo->cascades * KD_DENSE_WORDS, pass[4] = {words, 0, 0, 0};
    empty_list(gpu, svo, 0);
    kd_gpu_bind_uniform(gpu, 0, pass, sizeof pass);
    kd_gpu_bind_storage(gpu, 0, svo->counters);
    kd_gpu_bind_storage(gpu, 1, svo->work);
    kd_gpu_bind_storage(gpu, 2, svo->level_masks);
    kd_gpu_bind_storage(gpu, 7, svo->book);
    kd_gpu_dispatch(gpu, state->programs[SVO_DENSE_LIST], words / 64, 1, 1);
    kd_gpu_barrier(gpu, KD_BARRIER_STORAGE);
}

/* When anything below has changed: of the first two levels what holds something, of the others all, six
 * hundred cells. */
static void filter_above(kd_gpu *gpu, const svo_state *state, const kd_svo *svo)
{
    uint32_t changed = KD_COUNT_UP + svo->cascades;
    svo_args(gpu, state, svo, changed, 1, KD_UP_CELLS / 8, KD_ARGS_LIST);
    bind_children(gpu, svo);
    kd_gpu_dispatch_indirect(gpu, state->programs[SVO_ABOVE_LIST], svo->counters, KD_ARGS_LIST * 4);
    kd_gpu_barrier(gpu, KD_BARRIER_STORAGE);
    over_list(gpu, state, svo, SVO_FILTER_ABOVE, KD_COUNT_ABOVE, (uint32_t[8]){1});
    over_list(gpu, state, svo, SVO_FILTER_ABOVE, KD_COUNT_ABOVE_NEXT, (uint32_t[8]){2});
    for (uint32_t m = 3; m <= KD_DENSE_MIPS; m++) {
        uint32_t edge = (uint32_t)KD_DENSE >> m, pass[8] = {m};
        svo_args(gpu, state, svo, changed, 1, edge * edge * edge, KD_ARGS_LIST);
        bind_children(gpu, svo);
        kd_gpu_bind_uniform(gpu, 0, pass, sizeof pass);
        kd_gpu_dispatch_indirect(gpu, state->programs[SVO_FILTER_ABOVE], svo->counters, KD_ARGS_LIST * 4);
        kd_gpu_barrier(gpu, KD_BARRIER_IMAGE);
    }
}

/* Words to list dense cells that have nodes, or held something: of their own, or of the finer cascade; and a
 * good part of the nodes. */
static uint64_t list_words(const kd_svo *svo)
{
    uint32_t all = svo->cascades * KD_DENSE_WORDS * 32;
    uint64_t dense = 2ull * svo->node_room[0] + (uint64_t)svo->cascades * KD_UP_CELLS;
    dense = dense < all ? dense : all;
    return dense > LEAST_LIST ? dense : LEAST_LIST;
}

void svo_reserve_filter(kd_gpu *gpu, svo_state *state, kd_svo *svo)
{
    if (svo_reserve_work(gpu, svo, list_words(svo)) != KD_OK)
        svo_say_once(state, SVO_SAID_WORK,
                     "octree: no memory to filter it; its coarse levels stay as they are");
}

void svo_filter(kd_gpu *gpu, const svo_state *state, const kd_svo *svo)
{
    if (kd_gpu_buffer_size(gpu, svo->work) < 4 * list_words(svo))
        return;
    kd_gpu_bind_uniform(gpu, KD_BIND_SVO, &svo->places, sizeof svo->places);
    kd_gpu_bind_uniform_buffer(gpu, KD_BIND_TREE, svo->uniform, 0, sizeof(struct kd_tree_params));
    for (uint32_t l = svo_levels(svo); l-- > 1;)
        filter_sparse(gpu, state, svo, l);
    list_dense(gpu, state, svo);
    filter_listed(gpu, state, svo, 0);
    for (uint32_t c = 1; c < svo->cascades; c++)
        over_list(gpu, state, svo, SVO_FILTER_UP, KD_COUNT_UP + c, (uint32_t[8]){c});
    filter_above(gpu, state, svo);
}
