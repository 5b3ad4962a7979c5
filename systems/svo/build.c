/* The order-free build. Masks of occupied cells come from the transform; here:
 *   1. ranks of a layer's mask bits give every occupied cell a number; attributes of the voxels are added up
 * there;
 *   2. both layers' masks are joined and reduced, level by level; ranks of each level number its nodes;
 *   3. lists (node to code) and the node table (children, eight at a time) follow from masks and ranks alone.
 * Nothing depends on the order of threads. Source of the bottom-up idea: Karras 2012; of the level structure:
 * Yalciner 2016, section 4.4 and 4.5, where nodes are allocated top-down with atomics instead. */
#include "systems/svo/build.h"

#include "runtime/core/log.h"
#include "shaders/shared/bindings.h"

enum { GROUP = 128 };

static uint32_t groups(uint32_t count)
{
    return (count + 63) / 64;
}

static uint32_t counter_of(kd_voxel_layer layer)
{
    return layer == KD_LAYER_STATIC ? KD_COUNT_STATIC : KD_COUNT_DYNAMIC;
}

/* Room for a layer's cells, kept until its members change. Surfaces share two to three cells a voxel in any
 * pose, wires up to four, and what is counted now may lie on the lattice: twice the count covers that. */
static uint32_t cells_in_any_pose(kd_gpu *gpu, uint32_t counted, uint64_t voxels)
{
    uint64_t most = (uint64_t)kd_gpu_get_info(gpu)->max_ssbo_bytes / (KD_SUM_WORDS * 4);
    uint64_t want = voxels * 3 > (uint64_t)counted * 2 ? voxels * 3 : (uint64_t)counted * 2;
    return (uint32_t)(want + 1024 < most ? want + 1024 : most);
}

static uint32_t read_counter(kd_gpu *gpu, const kd_svo *svo, uint32_t counter)
{
    uint32_t value = 0;
    kd_gpu_barrier(gpu, KD_BARRIER_BUFFER_UPDATE);
    kd_gpu_read_buffer(gpu, svo->counters, counter * 4, &value, sizeof value);
    return value;
}

static void accumulate_layer(kd_gpu *gpu, svo_state *state, const kd_svo *svo, const kd_voxel_scene *scene,
                             kd_voxel_layer layer, uint32_t capacity)
{
    const kd_voxel_pages *pages = &scene->pages[layer];
    uint32_t slots = pages->page_count * KD_PAGE_SEGMENTS, pass[4] = {slots, capacity, 0, 0};
    size_t layer_bytes = (size_t)svo->layer_words * 4, first = layer * layer_bytes;
    kd_gpu_bind_uniform(gpu, 0, pass, sizeof pass);
    kd_gpu_bind_uniform_buffer(gpu, KD_BIND_TREE, svo->uniform, 0, sizeof(struct kd_tree_params));
    kd_gpu_bind_storage(gpu, 0, pages->segments);
    kd_gpu_bind_storage(gpu, 1, scene->object_params);
    kd_gpu_bind_storage(gpu, 2, scene->cache_shape);
    kd_gpu_bind_storage(gpu, 3, scene->cache_color);
    kd_gpu_bind_storage(gpu, 4, pages->voxels);
    kd_gpu_bind_storage_range(gpu, 5, svo->masks, first, layer_bytes);
    kd_gpu_bind_storage_range(gpu, 6, svo->ranks, first, layer_bytes);
    kd_gpu_bind_storage(gpu, 7, svo->sums);
    kd_gpu_dispatch(gpu, state->accumulate, KD_SEGMENT_VOXELS / GROUP, slots, 1);
    state->bytes_build += pages->voxel_count * (12 + 4 + 4 + 11 * 8);
}

static void pack_layer(kd_gpu *gpu, svo_state *state, const kd_svo *svo, kd_voxel_layer layer,
                       uint32_t capacity)
{
    uint32_t pass[4] = {counter_of(layer), capacity, 0, 0};
    kd_gpu_bind_uniform(gpu, 0, pass, sizeof pass);
    kd_gpu_bind_storage(gpu, 0, svo->counters);
    kd_gpu_bind_storage(gpu, 1, svo->sums);
    kd_gpu_bind_storage(gpu, 2, layer == KD_LAYER_STATIC ? svo->static_cells : svo->dynamic_cells);
    kd_gpu_dispatch_indirect(gpu, state->pack, svo->counters,
                             (layer == KD_LAYER_STATIC ? KD_ARGS_STATIC : KD_ARGS_DYNAMIC) * 4);
}

static void write_args(kd_gpu *gpu, svo_state *state, const kd_svo *svo)
{
    uint32_t pass[4] = {kd_svo_leaf_parent_level(svo) - KD_DENSE_LOG2, svo->node_capacity, svo->dynamic_room,
                        svo->static_room};
    struct {
        uint32_t first[4], size[4], cascades[4];
    } levels = {.cascades = {svo->cascades}};
    for (uint32_t l = 0; l < svo->leaf_level - KD_DENSE_LOG2; l++) {
        levels.first[l] = svo->mask_first[l];
        levels.size[l] = svo->mask_words[l] / svo->cascades;
    }
    kd_gpu_bind_uniform(gpu, 0, pass, sizeof pass);
    kd_gpu_bind_uniform(gpu, 1, &levels, sizeof levels);
    kd_gpu_bind_storage(gpu, 0, svo->counters);
    kd_gpu_bind_storage(gpu, 1, svo->level_ranks);
    kd_gpu_dispatch(gpu, state->args, 1, 1, 1);
    kd_gpu_barrier(gpu, KD_BARRIER_STORAGE | KD_BARRIER_INDIRECT);
}

void build_layer(kd_gpu *gpu, svo_state *state, kd_svo *svo, const kd_voxel_scene *scene,
                 kd_voxel_layer layer)
{
    uint32_t first = layer * svo->layer_words;
    kd_gpu_rank_run(gpu, &state->rank, svo->masks, first, svo->layer_words, svo->ranks, first, svo->counters,
                    counter_of(layer));
    kd_gpu_barrier(gpu, KD_BARRIER_STORAGE);
    state->bytes_build += (uint64_t)svo->layer_words * 12;
    if (!scene->pages[layer].segment_count)
        return;
    /* The static layer is built when something was loaded or the cascades moved: one wait does not count
     * then. The dynamic layer's room is settled when its members change, so that no frame depends on what
     * earlier ones needed. */
    uint32_t *capacity = layer == KD_LAYER_STATIC ? &svo->static_capacity : &svo->dynamic_capacity;
    uint32_t *in_use = layer == KD_LAYER_STATIC ? &svo->static_room : &svo->dynamic_room;
    uint32_t want = *in_use;
    if (layer == KD_LAYER_STATIC)
        want = read_counter(gpu, svo, counter_of(layer));
    else if (scene->pages[layer].changed || !want)
        want = cells_in_any_pose(gpu, read_counter(gpu, svo, counter_of(layer)),
                                 scene->pages[layer].voxel_count);
    if (want > *capacity && svo_reserve_cells(gpu, svo, layer, want) != KD_OK)
        kd_log(KD_LOG_WARNING, "octree: no room for %u cells; some voxels are left out", want);
    uint32_t room = *in_use = *capacity < want ? *capacity : want;
    kd_gpu_fill_buffer(gpu, svo->sums, 0, (size_t)room * KD_SUM_WORDS * 4, 0);
    write_args(gpu, state, svo);
    accumulate_layer(gpu, state, svo, scene, layer, room);
    kd_gpu_barrier(gpu, KD_BARRIER_STORAGE);
    pack_layer(gpu, state, svo, layer, room);
    kd_gpu_barrier(gpu, KD_BARRIER_STORAGE | KD_BARRIER_BUFFER_UPDATE);
}

static void merge_masks(kd_gpu *gpu, svo_state *state, const kd_svo *svo)
{
    uint32_t top = kd_svo_leaf_parent_level(svo) - KD_DENSE_LOG2, words = svo->mask_words[top];
    uint32_t pass[4] = {words, 0, 0, 0};
    size_t layer_bytes = (size_t)svo->layer_words * 4;
    kd_gpu_bind_uniform(gpu, 0, pass, sizeof pass);
    kd_gpu_bind_storage_range(gpu, 0, svo->masks, 0, layer_bytes);
    kd_gpu_bind_storage_range(gpu, 1, svo->masks, layer_bytes, layer_bytes);
    kd_gpu_bind_storage_range(gpu, 2, svo->level_masks, (size_t)svo->mask_first[top] * 4, (size_t)words * 4);
    kd_gpu_dispatch(gpu, state->merge, groups(words), 1, 1);
    kd_gpu_barrier(gpu, KD_BARRIER_STORAGE);
    for (uint32_t l = top; l-- > 0;) {
        uint32_t up[4] = {svo->mask_words[l], svo->mask_first[l + 1], svo->mask_first[l], 0};
        kd_gpu_bind_uniform(gpu, 0, up, sizeof up);
        kd_gpu_bind_storage(gpu, 0, svo->level_masks);
        kd_gpu_dispatch(gpu, state->reduce, groups(svo->mask_words[l]), 1, 1);
        kd_gpu_barrier(gpu, KD_BARRIER_STORAGE);
    }
    state->bytes_build += (uint64_t)svo->layer_words * 8;
}

static void list_level(kd_gpu *gpu, svo_state *state, const kd_svo *svo, uint32_t l)
{
    uint32_t pass[4] = {svo->mask_words[l], svo->mask_first[l], svo->node_capacity, l * svo->node_capacity};
    kd_gpu_bind_uniform(gpu, 0, pass, sizeof pass);
    kd_gpu_bind_storage(gpu, 0, svo->level_masks);
    kd_gpu_bind_storage(gpu, 1, svo->level_ranks);
    kd_gpu_bind_storage(gpu, 2, svo->lists[svo->current]);
    kd_gpu_bind_storage(gpu, 3, svo->index);
    kd_gpu_dispatch(gpu, l == 0 ? state->list_dense : state->list, groups(svo->mask_words[l]), 1, 1);
}

static void node_table(kd_gpu *gpu, svo_state *state, const kd_svo *svo, uint32_t l)
{
    uint32_t cap = svo->node_capacity,
             pass[4] = {KD_COUNT_LEVEL + l, svo->mask_first[l + 1], cap, l * 8 * cap};
    uint32_t place[4] = {l * cap, cap, 0, 0};
    kd_gpu_bind_uniform(gpu, 0, pass, sizeof pass);
    kd_gpu_bind_uniform(gpu, 1, place, sizeof place);
    kd_gpu_bind_storage(gpu, 0, svo->level_masks);
    kd_gpu_bind_storage(gpu, 1, svo->level_ranks);
    kd_gpu_bind_storage(gpu, 2, svo->lists[svo->current]);
    kd_gpu_bind_storage(gpu, 3, svo->counters);
    kd_gpu_bind_storage(gpu, 4, svo->nodes);
    kd_gpu_dispatch_indirect(gpu, state->nodes, svo->counters, (KD_ARGS_LEVEL + 3 * l) * 4);
}

/* Nodes are counted, with one wait, when a layer's members changed or the static layer was built anew; the
 * dynamic layer gets room for every pose, as with cells. */
static void reserve_nodes(kd_gpu *gpu, kd_svo *svo, const kd_voxel_scene *scene)
{
    bool counted = scene->static_changed || scene->pages[KD_LAYER_DYNAMIC].changed;
    if (!counted)
        return;
    uint32_t top = kd_svo_leaf_parent_level(svo) - KD_DENSE_LOG2;
    uint32_t want = read_counter(gpu, svo, KD_COUNT_LEVEL + top) + 1024;
    want += want / 4 + (uint32_t)scene->pages[KD_LAYER_DYNAMIC].voxel_count;
    uint64_t most = (uint64_t)kd_gpu_get_info(gpu)->max_ssbo_bytes / (8 * 8);
    want = want < most ? want : (uint32_t)most;
    if (want > svo->node_capacity && svo_reserve_nodes(gpu, svo, want) != KD_OK)
        kd_log(KD_LOG_WARNING, "octree: no room for %u nodes; some voxels are left out", want);
}

void build_tree(kd_gpu *gpu, svo_state *state, kd_svo *svo, const kd_voxel_scene *scene)
{
    uint32_t levels = svo->leaf_level - KD_DENSE_LOG2;
    /* the last frame's dense cells, to be emptied by the filter: groups and count */
    kd_gpu_copy_buffer(gpu, svo->counters, KD_ARGS_LEVEL * 4, svo->counters, KD_ARGS_PREVIOUS * 4, 12);
    kd_gpu_copy_buffer(gpu, svo->counters, KD_COUNT_LEVEL * 4, svo->counters, KD_COUNT_PREVIOUS * 4, 4);
    svo->current ^= 1;
    merge_masks(gpu, state, svo);
    for (uint32_t l = 0; l < levels; l++) {
        kd_gpu_rank_run(gpu, &state->rank, svo->level_masks, svo->mask_first[l], svo->mask_words[l],
                        svo->level_ranks, svo->mask_first[l], svo->counters, KD_COUNT_LEVEL + l);
        kd_gpu_barrier(gpu, KD_BARRIER_STORAGE);
    }
    reserve_nodes(gpu, svo, scene);
    svo->list_capacity[svo->current] = svo->node_capacity;
    svo_write_params(gpu, svo, scene);
    write_args(gpu, state, svo);
    kd_gpu_fill_buffer(gpu, svo->index, 0, kd_gpu_buffer_size(gpu, svo->index), KD_EMPTY);
    kd_gpu_barrier(gpu, KD_BARRIER_STORAGE);
    for (uint32_t l = 0; l < levels; l++)
        list_level(gpu, state, svo, l);
    kd_gpu_barrier(gpu, KD_BARRIER_STORAGE);
    for (uint32_t l = 0; l + 1 < levels; l++)
        node_table(gpu, state, svo, l);
}
