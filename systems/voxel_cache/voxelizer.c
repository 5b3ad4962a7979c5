/* Voxelization in compute: mark the cells that triangles touch, rank them, add up the attributes of all
 * fragments of a voxel in fixed point, pack. Every step gives the same bytes whatever the order of threads.
 */
#include "systems/voxel_cache/voxelizer.h"

#include <stdlib.h>
#include <string.h>

#include "components/material.h"
#include "runtime/core/log.h"
#include "runtime/asset/voxel_file.h"
#include "systems/voxel_cache/columns.h"
#include "runtime/asset/voxel_layout.h"
#include "systems/voxel_cache/fill.h"

struct pass_params {
    kd_gl_vec4 chunk_origin;
    kd_gl_uvec4 chunk_size, source, dest;
};

enum {
    SUM_WORDS = 16,
    PASS_THIN = 2,
    PASS_LONE = 4,
    ROWS_ALIGNED = 256 /* so many rows of whole words begin where GL lets a range begin */
};

uint32_t voxelizer_flags(const kd_voxel_scene *scene, const kd_voxel_cache *cache)
{
    uint32_t flags = scene->voxelize_flags & KD_VOXEL_LEVEL_FILLED;
    if (cache->kind == KD_VOXEL_SKINNED)
        flags |= scene->voxelize_flags & KD_VOXEL_LEVEL_GEODESIC;
    return flags | (cache->thin ? KD_VOXEL_LEVEL_THIN : 0);
}

kd_status voxelizer_init(kd_gpu *gpu, voxelizer *v)
{
    v->mark = kd_gpu_make_program(gpu, &(kd_gpu_program_desc){.compute = "shaders/voxel_cache/mark.comp"});
    v->accumulate =
        kd_gpu_make_program(gpu, &(kd_gpu_program_desc){.compute = "shaders/voxel_cache/accumulate.comp"});
    v->pack = kd_gpu_make_program(gpu, &(kd_gpu_program_desc){.compute = "shaders/voxel_cache/pack.comp"});
    v->bind = kd_gpu_make_program(gpu, &(kd_gpu_program_desc){.compute = "shaders/voxel_cache/bind.comp"});
    v->counter = kd_gpu_make_buffer(
        gpu, &(kd_gpu_buffer_desc){.size = 64, .zeroed = true, .name = "voxelizer.counter"});
    kd_status status = kd_gpu_rank_init(gpu, &v->rank);
    return v->mark.id && v->accumulate.id && v->pack.id && v->bind.id && v->counter.id ? status : KD_GPU;
}

void voxelizer_fini(kd_gpu *gpu, voxelizer *v)
{
    kd_gpu_program programs[] = {v->mark, v->accumulate, v->accumulate_glowing, v->pack, v->bind};
    for (size_t i = 0; i < sizeof programs / sizeof *programs; i++)
        kd_gpu_destroy_program(gpu, programs[i]);
    voxelizer_rest(gpu, v);
    kd_gpu_destroy_buffer(gpu, v->counter);
    kd_gpu_rank_fini(gpu, &v->rank);
    memset(v, 0, sizeof *v);
}

void voxelizer_rest(kd_gpu *gpu, voxelizer *v)
{
    kd_gpu_buffer *buffers[] = {&v->mask, &v->ranks, &v->sums, &v->nearest, &v->columns};
    for (size_t i = 0; i < sizeof buffers / sizeof *buffers; i++) {
        kd_gpu_destroy_buffer(gpu, *buffers[i]);
        *buffers[i] = (kd_gpu_buffer){0};
    }
}

static struct pass_params params_of(const kd_scene_store *store, const kd_voxel_cache *cache,
                                    const kd_voxel_scene *scene, const kd_voxel_chunk *chunk)
{
    const kd_store_primitive *p = &store->primitives[cache->primitive];
    const kd_store_material *m = &store->materials[cache->material];
    struct pass_params pass = {
        .chunk_origin = {chunk->origin.x, chunk->origin.y, chunk->origin.z, chunk->span},
        .chunk_size = {chunk->size[0], chunk->size[1], chunk->size[2], 0},
        .source = {p->first_index, p->base_vertex, p->index_count / 3, p->first_skin_vertex},
        .dest = {0, 0, cache->kind,
                 (m->desc.double_sided ? 1u : 0u) |
                     (voxelizer_flags(scene, cache) & KD_VOXEL_LEVEL_THIN ? PASS_THIN : 0u)},
    };
    return pass;
}

/* A buffer for work in progress of the given size, if shaders can have one that large at all. */
static kd_status ensure(kd_gpu *gpu, kd_gpu_buffer *buffer, size_t size, const char *name)
{
    if (size > (size_t)kd_gpu_get_info(gpu)->max_ssbo_bytes)
        return KD_OUT_OF_RANGE;
    return kd_gpu_ensure_buffer(gpu, buffer, size, 0, name);
}

/* Grow the cache by half: buffers are copied when they grow, so few growths matter more than a tight fit.
 * Shaders read it as texels, and write the voxels of one chunk at a time. */
static kd_status grow(kd_gpu *gpu, kd_gpu_buffer *buffer, size_t want, size_t texel_bytes, const char *name)
{
    size_t have = buffer->id ? kd_gpu_buffer_size(gpu, *buffer) : 0;
    size_t most = (size_t)kd_gpu_get_info(gpu)->max_texels * texel_bytes;
    if (want <= have)
        return KD_OK;
    if (want > most)
        return KD_TOO_LARGE;
    size_t size = have + have / 2 > want ? have + have / 2 : want + want / 4;
    return kd_gpu_ensure_buffer(gpu, buffer, size < most ? size : most, have, name);
}

kd_status voxelizer_take(kd_gpu *gpu, kd_voxel_scene *scene, uint32_t voxels, uint32_t bindings,
                         kd_voxel_chunk *chunk)
{
    size_t ends = (size_t)kd_ranges_bound(&scene->voxel_places, voxels), word = KD_BINDING_WORDS * 4;
    size_t bound = (size_t)kd_ranges_bound(&scene->binding_places, bindings);
    kd_status status = grow(gpu, &scene->cache_shape, ends * 8, 8, "voxels.shape");
    if (!status)
        status = grow(gpu, &scene->cache_color, ends * 4, 4, "voxels.color");
    if (!status)
        status = grow(gpu, &scene->cache_binding, (bound ? bound : 1) * word, 4, "voxels.binding");
    if (status)
        return status;
    chunk->first = kd_ranges_take(&scene->voxel_places, voxels);
    chunk->count = voxels;
    chunk->first_binding = bindings ? kd_ranges_take(&scene->binding_places, bindings) : KD_EMPTY;
    scene->cached_voxels += voxels;
    return KD_OK;
}

/* What both triangle passes read (shaders/voxel_cache/triangle.glsl), and the mask. */
static void bind_triangles(kd_gpu *gpu, const voxelizer *v, const kd_scene_store *store,
                           const struct pass_params *pass)
{
    kd_gpu_bind_uniform(gpu, 0, pass, sizeof *pass);
    kd_gpu_bind_storage(gpu, 0, store->geometry);
    kd_gpu_bind_storage(gpu, 1, store->attributes);
    kd_gpu_bind_storage(gpu, 2, store->indices);
    kd_gpu_bind_storage(gpu, 3, v->columns);
    kd_gpu_bind_storage(gpu, 4, v->mask);
}

static void mark_once(kd_gpu *gpu, voxelizer *v, const kd_scene_store *store, const struct pass_params *pass)
{
    bind_triangles(gpu, v, store, pass);
    kd_gpu_bind_storage(gpu, 5, v->ranks);
    kd_gpu_dispatch_linear(gpu, v->mark, (pass->chunk_size.w + 63) / 64);
}

/* Mark the cells that triangles touch; gives the number of voxels. */
static kd_status mark_cells(kd_gpu *gpu, voxelizer *v, const kd_scene_store *store,
                            const struct pass_params *pass, uint32_t words, uint32_t *count)
{
    kd_gpu_fill_buffer(gpu, v->mask, 0, (size_t)words * 4, 0);
    kd_gpu_barrier(gpu, KD_BARRIER_STORAGE);
    mark_once(gpu, v, store, pass);
    kd_gpu_barrier(gpu, KD_BARRIER_STORAGE | KD_BARRIER_BUFFER_UPDATE);
    if (pass->dest.w & PASS_THIN) { /* what they look back on is kept where the ranks come later */
        struct pass_params lone = *pass;
        lone.dest.w |= PASS_LONE;
        kd_gpu_copy_buffer(gpu, v->mask, 0, v->ranks, 0, (size_t)words * 4);
        kd_gpu_barrier(gpu, KD_BARRIER_STORAGE);
        mark_once(gpu, v, store, &lone);
        kd_gpu_barrier(gpu, KD_BARRIER_STORAGE);
    }
    kd_status status = kd_gpu_rank_run(gpu, &v->rank, v->mask, 0, words, v->ranks, 0, v->counter, 0);
    kd_gpu_barrier(gpu, KD_BARRIER_STORAGE | KD_BARRIER_BUFFER_UPDATE);
    kd_gpu_read_buffer(gpu, v->counter, 0, count, sizeof *count);
    return status;
}

/* Blocks of 8x8x8 cells, see shaders/voxel_cache/chunk_cell.glsl. */
static uint32_t mask_words(const kd_voxel_chunk *chunk)
{
    uint32_t blocks = 1;
    for (int k = 0; k < 3; k++)
        blocks *= (chunk->size[k] + 7) / 8;
    return blocks * (512 / 32);
}

/* Between the mask's order and rows of cells: takes every bit that is set over to `to`. */
static void reorder(const uint32_t *from, uint32_t words, bool to_rows, const uint32_t size[3], uint32_t *to)
{
    for (uint32_t w = 0; w < words; w++)
        for (uint32_t bits = from[w]; bits; bits &= bits - 1) {
            uint64_t bit = (uint64_t)w * 32 + (uint32_t)__builtin_ctz(bits), out;
            uint32_t cell;
            if (to_rows) {
                voxel_place_cell(size, bit, &cell);
                out = (cell & 1023) + size[0] * ((cell >> 10 & 1023) + (uint64_t)size[1] * (cell >> 20));
            } else {
                uint64_t row = bit / size[0];
                cell = (uint32_t)(bit % size[0] | (row % size[1]) << 10 | (row / size[1]) << 20);
                out = voxel_cell_place(size, cell);
            }
            to[out >> 5] |= 1u << (out & 31);
        }
}

/* Fill what the marked cells enclose, on the CPU: an option for making files, not for frames. */
static kd_status fill_inside(kd_gpu *gpu, voxelizer *v, const kd_voxel_chunk *chunk, uint32_t words,
                             uint32_t *count)
{
    uint32_t *mask = malloc((size_t)words * sizeof *mask), *rows = calloc(words, sizeof *rows);
    kd_status status = mask && rows ? KD_OK : KD_NO_MEMORY;
    if (!status) {
        kd_gpu_read_buffer(gpu, v->mask, 0, mask, (size_t)words * sizeof *mask);
        reorder(mask, words, true, chunk->size, rows);
        status = fill_enclosed(rows, chunk->size);
    }
    if (!status) {
        reorder(rows, words, false, chunk->size, mask);
        kd_gpu_write_buffer(gpu, v->mask, 0, mask, (size_t)words * sizeof *mask);
        kd_gpu_barrier(gpu, KD_BARRIER_STORAGE);
        status = kd_gpu_rank_run(gpu, &v->rank, v->mask, 0, words, v->ranks, 0, v->counter, 0);
        kd_gpu_barrier(gpu, KD_BARRIER_STORAGE | KD_BARRIER_BUFFER_UPDATE);
        kd_gpu_read_buffer(gpu, v->counter, 0, count, sizeof *count);
    }
    free(mask);
    free(rows);
    return status;
}

/* Software drivers run a branch that nothing takes, so what glows has a program of its own. */
static kd_gpu_program accumulate_program(kd_gpu *gpu, voxelizer *v, const kd_material_desc *material)
{
    static const char *const defines[] = {"KD_GLOWS 1", NULL};
    if (!kd_material_glows(material))
        return v->accumulate;
    if (!v->accumulate_glowing.id)
        v->accumulate_glowing =
            kd_gpu_make_program(gpu, &(kd_gpu_program_desc){.compute = "shaders/voxel_cache/accumulate.comp",
                                                            .defines = defines});
    return v->accumulate_glowing;
}

static void accumulate(kd_gpu *gpu, voxelizer *v, const kd_scene_store *store, const struct pass_params *pass,
                       kd_gpu_program program)
{
    bind_triangles(gpu, v, store, pass);
    kd_gpu_bind_storage(gpu, 5, v->ranks);
    kd_gpu_bind_storage(gpu, 6, v->sums);
    kd_gpu_bind_storage(gpu, 7, v->nearest);
    kd_gpu_dispatch_linear(gpu, program, (pass->chunk_size.w + 63) / 64);
    kd_gpu_barrier(gpu, KD_BARRIER_STORAGE);
}

/* Bind the part of a table in which a chunk's rows lie, which may be larger than what can be bound at once.
 * Returns the place of the first row in what is bound. */
static uint32_t bind_rows(kd_gpu *gpu, uint32_t binding, kd_gpu_buffer table, uint32_t first, uint32_t count,
                          size_t row_bytes)
{
    uint32_t from = first / ROWS_ALIGNED * ROWS_ALIGNED;
    kd_gpu_bind_storage_range(gpu, binding, table, from * row_bytes, (first - from + count) * row_bytes);
    return first - from;
}

static void pack(kd_gpu *gpu, voxelizer *v, const kd_voxel_scene *scene, struct pass_params pass,
                 const kd_voxel_chunk *chunk, uint32_t words)
{
    pass.chunk_size.w = words;
    bind_rows(gpu, 3, scene->cache_shape, chunk->first, chunk->count, 8);
    pass.dest.x = bind_rows(gpu, 4, scene->cache_color, chunk->first, chunk->count, 4);
    kd_gpu_bind_uniform(gpu, 0, &pass, sizeof pass);
    kd_gpu_bind_storage(gpu, 0, v->mask);
    kd_gpu_bind_storage(gpu, 1, v->ranks);
    kd_gpu_bind_storage(gpu, 2, v->sums);
    kd_gpu_dispatch_linear(gpu, v->pack, (words + 63) / 64);
}

static void bind(kd_gpu *gpu, voxelizer *v, const kd_scene_store *store, const kd_voxel_scene *scene,
                 struct pass_params pass, const kd_voxel_chunk *chunk, uint32_t words)
{
    pass.chunk_size.w = words;
    pass.dest.y =
        bind_rows(gpu, 7, scene->cache_binding, chunk->first_binding, chunk->count, KD_BINDING_WORDS * 4);
    kd_gpu_bind_uniform(gpu, 0, &pass, sizeof pass);
    kd_gpu_bind_storage(gpu, 0, store->geometry);
    kd_gpu_bind_storage(gpu, 2, store->indices);
    kd_gpu_bind_storage(gpu, 3, v->mask);
    kd_gpu_bind_storage(gpu, 4, v->ranks);
    kd_gpu_bind_storage(gpu, 5, v->nearest);
    kd_gpu_bind_storage(gpu, 6, store->skins_buffer.id ? store->skins_buffer : v->nearest);
    kd_gpu_dispatch_linear(gpu, v->bind, (words + 63) / 64);
}

/* All that the counted voxels need, before any of them is written. */
static kd_status make_room(kd_gpu *gpu, voxelizer *v, kd_voxel_scene *scene, uint32_t voxels,
                           uint32_t bindings, kd_voxel_chunk *chunk)
{
    kd_status status = ensure(gpu, &v->sums, (size_t)voxels * SUM_WORDS * 4, "voxelizer.sums");
    if (!status)
        status = ensure(gpu, &v->nearest, (size_t)voxels * 4, "voxelizer.nearest");
    return status ? status : voxelizer_take(gpu, scene, voxels, bindings, chunk);
}

static kd_status fill_chunk(kd_gpu *gpu, voxelizer *v, const kd_scene_store *store,
                            const kd_voxel_cache *cache, kd_voxel_scene *scene, kd_voxel_chunk *chunk,
                            struct pass_params *pass, uint32_t words)
{
    kd_gpu_program program = accumulate_program(gpu, v, &store->materials[cache->material].desc);
    uint32_t count = 0;
    if (!program.id)
        return KD_GPU;
    kd_status status = mark_cells(gpu, v, store, pass, words, &count);
    if (!status && count && scene->voxelize_flags & KD_VOXEL_LEVEL_FILLED)
        status = fill_inside(gpu, v, chunk, words, &count);
    uint32_t bindings = cache->kind == KD_VOXEL_RIGID ? 0 : count;
    if (status || count == 0)
        return status;
    status = make_room(gpu, v, scene, count, bindings, chunk);
    if (status)
        return status;
    kd_gpu_fill_buffer(gpu, v->sums, 0, (size_t)count * SUM_WORDS * 4, 0);
    kd_gpu_fill_buffer(gpu, v->nearest, 0, (size_t)count * 4, 0);
    kd_gpu_barrier(gpu, KD_BARRIER_STORAGE);
    accumulate(gpu, v, store, pass, program);
    pack(gpu, v, scene, *pass, chunk, words);
    if (bindings)
        bind(gpu, v, store, scene, *pass, chunk, words);
    kd_gpu_barrier(gpu, KD_BARRIER_STORAGE | KD_BARRIER_BUFFER_UPDATE);
    return KD_OK;
}

kd_status voxelizer_run(kd_gpu *gpu, voxelizer *v, const kd_scene_store *store, const kd_voxel_cache *cache,
                        kd_voxel_scene *scene, kd_voxel_chunk *chunk)
{
    kd_columns columns = {0};
    chunk->count = 0;
    chunk->first_binding = KD_EMPTY;
    kd_status status =
        columns_list(cache->desc, chunk, voxelizer_flags(scene, cache) & KD_VOXEL_LEVEL_THIN, &columns);
    if (status)
        return status == KD_TOO_LARGE ? KD_OUT_OF_RANGE : status;
    uint32_t words = mask_words(chunk);
    struct pass_params pass = params_of(store, cache, scene, chunk);
    pass.chunk_size.w = columns.columns;
    size_t row_bytes = ((size_t)columns.triangles + 1) * 16;
    if (ensure(gpu, &v->columns, row_bytes, "voxelizer.columns"))
        status = KD_TOO_LARGE; /* a row a triangle, wherever it lies: smaller chunks have as many */
    if (!status)
        status = ensure(gpu, &v->mask, (size_t)words * 4, "voxelizer.mask");
    if (!status)
        status = ensure(gpu, &v->ranks, (size_t)words * 4, "voxelizer.ranks");
    if (!status && columns.columns) {
        kd_gpu_write_buffer(gpu, v->columns, 0, columns.rows, row_bytes);
        kd_material_bind(gpu, &store->materials[cache->material]);
        status = fill_chunk(gpu, v, store, cache, scene, chunk, &pass, words);
    }
    free(columns.rows);
    return status;
}
