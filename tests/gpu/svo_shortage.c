/* Too little room for the tree: cascades give levels up, the outermost first, and have them back. What every
 * tree of a scene has in common are its dense cells, so a hole shows as one that is missing. */

#include "tests/tree_fixture.h"

enum { CASCADES = 3, FINE = 256, COARSE = 128, LEVELS_BACK_AFTER = 65 };

/* A room that all cascades see, with things in it, one of which moves from the second frame on. */
static void look_from(voxel_world *v, kd_vec3 at)
{
    kd_find_mut(v->world, v->camera, kd_transform)->position = at;
}

static voxel_world open_room(uint32_t resolution, int32_t memory, kd_entity *walker)
{
    voxel_world v = voxel_open((voxel_options){
        .resolution = resolution, .cascades = CASCADES, .span = resolution == FINE ? 0.003f : 0.006f});
    v.frame->settings.svo_memory = memory;
    voxel_load(&v, "samples/assets/cornell.gltf", voxel_at(0, 0, 0));
    *walker = voxel_shape(&v, KD_SHAPE_SPHERE, (kd_vec3){0.5f, 0.5f, 0.5f}, NULL, voxel_at(0.1f, 1, 0.1f));
    look_from(&v, (kd_vec3){0, 1, 0.2f});
    return v;
}

static void move(voxel_world *v, kd_entity walker, float x)
{
    kd_find_mut(v->world, walker, kd_transform)->position.x = x;
    voxel_frame(v);
}

static uint32_t *dense_cells(voxel_world *v)
{
    const kd_svo *svo = voxel_svo(v);
    return voxel_read(svo->level_masks, svo->mask_first[0] * 4ul, svo->mask_words[0] * 4ul);
}

static uint32_t away(voxel_world *v)
{
    uint32_t n = 0;
    kd_gpu_read_buffer(voxel_gpu, voxel_svo(v)->counters, KD_COUNT_AWAY * 4, &n, sizeof n);
    return n;
}

static void assert_same_dense_cells(voxel_world *a, voxel_world *b)
{
    uint32_t *x = dense_cells(a), *y = dense_cells(b);
    assert_memory_equal(x, y, voxel_svo(a)->mask_words[0] * 4ul);
    assert_int_equal(away(a), 0);
    free(x);
    free(y);
}

/* Optical depth of all dense cells, in all directions. */
static double depth_of(voxel_world *v)
{
    const kd_svo *svo = voxel_svo(v);
    size_t words = (size_t)KD_DENSE * KD_DENSE * KD_ATLAS_SLICES(svo->cascades, 2);
    uint32_t *texels = malloc(words * 4);
    double sum = 0;
    assert_non_null(texels);
    kd_gpu_read_texture(voxel_gpu, svo->depths, 0, texels, words * 4);
    for (size_t i = 0; i < words; i++)
        for (int k = 0; k < 3; k++)
            sum += ldexp(texels[i] >> (9 * k) & 511, (int)(texels[i] >> 27) - 24);
    free(texels);
    return sum;
}

static void assert_outermost_first(const kd_svo *svo)
{
    for (uint32_t c = 1; c < CASCADES; c++)
        assert_true(kd_svo_given_up(svo->given_up, c) >= kd_svo_given_up(svo->given_up, c - 1));
    assert_true(kd_svo_given_up(svo->given_up, CASCADES - 1) > 0);
}

static void assert_said(const char *what)
{
    const char *first = strstr(voxel_warnings, what);
    if (!first || strstr(first + 1, what))
        fail_msg("not once: %s\n%s", what, voxel_warnings);
}

static void levels_are_given_up_and_nothing_is_missing(void **state)
{
    (void)state;
    kd_entity moves, other;
    voxel_world whole = open_room(FINE, 0, &moves);
    move(&whole, moves, 0.1f);
    double depth = depth_of(&whole);
    assert_int_equal(voxel_svo(&whole)->given_up, 0);
    voxel_world v = open_room(FINE, 2, &other);
    move(&v, other, 0.1f); /* in the very first frame */
    const kd_svo *svo = voxel_svo(&v);
    printf("levels given up %03x, depth %g of %g\n", svo->given_up, depth_of(&v), depth);
    assert_outermost_first(svo);
    assert_true(svo->most_bytes == 2 << 20);
    assert_same_dense_cells(&whole, &v);
    assert_in_range(100 * depth_of(&v) / depth, 95, 150); /* walls stay closed, edges are thicker */
    assert_said("are not enough");
    voxel_warnings[0] = '\0';
    voxel_close(&v);
    voxel_close(&whole);
}

/* Frames in which something has begun to move, and in which the camera goes on. */
static void nothing_is_missing_while_things_move(void **state)
{
    (void)state;
    kd_entity moves, other;
    voxel_world whole = open_room(FINE, 0, &moves), v = open_room(FINE, 2, &other);
    for (int i = 0; i < 4; i++) {
        look_from(&whole, (kd_vec3){0.2f * (float)i, 1, 0.2f});
        look_from(&v, (kd_vec3){0.2f * (float)i, 1, 0.2f});
        move(&whole, moves, 0.1f * (float)i);
        move(&v, other, 0.1f * (float)i);
        assert_outermost_first(voxel_svo(&v));
        assert_same_dense_cells(&whole, &v);
    }
    assert_said("are not enough");
    voxel_warnings[0] = '\0';
    voxel_close(&v);
    voxel_close(&whole);
}

/* With more memory all levels come back, at once; with less they go; the message stays alone. */
static void levels_come_back_with_room(void **state)
{
    (void)state;
    kd_entity moves, other;
    voxel_world whole = open_room(FINE, 0, &moves), v = open_room(FINE, 2, &other);
    voxel_frame(&whole);
    voxel_frame(&v);
    uint32_t given_up = voxel_svo(&v)->given_up;
    assert_outermost_first(voxel_svo(&v));
    v.frame->settings.svo_memory = 100;
    look_from(&whole, (kd_vec3){0.7f, 1.5f, -0.4f});
    look_from(&v, (kd_vec3){0.7f, 1.5f, -0.4f});
    voxel_frame(&whole);
    voxel_frame(&v); /* more room, and all is stale, in one frame */
    assert_int_equal(voxel_svo(&v)->given_up, 0);
    assert_same_dense_cells(&whole, &v);
    double depth = depth_of(&whole);
    assert_true(fabs(depth_of(&v) - depth) < 1e-9 * depth);
    v.frame->settings.svo_memory = 2;
    look_from(&whole, (kd_vec3){0, 1, 0.2f});
    look_from(&v, (kd_vec3){0, 1, 0.2f});
    voxel_frame(&whole);
    voxel_frame(&v);
    assert_int_equal(voxel_svo(&v)->given_up, given_up);
    assert_same_dense_cells(&whole, &v);
    assert_said("are not enough");
    voxel_warnings[0] = '\0';
    voxel_close(&v);
    voxel_close(&whole);
}

/* What took the room leaves: all levels come back, and stay. */
static void levels_come_back_when_things_leave(void **state)
{
    (void)state;
    kd_entity other;
    voxel_world v = open_room(FINE, 4, &other);
    kd_entity crowd[24];
    for (int i = 0; i < 24; i++)
        crowd[i] = voxel_shape(&v, KD_SHAPE_SPHERE, (kd_vec3){0.3f, 0.3f, 0.3f}, NULL,
                               voxel_at(-0.6f + 0.4f * (float)(i % 4), 0.3f + 0.3f * (float)(i / 4), -0.2f));
    voxel_frame(&v);
    uint32_t crowded = voxel_svo(&v)->given_up, changes = 0;
    for (int i = 0; i < 24; i++)
        kd_destroy(v.world, crowd[i]);
    for (uint32_t i = 0, before = crowded; i < 2 * LEVELS_BACK_AFTER + 8; i++) {
        voxel_frame(&v);
        changes += voxel_svo(&v)->given_up != before;
        before = voxel_svo(&v)->given_up;
    }
    printf("given up: %03x with the crowd, %03x without, %u changes\n", crowded, voxel_svo(&v)->given_up,
           changes);
    assert_true(crowded > voxel_svo(&v)->given_up);
    assert_in_range(changes, 1, 2);
    assert_said("are not enough");
    voxel_warnings[0] = '\0';
    voxel_close(&v);
}

/* All that is stale at first is 6 MiB of marks, and chains of some 400 000 voxels: with 4 MiB an array both
 * are done in rounds. */
static void tree_made_in_rounds_is_the_same(void **state)
{
    (void)state;
    kd_entity moves, other;
    voxel_world whole = open_room(FINE, 0, &moves), v = open_room(FINE, 4, &other);
    voxel_frame(&whole);
    voxel_frame(&v);
    assert_int_equal(voxel_svo(&v)->given_up, 0);
    assert_true(voxel_svo(&v)->fresh_words < 8 * voxel_scene(&v)->stale_patch_count);
    tree_copy a = tree_read(&whole), b = tree_read(&v);
    tree_assert_same(&a, &b, false);
    tree_free(&a);
    tree_free(&b);
    voxel_close(&v);
    voxel_close(&whole);
}

/* Where leaves lie right below the dense cells nothing can be given up: more memory is taken than allowed. */
static void the_coarsest_tree_has_its_room(void **state)
{
    (void)state;
    kd_entity moves, other;
    voxel_world whole = open_room(COARSE, 0, &moves), v = open_room(COARSE, 1, &other);
    move(&whole, moves, 0.1f);
    move(&v, other, 0.1f);
    assert_int_equal(voxel_svo(&v)->given_up, 0);
    assert_true(voxel_svo(&v)->most_bytes > 1 << 20);
    assert_same_dense_cells(&whole, &v);
    assert_said("svo.memory=1 is too little");
    voxel_warnings[0] = '\0';
    voxel_close(&v);
    voxel_close(&whole);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(levels_are_given_up_and_nothing_is_missing),
        cmocka_unit_test(nothing_is_missing_while_things_move),
        cmocka_unit_test(levels_come_back_with_room),
        cmocka_unit_test(levels_come_back_when_things_leave),
        cmocka_unit_test(tree_made_in_rounds_is_the_same),
        cmocka_unit_test(the_coarsest_tree_has_its_room),
    };
    return cmocka_run_group_tests(tests, voxel_group_setup, voxel_group_teardown);
}
