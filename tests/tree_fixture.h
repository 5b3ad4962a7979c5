#ifndef KD_TESTS_TREE_FIXTURE_H
#define KD_TESTS_TREE_FIXTURE_H

/* The octree read back. Node numbers depend on a tree's history, so nodes are looked at in the order of their
 * codes, which does not. */

#include "tests/voxel_fixture.h"

typedef struct tree_copy {
    uint32_t levels, cascades, layer_words;
    uint32_t words[KD_MAX_NODE_LEVELS], count[KD_MAX_NODE_LEVELS];
    uint32_t *masks[KD_MAX_NODE_LEVELS];
    uint32_t *codes[KD_MAX_NODE_LEVELS];   /* [count], ascending */
    uint32_t *numbers[KD_MAX_NODE_LEVELS]; /* [count], of these nodes */
    uint32_t *still;                       /* [layer_words]: mask of the static layer */
    uint32_t *leaves, *surface, *emission; /* by number of the leaf parent: 8 x 2 words each */
    uint32_t *data;                        /* by number: 2 words, levels from 1 on */
    uint32_t *nodes, *index;
    uint32_t capacity, room[KD_MAX_NODE_LEVELS], data_first[KD_MAX_NODE_LEVELS],
        child_first[KD_MAX_NODE_LEVELS];
    uint32_t *atlas, *depths; /* words of the dense levels' radiance and depths */
    size_t atlas_words, depth_words;
} tree_copy;

static inline int tree_compare(const void *a, const void *b)
{
    uint32_t x = *(const uint32_t *)a, y = *(const uint32_t *)b;
    return x < y ? -1 : x > y;
}

/* Position of a code among the nodes of a level; fails when there is none. */
static inline uint32_t tree_find(const tree_copy *t, uint32_t l, uint32_t code)
{
    const uint32_t *at = t->count[l] ? bsearch(&code, t->codes[l], t->count[l], 4, tree_compare) : NULL;
    if (!at)
        fail_msg("level %u: no node has code %x", l, code);
    return (uint32_t)(at - t->codes[l]);
}

static inline void tree_read_level(voxel_world *v, tree_copy *t, uint32_t l)
{
    const kd_svo *svo = voxel_svo(v);
    uint32_t cap = svo->node_room[l], at = 0, live = 0;
    t->room[l] = cap;
    t->data_first[l] = l > 0 ? kd_svo_data_first(svo, l) : 0;
    t->child_first[l] = 8 * kd_svo_nodes_before(svo, 0, l);
    assert_int_equal((&svo->places.child.x)[l], t->child_first[l]);
    t->words[l] = svo->mask_words[l];
    t->masks[l] =
        voxel_read(svo->level_masks, (size_t)svo->mask_first[l] * 4, (size_t)t->words[l] * 4);
    t->count[l] = voxel_count_bits(t->masks[l], t->words[l]);
    t->codes[l] = calloc(t->count[l] + 1, 4);
    t->numbers[l] = calloc(t->count[l] + 1, 4);
    assert_true(t->codes[l] && t->numbers[l]);
    for (uint32_t code = 0; code < t->words[l] * 32; code++)
        if (t->masks[l][code >> 5] >> (code & 31) & 1u)
            t->codes[l][at++] = code;
    memset(t->numbers[l], 0xFF, (size_t)t->count[l] * 4);
    uint32_t *codes = voxel_read(svo->book, (size_t)(&svo->places.codes.x)[l] * 4, (size_t)cap * 4);
    for (uint32_t n = 0; n < cap; n++) {
        if (codes[n] == KD_EMPTY)
            continue;
        uint32_t node = tree_find(t, l, codes[n]);
        assert_int_equal(t->numbers[l][node], KD_EMPTY); /* no node has two numbers */
        t->numbers[l][node] = n;
        live++;
    }
    free(codes);
    assert_int_equal(live, t->count[l]); /* and all have one */
}

/* Numbers that are free are those that no node has. */
static inline void tree_assert_books(voxel_world *v, const tree_copy *t)
{
    const kd_svo *svo = voxel_svo(v);
    uint32_t counts[KD_COUNT_WORDS];
    kd_gpu_read_buffer(voxel_gpu, svo->counters, 0, counts, sizeof counts);
    for (uint32_t l = 0; l < t->levels; l++) {
        uint32_t free_count = counts[KD_COUNT_FREE + l], nodes = 0;
        assert_int_equal(free_count + t->count[l], t->room[l]);
        uint8_t *taken = calloc(t->room[l], 1);
        uint32_t *stack = voxel_read(svo->book, (size_t)(&svo->places.free.x)[l] * 4, (size_t)free_count * 4);
        for (uint32_t i = 0; i < t->count[l]; i++)
            taken[t->numbers[l][i]] = 1;
        for (uint32_t i = 0; i < free_count; i++) {
            assert_in_range(stack[i], 0, t->room[l] - 1);
            assert_int_equal(taken[stack[i]], 0);
            taken[stack[i]] = 1;
        }
        for (uint32_t c = 0; c < t->cascades; c++)
            nodes += counts[KD_COUNT_NODES + 4 * l + c];
        assert_int_equal(nodes, t->count[l]);
        free(stack);
        free(taken);
    }
    assert_int_equal(counts[KD_COUNT_STATIC], voxel_count_bits(t->still, t->layer_words));
}

static inline uint32_t tree_dense_place(uint32_t code)
{
    uint32_t cascade = code >> (3 * KD_DENSE_LOG2), cell[3];
    svo_morton_cell(code & ((1u << (3 * KD_DENSE_LOG2)) - 1), cell);
    return ((cascade * KD_DENSE + cell[2]) * KD_DENSE + cell[1]) * KD_DENSE + cell[0];
}

/* From the index and the node table one comes to every node, and to nothing else. */
static inline void tree_assert_links(const tree_copy *t)
{
    uint32_t cells = t->cascades * KD_DENSE * KD_DENSE * KD_DENSE, full = 0;
    for (uint32_t i = 0; i < cells; i++)
        full += t->index[i] != KD_EMPTY;
    assert_int_equal(full, t->count[0]);
    for (uint32_t i = 0; i < t->count[0]; i++)
        assert_int_equal(t->index[tree_dense_place(t->codes[0][i])], t->numbers[0][i]);
    for (uint32_t l = 0; l + 1 < t->levels; l++)
        for (uint32_t i = 0; i < t->count[l]; i++)
            for (uint32_t k = 0; k < 8; k++) {
                uint32_t code = t->codes[l][i] * 8 + k;
                uint32_t got = t->nodes[t->child_first[l] + (size_t)t->numbers[l][i] * 8 + k];
                bool there = (t->masks[l + 1][code >> 5] >> (code & 31) & 1u) != 0;
                assert_int_equal(got, there ? t->numbers[l + 1][tree_find(t, l + 1, code)] : KD_EMPTY);
            }
}

/* Word that leads to the leaves of leaf parent i. */
static inline uint32_t tree_block(const tree_copy *t, uint32_t i)
{
    uint32_t top = t->levels - 1, code = t->codes[top][i], first = t->child_first[top];
    if (top == 0)
        return t->nodes[first + tree_dense_place(code)];
    uint32_t above = t->numbers[top - 1][tree_find(t, top - 1, code >> 3)];
    return t->nodes[first + above * 8 + (code & 7)];
}

/* Leaves and static cells, spread out to eight a leaf parent. No two parents share a slot, and all lie where
 * there is room. */
static inline void tree_read_leaves(voxel_world *v, tree_copy *t)
{
    const kd_svo *svo = voxel_svo(v);
    uint32_t top = t->levels - 1, room = svo->leaf_room, cap = svo->node_capacity;
    size_t slots = kd_gpu_buffer_size(voxel_gpu, svo->leaves) / 8;
    uint32_t *leaves = voxel_read(svo->leaves, 0, slots * 8),
             *words = voxel_read(svo->book, (size_t)svo->places.blocks.x * 4, (size_t)cap * 4);
    uint32_t *albedo = voxel_read(svo->static_albedo, 0, (size_t)room * 4);
    uint32_t *emission = svo->glows ? voxel_read(svo->static_emission, 0, (size_t)room * 8) : calloc(room, 8);
    uint8_t *taken = calloc(slots, 1);
    t->leaves = calloc(cap, 64), t->surface = calloc(cap, 64), t->emission = calloc(cap, 64);
    assert_true(emission && taken && t->leaves && t->surface && t->emission);
    for (uint32_t i = 0; i < t->count[top]; i++)
        for (uint32_t k = 0; k < 8; k++) {
            uint32_t n = t->numbers[top][i], seen = kd_svo_block_slot(svo, tree_block(t, i), k),
                     slot = kd_svo_block_slot(svo, words[n], k);
            size_t at = 2 * ((size_t)n * 8 + k);
            if (slot != KD_EMPTY) {
                assert_in_range(slot, 0, room - 1);
                assert_int_equal(taken[slot]++, 0);
                t->surface[at] = albedo[slot];
                t->surface[at + 1] = leaves[2 * slot + 1];
                memcpy(t->emission + at, emission + 2 * slot, 8);
            }
            if (seen == KD_EMPTY)
                continue;
            assert_in_range(seen, 0, slots - 1);
            assert_true(seen == slot || (seen >= room && taken[seen]++ == 0));
            memcpy(t->leaves + at, leaves + 2 * seen, 8);
        }
    void *held[] = {leaves, words, albedo, emission, taken};
    for (size_t i = 0; i < sizeof held / sizeof *held; i++)
        free(held[i]);
}

/* Read the tree of this frame; checks that its parts belong together. */
static inline tree_copy tree_read(voxel_world *v)
{
    const kd_svo *svo = voxel_svo(v);
    uint32_t levels = svo->leaf_level - KD_DENSE_LOG2;
    tree_copy t = {.levels = levels,
                   .cascades = svo->cascades,
                   .layer_words = svo->layer_words,
                   .capacity = svo->node_capacity};
    for (uint32_t l = 0; l < levels; l++)
        tree_read_level(v, &t, l);
    t.still = voxel_read_mask(v, KD_LAYER_STATIC);
    t.data = voxel_read(svo->data, 0, (size_t)kd_svo_data_first(svo, levels) * 8);
    t.nodes = voxel_read(svo->nodes, 0, kd_gpu_buffer_size(voxel_gpu, svo->nodes));
    t.index = voxel_read(svo->index, 0, (size_t)svo->cascades * KD_DENSE * KD_DENSE * KD_DENSE * 4);
    tree_read_leaves(v, &t);
    t.atlas_words = (size_t)KD_DENSE * KD_DENSE * KD_ATLAS_SLICES(svo->cascades, 6);
    t.depth_words = (size_t)KD_DENSE * KD_DENSE * KD_ATLAS_SLICES(svo->cascades, 2);
    t.atlas = malloc(t.atlas_words * 4);
    t.depths = malloc(t.depth_words * 4);
    assert_true(t.atlas && t.depths);
    kd_gpu_read_texture(voxel_gpu, svo->atlas, 0, t.atlas, t.atlas_words * 4);
    kd_gpu_read_texture(voxel_gpu, svo->depths, 0, t.depths, t.depth_words * 4);
    tree_assert_books(v, &t);
    tree_assert_links(&t);
    return t;
}

static inline void tree_free(tree_copy *t)
{
    for (uint32_t l = 0; l < t->levels; l++) {
        free(t->masks[l]);
        free(t->codes[l]);
        free(t->numbers[l]);
    }
    void *held[] = {t->still, t->leaves, t->surface, t->emission, t->data,
                    t->nodes, t->index,  t->atlas,   t->depths};
    for (size_t i = 0; i < sizeof held / sizeof *held; i++)
        free(held[i]);
}

/* Static cell of leaf k of leaf parent i: surface (albedo, normal, weight), emission, area. */
static inline void tree_static_cell(const tree_copy *t, uint32_t i, uint32_t k, uint32_t cell[4])
{
    size_t slot = (size_t)t->numbers[t->levels - 1][i] * 8 + k;
    memcpy(cell, t->surface + 2 * slot, 8);
    memcpy(cell + 2, t->emission + 2 * slot, 8);
}

static inline void tree_assert_same_leaves(const tree_copy *a, const tree_copy *b, bool lit)
{
    uint32_t top = a->levels - 1;
    for (uint32_t i = 0; i < a->count[top]; i++)
        for (uint32_t k = 0; k < 8; k++) {
            uint32_t code = a->codes[top][i] * 8 + k, x[4], y[4];
            size_t p = (size_t)a->numbers[top][i] * 8 + k, q = (size_t)b->numbers[top][i] * 8 + k;
            if (lit && memcmp(a->leaves + 2 * p, b->leaves + 2 * q, 8) != 0)
                fail_msg("leaf %x: %08x %08x, expected %08x %08x", code, a->leaves[2 * p],
                         a->leaves[2 * p + 1], b->leaves[2 * q], b->leaves[2 * q + 1]);
            if (!(a->still[code >> 5] >> (code & 31) & 1u))
                continue;
            tree_static_cell(a, i, k, x);
            tree_static_cell(b, i, k, y);
            if (memcmp(x, y, sizeof x) != 0)
                fail_msg("static cell %x: %08x %08x %08x %08x, expected %08x %08x %08x %08x", code, x[0],
                         x[1], x[2], x[3], y[0], y[1], y[2], y[3]);
        }
}

static inline void tree_assert_same_dense(const char *what, const uint32_t *a, const uint32_t *b,
                                          size_t words)
{
    for (size_t i = 0; i < words; i++)
        if (a[i] != b[i])
            fail_msg("%s of the dense levels, texel %zu %zu %zu: %08x, expected %08x", what, i % KD_DENSE,
                     i / KD_DENSE % KD_DENSE, i / KD_DENSE / KD_DENSE, a[i], b[i]);
}

/* The same tree, whatever the numbers of its nodes; `lit`: light was injected and filtered. */
static inline void tree_assert_same(const tree_copy *a, const tree_copy *b, bool lit)
{
    assert_int_equal(a->levels, b->levels);
    assert_memory_equal(a->still, b->still, (size_t)a->layer_words * 4);
    for (uint32_t l = 0; l < a->levels; l++)
        assert_memory_equal(a->masks[l], b->masks[l], (size_t)a->words[l] * 4);
    tree_assert_same_leaves(a, b, lit);
    for (uint32_t l = 1; l < a->levels && lit; l++)
        for (uint32_t i = 0; i < a->count[l]; i++) {
            const uint32_t *x = a->data + 2 * ((size_t)a->data_first[l] + a->numbers[l][i]);
            const uint32_t *y = b->data + 2 * ((size_t)b->data_first[l] + b->numbers[l][i]);
            if (memcmp(x, y, 8) != 0)
                fail_msg("level %u, node %x: %08x %08x, expected %08x %08x", l, a->codes[l][i], x[0], x[1],
                         y[0], y[1]);
        }
    if (lit)
        tree_assert_same_dense("radiance", a->atlas, b->atlas, a->atlas_words);
    if (lit)
        tree_assert_same_dense("depth", a->depths, b->depths, a->depth_words);
}

#endif
