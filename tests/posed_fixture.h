#ifndef KD_TESTS_POSED_FIXTURE_H
#define KD_TESTS_POSED_FIXTURE_H

/* For tests of voxels in motion: the posed mesh of everything in a frame, voxelized directly on the CPU,
 * beside what the tree's leaves hold. Both in cells of the finest cascade. */

#include "systems/voxel_cache/reference.h"
#include "tests/voxel_fixture.h"

typedef struct posed {
    double (*triangles)[3][3]; /* [count][corner][axis] in cells from the world's origin */
    uint32_t count;
    int64_t low[3]; /* of a box round all of them, two cells wider */
    uint32_t size[3];
    size_t cells;
    uint8_t *direct; /* [cells] 1: a triangle touches it */
    uint8_t *ours;   /* [cells] 1: a leaf holds something there, of whichever cascade owns it */
} posed;

static inline size_t posed_at(const posed *p, const int64_t cell[3])
{
    size_t at = 0;
    for (int k = 2; k >= 0; k--)
        at = at * p->size[k] + (size_t)(cell[k] - p->low[k]);
    return at;
}

/* A vertex of an object in the world: as it was drawn. */
static inline kd_vec3 posed_vertex(const kd_voxel_object *o, const kd_scene_store *store,
                                   const uint32_t *geometry, uint32_t vertex)
{
    kd_vec3 p = o->desc->positions[vertex];
    if (o->deformed) {
        uint32_t base = store->deformed_primitives[o->deformed - 1].base_vertex;
        memcpy(&p, geometry + (size_t)(base + vertex) * KD_GEOMETRY_WORDS, sizeof p);
    }
    return kd_mat4_point(&o->model_ws, p);
}

static inline void posed_triangles(voxel_world *v, posed *p)
{
    const kd_voxel_scene *scene = voxel_scene(v);
    const kd_scene_store *store = kd_singleton(v->world, kd_scene_store);
    uint32_t *geometry = voxel_read(store->geometry, 0, (size_t)store->vertex_count * KD_GEOMETRY_WORDS * 4);
    size_t room = 0;
    for (uint32_t i = 0; i < scene->object_count; i++)
        room += scene->objects[i].alive ? scene->objects[i].desc->index_count / 3 : 0;
    p->triangles = calloc(room + 1, sizeof *p->triangles);
    assert_non_null(p->triangles);
    for (uint32_t i = 0; i < scene->object_count; i++) {
        const kd_voxel_object *o = &scene->objects[i];
        for (uint32_t n = 0; o->alive && n < o->desc->index_count; n++) {
            kd_vec3 at = posed_vertex(o, store, geometry, o->desc->indices[n]);
            for (int k = 0; k < 3; k++)
                p->triangles[p->count + n / 3][n % 3][k] = (double)(&at.x)[k] / (double)scene->span[0];
        }
        p->count += o->alive ? o->desc->index_count / 3 : 0;
    }
    free(geometry);
}

static inline void posed_bounds(const double t[3][3], int64_t margin, int64_t low[3], int64_t high[3])
{
    for (int k = 0; k < 3; k++) {
        low[k] = (int64_t)floor(fmin(t[0][k], fmin(t[1][k], t[2][k]))) - margin;
        high[k] = (int64_t)floor(fmax(t[0][k], fmax(t[1][k], t[2][k]))) + margin;
    }
}

static inline void posed_box(posed *p)
{
    int64_t low[3], high[3], end[3] = {INT64_MIN, INT64_MIN, INT64_MIN};
    for (int k = 0; k < 3; k++)
        p->low[k] = INT64_MAX;
    for (uint32_t t = 0; t < p->count; t++) {
        posed_bounds((const double(*)[3])p->triangles[t], 2, low, high);
        for (int k = 0; k < 3; k++) {
            p->low[k] = low[k] < p->low[k] ? low[k] : p->low[k];
            end[k] = high[k] > end[k] ? high[k] : end[k];
        }
    }
    p->cells = 1;
    for (int k = 0; k < 3; k++) {
        assert_true(end[k] > p->low[k] && end[k] - p->low[k] < 1024);
        p->size[k] = (uint32_t)(end[k] - p->low[k] + 1);
        p->cells *= p->size[k];
    }
}

static inline void posed_mark(posed *p)
{
    int64_t low[3], high[3], c[3];
    for (uint32_t t = 0; t < p->count; t++) {
        posed_bounds((const double(*)[3])p->triangles[t], 0, low, high);
        for (c[2] = low[2]; c[2] <= high[2]; c[2]++)
            for (c[1] = low[1]; c[1] <= high[1]; c[1]++)
                for (c[0] = low[0]; c[0] <= high[0]; c[0]++) {
                    const double from[3] = {(double)c[0], (double)c[1], (double)c[2]};
                    const double to[3] = {from[0] + 1, from[1] + 1, from[2] + 1};
                    uint8_t *cell = &p->direct[posed_at(p, c)];
                    *cell = *cell || voxel_reference_touches((const double(*)[3])p->triangles[t], from, to);
                }
    }
}

/* The leaf that holds a cell of the finest cascade: of the first cascade that owns it. */
static inline bool posed_leaf(const kd_voxel_scene *scene, const uint32_t *mask, const int64_t cell[3])
{
    for (uint32_t c = 0; c < scene->cascade_count; c++) {
        int32_t at[3];
        for (int k = 0; k < 3; k++)
            at[k] = (int32_t)(cell[k] >> c) - scene->origin_cells[c][k];
        if (!svo_owned(scene->resolution, c, at))
            continue;
        uint32_t bit = svo_wrapped_code(scene->resolution_log2, scene->origin_cells[c], at);
        bit += c << (3 * scene->resolution_log2);
        return mask[bit >> 5] >> (bit & 31) & 1u;
    }
    return false;
}

static inline posed posed_read(voxel_world *v)
{
    posed p = {0};
    int64_t c[3];
    uint32_t *mask = voxel_read_union(v);
    posed_triangles(v, &p);
    posed_box(&p);
    p.direct = calloc(p.cells, 1);
    p.ours = calloc(p.cells, 1);
    assert_true(p.direct && p.ours);
    posed_mark(&p);
    for (size_t i = 0; i < p.cells; i++) {
        c[0] = p.low[0] + (int64_t)(i % p.size[0]);
        c[1] = p.low[1] + (int64_t)(i / p.size[0] % p.size[1]);
        c[2] = p.low[2] + (int64_t)(i / p.size[0] / p.size[1]);
        p.ours[i] = posed_leaf(voxel_scene(v), mask, c);
    }
    free(mask);
    return p;
}

static inline void posed_free(posed *p)
{
    free(p->triangles);
    free(p->direct);
    free(p->ours);
}

/* How often the posed surface goes round the centre of a cell: 1 or -1 inside of a closed one, 0 outside.
 * Source: van Oosterom, Strackee 1983, for the solid angle of a triangle */
static inline double posed_winding(const posed *p, size_t cell)
{
    const double at[3] = {(double)(p->low[0] + (int64_t)(cell % p->size[0])) + 0.5,
                          (double)(p->low[1] + (int64_t)(cell / p->size[0] % p->size[1])) + 0.5,
                          (double)(p->low[2] + (int64_t)(cell / p->size[0] / p->size[1])) + 0.5};
    double sum = 0;
    for (uint32_t t = 0; t < p->count; t++) {
        double d[3][3], l[3], dots[3];
        for (int i = 0; i < 3; i++)
            for (int k = 0; k < 3; k++)
                d[i][k] = p->triangles[t][i][k] - at[k];
        for (int i = 0; i < 3; i++) {
            const double *a = d[i], *b = d[(i + 1) % 3];
            l[i] = sqrt(a[0] * a[0] + a[1] * a[1] + a[2] * a[2]);
            dots[i] = a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
        }
        double volume = d[0][0] * (d[1][1] * d[2][2] - d[1][2] * d[2][1]) -
                        d[0][1] * (d[1][0] * d[2][2] - d[1][2] * d[2][0]) +
                        d[0][2] * (d[1][0] * d[2][1] - d[1][1] * d[2][0]);
        sum += 2 * atan2(volume, l[0] * l[1] * l[2] + dots[0] * l[2] + dots[1] * l[0] + dots[2] * l[1]);
    }
    return sum / (4 * 3.14159265358979);
}

/* Cells inside of the surface that a flood from outside reaches, though the direct voxelization keeps them
 * apart. `inside` counts the cells that were looked at. */
static inline size_t posed_leaks(const posed *p, size_t *inside)
{
    uint8_t *closed = calloc(p->cells, 1), *outside = calloc(p->cells, 1);
    size_t leaks = 0;
    assert_true(closed && outside);
    voxel_flood(p->direct, p->size, closed);
    voxel_flood(p->ours, p->size, outside);
    for (size_t i = 0; i < p->cells; i++) {
        bool enclosed = !p->direct[i] && !closed[i];
        *inside += enclosed;
        leaks += enclosed && outside[i] && fabs(posed_winding(p, i)) > 0.5; /* no mere pocket between limbs */
    }
    free(closed);
    free(outside);
    return leaks;
}

#endif
