/* Cells of the dynamic layer, which come anew every frame. Its voxels are chained to the leaf parents whose
 * cells they cover, at the rank of the parent's mask bit, and one invocation a parent adds up its chain and
 * packs eight cells. Adding seven words to each cell that a voxel covers takes some forty atomics a voxel,
 * chains take three. Nothing depends on the order of threads: attributes are added up in integers. */
#include "runtime/core/log.h"
#include "shaders/shared/bindings.h"
#include "systems/svo/internal.h"

#define SLOT_CHAIN_BYTES ((size_t)KD_SEGMENT_VOXELS * SVO_CHAIN_BYTES)

/* Room is settled when the layer's members change, so that no frame depends on what earlier ones needed. */
static void settle_dynamic(kd_gpu *gpu, svo_state *state, kd_svo *svo, const kd_voxel_scene *scene)
{
    const kd_voxel_pages *pages = &scene->pages[KD_LAYER_DYNAMIC];
    if (!pages->changed && svo->dynamic_room)
        return;
    uint32_t counted = svo_read_counter(gpu, svo, KD_COUNT_PARENTS);
    uint32_t want = svo_parents_in_any_pose(svo->most_bytes, counted, svo_spread_voxels(pages));
    svo_reserve_dynamic(gpu, svo, want); /* if it fails, what there is has to do */
    svo->dynamic_room = svo->dynamic_capacity < want ? svo->dynamic_capacity : want;
    state->dynamic.wanted = svo->dynamic_room;
    state->moving_parents = counted;
}

void svo_say_dynamic(svo_state *state, const kd_svo *svo)
{
    if (state->moving_parents > svo->dynamic_room)
        svo_say_once(state, SVO_SAID_DYNAMIC,
                     "octree: room for the cells of what moves in %u of %u leaf parents; the "
                     "outermost ones stay dark; raise svo.memory or voxels.span",
                     svo->dynamic_room, state->moving_parents);
}

/* Segments whose voxels there is room to chain. */
static uint32_t reserve_slots(kd_gpu *gpu, svo_state *state, kd_svo *svo, uint32_t slots)
{
    uint32_t want = slots;
    if (svo_reserve_chains(gpu, svo, (uint64_t)want * KD_SEGMENT_VOXELS) != KD_OK)
        want = (uint32_t)(kd_gpu_buffer_size(gpu, svo->next) / SLOT_CHAIN_BYTES);
    if (want < slots)
        svo_say_once(
            state, SVO_SAID_CHAINS,
            "octree: room for %u of %u segments of what moves; the others stay dark; raise voxels.span", want,
            slots);
    return want;
}

/* Groups of voxels of so many slots, and the arguments of a dispatch over them. */
static void list_groups(kd_gpu *gpu, const svo_state *state, const kd_svo *svo, const kd_voxel_pages *pages,
                        uint32_t first, uint32_t slots)
{
    uint32_t pass[4] = {first, slots, 0, 0};
    kd_gpu_fill_buffer(gpu, svo->counters, KD_COUNT_PARTS * 4, 4, 0);
    kd_gpu_barrier(gpu, KD_BARRIER_STORAGE);
    kd_gpu_bind_uniform(gpu, 0, pass, sizeof pass);
    kd_gpu_bind_storage(gpu, 0, svo->counters);
    kd_gpu_bind_storage(gpu, 1, pages->segments);
    kd_gpu_bind_storage(gpu, 2, svo->groups);
    kd_gpu_dispatch_linear(gpu, state->programs[SVO_LINK_LIST], (slots + 63) / 64);
    kd_gpu_barrier(gpu, KD_BARRIER_STORAGE);
    svo_args(gpu, state, svo, KD_COUNT_PARTS, UINT32_MAX, KD_MOVING_GROUP, KD_ARGS_LIST);
}

/* Chains may be longer than a storage block of the driver: they are written in rounds, and read as texels. */
static void link_voxels(kd_gpu *gpu, svo_state *state, const kd_svo *svo, const kd_voxel_scene *scene,
                        uint32_t slots)
{
    const kd_voxel_pages *pages = &scene->pages[KD_LAYER_DYNAMIC];
    uint32_t round = (uint32_t)((uint64_t)kd_gpu_get_info(gpu)->max_ssbo_bytes / SLOT_CHAIN_BYTES);
    kd_texel_view_bind(gpu, &state->page_view, 0, pages->voxels, KD_RGBA32UI);
    for (uint32_t first = 0; first < slots; first += round) {
        uint32_t count = slots - first < round ? slots - first : round;
        uint32_t pass[4] = {svo->dynamic_room, kd_svo_parent_words(svo), first, 0};
        list_groups(gpu, state, svo, pages, first, count);
        kd_gpu_bind_uniform(gpu, 0, pass, sizeof pass);
        kd_gpu_bind_storage(gpu, 0, pages->segments);
        kd_gpu_bind_storage(gpu, 1, svo->moving);
        kd_gpu_bind_storage(gpu, 2, svo->heads);
        kd_gpu_bind_storage_range(gpu, 3, svo->next, first * SLOT_CHAIN_BYTES, count * SLOT_CHAIN_BYTES);
        kd_gpu_bind_storage(gpu, 4, svo->counters);
        kd_gpu_bind_storage(gpu, 5, svo->groups);
        kd_gpu_dispatch_indirect(gpu, state->programs[SVO_LINK], svo->counters, KD_ARGS_LIST * 4);
        kd_gpu_barrier(gpu, KD_BARRIER_STORAGE | KD_BARRIER_TEXTURE | KD_BARRIER_BUFFER_UPDATE);
    }
    kd_gpu_fill_buffer(gpu, svo->counters, KD_COUNT_PARTS * 4, 4, 0); /* the nodes' passes expect it so */
    kd_gpu_barrier(gpu, KD_BARRIER_STORAGE);
}

static void make_cells(kd_gpu *gpu, svo_state *state, const kd_svo *svo, const kd_voxel_scene *scene)
{
    const kd_voxel_pages *pages = &scene->pages[KD_LAYER_DYNAMIC];
    uint32_t pass[4] = {svo->dynamic_room, svo_levels(svo) - 1, svo->moved_room, 0};
    kd_texel_view_bind(gpu, &state->page_view, 0, pages->voxels, KD_RGBA32UI);
    svo_args(gpu, state, svo, KD_COUNT_PARENTS, svo->dynamic_room, 1, KD_ARGS_DYNAMIC);
    kd_gpu_bind_uniform(gpu, 0, pass, sizeof pass);
    kd_texel_view_bind(gpu, &state->next_view, 1, svo->next, KD_R32UI);
    kd_texel_view_bind(gpu, &state->segment_view, 2, pages->segments, KD_RGBA32UI);
    kd_texel_view_bind(gpu, &state->object_view, 3, scene->object_params, KD_RGBA32F);
    kd_gpu_bind_storage(gpu, 0, svo->counters);
    kd_gpu_bind_storage(gpu, 1, svo->heads);
    kd_gpu_bind_storage(gpu, 2, svo->dynamic_cells);
    kd_gpu_bind_storage(gpu, 3, svo->index);
    kd_gpu_bind_storage(gpu, 4, svo->nodes);
    kd_gpu_bind_storage(gpu, 5, svo->moved_room ? svo->moved_cells : svo->moving);
    kd_gpu_bind_storage(gpu, 7, svo->book);
    kd_gpu_dispatch_indirect(gpu, state->programs[SVO_CELLS], svo->counters, KD_ARGS_DYNAMIC * 4);
    kd_gpu_barrier(gpu, KD_BARRIER_STORAGE | KD_BARRIER_BUFFER_UPDATE);
}

void svo_build_dynamic(kd_gpu *gpu, svo_state *state, kd_svo *svo, const kd_voxel_scene *scene)
{
    const kd_voxel_pages *pages = &scene->pages[KD_LAYER_DYNAMIC];
    uint32_t words = kd_svo_parent_words(svo), slots = pages->page_count * KD_PAGE_SEGMENTS;
    kd_gpu_fill_buffer(gpu, svo->counters, KD_COUNT_DYNAMIC * 4, 4, 0);
    if (!pages->segment_count || !svo->has_moving) {
        svo->dynamic_room = state->dynamic.wanted = state->moving_parents = 0;
        return;
    }
    if (kd_gpu_rank_run(gpu, &state->rank, svo->moving, 0, words, svo->moving, words, svo->counters,
                        KD_COUNT_PARENTS) != KD_OK)
        kd_log(KD_LOG_WARNING, "octree: moving voxels cannot be numbered; they are left out");
    kd_gpu_barrier(gpu, KD_BARRIER_STORAGE | KD_BARRIER_BUFFER_UPDATE);
    settle_dynamic(gpu, state, svo, scene);
    uint32_t chained = reserve_slots(gpu, state, svo, slots);
    state->short_of_slots = chained < slots;
    state->linked_slots = svo->dynamic_room ? chained : 0;
    if (state->linked_slots)
        link_voxels(gpu, state, svo, scene, chained);
    state->bytes_build +=
        (uint64_t)words * 12 + pages->voxel_count * (2 * KD_PAGE_WORDS * 4 + SVO_CHAIN_BYTES);
}

/* When there are nodes, since each parent leads the tree to its leaves. */
void svo_build_moving_cells(kd_gpu *gpu, svo_state *state, kd_svo *svo, const kd_voxel_scene *scene)
{
    bool moves = scene->pages[KD_LAYER_DYNAMIC].segment_count > 0;
    if (moves && kd_svo_moving_room(svo) && state->linked_slots)
        make_cells(gpu, state, svo, scene);
    if (moves || state->dynamic_before)
        svo_keep_moving(gpu, svo);
}
