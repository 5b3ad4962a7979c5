/* Where the cascades stand, and which of them a box takes part in. */

#include "systems/svo/reference.h"
#include "systems/voxel_pages/placement.h"
#include "tests/systems_fixture.h"

static kd_voxel_scene scene_of(uint32_t resolution, uint32_t cascades, float span)
{
    kd_voxel_scene scene = {.cascade_count = cascades, .resolution = resolution, .span_m = span};
    for (uint32_t c = 0; c < cascades; c++)
        scene.span[c] = span * (float)(1u << c);
    return scene;
}

static float edge_of(const kd_voxel_scene *scene, uint32_t c)
{
    return scene->span[c] * (float)scene->resolution;
}

/* Whole cells of the outermost dense level, a common centre, each in the central half of the next. */
static void cascades_nest_on_one_lattice(void **state)
{
    (void)state;
    uint64_t random = 1;
    for (int i = 0; i < 2000; i++) {
        kd_voxel_scene scene =
            scene_of(128u << i % 3, 1 + (uint32_t)i % 4, fixture_float(&random, 0.005f, 0.3f));
        kd_vec3 focus = fixture_vec3(&random, -50, 50);
        placement_update(&scene, focus, (kd_vec3){-200, -200, -200}, (kd_vec3){200, 200, 200});
        uint32_t outer = scene.cascade_count - 1;
        float dense = edge_of(&scene, outer) / KD_DENSE;
        for (uint32_t c = 0; c < scene.cascade_count; c++)
            for (int k = 0; k < 3; k++) {
                float centre = (&scene.origin_ws[c].x)[k] + 0.5f * edge_of(&scene, c), steps = centre / dense;
                assert_float_equal(steps, roundf(steps), 1e-3f);
                assert_true(fabsf(centre - (&focus.x)[k]) <= 0.51f * dense);
                float finest = (&scene.origin_ws[0].x)[k] + 0.5f * edge_of(&scene, 0);
                assert_float_equal(centre, finest, 1e-3f * scene.span[0]);
            }
    }
}

static void small_scene_is_held_whole_wherever_the_camera_is(void **state)
{
    (void)state;
    uint64_t random = 2;
    for (int i = 0; i < 500; i++) {
        kd_voxel_scene scene = scene_of(128, 2, 0.02f);
        kd_vec3 low = fixture_vec3(&random, -3, 3),
                high = kd_vec3_add(low, fixture_vec3(&random, 0.1f, 2.4f));
        placement_update(&scene, fixture_vec3(&random, -20, 20), low, high);
        for (int k = 0; k < 3; k++) { /* 2.56 m; half a step of 0.08 m is what snapping may take */
            assert_true((&scene.origin_ws[0].x)[k] <= (&low.x)[k] + 1e-4f);
            assert_true((&scene.origin_ws[0].x)[k] + edge_of(&scene, 0) >= (&high.x)[k] - 1e-4f);
        }
    }
}

/* Whoever stands at an end of a large scene has the finest voxels up to it. */
static void ends_of_a_large_scene_are_held_by_the_finest_cascade(void **state)
{
    (void)state;
    uint64_t random = 3;
    for (int i = 0; i < 500; i++) {
        kd_voxel_scene scene = scene_of(128, 1 + (uint32_t)i % 4, fixture_float(&random, 0.01f, 0.1f));
        float edge = edge_of(&scene, 0);
        kd_vec3 low = fixture_vec3(&random, -30, 30);
        kd_vec3 high = kd_vec3_add(low, fixture_vec3(&random, 2 * edge, 5 * edge));
        placement_update(&scene, kd_vec3_sub(low, fixture_vec3(&random, 0, 3)), low, high);
        for (int k = 0; k < 3; k++)
            assert_true((&scene.origin_ws[0].x)[k] <= (&low.x)[k] + 0.02f * scene.span[0]);
        placement_update(&scene, kd_vec3_add(high, fixture_vec3(&random, 0, 3)), low, high);
        for (int k = 0; k < 3; k++)
            assert_true((&scene.origin_ws[0].x)[k] + edge >= (&high.x)[k] - 0.02f * scene.span[0]);
    }
}

static void staying_is_not_moving(void **state)
{
    (void)state;
    kd_voxel_scene scene = scene_of(128, 3, 0.02f);
    kd_vec3 far = {100, 100, 100}, near = {-100, -100, -100};
    placement_update(&scene, (kd_vec3){5, 0, 0}, near, far);
    assert_true(scene.moved);
    placement_update(&scene, (kd_vec3){5.001f, 0.001f, 0}, near, far);
    assert_false(scene.moved);
    placement_update(&scene, (kd_vec3){6, 0, 0}, near, far); /* further than a dense cell, 0.16 m */
    assert_true(scene.moved);
}

/* A box is in a cascade when some of its cells are owned by it, a margin of two cells aside. */
static void boxes_are_in_the_cascades_that_own_their_cells(void **state)
{
    (void)state;
    uint64_t random = 4;
    kd_voxel_scene scene = scene_of(128, 3, 0.02f);
    placement_update(&scene, (kd_vec3){1, 2, 3}, (kd_vec3){-90, -90, -90}, (kd_vec3){90, 90, 90});
    for (int i = 0; i < 4000; i++) {
        kd_vec3 size = fixture_vec3(&random, 0.01f, 1),
                at = kd_vec3_add((kd_vec3){1, 2, 3}, fixture_vec3(&random, -6, 6));
        for (uint32_t c = 0; c < scene.cascade_count; c++) {
            bool owned = false;
            for (int corner = 0; corner < 27; corner++) { /* corners, edges and faces sampled */
                int32_t cell[3];
                for (int k = 0; k < 3; k++) {
                    float share = 0.5f * (float)(corner / (k == 0 ? 1 : k == 1 ? 3 : 9) % 3);
                    float p = (&at.x)[k] + share * (&size.x)[k] - (&scene.origin_ws[c].x)[k];
                    cell[k] = (int32_t)floorf(p / scene.span[c]);
                }
                owned = owned || svo_owned(scene.resolution, c, cell);
            }
            if (owned)
                assert_true(placement_includes(&scene, c, at, kd_vec3_add(at, size)));
        }
    }
    kd_vec3 origin = scene.origin_ws[2];
    kd_vec3 away = {origin.x - 1, origin.y, origin.z}, inner = {1.1f, 2.1f, 3.1f};
    for (uint32_t c = 0; c < 3; c++) {
        assert_false(placement_includes(&scene, c, kd_vec3_sub(away, (kd_vec3){1, 1, 1}), away));
        assert_int_equal(placement_includes(&scene, c, (kd_vec3){1, 2, 3}, inner), c == 0);
    }
}

static void morton_codes_come_back(void **state)
{
    (void)state;
    uint64_t random = 6;
    assert_int_equal(svo_morton(1, 0, 0), 1);
    assert_int_equal(svo_morton(0, 1, 0), 2);
    assert_int_equal(svo_morton(0, 0, 1), 4);
    assert_int_equal(svo_morton(1023, 1023, 1023), 0x3FFFFFFF);
    for (int i = 0; i < 1000; i++) {
        uint32_t code = fixture_random(&random) & 0x3FFFFFFF, cell[3];
        svo_morton_cell(code, cell);
        assert_int_equal(svo_morton(cell[0], cell[1], cell[2]), code);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(cascades_nest_on_one_lattice),
        cmocka_unit_test(small_scene_is_held_whole_wherever_the_camera_is),
        cmocka_unit_test(ends_of_a_large_scene_are_held_by_the_finest_cascade),
        cmocka_unit_test(staying_is_not_moving),
        cmocka_unit_test(boxes_are_in_the_cascades_that_own_their_cells),
        cmocka_unit_test(morton_codes_come_back),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
