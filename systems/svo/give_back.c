/* Room that is given back. Buffers that have been more than half spare for QUIET runs are cut to what is
 * wanted. What they are wanted for follows from the scene alone, so giving back depends on no time, and as
 * node numbers cannot be seen it changes no picture. */
#include <stdlib.h>
#include <string.h>

#include "runtime/core/settings.h"
#include "shaders/shared/bindings.h"
#include "systems/svo/internal.h"

enum { QUIET = 64, LEAST = 4096, SLEEPING_SPARE = 64 };

static bool spare(svo_room *room, uint32_t capacity)
{
    uint32_t wanted = room->wanted > LEAST ? room->wanted : LEAST;
    room->quiet = wanted < capacity / 2 ? room->quiet + 1 : 0;
    if (room->quiet < QUIET)
        return false;
    room->quiet = 0;
    return true;
}

/* A buffer whose content nobody needs any more. */
static void cut(kd_gpu *gpu, kd_gpu_buffer *buffer, uint32_t *capacity, const svo_room *room, size_t size,
                const char *name)
{
    uint32_t cells = room->wanted > LEAST ? room->wanted : LEAST;
    kd_gpu_buffer made = kd_gpu_make_buffer(gpu, &(kd_gpu_buffer_desc){.size = cells * size, .name = name});
    if (!made.id)
        return;
    kd_gpu_destroy_buffer(gpu, *buffer);
    *buffer = made;
    *capacity = cells;
}

/* Cells and heads of chains have the same capacity. Nobody needs what is in them before the next build. */
void svo_cut_dynamic(kd_gpu *gpu, kd_svo *svo, const svo_room *room)
{
    kd_gpu_destroy_buffer(gpu, svo->dynamic_cells);
    kd_gpu_destroy_buffer(gpu, svo->heads);
    svo->dynamic_cells = svo->heads = (kd_gpu_buffer){0};
    svo->dynamic_capacity = 0;
    svo_reserve_dynamic(gpu, svo, room->wanted > LEAST ? room->wanted : LEAST);
}

/* Chains of static voxels, and their heads. */
static void cut_entries(kd_gpu *gpu, kd_svo *svo, const svo_room *room)
{
    kd_gpu_destroy_buffer(gpu, svo->entries);
    kd_gpu_destroy_buffer(gpu, svo->entry_glows);
    kd_gpu_destroy_buffer(gpu, svo->fresh_heads);
    svo->entries = svo->entry_glows = svo->fresh_heads = (kd_gpu_buffer){0};
    svo->entry_room = 0;
    svo_reserve_entries(gpu, svo, room->wanted > LEAST ? room->wanted : LEAST);
}

/* ---- nodes: they get the ranks of their codes as new numbers ---- */

enum { NODES, DATA, BOOK, PARTS };

typedef struct smaller {
    kd_gpu_buffer made[PARTS], moved_from, ranks;
    struct kd_svo_places places;
    uint32_t room[KD_MAX_NODE_LEVELS];
} smaller;

static void held(kd_svo *svo, kd_gpu_buffer *out[PARTS])
{
    kd_gpu_buffer *parts[PARTS] = {&svo->nodes, &svo->data, &svo->book};
    for (int i = 0; i < PARTS; i++)
        out[i] = parts[i];
}

/* `s`: with its room. */
static bool make_smaller(kd_gpu *gpu, const kd_svo *svo, smaller *s)
{
    static const char *const names[PARTS] = {"tree.nodes", "tree.data", "svo.book"};
    uint32_t levels = svo_levels(svo);
    s->places = svo->places;
    size_t book = (size_t)svo_place_nodes(svo, &s->places, s->room) * 4, most = 0;
    for (uint32_t l = 0; l < levels; l++)
        most = s->room[l] > most ? s->room[l] : most;
    const size_t sizes[PARTS] = {
        [NODES] = svo_node_bytes(svo, s->room), [DATA] = svo_rows(s->room, 1, levels) * 8, [BOOK] = book};
    bool all = true;
    for (int i = 0; i < PARTS; i++) {
        s->made[i] = kd_gpu_make_buffer(gpu, &(kd_gpu_buffer_desc){.size = sizes[i], .name = names[i]});
        all = all && s->made[i].id;
    }
    s->moved_from =
        kd_gpu_make_buffer(gpu, &(kd_gpu_buffer_desc){.size = most * 4, .name = "svo.moved_from"});
    s->ranks = kd_gpu_make_buffer(
        gpu, &(kd_gpu_buffer_desc){.size = svo->mask_words[levels - 1] * 4ul, .name = "svo.ranks"});
    return all && s->moved_from.id && s->ranks.id;
}

static void move_rows(kd_gpu *gpu, const svo_state *state, const smaller *s, kd_gpu_buffer from,
                      kd_gpu_buffer to, const uint32_t pass[4])
{
    kd_gpu_bind_uniform(gpu, 0, pass, 16);
    kd_gpu_bind_storage(gpu, 1, from);
    kd_gpu_bind_storage(gpu, 2, to);
    kd_gpu_bind_storage(gpu, 5, s->moved_from);
    kd_gpu_dispatch_linear(gpu, state->programs[SVO_MOVE],
                           (uint32_t)(((uint64_t)pass[0] * pass[1] + 63) / 64));
}

/* What belongs to the nodes of a level: the words of children, those that lead to their leaves, or the word
 * of a static block; filtered data. */
static void move_level(kd_gpu *gpu, const svo_state *state, const kd_svo *svo, const smaller *s, uint32_t l,
                       uint32_t count)
{
    const uint32_t *from = &svo->places.child.x, *to = &s->places.child.x, top = svo_levels(svo) - 1;
    if (l < top)
        move_rows(gpu, state, s, svo->nodes, s->made[NODES], (uint32_t[4]){8, count, from[l], to[l]});
    else
        move_rows(gpu, state, s, svo->book, s->made[BOOK],
                  (uint32_t[4]){1, count, svo->places.blocks.x, s->places.blocks.x});
    if (l + 1 == top)
        move_rows(gpu, state, s, svo->nodes, s->made[NODES], (uint32_t[4]){8, count, from[top], to[top]});
    uint32_t first = l > 1 ? (uint32_t)svo_rows(s->room, 1, l) : 0;
    if (l > 0)
        move_rows(gpu, state, s, svo->data, s->made[DATA],
                  (uint32_t[4]){2, count, 2 * kd_svo_data_first(svo, l), 2 * first});
    kd_gpu_barrier(gpu, KD_BARRIER_STORAGE);
}

static bool free_numbers(kd_gpu *gpu, const kd_svo *svo, const smaller *s, uint32_t l, uint32_t count)
{
    uint32_t left = s->room[l] - count, *stack = malloc((size_t)left * sizeof *stack + 4);
    if (!stack)
        return false;
    for (uint32_t i = 0; i < left; i++)
        stack[i] = s->room[l] - 1 - i;
    if (left)
        kd_gpu_write_buffer(gpu, s->made[BOOK], (size_t)(&s->places.free.x)[l] * 4, stack,
                            (size_t)left * sizeof *stack);
    kd_gpu_write_buffer(gpu, svo->counters, (KD_COUNT_FREE + l) * 4, &left, sizeof left);
    if (l + 1 == svo_levels(svo))
        kd_gpu_write_buffer(gpu, svo->counters, KD_COUNT_HIGH * 4, &count, sizeof count);
    free(stack);
    return true;
}

/* Nodes of level l: bits of its mask. */
static uint32_t rank_level(kd_gpu *gpu, svo_state *state, const kd_svo *svo, const smaller *s, uint32_t l)
{
    if (kd_gpu_rank_run(gpu, &state->rank, svo->level_masks, svo->mask_first[l], svo->mask_words[l], s->ranks,
                        0, svo->counters, KD_COUNT_DIFF) != KD_OK)
        return UINT32_MAX;
    kd_gpu_barrier(gpu, KD_BARRIER_STORAGE);
    return svo_read_counter(gpu, svo, KD_COUNT_DIFF);
}

static void renumber_level(kd_gpu *gpu, const svo_state *state, const kd_svo *svo, const smaller *s,
                           uint32_t l)
{
    uint32_t pass[4] = {svo->mask_words[l], svo->mask_first[l], l, (&s->places.codes.x)[l]};
    kd_gpu_bind_uniform(gpu, 0, pass, sizeof pass);
    kd_gpu_bind_storage(gpu, 0, svo->counters);
    kd_gpu_bind_storage(gpu, 1, svo->level_masks);
    kd_gpu_bind_storage(gpu, 2, s->ranks);
    kd_gpu_bind_storage(gpu, 3, svo->index);
    kd_gpu_bind_storage(gpu, 4, svo->nodes);
    kd_gpu_bind_storage(gpu, 5, s->moved_from);
    kd_gpu_bind_storage(gpu, 7, s->made[BOOK]);
    kd_gpu_dispatch_linear(gpu, state->programs[SVO_RENUMBER], (svo->mask_words[l] + 63) / 64);
    kd_gpu_barrier(gpu, KD_BARRIER_STORAGE);
}

static bool fits(kd_gpu *gpu, svo_state *state, const kd_svo *svo, const smaller *s,
                 uint32_t counts[KD_MAX_NODE_LEVELS])
{
    bool all = true;
    for (uint32_t l = 0; l < svo_levels(svo); l++) {
        counts[l] = rank_level(gpu, state, svo, s, l);
        all = all && counts[l] <= s->room[l];
    }
    return all;
}

/* To what is wanted and a `spare`th of it. */
static void cut_nodes(kd_gpu *gpu, svo_state *state, kd_svo *svo, uint32_t spare)
{
    uint32_t counts[KD_MAX_NODE_LEVELS];
    smaller s = {0};
    kd_gpu_buffer *parts[PARTS];
    held(svo, parts);
    for (uint32_t l = 0; l < svo_levels(svo); l++) {
        uint32_t want = state->nodes_wanted[l] + state->nodes_wanted[l] / spare;
        want = (want > LEAST ? want : LEAST) / 32 * 32 + 32;
        s.room[l] = want < svo->node_room[l] ? want : svo->node_room[l];
    }
    bool all = make_smaller(gpu, svo, &s) && fits(gpu, state, svo, &s, counts);
    if (all) {
        kd_gpu_fill_buffer(gpu, s.made[BOOK], 0, kd_gpu_buffer_size(gpu, s.made[BOOK]), 0);
        kd_gpu_copy_buffer(gpu, svo->book, 0, s.made[BOOK], 0, svo_fixed_book_bytes(svo));
        if (svo_levels(svo) == 1) /* words beside those of dense cells, which stay */
            kd_gpu_copy_buffer(gpu, svo->nodes, 0, s.made[NODES], 0, kd_gpu_buffer_size(gpu, svo->nodes));
    }
    for (uint32_t l = svo_levels(svo); all && l-- > 0;) {
        kd_gpu_fill_buffer(gpu, s.made[BOOK], (size_t)(&s.places.codes.x)[l] * 4, s.room[l] * 4ul, KD_EMPTY);
        all = free_numbers(gpu, svo, &s, l, counts[l]);
        kd_gpu_barrier(gpu, KD_BARRIER_STORAGE | KD_BARRIER_BUFFER_UPDATE);
        rank_level(gpu, state, svo, &s, l);
        kd_gpu_bind_uniform(gpu, KD_BIND_SVO, &svo->places, sizeof svo->places);
        renumber_level(gpu, state, svo, &s, l);
        move_level(gpu, state, svo, &s, l, counts[l]);
    }
    for (int i = 0; i < PARTS; i++) {
        kd_gpu_destroy_buffer(gpu, all ? *parts[i] : s.made[i]);
        if (all)
            *parts[i] = s.made[i];
    }
    kd_gpu_destroy_buffer(gpu, s.moved_from);
    kd_gpu_destroy_buffer(gpu, s.ranks);
    kd_gpu_barrier(gpu, KD_BARRIER_STORAGE | KD_BARRIER_BUFFER_UPDATE);
    if (!all)
        return;
    svo->places = s.places;
    memcpy(svo->node_room, s.room, sizeof s.room);
    svo->node_capacity = s.room[svo_levels(svo) - 1];
}

/* ---- a tree in which nothing changes ---- */

/* Masks of nodes can be had from their codes: all but that of the dense cells go. */
static void drop_masks(kd_gpu *gpu, kd_svo *svo)
{
    size_t dense = svo->mask_words[0] * 4ul;
    kd_gpu_buffer kept =
        kd_gpu_make_buffer(gpu, &(kd_gpu_buffer_desc){.size = dense, .name = "svo.level_masks"});
    kd_gpu_buffer none = kd_gpu_make_buffer(gpu, &(kd_gpu_buffer_desc){.size = 4, .name = "svo.masks"});
    bool away = svo_read_counter(gpu, svo, KD_COUNT_AWAY) !=
                0; /* what is to be asked for again is known by no code */
    if (svo_levels(svo) == 1 || away || !kept.id || !none.id) {
        kd_gpu_destroy_buffer(gpu, kept);
        kd_gpu_destroy_buffer(gpu, none);
        return;
    }
    kd_gpu_barrier(gpu, KD_BARRIER_BUFFER_UPDATE);
    kd_gpu_copy_buffer(gpu, svo->level_masks, 0, kept, 0, dense);
    kd_gpu_barrier(gpu, KD_BARRIER_STORAGE);
    kd_gpu_destroy_buffer(gpu, svo->level_masks);
    kd_gpu_destroy_buffer(gpu, svo->masks);
    svo->level_masks = kept;
    svo->masks = none;
    svo->asleep = true;
}

/* What only a tree that changes needs; and nearly all that is spare. */
static void fall_asleep(kd_gpu *gpu, svo_state *state, kd_svo *svo)
{
    uint32_t leaves = state->leaves.wanted + state->leaves.wanted / SLEEPING_SPARE + 64;
    kd_gpu_destroy_buffer(gpu, svo->before);
    kd_gpu_destroy_buffer(gpu, svo->work);
    svo->before = svo->work = (kd_gpu_buffer){0};
    cut_nodes(gpu, state, svo, SLEEPING_SPARE);
    kd_gpu_rank_rest(gpu, &state->rank);
    if (leaves < svo->leaf_room) /* if it fails there is more room than is needed */
        svo_gather_blocks(gpu, state, svo, leaves);
    drop_masks(gpu, svo);
}

static void put_bits(kd_gpu *gpu, const svo_state *state, const kd_svo *svo, uint32_t l, kd_gpu_buffer masks,
                     uint32_t first, bool still)
{
    uint32_t pass[4] = {l, first, still, 0};
    kd_gpu_bind_uniform(gpu, 0, pass, sizeof pass);
    kd_gpu_bind_storage(gpu, 1, masks);
    kd_gpu_dispatch_linear(gpu, state->programs[SVO_WAKE], (svo->node_room[l] + 63) / 64);
}

kd_status svo_wake(kd_gpu *gpu, const svo_state *state, kd_svo *svo)
{
    uint32_t top = svo_levels(svo) - 1;
    kd_gpu_buffer_desc masks = {.size = kd_svo_parent_words(svo) * 4ul, .zeroed = true, .name = "svo.masks"},
                       levels = {.size = (svo->mask_first[top] + svo->mask_words[top]) * 4ul,
                                 .zeroed = true,
                                 .name = "svo.level_masks"};
    kd_gpu_buffer still = kd_gpu_make_buffer(gpu, &masks), joined = kd_gpu_make_buffer(gpu, &levels);
    if (!still.id || !joined.id) {
        kd_gpu_destroy_buffer(gpu, still);
        kd_gpu_destroy_buffer(gpu, joined);
        return KD_GPU;
    }
    kd_gpu_barrier(gpu, KD_BARRIER_BUFFER_UPDATE | KD_BARRIER_STORAGE);
    kd_gpu_bind_uniform(gpu, KD_BIND_SVO, &svo->places, sizeof svo->places);
    kd_gpu_bind_storage(gpu, 0, svo->counters);
    kd_gpu_bind_storage(gpu, 7, svo->book);
    for (uint32_t l = 0; l <= top; l++)
        put_bits(gpu, state, svo, l, joined, svo->mask_first[l], false);
    put_bits(gpu, state, svo, top, still, 0, true);
    kd_gpu_barrier(gpu, KD_BARRIER_STORAGE | KD_BARRIER_TEXTURE | KD_BARRIER_BUFFER_UPDATE);
    kd_gpu_destroy_buffer(gpu, svo->masks);
    kd_gpu_destroy_buffer(gpu, svo->level_masks);
    svo->masks = still;
    svo->level_masks = joined;
    svo->asleep = false;
    return KD_OK;
}

void svo_give_back(kd_gpu *gpu, svo_state *state, kd_svo *svo, const kd_voxel_scene *scene)
{
    if (!svo->asleep && spare(&state->nodes, svo->node_capacity)) {
        cut_nodes(gpu, state, svo, SVO_SPARE);
        svo_write_params(gpu, svo, scene);
    }
    uint32_t leaves = state->leaves.wanted + state->leaves.wanted / SVO_SPARE + 1024;
    if (spare(&state->leaves, svo->leaf_room) &&
        svo_gather_blocks(gpu, state, svo, leaves > LEAST ? leaves : LEAST) == KD_OK)
        svo_write_params(gpu, svo, scene);
    if (spare(&state->sums, svo->sum_capacity))
        cut(gpu, &svo->sums, &svo->sum_capacity, &state->sums, KD_SUM_WORDS * 4, "svo.sums");
    if (spare(&state->fresh, svo->fresh_words) && !scene->static_changed)
        cut(gpu, &svo->fresh, &svo->fresh_words, &state->fresh, 4, "svo.fresh");
    if (spare(&state->entries, svo->entry_room) && !scene->static_changed)
        cut_entries(gpu, svo, &state->entries);
    state->entries.wanted = 0; /* until something static is built anew */
    if (state->still_runs > QUIET) {
        svo_reserve_moving(gpu, svo, false);
        svo_reserve_chains(gpu, svo, 0);
        svo_fit_leaves(gpu, svo); /* if it fails there is more room than is needed */
    }
    if (state->same_runs == QUIET) {
        fall_asleep(gpu, state, svo);
        svo_write_params(gpu, svo, scene);
    }
    if (spare(&state->dynamic, svo->dynamic_capacity))
        svo_cut_dynamic(gpu, svo, &state->dynamic);
    if (scene->build != KD_SVO_BUILD_ORDERFREE)
        svo->dynamic_room = svo->sum_capacity;
}
