/* A table of sides by the places of their ends: the second triangle at a side finds the first. */
#include "systems/voxel_cache/creases.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Cosine of 22.5 degrees: what bends less is round, and its thin voxels lie side by side as on a plane. */
#define FLAT 0.924f

typedef struct side {
    uint32_t number; /* 3 * triangle + side, plus one; 0: free */
    uint32_t shared; /* other triangles at it */
} side;

typedef struct sides {
    const kd_primitive_desc *primitive;
    side *slots;
    uint32_t mask;
} sides;

/* The ends of a side, in an order that both its triangles give. */
static void ends_of(const kd_primitive_desc *p, uint32_t number, kd_vec3 ends[2])
{
    uint32_t first = number - number % 3, k = number % 3;
    kd_vec3 zero = {0, 0, 0}; /* -0 becomes 0 */
    ends[0] = kd_vec3_add(p->positions[p->indices[first + k]], zero);
    ends[1] = kd_vec3_add(p->positions[p->indices[first + (k + 1) % 3]], zero);
    if (memcmp(&ends[0], &ends[1], sizeof *ends) > 0) {
        kd_vec3 swap = ends[0];
        ends[0] = ends[1];
        ends[1] = swap;
    }
}

static uint32_t hash_of(const kd_vec3 ends[2])
{
    uint32_t words[6], h = 0;
    memcpy(words, ends, sizeof words);
    for (int i = 0; i < 6; i++)
        h = (h ^ words[i]) * 0x9E3779B1u ^ h >> 15;
    return h ^ h >> 16;
}

static side *find(const sides *s, uint32_t number)
{
    kd_vec3 ends[2], other[2];
    ends_of(s->primitive, number, ends);
    uint32_t at = hash_of(ends) & s->mask;
    for (; s->slots[at].number; at = (at + 1) & s->mask) {
        ends_of(s->primitive, s->slots[at].number - 1, other);
        if (memcmp(ends, other, sizeof ends) == 0)
            break;
    }
    return &s->slots[at];
}

static kd_vec3 normal_of(const kd_primitive_desc *p, uint32_t triangle)
{
    const uint32_t *i = p->indices + (size_t)3 * triangle;
    kd_vec3 a = p->positions[i[0]];
    return kd_vec3_normalize(
        kd_vec3_cross(kd_vec3_sub(p->positions[i[1]], a), kd_vec3_sub(p->positions[i[2]], a)),
        (kd_vec3){0, 0, 0});
}

static void mark(kd_columns *columns, uint32_t number)
{
    columns->rows[number / 3][3] |= 1u << number % 3;
}

/* Three and more at a side are a crease however they lie. A fold by which two lie on each other is one, too.
 */
static void meet(const sides *s, kd_columns *columns, uint32_t number)
{
    side *first = find(s, number);
    if (!first->number) {
        first->number = number + 1;
        return;
    }
    uint32_t other = first->number - 1;
    kd_vec3 a = normal_of(s->primitive, number / 3), b = normal_of(s->primitive, other / 3);
    bool same_way = memcmp(&s->primitive->positions[s->primitive->indices[number]],
                           &s->primitive->positions[s->primitive->indices[other]], sizeof a) == 0;
    float cosine = same_way ? -kd_vec3_dot(a, b) : kd_vec3_dot(a, b);
    if (first->shared++ || !(cosine > FLAT)) {
        mark(columns, number);
        mark(columns, other);
    }
}

kd_status creases_mark(const kd_primitive_desc *primitive, kd_columns *columns)
{
    uint32_t listed = 0, count = 64;
    for (uint32_t t = 0; t < columns->triangles; t++)
        listed += columns->rows[t + 1][0] > columns->rows[t][0];
    while (count < listed * 4u)
        count *= 2;
    sides s = {.primitive = primitive, .slots = calloc(count, sizeof *s.slots), .mask = count - 1};
    if (!s.slots)
        return KD_NO_MEMORY;
    for (uint32_t t = 0; t < columns->triangles; t++)
        for (uint32_t k = 0; k < 3 && columns->rows[t + 1][0] > columns->rows[t][0]; k++)
            meet(&s, columns, 3 * t + k);
    for (uint32_t i = 0; i < count; i++)
        if (s.slots[i].number && !s.slots[i].shared)
            mark(columns, s.slots[i].number - 1); /* the surface ends there */
    free(s.slots);
    return KD_OK;
}
