/* How far voxels are from the surface they stand for, in percent of the diagonal of its box, by default
 * settings: no further than the source has it. Source: Gaitatzes & Papaioannou 2012, "Progressive
 * Screen-Space Multichannel Surface Voxelization", table 6.2 */

#include "tests/voxel_fixture.h"

#include "systems/voxel_cache/distance.h"

static voxel_distances measure(const char *path, uint32_t voxels, int32_t separating, double *diagonal)
{
    kd_model *model = fixture_asset(path);
    kd_vec3 size = kd_vec3_sub(model->bounds_max, model->bounds_min);
    float span = fmaxf(size.x, fmaxf(size.y, size.z)) / (float)voxels;
    voxel_world v = voxel_open((voxel_options){.resolution = voxels > 128 ? 256 : 128, .span = span});
    if (separating)
        v.frame->settings.voxels_separating = separating;
    voxel_spawn(&v, model, voxel_at(0, 0, 0));
    voxel_frame(&v);
    const kd_voxel_scene *scene = voxel_scene(&v);
    const kd_voxel_cache *cache = &scene->caches[scene->objects[0].caches[0] - 1];
    const kd_voxel_chunk *chunk = &scene->chunks[cache->first_chunk];
    voxel_distances sum = {0};
    assert_int_equal(cache->chunk_count, 1);
    uint32_t(*shape)[2] =
        voxel_read(scene->cache_shape, (size_t)chunk->first * 8, chunk->count * sizeof *shape);
    assert_int_equal(voxel_distances_add(cache->desc, chunk, (const uint32_t(*)[2])shape, &sum), KD_OK);
    *diagonal = (double)kd_vec3_length(size) / (double)cache->span;
    free(shape);
    voxel_close(&v);
    return sum;
}

/* In percent of the diagonal of the mesh's box. */
static double distance_at(const char *path, uint32_t voxels, int32_t separating)
{
    double diagonal;
    voxel_distances d = measure(path, voxels, separating, &diagonal);
    double to_mesh = d.to_mesh / (double)d.voxels, to_voxels = d.to_voxels / (double)d.vertices;
    print_message(
        "%-18s %3u  %s  %7u voxels  to the mesh %.3f %%  to the voxels %.3f %%  (%.2f, %.2f of an edge)\n",
        path, voxels, separating ? "26-separating" : "by default   ", (unsigned)d.voxels,
        100 * to_mesh / diagonal, 100 * to_voxels / diagonal, to_mesh, to_voxels);
    return 100 * to_mesh / diagonal;
}

static void voxels_lie_near_the_surface(void **state)
{
    (void)state;
    static const struct {
        const char *path;
        double limits[3];
    } models[] = {{"bunny/bunny.glb", {0.33, 0.17, 0.11}}, {"dragon/dragon.glb", {0.36, 0.19, 0.13}}};
    for (size_t m = 0; m < 2; m++)
        for (uint32_t i = 0; i < 3; i++)
            assert_true(distance_at(models[m].path, 64u << i, 0) <= models[m].limits[i]);
}

/* A plane through the middle of its cells, exactly; its four corners are half a cell's diagonal from the
 * centres. */
static void distances_to_a_plane_are_known(void **state)
{
    (void)state;
    static const kd_vec3 corners[4] = {{0, 0.5f, 0}, {4, 0.5f, 0}, {4, 0.5f, 4}, {0, 0.5f, 4}};
    static const uint32_t indices[6] = {0, 1, 2, 0, 2, 3};
    const kd_primitive_desc plane = {
        .positions = corners, .vertex_count = 4, .indices = indices, .index_count = 6};
    const kd_voxel_chunk chunk = {.span = 1, .size = {4, 2, 4}, .count = 32};
    uint32_t shape[32][2] = {{0}};
    voxel_distances d = {0};
    for (uint32_t i = 0; i < 32; i++) /* two layers: one on the plane, one an edge above */
        shape[i][0] = i % 4 | (i / 16) << 10 | (i / 4 % 4) << 20;
    assert_int_equal(voxel_distances_add(&plane, &chunk, (const uint32_t(*)[2])shape, &d), KD_OK);
    assert_int_equal(d.voxels, 32);
    assert_float_equal(d.to_mesh, 16, 1e-4);
    assert_float_equal(d.to_voxels, 4 * sqrtf(0.5f), 1e-4);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(distances_to_a_plane_are_known),
        cmocka_unit_test(voxels_lie_near_the_surface),
    };
    return VOXEL_GROUP(tests);
}
