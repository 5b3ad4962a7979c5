/* Triangles are sorted into the cells that their boxes touch, voxels into their own, so that what is near is
 * looked for in few cells. */
#include "systems/voxel_cache/distance.h"

#include <math.h>
#include <stdlib.h>

typedef struct grid {
    const kd_primitive_desc *primitive;
    const kd_voxel_chunk *chunk;
    uint32_t *starts, *triangles; /* [cells + 1], [starts[cells]] */
    uint8_t *taken;               /* [cells] */
    size_t cells;
} grid;

static kd_vec3 to_cells(const grid *g, kd_vec3 p)
{
    return kd_vec3_scale(kd_vec3_sub(p, g->chunk->origin), 1 / g->chunk->span);
}

static kd_vec3 corner_of(const grid *g, uint32_t triangle, uint32_t corner)
{
    const kd_primitive_desc *p = g->primitive;
    return to_cells(g, p->positions[p->indices[3 * triangle + corner]]);
}

static size_t cell_at(const grid *g, uint32_t x, uint32_t y, uint32_t z)
{
    return ((size_t)z * g->chunk->size[1] + y) * g->chunk->size[0] + x;
}

static uint32_t clamp_cell(float x, uint32_t size)
{
    return (uint32_t)fminf(fmaxf(x, 0), (float)(size - 1));
}

static void range_of(const grid *g, uint32_t triangle, uint32_t low[3], uint32_t high[3])
{
    kd_vec3 v[3] = {corner_of(g, triangle, 0), corner_of(g, triangle, 1), corner_of(g, triangle, 2)};
    for (int k = 0; k < 3; k++) {
        float a = (&v[0].x)[k], b = (&v[1].x)[k], c = (&v[2].x)[k];
        low[k] = clamp_cell(fminf(a, fminf(b, c)), g->chunk->size[k]);
        high[k] = clamp_cell(fmaxf(a, fmaxf(b, c)), g->chunk->size[k]);
    }
}

/* Count a triangle in its cells, or place it; starts are one cell ahead meanwhile. */
static void sort_triangle(grid *g, uint32_t triangle, bool place)
{
    uint32_t low[3], high[3];
    range_of(g, triangle, low, high);
    for (uint32_t z = low[2]; z <= high[2]; z++)
        for (uint32_t y = low[1]; y <= high[1]; y++)
            for (uint32_t x = low[0]; x <= high[0]; x++) {
                size_t cell = cell_at(g, x, y, z);
                if (place)
                    g->triangles[g->starts[cell + 1]++] = triangle;
                else
                    g->starts[cell + 2]++;
            }
}

static kd_status open_grid(grid *g, const uint32_t (*shape)[2])
{
    uint32_t triangles = g->primitive->index_count / 3;
    g->cells = (size_t)g->chunk->size[0] * g->chunk->size[1] * g->chunk->size[2];
    g->starts = calloc(g->cells + 2, sizeof *g->starts);
    g->taken = calloc(g->cells, 1);
    if (!g->starts || !g->taken)
        return KD_NO_MEMORY;
    for (uint32_t t = 0; t < triangles; t++)
        sort_triangle(g, t, false);
    for (size_t i = 0; i < g->cells; i++)
        g->starts[i + 2] += g->starts[i + 1];
    g->triangles = malloc(((size_t)g->starts[g->cells + 1] + 1) * sizeof *g->triangles);
    if (!g->triangles)
        return KD_NO_MEMORY;
    for (uint32_t t = 0; t < triangles; t++)
        sort_triangle(g, t, true);
    for (uint32_t i = 0; i < g->chunk->count; i++) {
        uint32_t cell = shape[i][0];
        g->taken[cell_at(g, cell & 1023u, cell >> 10 & 1023u, cell >> 20 & 1023u)] = 1;
    }
    return KD_OK;
}

static void close_grid(grid *g)
{
    free(g->starts);
    free(g->triangles);
    free(g->taken);
}

/* Source: Ericson 2004, "Real-Time Collision Detection", section 5.1.5 */
static float distance_to(kd_vec3 p, kd_vec3 a, kd_vec3 b, kd_vec3 c)
{
    kd_vec3 ab = kd_vec3_sub(b, a), ac = kd_vec3_sub(c, a), ap = kd_vec3_sub(p, a);
    float d1 = kd_vec3_dot(ab, ap), d2 = kd_vec3_dot(ac, ap);
    if (d1 <= 0 && d2 <= 0)
        return kd_vec3_length(ap);
    kd_vec3 bp = kd_vec3_sub(p, b), cp = kd_vec3_sub(p, c);
    float d3 = kd_vec3_dot(ab, bp), d4 = kd_vec3_dot(ac, bp), d5 = kd_vec3_dot(ab, cp),
          d6 = kd_vec3_dot(ac, cp);
    if (d3 >= 0 && d4 <= d3)
        return kd_vec3_length(bp);
    if (d6 >= 0 && d5 <= d6)
        return kd_vec3_length(cp);
    float vc = d1 * d4 - d3 * d2, vb = d5 * d2 - d1 * d6, va = d3 * d6 - d5 * d4;
    if (vc <= 0 && d1 >= 0 && d3 <= 0)
        return kd_vec3_length(kd_vec3_sub(ap, kd_vec3_scale(ab, d1 / (d1 - d3))));
    if (vb <= 0 && d2 >= 0 && d6 <= 0)
        return kd_vec3_length(kd_vec3_sub(ap, kd_vec3_scale(ac, d2 / (d2 - d6))));
    if (va <= 0 && d4 - d3 >= 0 && d5 - d6 >= 0)
        return kd_vec3_length(
            kd_vec3_sub(bp, kd_vec3_scale(kd_vec3_sub(c, b), (d4 - d3) / ((d4 - d3) + (d5 - d6)))));
    kd_vec3 n = kd_vec3_normalize(kd_vec3_cross(ab, ac), (kd_vec3){0, 0, 0});
    return fabsf(kd_vec3_dot(n, ap));
}

/* The nearest of what lies within `reach` cells of a cell, by `distance`. */
typedef float distance_in_cell(const grid *g, size_t cell, const int64_t at[3], kd_vec3 p);

static float nearest_within(const grid *g, kd_vec3 p, int64_t reach, distance_in_cell *distance)
{
    int64_t low[3], high[3], at[3];
    float best = INFINITY;
    for (int k = 0; k < 3; k++) {
        int64_t middle = (int64_t)floorf((&p.x)[k]), last = (int64_t)g->chunk->size[k] - 1;
        low[k] = middle - reach > 0 ? middle - reach : 0;
        high[k] = middle + reach < last ? middle + reach : last;
    }
    for (at[2] = low[2]; at[2] <= high[2]; at[2]++)
        for (at[1] = low[1]; at[1] <= high[1]; at[1]++)
            for (at[0] = low[0]; at[0] <= high[0]; at[0]++)
                best = fminf(
                    best, distance(g, cell_at(g, (uint32_t)at[0], (uint32_t)at[1], (uint32_t)at[2]), at, p));
    return best;
}

static float to_triangles(const grid *g, size_t cell, const int64_t at[3], kd_vec3 p)
{
    float best = INFINITY;
    (void)at;
    for (uint32_t i = g->starts[cell]; i < g->starts[cell + 1]; i++) {
        uint32_t t = g->triangles[i];
        best = fminf(best, distance_to(p, corner_of(g, t, 0), corner_of(g, t, 1), corner_of(g, t, 2)));
    }
    return best;
}

static float to_centre(const grid *g, size_t cell, const int64_t at[3], kd_vec3 p)
{
    kd_vec3 centre = {(float)at[0] + 0.5f, (float)at[1] + 0.5f, (float)at[2] + 0.5f};
    return g->taken[cell] ? kd_vec3_length(kd_vec3_sub(centre, p)) : INFINITY;
}

/* A voxel's own cell holds a part of the surface, so the nearest lies in it or next to it; thin voxels may
 * leave out the cell of a vertex and those round it. */
static void add_up(const grid *g, const uint32_t (*shape)[2], voxel_distances *sum)
{
    for (uint32_t i = 0; i < g->chunk->count; i++) {
        uint32_t cell = shape[i][0];
        kd_vec3 centre = {(float)(cell & 1023u) + 0.5f, (float)(cell >> 10 & 1023u) + 0.5f,
                          (float)(cell >> 20 & 1023u) + 0.5f};
        float distance = nearest_within(g, centre, 1, to_triangles);
        sum->to_mesh += isfinite(distance) ? (double)distance : 2;
    }
    for (uint32_t i = 0; i < g->primitive->vertex_count; i++) {
        float distance = nearest_within(g, to_cells(g, g->primitive->positions[i]), 3, to_centre);
        sum->to_voxels += isfinite(distance) ? (double)distance : 4;
    }
    sum->voxels += g->chunk->count;
    sum->vertices += g->primitive->vertex_count;
}

kd_status voxel_distances_add(const kd_primitive_desc *primitive, const kd_voxel_chunk *chunk,
                              const uint32_t (*shape)[2], voxel_distances *sum)
{
    grid g = {.primitive = primitive, .chunk = chunk};
    kd_status status = open_grid(&g, shape);
    if (!status)
        add_up(&g, shape, sum);
    close_grid(&g);
    return status;
}
