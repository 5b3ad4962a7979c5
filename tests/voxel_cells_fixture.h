#ifndef KD_TESTS_VOXEL_CELLS_FIXTURE_H
#define KD_TESTS_VOXEL_CELLS_FIXTURE_H

/* For tests of the voxelizer: the voxels of a cache entry on their lattice. */

#include "tests/voxel_fixture.h"

/* All cells of a cache entry with one free cell round them. */
typedef struct cells {
    int64_t low[3]; /* lattice number of the first cell */
    uint32_t size[3], total;
    uint8_t *wall;
    uint32_t *voxel; /* number of the voxel, in cache order */
    uint32_t (*shape)[2], *color;
    const kd_voxel_cache *cache;
} cells;

static inline size_t cell_at(const cells *c, const int64_t cell[3])
{
    size_t at = 0;
    for (int k = 2; k >= 0; k--) {
        assert_true(cell[k] >= c->low[k] && cell[k] < c->low[k] + (int64_t)c->size[k]);
        at = at * c->size[k] + (size_t)(cell[k] - c->low[k]);
    }
    return at;
}

static inline int64_t chunk_corner(const cells *c, const kd_voxel_chunk *chunk, int k)
{
    return llroundf(((&chunk->origin.x)[k] - (&c->cache->phase.x)[k]) / chunk->span);
}

static inline void lattice_of(cells *c, const kd_voxel_scene *scene)
{
    int64_t high[3];
    for (int k = 0; k < 3; k++) {
        c->low[k] = INT64_MAX;
        high[k] = INT64_MIN;
        for (uint32_t i = 0; i < c->cache->chunk_count; i++) {
            const kd_voxel_chunk *chunk = &scene->chunks[c->cache->first_chunk + i];
            int64_t corner = chunk_corner(c, chunk, k);
            c->low[k] = corner < c->low[k] ? corner : c->low[k];
            high[k] = corner + chunk->size[k] > high[k] ? corner + chunk->size[k] : high[k];
        }
        c->low[k]--;
        c->size[k] = (uint32_t)(high[k] + 1 - c->low[k]);
    }
}

static inline cells read_cells(voxel_world *v, uint32_t object)
{
    const kd_voxel_scene *scene = voxel_scene(v);
    cells c = {.cache = &scene->caches[scene->objects[object].caches[0] - 1]};
    lattice_of(&c, scene);
    size_t count = (size_t)c.size[0] * c.size[1] * c.size[2];
    c.wall = calloc(count, 1);
    c.voxel = calloc(count, 4);
    assert_true(c.wall && c.voxel);
    c.shape = voxel_read(scene->cache_shape, 0, (size_t)scene->voxel_places.end * 8);
    c.color = voxel_read(scene->cache_color, 0, (size_t)scene->voxel_places.end * 4);
    for (uint32_t i = 0; i < c.cache->chunk_count; i++) {
        const kd_voxel_chunk *chunk = &scene->chunks[c.cache->first_chunk + i];
        for (uint32_t n = chunk->first; n < chunk->first + chunk->count; n++) {
            int64_t cell[3];
            for (int k = 0; k < 3; k++)
                cell[k] = chunk_corner(&c, chunk, k) + (int64_t)(c.shape[n][0] >> (10 * k) & 1023u);
            assert_int_equal(c.wall[cell_at(&c, cell)], 0); /* none twice */
            c.wall[cell_at(&c, cell)] = 1;
            c.voxel[cell_at(&c, cell)] = n;
            c.total++;
        }
    }
    assert_int_equal(c.total, c.cache->voxel_count);
    return c;
}

static inline void free_cells(cells *c)
{
    free(c->wall);
    free(c->voxel);
    free(c->shape);
    free(c->color);
}

#endif
