/* Two layers are a matter of cost alone: what is shown is the same with one. */

#include "tests/voxel_fixture.h"

typedef struct show {
    voxel_world v;
    kd_entity ball;
} show;

/* A room with something still and turned, something that starts to move, and something that walks. */
static show open_show(bool one_layer, uint32_t cascades)
{
    show s = {.v =
                  voxel_open((voxel_options){.cascades = cascades, .span = 0.0121f, .one_layer = one_layer})};
    kd_transform turned = {{-0.413f, 0.21f, 0.1f}, {0.36f, 0.48f, 0, 0.8f}, {1, 1, 1}};
    voxel_shape(&s.v, KD_SHAPE_BOX, (kd_vec3){0.3f, 0.4f, 0.2f}, NULL, turned);
    voxel_shape(&s.v, KD_SHAPE_PLANE, (kd_vec3){2.31f, 0, 1.9f}, NULL, voxel_at(0.011f, -0.007f, 0.003f));
    voxel_shape(&s.v, KD_SHAPE_BOX, (kd_vec3){0.05f, 1.5f, 0.05f}, NULL,
                voxel_at(-0.9f, 0.75f, -0.8f)); /* the highest */
    s.ball = voxel_shape(&s.v, KD_SHAPE_SPHERE, (kd_vec3){0.3f, 0.3f, 0.3f}, NULL, voxel_at(0.3f, 0.4f, 0));
    voxel_load(&s.v, "samples/assets/walker.gltf",
               (kd_transform){{0, 0, -0.3f}, {0, 0, 0, 1}, {0.5f, 0.5f, 0.5f}});
    return s;
}

static void assert_same_masks(voxel_world *a, voxel_world *b, const char *what)
{
    uint32_t words = voxel_svo(a)->layer_words, *x = voxel_read_union(a), *y = voxel_read_union(b),
             differ = 0;
    assert_int_equal(words, voxel_svo(b)->layer_words);
    for (uint32_t i = 0; i < words; i++)
        for (uint32_t w = x[i] ^ y[i]; w; w &= w - 1)
            differ++;
    assert_true(voxel_count_bits(x, words) > 500);
    if (differ)
        fail_msg("%s: %u of %u cells differ", what, differ, voxel_count_bits(x, words));
    free(x);
    free(y);
}

static void one_layer_shows_the_same_as_two(void **state)
{
    (void)state;
    show one = open_show(true, 2), two = open_show(false, 2);
    for (int i = 0; i < 4; i++) {
        if (i >= 2) /* the ball rests at first */
            kd_find_mut(one.v.world, one.ball, kd_transform)->position.x =
                kd_find_mut(two.v.world, two.ball, kd_transform)->position.x -= 0.0317f;
        voxel_frame(&one.v);
        voxel_frame(&two.v);
        assert_same_masks(&one.v, &two.v, i < 2 ? "at rest" : "moving");
        assert_int_equal(voxel_scene(&one.v)->pages[KD_LAYER_STATIC].segment_count, 0);
        assert_true(voxel_scene(&two.v)->pages[KD_LAYER_STATIC].segment_count > 0);
    }
    voxel_close(&one.v);
    voxel_close(&two.v);
}

static void static_layer_is_rebuilt_only_when_it_must(void **state)
{
    (void)state;
    show s = open_show(false, 2);
    voxel_frame(&s.v);
    assert_true(voxel_scene(&s.v)->static_changed);
    for (int i = 0; i < 3; i++) { /* the walker walks */
        voxel_frame(&s.v);
        assert_false(voxel_scene(&s.v)->static_changed);
    }
    uint32_t words = voxel_svo(&s.v)->layer_words, *before = voxel_read_mask(&s.v, KD_LAYER_STATIC);
    kd_find_mut(s.v.world, s.ball, kd_transform)->position.y += 0.02f;
    voxel_frame(&s.v);
    assert_true(voxel_scene(&s.v)->static_changed);
    kd_find_mut(s.v.world, s.ball, kd_transform)->position.y += 0.02f;
    voxel_frame(&s.v);
    assert_false(voxel_scene(&s.v)->static_changed); /* dynamic for good */
    uint32_t *after = voxel_read_mask(&s.v, KD_LAYER_STATIC);
    assert_true(voxel_count_bits(after, words) < voxel_count_bits(before, words));
    free(before);
    free(after);
    voxel_close(&s.v);
}

/* Far to the side something small makes the scene larger than the finest cascade, which then follows the
 * camera. */
static show open_wide_show(void)
{
    show s = open_show(false, 2);
    voxel_shape(&s.v, KD_SHAPE_BOX, (kd_vec3){0.1f, 0.1f, 0.1f}, NULL, voxel_at(6, 0, 0));
    return s;
}

static void layers_follow_the_cascades(void **state)
{
    (void)state;
    show wanders = open_wide_show(), fresh = open_wide_show();
    float places[] = {0.2f, 2.5f, 5.5f, 0.4f};
    for (int i = 0; i < 4; i++) {
        kd_find_mut(wanders.v.world, wanders.v.camera, kd_transform)->position.x = places[i];
        voxel_frame(&wanders.v);
        assert_true(voxel_scene(&wanders.v)->moved);
        assert_true(voxel_scene(&wanders.v)->static_changed);
    }
    kd_find_mut(fresh.v.world, fresh.v.camera, kd_transform)->position.x = places[3];
    for (int i = 0; i < 4; i++) /* the walker has made as many steps */
        voxel_frame(&fresh.v);
    assert_same_masks(&wanders.v, &fresh.v, "after wandering");
    voxel_close(&wanders.v);
    voxel_close(&fresh.v);
}

/* By whole cells, so that a fresh run cuts the ball into the same voxels. */
static void what_starts_to_move_leaves_no_ghost(void **state)
{
    (void)state;
    show moves = open_show(false, 1), fresh = open_show(false, 1);
    kd_vec3 by = {-16 * 0.0121f, 8 * 0.0121f, 4 * 0.0121f};
    voxel_frame(&moves.v);
    kd_transform *t = kd_find_mut(moves.v.world, moves.ball, kd_transform);
    t->position = kd_vec3_add(t->position, by);
    voxel_frame(&moves.v);
    t = kd_find_mut(fresh.v.world, fresh.ball, kd_transform);
    t->position = kd_vec3_add(t->position, by);
    voxel_frame(&fresh.v);
    voxel_frame(&fresh.v); /* the walker's second step */
    assert_same_masks(&moves.v, &fresh.v, "after the first move");
    voxel_close(&moves.v);
    voxel_close(&fresh.v);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(one_layer_shows_the_same_as_two),
        cmocka_unit_test(static_layer_is_rebuilt_only_when_it_must),
        cmocka_unit_test(layers_follow_the_cascades),
        cmocka_unit_test(what_starts_to_move_leaves_no_ghost),
    };
    return VOXEL_GROUP(tests);
}
