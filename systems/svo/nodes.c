/* The tree above the cells, kept from frame to frame:
 *   1. the static layer's cells and the leaf parents of the dynamic one are joined and reduced, level by
 * level;
 *   2. what differs from the masks of the frame before is nodes that go and nodes that come. Those that go
 * give their numbers back, from below; those that come take numbers, from above, both in the order of their
 *      codes by the ranks of their bits;
 *   3. leaf parents whose cells may have changed are listed, for the attributes and the light.
 * Nothing depends on the order of threads. Source of the bottom-up idea: Karras 2012; of the level structure:
 * Yalciner 2016, section 4.4 and 4.5, where nodes are allocated top-down with atomics instead. */
#include "runtime/core/log.h"
#include "shaders/shared/bindings.h"
#include "systems/svo/internal.h"

static uint32_t groups(uint32_t count)
{
    return (count + 63) / 64;
}

static void bind_book(kd_gpu *gpu, const kd_svo *svo)
{
    kd_gpu_bind_storage(gpu, 0, svo->counters);
    kd_gpu_bind_storage(gpu, 3, svo->index);
    kd_gpu_bind_storage(gpu, 4, svo->nodes);
    kd_gpu_bind_storage(gpu, 7, svo->book);
}

static size_t dense_bytes(const kd_svo *svo)
{
    return (size_t)svo->cascades * KD_DENSE_WORDS * 4;
}

static uint32_t most_room(const kd_svo *svo)
{
    uint32_t most = 0;
    for (uint32_t l = 0; l < svo_levels(svo); l++)
        most = svo->node_room[l] > most ? svo->node_room[l] : most;
    return most;
}

void svo_empty_nodes(kd_gpu *gpu, const svo_state *state, const kd_svo *svo)
{
    kd_gpu_barrier(gpu, KD_BARRIER_BUFFER_UPDATE);
    kd_gpu_fill_buffer(gpu, svo->level_masks, 0, kd_gpu_buffer_size(gpu, svo->level_masks), 0);
    kd_gpu_fill_buffer(gpu, svo->index, 0, kd_gpu_buffer_size(gpu, svo->index), KD_EMPTY);
    kd_gpu_fill_buffer(gpu, svo->counters, KD_COUNT_NODES * 4, 16 * 4, 0);
    kd_gpu_fill_buffer(gpu, svo->counters, KD_COUNT_TOP * 4, 4, 0);
    kd_gpu_fill_buffer(gpu, svo->counters, KD_COUNT_CELLS * 4, (KD_COUNT_WORDS - KD_COUNT_CELLS) * 4, 0);
    size_t blocks = (size_t)(&svo->places.child.x)[svo_levels(svo) - 1] * 4;
    kd_gpu_fill_buffer(gpu, svo->nodes, blocks, kd_gpu_buffer_size(gpu, svo->nodes) - blocks, 0);
    kd_gpu_barrier(gpu, KD_BARRIER_STORAGE | KD_BARRIER_BUFFER_UPDATE);
    kd_gpu_bind_uniform(gpu, KD_BIND_SVO, &svo->places, sizeof svo->places);
    bind_book(gpu, svo);
    kd_gpu_dispatch_linear(gpu, state->programs[SVO_EMPTY], groups(most_room(svo)));
    kd_gpu_barrier(gpu, KD_BARRIER_STORAGE | KD_BARRIER_BUFFER_UPDATE);
}

/* Lists and bits of work are empty but for the dense cells of stale bricks, which show another place now. */
void svo_begin_nodes(kd_gpu *gpu, svo_state *state, kd_svo *svo, const kd_voxel_scene *scene)
{
    size_t first = (size_t)svo->places.changed.x * 4,
           node_bits = svo_rows(svo->node_room, 1, svo_levels(svo)) / 8;
    kd_gpu_barrier(gpu, KD_BARRIER_STORAGE | KD_BARRIER_BUFFER_UPDATE);
    kd_gpu_fill_buffer(gpu, svo->counters, KD_COUNT_TRANSIENT * 4,
                       (KD_COUNT_TRANSIENT_END - KD_COUNT_TRANSIENT) * 4, 0);
    kd_gpu_fill_buffer(gpu, svo->counters, (KD_COUNT_WANTED + 1) * 4, 16 * 4, 0);
    if (scene->moved) /* what is above the outermost cascade is counted from its corner */
        kd_gpu_fill_buffer(gpu, svo->counters, (KD_COUNT_UP + svo->cascades) * 4, 4, 1);
    kd_gpu_fill_buffer(gpu, svo->book, (size_t)svo->places.others.y * 4, dense_bytes(svo), 0);
    kd_gpu_fill_buffer(gpu, svo->book, (size_t)svo->places.news.x * 4, dense_bytes(svo),
                       svo->again ? KD_EMPTY : 0);
    if (svo_levels(svo) > 1)
        kd_gpu_fill_buffer(gpu, svo->book, (size_t)svo->places.changed.y * 4, node_bits, 0);
    if (scene->static_changed)
        kd_gpu_copy_buffer(gpu, scene->stale, (size_t)scene->stale_places.bits * 4, svo->book, first,
                           dense_bytes(svo));
    else
        kd_gpu_fill_buffer(gpu, svo->book, first, dense_bytes(svo), 0);
    kd_gpu_bind_uniform(gpu, KD_BIND_SVO, &svo->places, sizeof svo->places);
    if (scene->one_layer || svo->again) { /* what held something is to be emptied, or filled anew */
        kd_gpu_copy_buffer(gpu, svo->book, (size_t)svo->places.others.x * 4, svo->book, first,
                           dense_bytes(svo));
        svo_empty_nodes(gpu, state, svo);
    }
    kd_gpu_barrier(gpu, KD_BARRIER_STORAGE);
}

/* First of the bits in `diff`, one a word, of what has changed in a level's mask. */
static uint32_t changed_words(const kd_svo *svo, uint32_t l)
{
    return svo->mask_first[l] / 32;
}

static void bind_merge(kd_gpu *gpu, svo_state *state, const kd_svo *svo, uint32_t count, uint32_t first)
{
    uint32_t top = svo_levels(svo) - 1;
    uint32_t pass[8] = {
        count, svo->mask_first[top], svo_levels(svo), changed_words(svo, top), svo->has_moving, first};
    kd_gpu_bind_uniform(gpu, 0, pass, sizeof pass);
    kd_texel_view_bind(gpu, &state->moving_view, 0, svo->has_moving ? svo->moving : svo->masks, KD_RGBA32UI);
    kd_gpu_bind_storage(gpu, 0, svo->counters);
    kd_gpu_bind_storage(gpu, 2, svo->diff);
    kd_gpu_bind_storage(gpu, 3, svo->level_masks);
    kd_gpu_bind_storage(gpu, 7, svo->book);
}

/* What was built anew. */
static void merge_stale(kd_gpu *gpu, svo_state *state, const kd_svo *svo, const kd_voxel_scene *scene,
                        svo_marks marks)
{
    bind_merge(gpu, state, svo, marks.count, marks.first);
    kd_gpu_bind_uniform(gpu, 1, &scene->stale_places, sizeof scene->stale_places);
    kd_gpu_bind_storage(gpu, 1, svo->masks);
    kd_gpu_bind_storage(gpu, 5, scene->stale);
    kd_gpu_bind_storage(gpu, 6, svo->fresh);
    kd_gpu_dispatch_linear(gpu, state->programs[SVO_MERGE_STALE], groups(marks.count));
    kd_gpu_barrier(gpu, KD_BARRIER_STORAGE | KD_BARRIER_TEXTURE);
}

/* What moves, or did. Nodes that stayed away are asked for once more. */
static void merge_moving(kd_gpu *gpu, svo_state *state, const kd_svo *svo)
{
    uint32_t words = kd_svo_parent_words(svo);
    bind_merge(gpu, state, svo, words, 0);
    kd_texel_view_bind(gpu, &state->still_view, 1, svo->masks, KD_RGBA32UI);
    kd_texel_view_bind(gpu, &state->moved_view, 2, svo->moved, KD_RGBA32UI);
    kd_gpu_dispatch_linear(gpu, state->programs[SVO_MERGE], groups(words / 4));
    kd_gpu_barrier(gpu, KD_BARRIER_STORAGE | KD_BARRIER_TEXTURE | KD_BARRIER_BUFFER_UPDATE);
    kd_gpu_fill_buffer(gpu, svo->counters, KD_COUNT_AWAY * 4, 4, 0);
}

static void reduce_level(kd_gpu *gpu, const svo_state *state, const kd_svo *svo, uint32_t l)
{
    uint32_t blocks = svo->mask_words[l] / 32;
    uint32_t pass[8] = {blocks, svo->mask_first[l + 1],    svo->mask_first[l],
                        0,      changed_words(svo, l + 1), changed_words(svo, l)};
    kd_gpu_bind_uniform(gpu, 0, pass, sizeof pass);
    kd_gpu_bind_storage(gpu, 0, svo->level_masks);
    kd_gpu_bind_storage(gpu, 1, svo->diff);
    kd_gpu_dispatch(gpu, state->programs[SVO_REDUCE], groups(blocks), 1, 1);
    kd_gpu_barrier(gpu, KD_BARRIER_STORAGE);
}

/* Masks of both layers joined, from those of the frame before: words are made anew where something changed.
 */
static void merge_masks(kd_gpu *gpu, svo_state *state, kd_svo *svo, const kd_voxel_scene *scene)
{
    uint32_t top = svo_levels(svo) - 1;
    kd_gpu_fill_buffer(gpu, svo->diff, (size_t)changed_words(svo, top) * 4, svo->mask_words[top] / 8, 0);
    kd_gpu_copy_buffer(gpu, svo->level_masks, 0, svo->before, 0, kd_gpu_buffer_size(gpu, svo->level_masks));
    kd_gpu_barrier(gpu, KD_BARRIER_STORAGE | KD_BARRIER_TEXTURE);
    svo_marks marks = {0, 0};
    while (scene->static_changed && svo_next_marks(gpu, state, svo, scene, &marks))
        merge_stale(gpu, state, svo, scene, marks);
    if (scene->pages[KD_LAYER_DYNAMIC].segment_count > 0 || state->dynamic_before)
        merge_moving(gpu, state, svo);
    for (uint32_t l = top; l-- > 0;)
        reduce_level(gpu, state, svo, l);
    state->bytes_build += (uint64_t)kd_svo_parent_words(svo) * 24;
}

/* Entries of two words that the list of mask words has room for. */
static uint32_t list_room(kd_gpu *gpu, const kd_svo *svo)
{
    return (uint32_t)(kd_gpu_buffer_size(gpu, svo->work) / 8);
}

/* The list of words in which nodes of level 6 + l go, or come, and the sums of their bits. */
static void find_changes(kd_gpu *gpu, svo_state *state, const kd_svo *svo, uint32_t l, bool come,
                         kd_gpu_buffer sums)
{
    uint32_t words = svo->mask_words[l], parents = l > 0 ? svo->mask_first[l - 1] : KD_EMPTY;
    uint32_t pass[8] = {words / 32, svo->mask_first[l],    come,
                        parents,    changed_words(svo, l), list_room(gpu, svo)};
    kd_gpu_bind_uniform(gpu, 0, pass, sizeof pass);
    kd_gpu_bind_storage(gpu, 0, svo->counters);
    kd_gpu_bind_storage(gpu, 1, svo->before);
    kd_gpu_bind_storage(gpu, 2, svo->diff);
    kd_gpu_bind_storage(gpu, 3, svo->level_masks);
    kd_gpu_bind_storage(gpu, 4, svo->work);
    kd_gpu_bind_storage(gpu, 5, sums);
    kd_gpu_bind_storage(gpu, 7, svo->book);
    kd_gpu_dispatch(gpu, state->programs[SVO_DIFF], groups(words / 32), 1, 1);
    kd_gpu_barrier(gpu, KD_BARRIER_STORAGE);
    kd_gpu_rank_scan(gpu, &state->rank, words, svo->counters, KD_COUNT_DIFF);
    kd_gpu_barrier(gpu, KD_BARRIER_STORAGE);
}

static void change_level(kd_gpu *gpu, svo_state *state, const kd_svo *svo, uint32_t l, bool come)
{
    uint32_t room = list_room(gpu, svo), at[4] = {room, l, svo->mask_first[l], 0},
             settle[4] = {l, come, 0, 0};
    kd_gpu_buffer sums = kd_gpu_rank_sums(gpu, &state->rank, svo->mask_words[l]);
    find_changes(gpu, state, svo, l, come, sums);
    svo_args(gpu, state, svo, KD_COUNT_PARTS, room, 1, KD_ARGS_LIST);
    bind_book(gpu, svo);
    kd_gpu_bind_uniform(gpu, 0, at, sizeof at);
    kd_gpu_bind_storage(gpu, 1, svo->before);
    kd_gpu_bind_storage(gpu, 2, svo->work);
    kd_gpu_bind_storage(gpu, 5, svo->level_masks);
    kd_gpu_bind_storage(gpu, 6, sums);
    kd_gpu_dispatch_indirect(gpu, state->programs[come ? SVO_COME : SVO_VANISH], svo->counters,
                             KD_ARGS_LIST * 4);
    kd_gpu_barrier(gpu, KD_BARRIER_STORAGE);
    kd_gpu_bind_uniform(gpu, 0, settle, sizeof settle);
    kd_gpu_dispatch(gpu, state->programs[SVO_SETTLE], 1, 1, 1);
    kd_gpu_barrier(gpu, KD_BARRIER_STORAGE);
}

/* Nodes that the masks ask for. */
static void count_nodes(kd_gpu *gpu, svo_state *state, const kd_svo *svo,
                        uint32_t counted[KD_MAX_NODE_LEVELS])
{
    for (uint32_t l = 0; l < svo_levels(svo); l++)
        if (kd_gpu_rank_count(gpu, &state->rank, svo->level_masks, svo->mask_first[l], svo->mask_words[l],
                              svo->counters, KD_COUNT_NEED + l) != KD_OK)
            kd_log(KD_LOG_WARNING, "octree: nodes cannot be counted; some may stay away");
    kd_gpu_barrier(gpu, KD_BARRIER_BUFFER_UPDATE);
    kd_gpu_read_buffer(gpu, svo->counters, KD_COUNT_NEED * 4, counted, KD_MAX_NODE_LEVELS * 4);
}

/* Nodes of a level in any pose of what moves: a node a voxel of the leaf parents, half as many of each level
 * above, as wires have, seven more for each thing that may lie across the corner of eight, and no more than
 * the level has cells. */
static uint64_t nodes_in_any_pose(const kd_svo *svo, uint32_t l, uint32_t counted,
                                  const kd_voxel_pages *moving)
{
    uint64_t want =
        counted + 1024ull + (moving->voxel_count >> (svo_levels(svo) - 1 - l)) + 7ull * moving->segment_count;
    uint64_t cells = svo->mask_words[l] * 32ull;
    return want < cells ? want : cells;
}

/* Nodes are counted, with one wait, when a layer's members changed or static parts were built anew; the
 * dynamic layer gets room for every pose, as with cells. */
static void reserve_nodes(kd_gpu *gpu, svo_state *state, kd_svo *svo, const kd_voxel_scene *scene,
                          const uint32_t *counted)
{
    uint32_t room[KD_MAX_NODE_LEVELS];
    double least[KD_MAX_NODE_LEVELS] = {0}, want[KD_MAX_NODE_LEVELS] = {0};
    bool more = false;
    state->nodes_asked = 0;
    for (uint32_t l = 0; l < svo_levels(svo); l++) {
        uint64_t any_pose = nodes_in_any_pose(svo, l, counted[l], &scene->pages[KD_LAYER_DYNAMIC]);
        state->nodes_asked = any_pose > state->nodes_asked ? any_pose : state->nodes_asked;
        want[l] = (double)any_pose;
        least[l] = counted[l];
    }
    svo_fit_tables(svo, least, want, state->nodes_wanted);
    for (uint32_t l = 0; l < svo_levels(svo); l++) {
        bool grows = state->nodes_wanted[l] > svo->node_room[l];
        want[l] += grows ? want[l] / SVO_SPARE : 0;
        more = more || grows;
        least[l] = least[l] > svo->node_room[l] ? least[l] : svo->node_room[l]; /* what there is stays */
        want[l] = want[l] > least[l] ? want[l] : least[l];
    }
    more = more && svo_table_share(svo, least, svo->most_bytes) < 1;
    svo_fit_tables(svo, least, want, room);
    uint32_t top = svo_levels(svo) - 1;
    state->nodes.wanted = state->nodes_wanted[top];
    kd_status made = more ? svo_reserve_nodes(gpu, svo, room) : KD_OK;
    if (more) {
        kd_gpu_bind_uniform(gpu, KD_BIND_SVO, &svo->places, sizeof svo->places);
        svo_write_params(gpu, svo, scene);
    }
    if (counted[top] > svo->node_capacity)
        svo_say_once(state, SVO_SAID_NODES,
                     "octree: %s for %u of %u nodes; those of the outermost cascade stay away; raise %s",
                     made ? "memory" : "room", svo->node_capacity, counted[top],
                     made ? "voxels.span" : "svo.memory or voxels.span");
}

/* Room to list mask words of any level in which nodes go or come, no more than there are nodes or are to be;
 * then the touched leaf parents. */
static kd_status reserve_list(kd_gpu *gpu, svo_state *state, kd_svo *svo)
{
    uint64_t words = svo->mask_words[svo_levels(svo) - 1], nodes = most_room(svo),
             touched = svo->node_capacity;
    nodes = state->nodes_asked > nodes ? state->nodes_asked : nodes;
    words = 2 * (words < nodes ? words : nodes);
    return svo_reserve_work(gpu, svo, words > touched ? words : touched);
}

/* The nodes are those of the frame before; all words are to be looked at once more. */
static void leave_nodes(kd_gpu *gpu, svo_state *state, const kd_svo *svo)
{
    svo_say_once(state, SVO_SAID_WORK, SVO_NO_MEMORY);
    kd_gpu_copy_buffer(gpu, svo->before, 0, svo->level_masks, 0, kd_gpu_buffer_size(gpu, svo->level_masks));
    kd_gpu_fill_buffer(gpu, svo->counters, KD_COUNT_AWAY * 4, 4, 1);
    kd_gpu_barrier(gpu, KD_BARRIER_STORAGE);
}

/* Numbers of the touched leaf parents. */
static void list_touched(kd_gpu *gpu, svo_state *state, const kd_svo *svo, const kd_voxel_scene *scene)
{
    uint32_t top = svo_levels(svo) - 1, pass[4] = {scene->stale_patch_count, top, svo->mask_first[top], 0};
    bind_book(gpu, svo);
    kd_gpu_bind_uniform(gpu, 0, pass, sizeof pass);
    kd_gpu_bind_uniform(gpu, 1, &scene->stale_places, sizeof scene->stale_places);
    kd_gpu_bind_storage(gpu, 1, scene->stale);
    kd_gpu_bind_storage(gpu, 2, svo->work);
    kd_gpu_bind_storage(gpu, 5, svo->level_masks);
    kd_gpu_dispatch_linear(gpu, state->programs[SVO_TOUCHED], groups(pass[0]));
    kd_gpu_barrier(gpu, KD_BARRIER_STORAGE);
    svo_args(gpu, state, svo, KD_COUNT_TOUCHED, svo->node_capacity, 8, KD_ARGS_TOUCHED);
}

bool svo_build_nodes(kd_gpu *gpu, svo_state *state, kd_svo *svo, const kd_voxel_scene *scene)
{
    uint32_t levels = svo_levels(svo), counted[KD_MAX_NODE_LEVELS];
    if (svo_reserve_before(gpu, svo) != KD_OK) {
        svo_say_once(state, SVO_SAID_WORK, SVO_NO_MEMORY);
        return true;
    }
    merge_masks(gpu, state, svo, scene);
    if (svo_asks_for_room(state) || scene->static_changed || scene->pages[KD_LAYER_DYNAMIC].changed) {
        count_nodes(gpu, state, svo, counted);
        if (!svo_has_room(gpu, state, svo, scene, counted))
            return false;
        reserve_nodes(gpu, state, svo, scene, counted);
    }
    if (reserve_list(gpu, state, svo) != KD_OK) {
        leave_nodes(gpu, state, svo);
        return true;
    }
    for (uint32_t l = levels; l-- > 0;)
        change_level(gpu, state, svo, l, false);
    for (uint32_t l = 0; l < levels; l++)
        change_level(gpu, state, svo, l, true);
    if (scene->static_changed)
        list_touched(gpu, state, svo, scene);
    svo_args(gpu, state, svo, KD_COUNT_HIGH, svo->node_capacity, 1, KD_ARGS_ALL);
    return true;
}
