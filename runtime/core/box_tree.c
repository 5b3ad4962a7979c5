#include "runtime/core/box_tree.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static const kd_box no_box = {{INFINITY, INFINITY, INFINITY}, {-INFINITY, -INFINITY, -INFINITY}};

static void join(kd_box *b, const kd_box *other)
{
    b->low = (kd_vec3){fminf(b->low.x, other->low.x), fminf(b->low.y, other->low.y),
                       fminf(b->low.z, other->low.z)};
    b->high = (kd_vec3){fmaxf(b->high.x, other->high.x), fmaxf(b->high.y, other->high.y),
                        fmaxf(b->high.z, other->high.z)};
}

static bool grow(void **items, uint64_t count, size_t size)
{
    void *grown = realloc(*items, (size_t)count * size);
    *items = grown ? grown : *items;
    return grown != NULL;
}

kd_status kd_box_tree_reserve(kd_box_tree *t, uint32_t count)
{
    if (count > t->capacity) {
        uint64_t capacity = (uint64_t)count + count / 2 + 64,
                 nodes = capacity / (KD_BOX_FAN - 1) + KD_BOX_LEVELS;
        if (!grow((void **)&t->boxes, capacity, sizeof *t->boxes) ||
            !grow((void **)&t->still, capacity, sizeof *t->still) ||
            !grow((void **)&t->order, capacity, sizeof *t->order) ||
            !grow((void **)&t->place, capacity, sizeof *t->place) ||
            !grow((void **)&t->keys, capacity * 2, sizeof *t->keys) ||
            !grow((void **)&t->nodes, nodes, sizeof *t->nodes))
            return KD_NO_MEMORY;
        t->capacity = (uint32_t)capacity;
    }
    t->count = count;
    return KD_OK;
}

/* ---- building ---- */

/* Ten bits, two free places between each. */
static uint32_t spread(uint32_t v)
{
    v = (v | v << 16) & 0x030000FFu;
    v = (v | v << 8) & 0x0300F00Fu;
    v = (v | v << 4) & 0x030C30C3u;
    return (v | v << 2) & 0x09249249u;
}

static float centre_of(const kd_box *b, int axis)
{
    return 0.5f * ((&b->low.x)[axis] + (&b->high.x)[axis]);
}

/* Boxes without a finite centre come first. */
static uint32_t morton_of(const kd_box *b, const float *low, const float *scale)
{
    uint32_t code = 0;
    for (int k = 0; k < 3; k++) {
        float at = (centre_of(b, k) - low[k]) * scale[k];
        code |= spread(at > 0 ? (at < 1023 ? (uint32_t)at : 1023) : 0) << k;
    }
    return code;
}

/* By digits of ten bits from `shift` up, three or fewer; the result is in the half that is returned. */
static uint64_t *sort_keys(uint64_t *from, uint64_t *to, uint32_t count, uint32_t shift, uint32_t bits)
{
    for (uint32_t end = shift + bits; shift < end; shift += 10) {
        uint32_t starts[1024] = {0}, at = 0;
        for (uint32_t i = 0; i < count; i++)
            starts[from[i] >> shift & 1023]++;
        for (uint32_t d = 0; d < 1024; d++) {
            uint32_t n = starts[d];
            starts[d] = at;
            at += n;
        }
        for (uint32_t i = 0; i < count; i++)
            to[starts[from[i] >> shift & 1023]++] = from[i];
        uint64_t *swap = from;
        from = to;
        to = swap;
    }
    return from;
}

static void order_items(kd_box_tree *t)
{
    float low[3] = {INFINITY, INFINITY, INFINITY}, high[3] = {-INFINITY, -INFINITY, -INFINITY}, scale[3];
    for (uint32_t i = 0; i < t->count; i++)
        for (int k = 0; k < 3; k++) {
            float at = centre_of(&t->boxes[i], k);
            if (!isfinite(at))
                continue;
            low[k] = fminf(low[k], at);
            high[k] = fmaxf(high[k], at);
        }
    for (int k = 0; k < 3; k++)
        scale[k] = high[k] > low[k] ? 1023.99f / (high[k] - low[k]) : 0;
    for (uint32_t i = 0; i < t->count; i++)
        t->keys[i] = (uint64_t)morton_of(&t->boxes[i], low, scale) << 32 | i;
    const uint64_t *sorted = sort_keys(t->keys, t->keys + t->capacity, t->count, 32, 30);
    for (uint32_t i = 0; i < t->count; i++) {
        t->order[i] = (uint32_t)sorted[i];
        t->place[t->order[i]] = i;
    }
}

/* Node `at` of a level from what is below it. */
static void sum_node(kd_box_tree *t, uint32_t level, uint32_t at)
{
    kd_box_node *node = &t->nodes[t->first[level] + at];
    uint32_t below = level ? t->nodes_on[level - 1] : t->count, end = (at + 1) * KD_BOX_FAN;
    *node = (kd_box_node){no_box, no_box};
    for (uint32_t i = at * KD_BOX_FAN; i < end && i < below; i++) {
        if (level) {
            const kd_box_node *child = &t->nodes[t->first[level - 1] + i];
            join(&node->all, &child->all);
            join(&node->still, &child->still);
            continue;
        }
        join(&node->all, &t->boxes[t->order[i]]);
        if (t->still[t->order[i]])
            join(&node->still, &t->boxes[t->order[i]]);
    }
}

void kd_box_tree_build(kd_box_tree *t)
{
    uint32_t below = t->count, at = 0;
    t->levels = 0;
    t->changes = 0;
    if (!t->count)
        return;
    order_items(t);
    do {
        uint32_t level = t->levels++;
        t->first[level] = at;
        t->nodes_on[level] = (below + KD_BOX_FAN - 1) / KD_BOX_FAN;
        for (uint32_t i = 0; i < t->nodes_on[level]; i++)
            sum_node(t, level, i);
        below = t->nodes_on[level];
        at += below;
    } while (below > 1);
}

void kd_box_tree_set(kd_box_tree *t, uint32_t item, kd_box box, bool still)
{
    t->boxes[item] = box;
    t->still[item] = still;
    t->changes++;
    for (uint32_t level = 0, at = t->place[item]; level < t->levels; level++) {
        at /= KD_BOX_FAN;
        sum_node(t, level, at);
    }
}

kd_box kd_box_tree_all(const kd_box_tree *t)
{
    return t->levels ? t->nodes[t->first[t->levels - 1]].all : no_box;
}

kd_box kd_box_tree_still(const kd_box_tree *t)
{
    return t->levels ? t->nodes[t->first[t->levels - 1]].still : no_box;
}

/* ---- questions ---- */

typedef bool touches_fn(const void *region, const kd_box *box);

static bool touches_frustum(const void *region, const kd_box *b)
{
    return b->low.x <= b->high.x && kd_frustum_touches(region, b->low, b->high);
}

static bool touches_box(const void *region, const kd_box *b)
{
    const kd_box *r = region;
    return b->low.x <= r->high.x && b->low.y <= r->high.y && b->low.z <= r->high.z && r->low.x <= b->high.x &&
           r->low.y <= b->high.y && r->low.z <= b->high.z;
}

typedef struct question {
    const kd_box_tree *tree;
    touches_fn *touches;
    const void *region;
    uint32_t *out, count;
} question;

/* No deeper than the levels. */
static void visit(question *q, uint32_t level, uint32_t at)
{
    const kd_box_tree *t = q->tree;
    uint32_t below = level ? t->nodes_on[level - 1] : t->count, end = (at + 1) * KD_BOX_FAN;
    for (uint32_t i = at * KD_BOX_FAN; i < end && i < below; i++) {
        if (!level && q->touches(q->region, &t->boxes[t->order[i]]))
            q->out[q->count++] = t->order[i];
        else if (level && q->touches(q->region, &t->nodes[t->first[level - 1] + i].all))
            visit(q, level - 1, i);
    }
}

/* Ascending, by digits of eleven bits. */
static void sort_numbers(uint32_t *numbers, uint32_t *spare, uint32_t count, uint32_t largest)
{
    uint32_t *from = numbers, *to = spare;
    for (uint32_t shift = 0; shift < 32 && largest >> shift; shift += 11) {
        uint32_t starts[2048] = {0}, at = 0;
        for (uint32_t i = 0; i < count; i++)
            starts[from[i] >> shift & 2047]++;
        for (uint32_t d = 0; d < 2048; d++) {
            uint32_t n = starts[d];
            starts[d] = at;
            at += n;
        }
        for (uint32_t i = 0; i < count; i++)
            to[starts[from[i] >> shift & 2047]++] = from[i];
        uint32_t *swap = from;
        from = to;
        to = swap;
    }
    if (from != numbers)
        memcpy(numbers, from, count * sizeof *numbers);
}

static uint32_t ask(const kd_box_tree *t, touches_fn *touches, const void *region, uint32_t *out)
{
    question q = {.tree = t, .touches = touches, .region = region, .out = out};
    if (t->levels)
        visit(&q, t->levels - 1, 0);
    sort_numbers(out, out + t->count, q.count, t->count);
    return q.count;
}

uint32_t kd_box_tree_in_frustum(const kd_box_tree *t, const kd_frustum *frustum, uint32_t *out)
{
    return ask(t, touches_frustum, frustum, out);
}

uint32_t kd_box_tree_in_box(const kd_box_tree *t, const kd_box *box, uint32_t *out)
{
    return ask(t, touches_box, box, out);
}

void kd_box_tree_fini(kd_box_tree *t)
{
    void *const arrays[] = {t->boxes, t->still, t->order, t->place, t->nodes, t->keys};
    for (size_t i = 0; i < sizeof arrays / sizeof *arrays; i++)
        free(arrays[i]);
    *t = (kd_box_tree){0};
}
