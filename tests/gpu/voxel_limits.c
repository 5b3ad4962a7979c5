/* Chunks that need more work groups than an axis has are packed in full; what no buffer can hold is left out
 * whole. */

#include "runtime/asset/voxel_layout.h"
#include "runtime/gpu/internal.h"
#include "tests/voxel_cells_fixture.h"

#include "systems/voxel_cache/columns.h"
#include "systems/voxel_cache/voxelizer.h"

#define SPAN 0.02f

static kd_model *model_of(kd_model *model, kd_primitive_desc p)
{
    kd_primitive_desc *kept = FIXTURE_NEW(model, kd_primitive_desc, 1);
    kd_mesh_desc *mesh = FIXTURE_NEW(model, kd_mesh_desc, 1);
    kd_vec3 *normals = FIXTURE_NEW(model, kd_vec3, p.vertex_count);
    for (uint32_t i = 0; i < p.vertex_count; i++)
        normals[i] = (kd_vec3){0, 1, 0};
    p.material = KD_NONE;
    p.normals = normals;
    *kept = p;
    *mesh = (kd_mesh_desc){.name = "mesh", .primitive_count = 1, .primitives = kept};
    fixture_nodes(model, 1)->mesh = 0;
    model->meshes = mesh;
    model->mesh_count = 1;
    return model;
}

/* A plane of n x n squares of two triangles each. */
static kd_model *make_grid(uint32_t n, float edge)
{
    kd_model *model = fixture_model();
    uint32_t row = n + 1, at = 0;
    kd_vec3 *positions = FIXTURE_NEW(model, kd_vec3, row * row);
    uint32_t *indices = FIXTURE_NEW(model, uint32_t, 6 * n * n);
    for (uint32_t i = 0; i < row * row; i++)
        positions[i] = (kd_vec3){edge * (float)(i % row) / (float)n, 0, edge * (float)(i / row) / (float)n};
    for (uint32_t i = 0; i < row * row; i++) {
        if (i % row == n || i / row == n)
            continue;
        const uint32_t corners[6] = {i, i + row, i + 1, i + 1, i + row, i + row + 1};
        memcpy(indices + at, corners, sizeof corners);
        at += 6;
    }
    return model_of(model, (kd_primitive_desc){.vertex_count = row * row,
                                               .index_count = at,
                                               .positions = positions,
                                               .indices = indices,
                                               .bounds_max = {edge, 0, edge}});
}

/* A triangle from corner to corner of a cube. */
static kd_model *make_slope(float edge)
{
    kd_model *model = fixture_model();
    kd_vec3 *positions = FIXTURE_NEW(model, kd_vec3, 3);
    uint32_t *indices = FIXTURE_NEW(model, uint32_t, 3);
    for (uint32_t i = 0; i < 3; i++) {
        (&positions[i].x)[i] = edge;
        indices[i] = i;
    }
    return model_of(model, (kd_primitive_desc){.vertex_count = 3,
                                               .index_count = 3,
                                               .positions = positions,
                                               .indices = indices,
                                               .bounds_max = {edge, edge, edge}});
}

static const kd_voxel_cache *cache_of(voxel_world *v)
{
    const kd_voxel_scene *scene = voxel_scene(v);
    return &scene->caches[scene->objects[0].caches[0] - 1];
}

/* Voxels come in the order of their cells: each in a later one than the voxel before. What was not packed is
 * not. */
static void assert_packed(voxel_world *v, const kd_voxel_chunk *chunk)
{
    uint32_t(*shape)[2] =
        voxel_read(voxel_scene(v)->cache_shape, (size_t)chunk->first * 8, (size_t)chunk->count * 8);
    uint64_t last = 0;
    for (uint32_t i = 0; i < chunk->count; i++) {
        uint64_t x = shape[i][0] & 1023u, y = shape[i][0] >> 10 & 1023u, z = shape[i][0] >> 20 & 1023u;
        uint64_t place = voxel_cell_place(chunk->size, shape[i][0]);
        if (x >= chunk->size[0] || y >= chunk->size[1] || z >= chunk->size[2] || (i && place <= last))
            fail_msg("voxel %u of %u was not packed", i, chunk->count);
        last = place;
    }
    free(shape);
}

static void chunk_of_many_columns_is_packed_in_full(void **state)
{
    (void)state;
    voxel_world v = voxel_open((voxel_options){.resolution = 256, .span = SPAN});
    voxel_spawn(&v, make_grid(300, 700 * SPAN), voxel_at(0, 0, 0));
    voxel_frame(&v);
    const kd_voxel_cache *cache = cache_of(&v);
    const kd_voxel_chunk *chunk = &voxel_scene(&v)->chunks[cache->first_chunk];
    assert_int_equal(cache->chunk_count, 1);
    kd_columns columns;
    assert_int_equal(columns_list(cache->desc, chunk, false, &columns), KD_OK);
    free(columns.rows);
    assert_true(columns.columns > 65535u * 64);
    assert_int_equal(chunk->count, 701 * 701); /* the nudge puts the far edges into one cell more */
    assert_packed(&v, chunk);
    voxel_close(&v);
}

static void chunk_of_many_cells_is_packed_in_full(void **state)
{
    (void)state;
    voxel_world v = voxel_open((voxel_options){.resolution = 256, .span = SPAN});
    v.frame->settings.voxels_separating = 26;
    voxel_spawn(&v, make_slope(520 * SPAN), voxel_at(0, 0, 0));
    voxel_frame(&v);
    const kd_voxel_cache *cache = cache_of(&v);
    const kd_voxel_chunk *chunk = &voxel_scene(&v)->chunks[cache->first_chunk];
    assert_int_equal(cache->chunk_count, 1);
    assert_true((uint64_t)chunk->size[0] * chunk->size[1] * chunk->size[2] / 32 > 65535u * 64);
    /* A column of the plane x + y + z = edge holds 3 cells, and half of the columns are on it. */
    assert_in_range(chunk->count, 518 * 519 / 2 * 3, 522 * 523 / 2 * 3);
    assert_packed(&v, chunk);
    voxel_close(&v);
}

/* Voxelize the first chunk of the world once more, while the driver binds no more than `limit` bytes of
 * a buffer, and reads `texels` of one.
 */
static kd_status again(voxel_world *v, voxelizer *tool, int64_t limit, int64_t texels, kd_voxel_chunk *chunk)
{
    kd_voxel_scene *scene = kd_singleton(v->world, kd_voxel_scene);
    kd_gpu_info driver = voxel_gpu->info;
    *chunk = scene->chunks[cache_of(v)->first_chunk];
    voxel_gpu->info.max_ssbo_bytes = limit;
    voxel_gpu->info.max_texels = texels;
    kd_status status =
        voxelizer_run(voxel_gpu, tool, kd_singleton(v->world, kd_scene_store), cache_of(v), scene, chunk);
    voxel_gpu->info = driver;
    return status;
}

static void assert_left_out(voxel_world *v, voxelizer *tool, int64_t limit, kd_status why)
{
    uint32_t had = voxel_scene(v)->cached_voxels;
    kd_voxel_chunk chunk;
    assert_int_equal(again(v, tool, limit, limit / 8, &chunk), why);
    assert_int_equal(chunk.count, 0);
    assert_int_equal(voxel_scene(v)->cached_voxels, had);
    assert_packed(v, &voxel_scene(v)->chunks[cache_of(v)->first_chunk]);
}

static void voxels_that_no_buffer_holds_are_left_out_whole(void **state)
{
    (void)state;
    voxelizer tool = {0};
    kd_voxel_chunk chunk;
    const uint32_t count = 351 * 351;
    const int64_t limit = (int64_t)count * 16 * 4 + 1000; /* eight chunks of shapes; sums of one */
    voxel_world v = voxel_open((voxel_options){.resolution = 256, .span = SPAN});
    voxel_spawn(&v, make_grid(50, 350 * SPAN), voxel_at(0, 0, 0));
    voxel_frame(&v);
    assert_int_equal(voxelizer_init(voxel_gpu, &tool), KD_OK);
    assert_left_out(&v, &tool, limit - 2000, KD_OUT_OF_RANGE);
    for (uint32_t n = 1; n < 8; n++) {
        assert_int_equal(again(&v, &tool, limit, limit / 8, &chunk), KD_OK);
        assert_int_equal(chunk.count, count);
        assert_int_equal(chunk.first, n * count);
        assert_packed(&v, &chunk);
    }
    assert_left_out(&v, &tool, limit, KD_TOO_LARGE);
    assert_packed(&v, &chunk);
    /* more of them than a pass may bind at once, but not than may be read */
    assert_int_equal(again(&v, &tool, limit, limit, &chunk), KD_OK);
    assert_int_equal(chunk.first, 8 * count);
    assert_true(kd_gpu_buffer_size(voxel_gpu, voxel_scene(&v)->cache_shape) > (size_t)limit);
    assert_packed(&v, &chunk);
    voxelizer_fini(voxel_gpu, &tool);
    voxel_close(&v);
}

static void mask_that_no_buffer_holds_is_refused(void **state)
{
    (void)state;
    voxelizer tool = {0};
    voxel_world v = voxel_open((voxel_options){.resolution = 256, .span = SPAN});
    voxel_spawn(&v, make_slope(300 * SPAN), voxel_at(0, 0, 0));
    voxel_frame(&v);
    assert_int_equal(voxelizer_init(voxel_gpu, &tool), KD_OK);
    assert_left_out(&v, &tool, 300 * 300 * 300 / 8, KD_OUT_OF_RANGE); /* the mask has a little more */
    assert_int_equal(kd_gpu_buffer_size(voxel_gpu, tool.mask), 0);
    voxelizer_fini(voxel_gpu, &tool);
    voxel_close(&v);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(chunk_of_many_columns_is_packed_in_full),
        cmocka_unit_test(chunk_of_many_cells_is_packed_in_full),
        cmocka_unit_test(voxels_that_no_buffer_holds_are_left_out_whole),
        cmocka_unit_test(mask_that_no_buffer_holds_is_refused),
    };
    return VOXEL_GROUP(tests);
}
