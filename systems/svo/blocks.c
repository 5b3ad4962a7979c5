/* Blocks: the leaves of a parent that there are, one after the other, with what is known of static cells
 * beside them. Of what stands still a block is taken when its cells come and given back when they go; free
 * ones wait on lists by size. Behind them each parent in which something moves has eight leaves of its own,
 * at its rank, made anew every frame; its static cells keep their block meanwhile.
 *
 * Which block a parent gets depends on the order of threads, but how many are free does not, and where leaves
 * lie cannot be seen. When no room is left all blocks are moved together into buffers that are larger. */
#include "runtime/core/log.h"
#include "shaders/shared/bindings.h"
#include "systems/svo/internal.h"

enum { PLACES, COPY, WORDS }; /* steps of shaders/svo/gather_blocks.comp */

static uint32_t leaf_parents(const kd_svo *svo)
{
    return svo_levels(svo) - 1;
}

static void bind_book(kd_gpu *gpu, const kd_svo *svo)
{
    kd_gpu_bind_storage(gpu, 0, svo->counters);
    kd_gpu_bind_storage(gpu, 3, svo->index);
    kd_gpu_bind_storage(gpu, 4, svo->nodes);
    kd_gpu_bind_storage(gpu, 7, svo->book);
}

/* ---- room ---- */

/* Slots of leaves of what moves. */
static uint64_t moving_slots(const kd_svo *svo)
{
    return svo->has_moving ? 8ull * svo->dynamic_capacity : 0;
}

/* Slots of static leaves that there may be. */
static uint32_t most_leaves(const kd_svo *svo)
{
    uint64_t most = svo_most_slots(svo->most_bytes);
    return most > moving_slots(svo) ? (uint32_t)(most - moving_slots(svo)) : 0;
}

kd_status svo_fit_leaves(kd_gpu *gpu, kd_svo *svo)
{
    size_t size = (svo->leaf_room + moving_slots(svo)) * 8, still = (size_t)svo->leaf_room * 8;
    if (svo->leaves.id && kd_gpu_buffer_size(gpu, svo->leaves) == size)
        return KD_OK;
    kd_gpu_buffer made =
        kd_gpu_make_buffer(gpu, &(kd_gpu_buffer_desc){.size = size, .zeroed = true, .name = "tree.leaves"});
    if (!made.id)
        return KD_GPU;
    kd_gpu_barrier(gpu, KD_BARRIER_BUFFER_UPDATE);
    if (svo->leaves.id && still)
        kd_gpu_copy_buffer(gpu, svo->leaves, 0, made, 0, still);
    kd_gpu_barrier(gpu, KD_BARRIER_STORAGE);
    kd_gpu_destroy_buffer(gpu, svo->leaves);
    svo->leaves = made;
    return KD_OK;
}

typedef struct gathered {
    kd_gpu_buffer leaves, albedo, emission, moved;
    uint32_t room; /* slots of static leaves */
} gathered;

static void destroy_buffers(kd_gpu *gpu, const kd_gpu_buffer *buffers, size_t count)
{
    for (size_t i = 0; i < count; i++)
        kd_gpu_destroy_buffer(gpu, buffers[i]);
}

/* Errors: nothing is left of them. */
static bool make_gathered(kd_gpu *gpu, const kd_svo *svo, uint32_t room, gathered *g)
{
    const struct {
        kd_gpu_buffer *buffer;
        size_t size;
        const char *name;
    } rows[] = {
        {&g->leaves, ((room ? room : 1) + moving_slots(svo)) * 8, "tree.leaves"},
        {&g->albedo, (size_t)(room ? room : 1) * 4, "svo.static_albedo"},
        {&g->emission, svo_emission_bytes(svo, room), "svo.static_emission"},
        {&g->moved, (size_t)svo->node_capacity * 4, "svo.moved_blocks"},
    };
    bool all = true;
    g->room = room;
    for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
        *rows[i].buffer = kd_gpu_make_buffer(
            gpu, &(kd_gpu_buffer_desc){.size = rows[i].size, .zeroed = true, .name = rows[i].name});
        all = all && rows[i].buffer->id;
    }
    if (!all) {
        kd_gpu_buffer made[] = {g->leaves, g->albedo, g->emission, g->moved};
        destroy_buffers(gpu, made, sizeof made / sizeof *made);
    }
    return all;
}

/* They take the place of those that were there. */
static void take_gathered(kd_gpu *gpu, kd_svo *svo, const gathered *g)
{
    kd_gpu_buffer gone[] = {svo->leaves, svo->static_albedo, svo->static_emission, g->moved};
    destroy_buffers(gpu, gone, sizeof gone / sizeof *gone);
    svo->leaves = g->leaves;
    svo->static_albedo = g->albedo;
    svo->static_emission = g->emission;
    svo->leaf_room = svo->places.blocks.w = g->room;
}

static void step(kd_gpu *gpu, const svo_state *state, const kd_svo *svo, const gathered *g, uint32_t what,
                 kd_gpu_buffer from, kd_gpu_buffer to, uint32_t words)
{
    uint32_t pass[4] = {leaf_parents(svo), what, words, g->room};
    bind_book(gpu, svo);
    kd_gpu_bind_uniform(gpu, 0, pass, sizeof pass);
    if (what == COPY) {
        kd_gpu_bind_storage(gpu, 1, from);
        kd_gpu_bind_storage(gpu, 2, to);
    }
    kd_gpu_bind_storage(gpu, 5, g->moved);
    kd_gpu_dispatch_linear(gpu, state->programs[SVO_GATHER_BLOCKS], (svo->node_capacity + 63) / 64);
    kd_gpu_barrier(gpu, KD_BARRIER_STORAGE);
}

kd_status svo_gather_blocks(kd_gpu *gpu, const svo_state *state, kd_svo *svo, uint32_t room)
{
    gathered g = {0};
    if (!make_gathered(gpu, svo, room, &g))
        return KD_GPU;
    kd_gpu_barrier(gpu, KD_BARRIER_STORAGE | KD_BARRIER_BUFFER_UPDATE);
    kd_gpu_fill_buffer(gpu, svo->counters, KD_COUNT_TOP * 4, 4, 0);
    kd_gpu_fill_buffer(gpu, svo->counters, (KD_COUNT_BLOCKS + 1) * 4, 8 * 4, 0);
    kd_gpu_bind_uniform(gpu, KD_BIND_SVO, &svo->places, sizeof svo->places);
    kd_gpu_barrier(gpu, KD_BARRIER_STORAGE);
    step(gpu, state, svo, &g, PLACES, g.leaves, g.leaves, 0);
    step(gpu, state, svo, &g, COPY, svo->leaves, g.leaves, 2);
    step(gpu, state, svo, &g, COPY, svo->static_albedo, g.albedo, 1);
    if (svo->glows)
        step(gpu, state, svo, &g, COPY, svo->static_emission, g.emission, 2);
    step(gpu, state, svo, &g, WORDS, g.leaves, g.leaves, 0);
    take_gathered(gpu, svo, &g);
    kd_gpu_bind_uniform(gpu, KD_BIND_SVO, &svo->places, sizeof svo->places);
    return KD_OK;
}

kd_status svo_reserve_leaves(kd_gpu *gpu, kd_svo *svo, uint64_t leaves)
{
    uint32_t most = most_leaves(svo), room = leaves < most ? (uint32_t)leaves : most;
    gathered g = {0};
    if (room <= svo->leaf_room)
        return KD_OK;
    if (!make_gathered(gpu, svo, room, &g))
        return KD_GPU;
    take_gathered(gpu, svo, &g);
    return KD_OK;
}

/* Slots beyond those in use that the blocks take which are on no list. */
static uint64_t wanted_slots(const uint32_t *counts, uint32_t listed_room)
{
    uint64_t slots = 0;
    for (uint32_t n = 1; n <= 8; n++) {
        uint32_t listed =
            counts[KD_COUNT_BLOCKS + n] < listed_room ? counts[KD_COUNT_BLOCKS + n] : listed_room;
        uint32_t wanted = counts[KD_COUNT_WANTED + n];
        slots += wanted > listed ? (uint64_t)n * (wanted - listed) : 0;
    }
    return slots;
}

/* Slots of static leaves, at most. */
static uint32_t slots_in_use(const kd_svo *svo, const uint32_t *counts)
{
    uint32_t slots = 0;
    for (uint32_t c = 0; c < svo->cascades; c++)
        slots += kd_svo_wide_blocks(svo) ? 8 * counts[KD_COUNT_NODES + c] : counts[KD_COUNT_CELLS + c];
    return slots;
}

/* Room for the blocks that are wanted in this frame, beside what moves: waits for their counts. */
static void make_room(kd_gpu *gpu, svo_state *state, kd_svo *svo, const kd_voxel_scene *scene)
{
    uint32_t counts[KD_COUNT_WORDS], most = most_leaves(svo);
    kd_gpu_barrier(gpu, KD_BARRIER_BUFFER_UPDATE);
    kd_gpu_read_buffer(gpu, svo->counters, 0, counts, sizeof counts);
    uint32_t leaves = slots_in_use(svo, counts);
    state->leaves.wanted = leaves;
    if (svo->leaf_room <= most &&
        counts[KD_COUNT_TOP] + wanted_slots(counts, svo->places.blocks.z) <= svo->leaf_room)
        return;
    uint64_t want = (uint64_t)leaves + leaves / SVO_SPARE + 1024;
    kd_status made = svo_gather_blocks(gpu, state, svo, want < most ? (uint32_t)want : most);
    svo_write_params(gpu, svo, scene);
    if (made || leaves > most)
        svo_say_once(state, SVO_SAID_LEAVES, "octree: %s for %u leaves; some are left out; raise %s",
                     made ? "no memory" : "no room", leaves,
                     made ? "voxels.span" : "svo.memory or voxels.span");
}

/* ---- passes ---- */

static void over_touched(kd_gpu *gpu, const svo_state *state, const kd_svo *svo, const kd_voxel_scene *scene,
                         svo_program program, svo_marks marks)
{
    uint32_t pass[4] = {leaf_parents(svo), marks.first, marks.count, 0};
    bind_book(gpu, svo);
    kd_gpu_bind_uniform(gpu, 0, pass, sizeof pass);
    kd_gpu_bind_uniform(gpu, 1, &scene->stale_places, sizeof scene->stale_places);
    kd_gpu_bind_storage(gpu, 1, svo->fresh);
    kd_gpu_bind_storage(gpu, 2, svo->work);
    kd_gpu_bind_storage(gpu, 5, scene->stale);
    kd_gpu_dispatch_indirect(gpu, state->programs[program], svo->counters, KD_ARGS_LIST * 4);
    kd_gpu_barrier(gpu, KD_BARRIER_STORAGE);
}

static void bind_show(kd_gpu *gpu, const kd_svo *svo)
{
    uint32_t pass[4] = {leaf_parents(svo), kd_svo_moving_room(svo), kd_svo_parent_words(svo),
                        svo->moved_room};
    bind_book(gpu, svo);
    kd_gpu_bind_uniform(gpu, 0, pass, sizeof pass);
    kd_gpu_bind_storage(gpu, 2, svo->moving);
}

static void show_moving(kd_gpu *gpu, svo_state *state, const kd_svo *svo)
{
    uint32_t short_of[4] = {state->short_of_slots};
    bind_show(gpu, svo);
    kd_gpu_bind_uniform(gpu, 1, short_of, sizeof short_of);
    kd_texel_view_bind(gpu, &state->moving_view, 0, svo->has_moving ? svo->moving : svo->masks, KD_RGBA32UI);
    kd_texel_view_bind(gpu, &state->still_view, 1, svo->masks, KD_RGBA32UI);
    kd_texel_view_bind(gpu, &state->moved_view, 2, svo->moved, KD_RGBA32UI);
    kd_gpu_bind_storage(gpu, 1, svo->moved_room ? svo->moved_cells : svo->moving);
    kd_gpu_bind_storage(gpu, 5, svo->dynamic_cells);
    kd_gpu_bind_storage(gpu, 6, svo->moved);
    kd_gpu_dispatch_linear(gpu, state->programs[SVO_SHOW_MOVING], (kd_svo_parent_words(svo) / 4 + 63) / 64);
    kd_gpu_barrier(gpu, KD_BARRIER_STORAGE | KD_BARRIER_TEXTURE);
}

void svo_build_blocks(kd_gpu *gpu, svo_state *state, kd_svo *svo, const kd_voxel_scene *scene)
{
    if (scene->static_changed) {
        svo_args(gpu, state, svo, KD_COUNT_TOUCHED, svo->node_capacity, 1, KD_ARGS_LIST);
        for (svo_marks marks = {0, 0}; svo_next_marks(gpu, state, svo, scene, &marks);)
            over_touched(gpu, state, svo, scene, SVO_RELEASE_BLOCKS, marks);
    }
    if (scene->static_changed || svo->leaf_room > most_leaves(svo)) /* what moves has come, or needs more */
        make_room(gpu, state, svo, scene);
    if (scene->static_changed) {
        over_touched(gpu, state, svo, scene, SVO_TAKE_BLOCKS, (svo_marks){0, 0});
        kd_gpu_bind_storage(gpu, 0, svo->counters);
        kd_gpu_bind_storage(gpu, 7, svo->book);
        kd_gpu_dispatch(gpu, state->programs[SVO_SETTLE_BLOCKS], 1, 1, 1);
        kd_gpu_barrier(gpu, KD_BARRIER_STORAGE);
    }
    if (svo_fit_leaves(gpu, svo) != KD_OK) {
        svo_say_once(state, SVO_SAID_LEAVES, "octree: no memory for the leaves of what moves; it stays dark");
        /* Nothing leads to leaves that are not there, and nothing stays chained; tried again in the next
         * frame. */
        svo->dynamic_room = state->dynamic.wanted = 0;
        svo_cut_dynamic(gpu, svo, &state->dynamic);
        svo_write_params(gpu, svo, scene);
    }
    if (scene->static_changed) {
        bind_show(gpu, svo);
        kd_gpu_bind_storage(gpu, 1, svo->work);
        kd_gpu_dispatch_indirect(gpu, state->programs[SVO_SHOW_BLOCKS], svo->counters, KD_ARGS_LIST * 4);
        kd_gpu_barrier(gpu, KD_BARRIER_STORAGE);
    }
    if (scene->pages[KD_LAYER_DYNAMIC].segment_count > 0 || state->dynamic_before)
        show_moving(gpu, state, svo);
}
