/* Cells of the two layers: attributes of voxels are added up in fixed point, at the rank of the cell's mask
 * bit, then packed. Nothing depends on the order of threads. Where there is not room for the sums of all
 * cells at once they are done in rounds, each for a range of ranks.
 *
 * The dynamic layer comes anew every frame and keeps its cells in the order of the bits. Of the static layer
 * the cells of stale bricks come anew; they go beside their leaves, where they stay while those do. */
#include "runtime/core/log.h"
#include "shaders/shared/bindings.h"
#include "systems/svo/internal.h"

enum { GROUP = 128 };

/* Room for a layer's cells, kept until its members change. Surfaces share two to three cells a voxel in any
 * pose, wires up to four, and what is counted now may lie on the lattice: twice the count covers that. */
static uint32_t cells_in_any_pose(const kd_svo *svo, uint32_t counted, uint64_t voxels)
{
    uint64_t most = svo->most_bytes / 16;
    uint64_t want = voxels * 3 > (uint64_t)counted * 2 ? voxels * 3 : (uint64_t)counted * 2;
    return (uint32_t)(want + 1024 < most ? want + 1024 : most);
}

void svo_empty_sums(kd_gpu *gpu, const kd_svo *svo, uint32_t cells)
{
    kd_gpu_barrier(gpu, KD_BARRIER_BUFFER_UPDATE);
    kd_gpu_fill_buffer(gpu, svo->sums, 0, (size_t)cells * KD_SUM_WORDS * 4, 0);
    kd_gpu_barrier(gpu, KD_BARRIER_STORAGE);
}

static void accumulate_dynamic(kd_gpu *gpu, svo_state *state, const kd_svo *svo, const kd_voxel_scene *scene,
                               const uint32_t pass[4])
{
    const kd_voxel_pages *pages = &scene->pages[KD_LAYER_DYNAMIC];
    kd_gpu_bind_uniform(gpu, 0, pass, 16);
    kd_gpu_bind_storage(gpu, 0, pages->segments);
    kd_gpu_bind_storage(gpu, 1, scene->object_params);
    kd_gpu_bind_storage(gpu, 2, scene->cache_shape);
    kd_gpu_bind_storage(gpu, 3, scene->cache_color);
    kd_gpu_bind_storage(gpu, 4, pages->voxels);
    kd_gpu_bind_storage(gpu, 5, svo->moving);
    kd_gpu_bind_storage(gpu, 7, svo->sums);
    kd_gpu_dispatch(gpu, state->programs[SVO_ACCUMULATE], KD_SEGMENT_VOXELS / GROUP,
                    pages->page_count * KD_PAGE_SEGMENTS, 1);
    kd_gpu_barrier(gpu, KD_BARRIER_STORAGE);
    state->bytes_build += pages->voxel_count * (12 + 4 + 4 + 11 * 8);
}

static void pack_dynamic(kd_gpu *gpu, const svo_state *state, const kd_svo *svo, const uint32_t pass[4])
{
    svo_args(gpu, state, svo, KD_COUNT_DYNAMIC, pass[1], 1, KD_ARGS_DYNAMIC);
    kd_gpu_bind_uniform(gpu, 0, pass, 16);
    kd_gpu_bind_storage(gpu, 0, svo->counters);
    kd_gpu_bind_storage(gpu, 1, svo->sums);
    kd_gpu_bind_storage(gpu, 2, svo->dynamic_cells);
    kd_gpu_dispatch_indirect(gpu, state->programs[SVO_PACK], svo->counters, KD_ARGS_DYNAMIC * 4);
    kd_gpu_barrier(gpu, KD_BARRIER_STORAGE | KD_BARRIER_BUFFER_UPDATE);
}

/* Room for the sums of so many cells, or of as many as there is room for; returns how many make a round. */
static uint32_t reserve_round(kd_gpu *gpu, svo_state *state, kd_svo *svo, uint32_t cells)
{
    uint32_t most = (uint32_t)(svo->most_bytes / (KD_SUM_WORDS * 4)), want = cells < most ? cells : most;
    if (svo_reserve_sums(gpu, svo, want) != KD_OK)
        svo_say_once(state, SVO_SAID_SUMS,
                     "octree: no memory for the sums of %u cells at once; they are "
                     "done in rounds of %u",
                     want, svo->sum_capacity);
    state->sums.wanted = want > state->sums.wanted ? want : state->sums.wanted;
    return svo->sum_capacity < want ? svo->sum_capacity : want;
}

/* Room is settled when the layer's members change, so that no frame depends on what earlier ones needed. */
static void settle_dynamic(kd_gpu *gpu, svo_state *state, kd_svo *svo, const kd_voxel_scene *scene)
{
    const kd_voxel_pages *pages = &scene->pages[KD_LAYER_DYNAMIC];
    if (!pages->changed && svo->dynamic_room)
        return;
    uint32_t counted = svo_read_counter(gpu, svo, KD_COUNT_DYNAMIC);
    uint32_t want = cells_in_any_pose(svo, counted, pages->voxel_count);
    bool made = svo_reserve_dynamic(gpu, svo, want) == KD_OK;
    svo->dynamic_room = svo->dynamic_capacity < want ? svo->dynamic_capacity : want;
    state->dynamic.wanted = svo->dynamic_room;
    if (!made || counted > svo->dynamic_room)
        svo_say_once(state, SVO_SAID_DYNAMIC,
                     "octree: room for %u of %u cells of what moves; the "
                     "outermost ones stay dark; raise svo.memory or voxels.span",
                     svo->dynamic_room, counted);
}

void svo_build_dynamic(kd_gpu *gpu, svo_state *state, kd_svo *svo, const kd_voxel_scene *scene)
{
    if (!scene->pages[KD_LAYER_DYNAMIC].segment_count || !svo->has_moving) {
        kd_gpu_fill_buffer(gpu, svo->counters, KD_COUNT_DYNAMIC * 4, 4, 0);
        svo->dynamic_room = state->dynamic.wanted = 0;
        return;
    }
    if (kd_gpu_rank_run(gpu, &state->rank, svo->moving, 0, svo->layer_words, svo->moving, svo->layer_words,
                        svo->counters, KD_COUNT_DYNAMIC) != KD_OK)
        kd_log(KD_LOG_WARNING, "octree: moving voxels cannot be numbered; they are left out");
    kd_gpu_barrier(gpu, KD_BARRIER_STORAGE | KD_BARRIER_BUFFER_UPDATE);
    state->bytes_build += (uint64_t)svo->layer_words * 12;
    settle_dynamic(gpu, state, svo, scene);
    uint32_t cells = reserve_round(gpu, state, svo, svo->dynamic_room);
    for (uint32_t first = 0; cells && first < svo->dynamic_room; first += cells) {
        uint32_t left = svo->dynamic_room - first;
        uint32_t pass[4] = {first, left < cells ? left : cells, svo->layer_words, 0};
        svo_empty_sums(gpu, svo, pass[1]);
        accumulate_dynamic(gpu, state, svo, scene, pass);
        pack_dynamic(gpu, state, svo, pass);
    }
}

static void accumulate_static(kd_gpu *gpu, const svo_state *state, const kd_svo *svo,
                              const kd_voxel_scene *scene, const uint32_t pass[4])
{
    kd_gpu_bind_uniform(gpu, 0, pass, 16);
    kd_gpu_bind_uniform(gpu, 1, &scene->stale_places, sizeof scene->stale_places);
    kd_gpu_bind_storage(gpu, 0, scene->stale);
    kd_gpu_bind_storage(gpu, 1, scene->pages[KD_LAYER_STATIC].segments);
    kd_gpu_bind_storage(gpu, 2, scene->object_params);
    kd_gpu_bind_storage(gpu, 3, scene->chunk_params);
    kd_gpu_bind_storage(gpu, 4, scene->cache_shape);
    kd_gpu_bind_storage(gpu, 5, scene->cache_color);
    kd_gpu_bind_storage(gpu, 6, svo->fresh);
    kd_gpu_bind_storage(gpu, 7, svo->sums);
    kd_gpu_dispatch_indirect(gpu, state->programs[SVO_ACCUMULATE_STATIC], scene->stale, 0);
    kd_gpu_barrier(gpu, KD_BARRIER_STORAGE);
}

static void pack_static(kd_gpu *gpu, const svo_state *state, const kd_svo *svo, const kd_voxel_scene *scene,
                        const uint32_t pass[4])
{
    kd_gpu_bind_uniform(gpu, 0, pass, 16);
    kd_gpu_bind_storage(gpu, 0, svo->counters);
    kd_gpu_bind_storage(gpu, 1, svo->sums);
    kd_gpu_bind_storage(gpu, 2, svo->fresh);
    kd_gpu_bind_storage(gpu, 3, svo->static_surface);
    kd_gpu_bind_storage(gpu, 4, svo->static_emission);
    kd_gpu_bind_uniform(gpu, 1, &scene->stale_places, sizeof scene->stale_places);
    kd_gpu_bind_storage(gpu, 5, scene->stale);
    kd_gpu_bind_storage(gpu, 7, svo->book);
    kd_gpu_dispatch_indirect(gpu, state->programs[SVO_PACK_STATIC], svo->counters, KD_ARGS_TOUCHED * 4);
    kd_gpu_barrier(gpu, KD_BARRIER_STORAGE);
}

/* After the nodes: cells go beside leaves, which must have their places. */
void svo_build_static(kd_gpu *gpu, svo_state *state, kd_svo *svo, const kd_voxel_scene *scene)
{
    uint32_t words = scene->stale_patch_count * 8;
    if (kd_gpu_rank_run(gpu, &state->rank, svo->fresh, 0, words, svo->fresh, svo->fresh_words, svo->counters,
                        KD_COUNT_FRESH) != KD_OK)
        kd_log(KD_LOG_WARNING, "octree: new voxels cannot be numbered; they are left out");
    kd_gpu_barrier(gpu, KD_BARRIER_STORAGE | KD_BARRIER_BUFFER_UPDATE);
    uint32_t fresh = svo_read_counter(gpu, svo, KD_COUNT_FRESH);
    state->bytes_build += (uint64_t)words * 12 + (uint64_t)fresh * (KD_SUM_WORDS * 8 + 16);
    uint32_t cells = reserve_round(gpu, state, svo, fresh);
    for (uint32_t first = 0; cells && first < fresh; first += cells) {
        uint32_t left = fresh - first;
        uint32_t pass[4] = {first, left < cells ? left : cells, svo->fresh_words, svo_levels(svo) - 1};
        svo_empty_sums(gpu, svo, pass[1]);
        accumulate_static(gpu, state, svo, scene, pass);
        pack_static(gpu, state, svo, scene, pass);
    }
}
