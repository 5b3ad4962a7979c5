/* Local lights by tile of the picture against all of them everywhere: the same bytes. */

#include "tests/render_fixture.h"

#include "shaders/shared/scene.h"

static void add_hall(render *r)
{
    const kd_material_desc grey = render_matte(0.7f);
    r->frame->width = 96;
    r->frame->height = 64;
    render_shape(r, KD_SHAPE_BOX, (kd_vec3){10, 0.2f, 10}, &grey, (kd_vec3){0, -1, 0}, RENDER_UPRIGHT,
                 RENDER_UNIT);
    for (int i = 0; i < 4; i++)
        render_shape(r, KD_SHAPE_SPHERE, RENDER_UNIT, &grey, (kd_vec3){1.5f * (float)i - 2.2f, 0, (float)i},
                     RENDER_UPRIGHT, RENDER_UNIT);
}

static kd_entity add_lamp(render *r, kd_vec3 position, float range)
{
    return render_light(
        r,
        (kd_light){
            .type = KD_POINT, .color = {1, 0.8f, 0.5f}, .intensity = 1, .range = range, .no_shadow = true},
        position, (kd_vec3){0, -1, 0});
}

/* The lights of a grid over the floor, from `first` on. */
static void add_grid(render *r, int first, int count, float range)
{
    for (int i = first; i < first + count; i++)
        add_lamp(
            r,
            (kd_vec3){0.55f * (float)(i % 16) - 4.1f, 0.1f * (float)(i % 7), 0.55f * (float)(i / 16) - 4.1f},
            range);
}

/* Returns how many of the picture's pixels show light. */
static size_t expect_same(render *r, const char *name)
{
    size_t values = (size_t)r->frame->width * r->frame->height * 4, lit = 0;
    r->frame->settings.light_tiles = KD_TILES_OFF;
    render_frame(r, name);
    float *plain = malloc(values * sizeof *plain);
    assert_non_null(plain);
    memcpy(plain, r->hdr, values * sizeof *plain);
    for (int32_t tiles = KD_TILES_AUTO; tiles <= KD_TILES_ON; tiles++) {
        r->frame->settings.light_tiles = tiles;
        render_frame(r, name);
        for (size_t i = 0; i < values; i++)
            if (r->hdr[i] != plain[i])
                fail_msg("%s, %s: value %zu is %g instead of %g", name, tiles == KD_TILES_ON ? "on" : "auto",
                         i, (double)r->hdr[i], (double)plain[i]);
    }
    for (size_t i = 0; i < values; i += 4)
        lit += plain[i] > 0.001f;
    free(plain);
    return lit;
}

static void ranges_end_inside_tiles(void **state)
{
    render *r = *state;
    add_hall(r);
    render_camera(r, (kd_vec3){0, 1.5f, 6}, (kd_vec3){0, -0.5f, 0}, 0.9f);
    assert_int_equal(expect_same(r, "no lamp"), 0);
    add_lamp(r, (kd_vec3){0, 0, 2}, 0.7f);
    assert_true(expect_same(r, "one lamp") > 0);
    add_grid(r, 0, 60, 0.7f);
    size_t some = expect_same(r, "some lamps");
    add_grid(r, 60, 140, 0.7f);
    assert_true(expect_same(r, "many lamps") > some);
    r->frame->width = 83; /* tiles that the picture's edges cut */
    r->frame->height = 61;
    expect_same(r, "cut tiles");
    r->frame->width = 7; /* fewer pixels than a tile */
    r->frame->height = 100;
    expect_same(r, "narrow");
}

static void camera_stands_in_lamps(void **state)
{
    render *r = *state;
    add_hall(r);
    render_camera(r, (kd_vec3){0, 1.5f, 6}, (kd_vec3){0, -0.5f, 0}, 0.9f);
    add_lamp(r, (kd_vec3){0, 1.4f, 6.1f}, 5); /* around the camera */
    add_lamp(r, (kd_vec3){0, 1.5f, 11}, 9);   /* behind it, reaching what it sees */
    add_lamp(r, (kd_vec3){0, 1.5f, 14}, 2);   /* behind it, reaching nothing */
    add_lamp(r, (kd_vec3){0, 40, 0}, 41.5f);  /* far above */
    add_lamp(r, (kd_vec3){2, 0.5f, 2}, 0);    /* without an end */
    add_lamp(r, (kd_vec3){-3, -0.9f, 1}, 1e-6f);
    render_light(r,
                 (kd_light){.type = KD_SPOT,
                            .color = {1, 1, 1},
                            .intensity = 9,
                            .range = 3,
                            .inner_cone = 0.2f,
                            .outer_cone = 0.5f},
                 (kd_vec3){-1, 1.5f, 2}, (kd_vec3){0, -1, 0});
    render_light(r, (kd_light){.type = KD_DIRECTIONAL, .color = {1, 1, 1}, .intensity = 0.3f},
                 (kd_vec3){0, 9, 0}, (kd_vec3){0.3f, -1, -0.2f});
    assert_true(expect_same(r, "perspective") > 1000);
    r->frame->settings.light_ambient = 0.2f;
    assert_true(expect_same(r, "before a sky") == (size_t)r->frame->width * r->frame->height);
}

static void top_camera_and_blended(void **state)
{
    render *r = *state;
    add_hall(r);
    kd_material_desc glass = render_matte(0.5f);
    glass.alpha_mode = KD_ALPHA_BLEND;
    glass.base_color.w = 0.5f;
    render_shape(r, KD_SHAPE_BOX, RENDER_UNIT, &glass, (kd_vec3){4.8f, 0, 0}, RENDER_UPRIGHT, RENDER_UNIT);
    render_top_camera(r, 6);
    add_grid(r, 0, 40, 2.5f);
    assert_true(expect_same(r, "from above") > 1000);
}

/* All that are taken, and more: every word of a tile's marks is full. */
static void as_many_as_there_may_be(void **state)
{
    render *r = *state;
    add_hall(r);
    render_camera(r, (kd_vec3){0, 1.5f, 6}, (kd_vec3){0, -0.5f, 0}, 0.9f);
    add_grid(r, 0, KD_MAX_LIGHTS, 1.3f);
    assert_true(expect_same(r, "every light") > 500);
    r->frame->view = KD_VIEW_LIGHT;
    expect_same(r, "light alone");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        RENDER_TEST(ranges_end_inside_tiles),
        RENDER_TEST(camera_stands_in_lamps),
        RENDER_TEST(top_camera_and_blended),
        RENDER_TEST(as_many_as_there_may_be),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
