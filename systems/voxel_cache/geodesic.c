/* Distances run from the cells of a bone through the body, nearest cells first. They go through cells inside;
 * those of the surface end a path, so that parts which touch each other stay apart. What is reached in no
 * such way (limbs of a cell's width have nothing inside) is then reached by any way through the body. */
#include "systems/voxel_cache/geodesic.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Steps by faces, edges and corners in tenths of a cell. Source: Borgefors 1986, chamfer distances */
static const uint32_t step_costs[4] = {0, 10, 14, 17};
enum { NEIGHBOURS = 26, BUCKETS = 18 };
#define FAR UINT32_MAX

typedef struct bucket {
    uint32_t *cells;
    uint32_t count, capacity;
} bucket;

typedef struct spread {
    const geodesic_body *body;
    uint32_t *distance;            /* [cells] of the bone at hand, in tenths of a cell */
    uint8_t *settled;              /* [cells] reached through the inside: other ways are no shorter ones */
    bucket buckets[BUCKETS], late; /* late: cells from which the rest is reached, by distance */
    int32_t offsets[NEIGHBOURS];   /* of the 26 neighbours; the body has free cells all round */
    uint32_t costs[NEIGHBOURS];
    uint32_t waiting;
    bool failed;
} spread;

static uint32_t cell_count(const geodesic_body *b)
{
    return b->size[0] * b->size[1] * b->size[2];
}

static void add(spread *s, bucket *b, uint32_t cell)
{
    if (b->count == b->capacity) {
        uint32_t capacity = b->capacity ? b->capacity * 2 : 1024;
        uint32_t *grown = realloc(b->cells, capacity * sizeof *grown);
        if (!grown) {
            s->failed = true;
            return;
        }
        b->cells = grown;
        b->capacity = capacity;
    }
    b->cells[b->count++] = cell;
}

static void reach(spread *s, uint32_t cell, uint32_t distance)
{
    if (s->body->cells[cell] == GEODESIC_OUTSIDE || s->settled[cell] || distance >= s->distance[cell])
        return;
    s->distance[cell] = distance;
    add(s, &s->buckets[distance % BUCKETS], cell);
    s->waiting++;
}

static void go_on(spread *s, uint32_t cell)
{
    for (int n = 0; n < NEIGHBOURS; n++)
        reach(s, (uint32_t)((int32_t)cell + s->offsets[n]), s->distance[cell] + s->costs[n]);
}

/* Take what waits, by distance; paths end at the surface or go on there, too. No step is as long as there are
 * buckets, so each holds cells of one distance. Source: Dial 1969 */
static void run(spread *s, bool through_surface)
{
    uint32_t late = 0;
    for (uint32_t distance = 0; (s->waiting || late < s->late.count) && !s->failed; distance++) {
        bucket *b = &s->buckets[distance % BUCKETS];
        for (; late < s->late.count && s->distance[s->late.cells[late]] == distance; late++)
            go_on(s, s->late.cells[late]);
        for (uint32_t i = 0; i < b->count; i++) {
            uint32_t cell = b->cells[i];
            bool ends = !through_surface && distance > 0 && s->body->cells[cell] == GEODESIC_SURFACE;
            if (!ends && s->distance[cell] == distance)
                go_on(s, cell);
        }
        s->waiting -= b->count;
        b->count = 0;
    }
}

static bool has_far_neighbour(const spread *s, uint32_t cell)
{
    for (int n = 0; n < NEIGHBOURS; n++) {
        uint32_t at = (uint32_t)((int32_t)cell + s->offsets[n]);
        if (s->body->cells[at] != GEODESIC_OUTSIDE && s->distance[at] == FAR)
            return true;
    }
    return false;
}

/* Order cells by distance, those of one distance as they were. Source: Seward 1954, radix sort */
static void sort_late(spread *s)
{
    bucket *b = &s->late, sorted = {.cells = malloc(b->count * sizeof *b->cells + 1)};
    uint32_t starts[257];
    if (!sorted.cells) {
        s->failed = true;
        return;
    }
    for (int shift = 0; shift < 32; shift += 8) {
        memset(starts, 0, sizeof starts);
        for (uint32_t i = 0; i < b->count; i++)
            starts[(s->distance[b->cells[i]] >> shift & 255) + 1]++;
        for (int i = 0; i < 256; i++)
            starts[i + 1] += starts[i];
        for (uint32_t i = 0; i < b->count; i++)
            sorted.cells[starts[s->distance[b->cells[i]] >> shift & 255]++] = b->cells[i];
        memcpy(b->cells, sorted.cells, b->count * sizeof *b->cells);
    }
    free(sorted.cells);
}

static void list_late(spread *s)
{
    uint32_t count = cell_count(s->body);
    for (uint32_t i = 0; i < count && !s->failed; i++) {
        s->settled[i] = s->distance[i] < FAR;
        if (s->settled[i] && has_far_neighbour(s, i))
            add(s, &s->late, i);
    }
    if (s->late.count)
        sort_late(s);
}

/* ---- bones ---- */

static bool cell_of(const geodesic_body *b, kd_vec3 p, uint32_t *cell)
{
    uint32_t at = 0;
    for (int k = 2; k >= 0; k--) {
        float x = floorf(((&p.x)[k] - (&b->origin.x)[k]) / b->span);
        if (!(x >= 1 && x < (float)b->size[k] - 1))
            return false;
        at = at * b->size[k] + (uint32_t)x;
    }
    *cell = at;
    return true;
}

/* Cells along a bone that are of the body; what goes on from an open end stops where the body does. */
static void seed(spread *s, const geodesic_bone *bone)
{
    kd_vec3 way = kd_vec3_sub(bone->to, bone->from);
    float length = kd_vec3_length(way) / s->body->span;
    uint32_t steps = (uint32_t)fminf(length * 2, 4096) + 1, cell;
    kd_vec3 step = kd_vec3_scale(way, 1.0f / (float)steps);
    for (uint32_t i = 0; i <= steps; i++)
        if (cell_of(s->body, kd_vec3_add(bone->from, kd_vec3_scale(step, (float)i)), &cell))
            reach(s, cell, 0);
    for (uint32_t i = steps + 1; bone->open_ended && length > 0 && i < steps + 4 * GEODESIC_MOST_CELLS; i++) {
        kd_vec3 at = kd_vec3_add(bone->from, kd_vec3_scale(step, (float)i));
        if (!cell_of(s->body, at, &cell) || s->body->cells[cell] == GEODESIC_OUTSIDE)
            return;
        reach(s, cell, 0);
    }
}

static bool spread_from(spread *s, const geodesic_bone *bones, uint32_t count)
{
    memset(s->distance, 0xFF, cell_count(s->body) * sizeof *s->distance);
    memset(s->settled, 0, cell_count(s->body));
    s->late.count = 0;
    for (uint32_t i = 0; i < count; i++)
        seed(s, &bones[i]);
    if (!s->waiting)
        return false;
    run(s, false);
    list_late(s);
    run(s, true);
    return true;
}

/* ---- weights ---- */

/* In the cell of the point, or in the nearest one beside it: points of a finer grid may lie just outside. */
static uint32_t distance_at(const spread *s, kd_vec3 p)
{
    uint32_t cell, best = FAR;
    if (!cell_of(s->body, p, &cell))
        return FAR;
    if (s->distance[cell] < FAR)
        return s->distance[cell];
    for (int n = 0; n < NEIGHBOURS; n++) {
        uint32_t near = s->distance[(uint32_t)((int32_t)cell + s->offsets[n])];
        if (near < FAR && near + s->costs[n] < best)
            best = near + s->costs[n];
    }
    return best;
}

/* The weight falls with the fourth power of the distance (the source's alpha of 1), which half a cell bounds.
 */
static float weight_at(uint32_t distance)
{
    float d = fmaxf((float)distance, 5);
    return 1e4f / (d * d * d * d);
}

/* Keep the four largest, in order. */
static void keep(uint16_t joints[4], float weights[4], uint16_t joint, float weight)
{
    int at = 3;
    if (!(weight > weights[3]))
        return;
    for (; at > 0 && weight > weights[at - 1]; at--) {
        weights[at] = weights[at - 1];
        joints[at] = joints[at - 1];
    }
    weights[at] = weight;
    joints[at] = joint;
}

static void lay_out(spread *s)
{
    int32_t row = (int32_t)s->body->size[0], slice = row * (int32_t)s->body->size[1];
    int n = 0;
    for (int32_t z = -1; z <= 1; z++)
        for (int32_t y = -1; y <= 1; y++)
            for (int32_t x = -1; x <= 1; x++)
                if (x || y || z) {
                    s->offsets[n] = x + y * row + z * slice;
                    s->costs[n++] = step_costs[(x != 0) + (y != 0) + (z != 0)];
                }
}

static void normalize(float (*weights)[4], uint32_t count)
{
    for (uint32_t i = 0; i < count; i++) {
        float sum = weights[i][0] + weights[i][1] + weights[i][2] + weights[i][3];
        for (int k = 0; k < 4 && sum > 0; k++)
            weights[i][k] /= sum;
    }
}

kd_status geodesic_weights(const geodesic_body *body, const uint32_t *first, const geodesic_bone *bones,
                           uint32_t joint_count, const kd_vec3 *points, uint32_t count, uint16_t (*joints)[4],
                           float (*weights)[4])
{
    uint32_t cells = cell_count(body);
    spread s = {
        .body = body, .distance = malloc(cells * sizeof *s.distance + 1), .settled = malloc(cells + 1)};
    s.failed = !s.distance || !s.settled;
    memset(joints, 0, count * sizeof *joints);
    memset(weights, 0, count * sizeof *weights);
    lay_out(&s);
    for (uint32_t j = 0; j < joint_count && !s.failed; j++)
        if (spread_from(&s, bones + first[j], first[j + 1] - first[j]))
            for (uint32_t i = 0; i < count && !s.failed; i++) {
                uint32_t distance = distance_at(&s, points[i]);
                if (distance < FAR)
                    keep(joints[i], weights[i], (uint16_t)j, weight_at(distance));
            }
    normalize(weights, count);
    for (int i = 0; i < BUCKETS; i++)
        free(s.buckets[i].cells);
    free(s.late.cells);
    free(s.distance);
    free(s.settled);
    return s.failed ? KD_NO_MEMORY : KD_OK;
}
