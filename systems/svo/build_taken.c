/* What the builds `atomic` and `levels` share: nodes and cells take their numbers from counters, in the order
 * in which threads come. The tree is empty before (svo_begin_nodes); after it the tables are those of any
 * other build. Cells lie beside their leaves, as static cells do. */
#include "runtime/core/log.h"
#include "shaders/shared/bindings.h"
#include "systems/svo/internal.h"

void svo_bind_taken(kd_gpu *gpu, const kd_svo *svo, const kd_voxel_scene *scene)
{
    const kd_voxel_pages *pages = &scene->pages[KD_LAYER_DYNAMIC];
    kd_gpu_bind_storage(gpu, 0, svo->counters);
    kd_gpu_bind_storage(gpu, 1, pages->segments);
    kd_gpu_bind_storage(gpu, 2, pages->voxels);
    kd_gpu_bind_storage(gpu, 3, svo->index);
    kd_gpu_bind_storage(gpu, 4, svo->nodes);
    kd_gpu_bind_storage(gpu, 5, svo->taken);
    kd_gpu_bind_storage(gpu, 6, svo->sums);
    kd_gpu_bind_storage(gpu, 7, svo->book);
}

void svo_add_taken(kd_gpu *gpu, svo_state *state, const kd_svo *svo, const kd_voxel_scene *scene)
{
    const kd_voxel_pages *pages = &scene->pages[KD_LAYER_DYNAMIC];
    uint32_t slots = pages->page_count * KD_PAGE_SEGMENTS, pass[4] = {svo->dynamic_room, 0, slots, 0};
    kd_texel_view_bind(gpu, &state->object_view, 0, scene->object_params, KD_RGBA32F);
    svo_bind_taken(gpu, svo, scene);
    kd_gpu_bind_uniform(gpu, 0, pass, sizeof pass);
    kd_gpu_dispatch_linear(gpu, state->programs[SVO_TAKEN_ADD], slots * (KD_SEGMENT_VOXELS / 128));
    kd_gpu_barrier(gpu, KD_BARRIER_STORAGE);
    state->bytes_build += pages->voxel_count * (KD_PAGE_WORDS * 4 + 11 * 8);
}

/* Bits of masks, counts in the cascades and lists of work from the tables. */
static void finish(kd_gpu *gpu, svo_state *state, const kd_svo *svo)
{
    uint32_t levels = svo_levels(svo), settle[4] = {svo->dynamic_room, 0, 0, 0},
             pack[4] = {svo->dynamic_room, levels - 1, 0, 0};
    for (uint32_t l = 0; l < levels; l++) {
        uint32_t pass[4] = {l, 0, 0, 0};
        svo_args(gpu, state, svo, KD_COUNT_NEED + l, svo->node_room[l], 1, KD_ARGS_LIST);
        kd_gpu_bind_uniform(gpu, 0, pass, sizeof pass);
        kd_gpu_bind_storage(gpu, 1, svo->level_masks);
        kd_gpu_bind_storage(gpu, 7, svo->book);
        kd_gpu_dispatch_indirect(gpu, state->programs[SVO_TAKEN_LIST], svo->counters, KD_ARGS_LIST * 4);
        kd_gpu_barrier(gpu, KD_BARRIER_STORAGE);
    }
    kd_gpu_bind_uniform(gpu, 0, settle, sizeof settle);
    kd_gpu_dispatch(gpu, state->programs[SVO_TAKEN_SETTLE], 1, 1, 1);
    kd_gpu_barrier(gpu, KD_BARRIER_STORAGE);
    svo_args(gpu, state, svo, KD_COUNT_HIGH, svo->node_capacity, 1, KD_ARGS_ALL);
    svo_args(gpu, state, svo, KD_COUNT_HIGH, svo->node_capacity, 8, KD_ARGS_LIST);
    kd_gpu_bind_storage(gpu, 3, svo->index);
    kd_gpu_bind_storage(gpu, 4, svo->nodes);
    kd_gpu_bind_storage(gpu, 5, svo->taken);
    kd_gpu_bind_uniform(gpu, 0, pack, sizeof pack);
    kd_gpu_dispatch_linear(gpu, state->programs[SVO_TAKEN_BLOCKS], (svo->node_capacity + 63) / 64);
    kd_gpu_barrier(gpu, KD_BARRIER_STORAGE);
    kd_gpu_bind_storage(gpu, 1, svo->sums);
    kd_gpu_bind_storage(gpu, 2, svo->taken);
    kd_gpu_bind_storage(gpu, 3, svo->static_albedo);
    kd_gpu_bind_storage(gpu, 4, svo->static_emission);
    kd_gpu_bind_storage(gpu, 5, svo->leaves);
    kd_gpu_bind_storage(gpu, 7, svo->book);
    kd_gpu_dispatch_indirect(gpu, state->programs[SVO_TAKEN_PACK], svo->counters, KD_ARGS_LIST * 4);
    kd_gpu_barrier(gpu, KD_BARRIER_STORAGE | KD_BARRIER_BUFFER_UPDATE);
}

static void empty_sums(kd_gpu *gpu, const kd_svo *svo, uint32_t cells)
{
    kd_gpu_barrier(gpu, KD_BARRIER_BUFFER_UPDATE);
    kd_gpu_fill_buffer(gpu, svo->sums, 0, (size_t)cells * KD_SUM_WORDS * 4, 0);
    kd_gpu_barrier(gpu, KD_BARRIER_STORAGE);
}

static void make_once(kd_gpu *gpu, svo_state *state, kd_svo *svo, const kd_voxel_scene *scene,
                      svo_build *fill)
{
    kd_gpu_fill_buffer(gpu, svo->counters, KD_COUNT_DYNAMIC * 4, 4, 0);
    kd_gpu_fill_buffer(gpu, svo->counters, KD_COUNT_NEED * 4, KD_MAX_NODE_LEVELS * 4, 0);
    empty_sums(gpu, svo, svo->dynamic_room);
    if (scene->pages[KD_LAYER_DYNAMIC].segment_count)
        fill(gpu, state, svo, scene);
    finish(gpu, state, svo);
}

/* Room for nodes and cells, or for as many as there may be. Where there is no memory for it, what is there
 * has to do. */
static kd_status reserve(kd_gpu *gpu, svo_state *state, kd_svo *svo, const kd_voxel_scene *scene,
                         const uint64_t *nodes, uint64_t cells)
{
    uint64_t most_nodes = svo->most_bytes / 64, most_cells = svo->most_bytes / (KD_SUM_WORDS * 4);
    double want[KD_MAX_NODE_LEVELS] = {0}, none[KD_MAX_NODE_LEVELS] = {0};
    for (uint32_t l = 0; l < svo_levels(svo); l++) /* cells have numbers too, eight a leaf parent */
        want[l] = (double)(nodes[l] < most_nodes ? nodes[l] : most_nodes);
    svo_fit_tables(svo, none, want, state->nodes_wanted);
    state->nodes.wanted = state->nodes_wanted[svo_levels(svo) - 1];
    state->sums.wanted = (uint32_t)(cells < most_cells ? cells : most_cells);
    kd_status nodes_made = svo_reserve_nodes(gpu, svo, state->nodes_wanted);
    kd_status cells_made = svo_reserve_sums(gpu, svo, state->sums.wanted);
    state->leaves.wanted = kd_svo_wide_blocks(svo) ? 8 * state->nodes.wanted : state->sums.wanted;
    if (!cells_made)
        cells_made = svo_reserve_leaves(
            gpu, svo, kd_svo_wide_blocks(svo) ? 8ull * svo->node_capacity : svo->sum_capacity);
    svo->dynamic_room = svo->sum_capacity;
    svo_write_params(gpu, svo, scene);
    return nodes_made ? nodes_made : cells_made;
}

/* Twice the room where there was too little; false when all had room, or no more is to be had. Asked in every
 * frame, since another pose may need more: these builds make everything anew and read their counters. */
static bool grow(kd_gpu *gpu, svo_state *state, kd_svo *svo, const kd_voxel_scene *scene)
{
    uint32_t levels = svo_levels(svo), had = kd_svo_nodes_before(svo, 0, levels), cells = svo->dynamic_room;
    uint64_t nodes[KD_MAX_NODE_LEVELS];
    bool short_of_nodes = false;
    for (uint32_t l = 0; l < levels; l++) {
        bool is_short = svo_read_counter(gpu, svo, KD_COUNT_NEED + l) > svo->node_room[l];
        nodes[l] = (is_short ? 2ull : 1ull) * svo->node_room[l];
        short_of_nodes = short_of_nodes || is_short;
    }
    bool short_of_cells = svo_read_counter(gpu, svo, KD_COUNT_FRESH) > cells;
    if (!short_of_nodes && !short_of_cells)
        return false;
    kd_status made = reserve(gpu, state, svo, scene, nodes, (short_of_cells ? 2ull : 1ull) * cells);
    if (kd_svo_nodes_before(svo, 0, levels) > had || svo->dynamic_room > cells)
        return true;
    svo_say_once(state, SVO_SAID_TAKEN,
                 "octree: %s more than %u nodes and %u cells; what comes last is left out; raise %s",
                 made ? "no memory for" : "no room for", svo->node_capacity, cells,
                 made ? "voxels.span" : "svo.memory or voxels.span");
    return false;
}

/* Surfaces share two to three cells a voxel in any pose, and up to one leaf parent. */
static void reserve_for(kd_gpu *gpu, svo_state *state, kd_svo *svo, const kd_voxel_scene *scene,
                        uint64_t voxels)
{
    uint64_t nodes[KD_MAX_NODE_LEVELS];
    for (uint32_t l = 0; l < KD_MAX_NODE_LEVELS; l++)
        nodes[l] = voxels + 1024;
    reserve(gpu, state, svo, scene, nodes, 3 * voxels + 1024);
}

void svo_build_taken(kd_gpu *gpu, svo_state *state, kd_svo *svo, const kd_voxel_scene *scene, svo_build *fill)
{
    const kd_voxel_pages *pages = &scene->pages[KD_LAYER_DYNAMIC];
    if (pages->changed)
        reserve_for(gpu, state, svo, scene, pages->voxel_count);
    do {
        if (kd_gpu_ensure_buffer(gpu, &svo->taken, (size_t)svo->node_capacity * 32, 0, "svo.taken") !=
            KD_OK) {
            kd_log(KD_LOG_WARNING, "octree: no memory for the cells of %u nodes; the tree stays as it is",
                   svo->node_capacity);
            return;
        }
        svo_empty_nodes(gpu, state, svo);
        make_once(gpu, state, svo, scene, fill);
    } while (grow(gpu, state, svo, scene));
}
