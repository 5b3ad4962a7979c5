/* Cells of the two layers: attributes of voxels are added up in fixed point, at the rank of the cell's mask
 * bit, then packed. Nothing depends on the order of threads.
 *
 * The dynamic layer comes anew every frame and keeps its cells in the order of the bits. Of the static layer
 * the cells of stale bricks come anew; they go beside their leaves, where they stay while those do. */
#include "runtime/core/log.h"
#include "shaders/shared/bindings.h"
#include "systems/svo/internal.h"

enum { GROUP = 128 };

/* Room for a layer's cells, kept until its members change. Surfaces share two to three cells a voxel in any
 * pose, wires up to four, and what is counted now may lie on the lattice: twice the count covers that. */
static uint32_t cells_in_any_pose(kd_gpu *gpu, uint32_t counted, uint64_t voxels)
{
    uint64_t most = (uint64_t)kd_gpu_get_info(gpu)->max_ssbo_bytes / (KD_SUM_WORDS * 4);
    uint64_t want = voxels * 3 > (uint64_t)counted * 2 ? voxels * 3 : (uint64_t)counted * 2;
    return (uint32_t)(want + 1024 < most ? want + 1024 : most);
}

static void accumulate_dynamic(kd_gpu *gpu, svo_state *state, const kd_svo *svo, const kd_voxel_scene *scene)
{
    const kd_voxel_pages *pages = &scene->pages[KD_LAYER_DYNAMIC];
    uint32_t slots = pages->page_count * KD_PAGE_SEGMENTS, pass[4] = {slots, svo->dynamic_room, 0, 0};
    size_t layer_bytes = (size_t)svo->layer_words * 4;
    kd_gpu_bind_uniform(gpu, 0, pass, sizeof pass);
    kd_gpu_bind_storage(gpu, 0, pages->segments);
    kd_gpu_bind_storage(gpu, 1, scene->object_params);
    kd_gpu_bind_storage(gpu, 2, scene->cache_shape);
    kd_gpu_bind_storage(gpu, 3, scene->cache_color);
    kd_gpu_bind_storage(gpu, 4, pages->voxels);
    kd_gpu_bind_storage_range(gpu, 5, svo->masks, layer_bytes, layer_bytes);
    kd_gpu_bind_storage(gpu, 6, svo->ranks);
    kd_gpu_bind_storage(gpu, 7, svo->sums);
    kd_gpu_dispatch(gpu, state->programs[SVO_ACCUMULATE], KD_SEGMENT_VOXELS / GROUP, slots, 1);
    state->bytes_build += pages->voxel_count * (12 + 4 + 4 + 11 * 8);
}

static void pack_dynamic(kd_gpu *gpu, const svo_state *state, const kd_svo *svo)
{
    uint32_t pass[4] = {KD_COUNT_DYNAMIC, svo->dynamic_room, 0, 0};
    svo_args(gpu, state, svo, KD_COUNT_DYNAMIC, svo->dynamic_room, 1, KD_ARGS_DYNAMIC);
    kd_gpu_bind_uniform(gpu, 0, pass, sizeof pass);
    kd_gpu_bind_storage(gpu, 0, svo->counters);
    kd_gpu_bind_storage(gpu, 1, svo->sums);
    kd_gpu_bind_storage(gpu, 2, svo->dynamic_cells);
    kd_gpu_dispatch_indirect(gpu, state->programs[SVO_PACK], svo->counters, KD_ARGS_DYNAMIC * 4);
    kd_gpu_barrier(gpu, KD_BARRIER_STORAGE | KD_BARRIER_BUFFER_UPDATE);
}

void svo_empty_sums(kd_gpu *gpu, const kd_svo *svo, uint32_t cells)
{
    kd_gpu_fill_buffer(gpu, svo->sums, 0, (size_t)cells * KD_SUM_WORDS * 4, 0);
    kd_gpu_barrier(gpu, KD_BARRIER_STORAGE);
}

/* Room is settled when the layer's members change, so that no frame depends on what earlier ones needed. */
static void settle_dynamic(kd_gpu *gpu, kd_svo *svo, const kd_voxel_scene *scene)
{
    const kd_voxel_pages *pages = &scene->pages[KD_LAYER_DYNAMIC];
    if (!pages->changed && svo->dynamic_room)
        return;
    uint32_t want = cells_in_any_pose(gpu, svo_read_counter(gpu, svo, KD_COUNT_DYNAMIC), pages->voxel_count);
    if (svo_reserve_dynamic(gpu, svo, want) != KD_OK || svo_reserve_sums(gpu, svo, want) != KD_OK)
        kd_log(KD_LOG_WARNING, "octree: no room for %u dynamic cells; some voxels are left out", want);
    svo->dynamic_room = svo->dynamic_capacity < want ? svo->dynamic_capacity : want;
    if (svo->sum_capacity < svo->dynamic_room)
        svo->dynamic_room = svo->sum_capacity;
}

void svo_build_dynamic(kd_gpu *gpu, svo_state *state, kd_svo *svo, const kd_voxel_scene *scene)
{
    if (!scene->pages[KD_LAYER_DYNAMIC].segment_count) {
        kd_gpu_fill_buffer(gpu, svo->counters, KD_COUNT_DYNAMIC * 4, 4, 0);
        return;
    }
    if (kd_gpu_rank_run(gpu, &state->rank, svo->masks, svo->layer_words, svo->layer_words, svo->ranks, 0,
                        svo->counters, KD_COUNT_DYNAMIC) != KD_OK)
        kd_log(KD_LOG_WARNING, "octree: moving voxels cannot be numbered; they are left out");
    kd_gpu_barrier(gpu, KD_BARRIER_STORAGE | KD_BARRIER_BUFFER_UPDATE);
    state->bytes_build += (uint64_t)svo->layer_words * 12;
    settle_dynamic(gpu, svo, scene);
    svo_empty_sums(gpu, svo, svo->dynamic_room);
    accumulate_dynamic(gpu, state, svo, scene);
    kd_gpu_barrier(gpu, KD_BARRIER_STORAGE);
    pack_dynamic(gpu, state, svo);
}

void svo_sum_static(kd_gpu *gpu, svo_state *state, kd_svo *svo, const kd_voxel_scene *scene)
{
    uint32_t words = scene->stale_patch_count * 8;
    if (kd_gpu_rank_run(gpu, &state->rank, svo->fresh, 0, words, svo->fresh, svo->layer_words, svo->counters,
                        KD_COUNT_FRESH) != KD_OK)
        kd_log(KD_LOG_WARNING, "octree: new voxels cannot be numbered; they are left out");
    kd_gpu_barrier(gpu, KD_BARRIER_STORAGE | KD_BARRIER_BUFFER_UPDATE);
    uint32_t fresh = svo_read_counter(gpu, svo, KD_COUNT_FRESH);
    state->bytes_build += (uint64_t)words * 12;
    if (!fresh)
        return;
    if (svo_reserve_sums(gpu, svo, fresh) != KD_OK)
        kd_log(KD_LOG_WARNING, "octree: no room for %u new cells; some voxels are left out", fresh);
    fresh = svo->sum_capacity < fresh ? svo->sum_capacity : fresh;
    svo_empty_sums(gpu, svo, fresh);
    uint32_t pass[4] = {svo->sum_capacity, svo->layer_words, 0, 0};
    kd_gpu_bind_uniform(gpu, 0, pass, sizeof pass);
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
    state->bytes_build += (uint64_t)fresh * (KD_SUM_WORDS * 8 + 16);
}

void svo_pack_static(kd_gpu *gpu, svo_state *state, const kd_svo *svo, const kd_voxel_scene *scene)
{
    uint32_t pass[4] = {svo->sum_capacity, svo->layer_words, svo_levels(svo) - 1, 0};
    kd_gpu_bind_uniform(gpu, 0, pass, sizeof pass);
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
