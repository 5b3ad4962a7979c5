/* Surfaces that let through what is behind them: they add their own light by their opacity, whatever the
 * order in which they were made. */

#include "tests/render_fixture.h"

static kd_material_desc glass(kd_vec3 color, float opacity)
{
    kd_material_desc m = kd_material_default();
    m.base_color = (kd_vec4){color.x, color.y, color.z, opacity};
    m.alpha_mode = KD_ALPHA_BLEND;
    m.unlit = true;
    return m;
}

static kd_material_desc lamp(float radiance)
{
    kd_material_desc m = kd_material_default();
    m.base_color = (kd_vec4){0, 0, 0, 1};
    m.metallic = 1; /* reflects nothing: black metal */
    m.emissive = (kd_vec3){radiance, radiance, radiance};
    return m;
}

static void add_plane(render *r, const kd_material_desc *m, float size, kd_vec3 position)
{
    render_shape(r, KD_SHAPE_PLANE, (kd_vec3){size, 1, size}, m, position, RENDER_UPRIGHT, RENDER_UNIT);
}

/* Half of a glass of 0.8 and half of what is behind: 0.4 + 0.5 over a radiance of 1, 0.4 over black and over
 * nothing. The pane lies over both halves of the floor and beyond its rear edge. */
static void half_a_pane_over_white_and_black(void **state)
{
    render *r = *state;
    kd_material_desc pane = glass((kd_vec3){0.8f, 0.8f, 0.8f}, 0.5f), white = lamp(1), black = lamp(0);
    add_plane(r, &pane, 2, (kd_vec3){0, 1, 0});
    add_plane(r, &white, 1, (kd_vec3){-0.5f, 0, 0.3f});
    add_plane(r, &black, 1, (kd_vec3){0.5f, 0, 0.3f});
    render_top_camera(r, 1.2f); /* a pixel is 2 cm; the middle is 80, 60 */
    render_frame(r, "pane");
    render_expect(r, 60, 70, (kd_vec3){0.9f, 0.9f, 0.9f}, 0.002f);
    render_expect(r, 100, 70, (kd_vec3){0.4f, 0.4f, 0.4f}, 0.002f);
    render_expect(r, 80, 20, (kd_vec3){0.4f, 0.4f, 0.4f}, 0.002f);
    render_expect(r, 2, 2, (kd_vec3){0, 0, 0}, 0.002f); /* beside everything */
}

/* 255 times 0.9, encoded as sRGB: the picture on the screen holds the pane as well. */
static void the_screen_shows_panes(void **state)
{
    render *r = *state;
    kd_material_desc pane = glass((kd_vec3){0.8f, 0.8f, 0.8f}, 0.5f), white = lamp(1);
    add_plane(r, &pane, 1, (kd_vec3){0, 1, 0});
    add_plane(r, &white, 1, (kd_vec3){0, 0, 0});
    render_top_camera(r, 1.2f);
    render_frame(r, "screen");
    assert_in_range(r->ldr[(60 * 160 + 80) * 4], 242, 244); /* 0.9 encodes to 243.4 */
}

/* Window glass of n = 1.5 reflects 4 % head-on; of the rest it lets its colour through, and a second pane of
 * that again. What the pane is lit by is black, so that nothing else is seen. */
static void tinted_panes_let_their_colour_through(void **state)
{
    render *r = *state;
    kd_material_desc pane = kd_material_default(), white = lamp(1);
    pane.base_color = (kd_vec4){0.5f, 0.8f, 1, 0}; /* the alpha of what is opaque says nothing */
    pane.metallic = 0;
    pane.transmission = 1;
    pane.alpha_mode = KD_ALPHA_BLEND;
    pane.alpha_ignored = true;
    r->frame->gi = KD_GI_NONE;
    add_plane(r, &white, 1, (kd_vec3){0, 0, 0});
    add_plane(r, &pane, 1, (kd_vec3){0.5f, 0.5f, 0});
    add_plane(r, &pane, 1, (kd_vec3){0.5f, 1, 0.5f});
    render_top_camera(r, 1.2f);
    render_frame(r, "tint");
    render_expect(r, 62, 60, (kd_vec3){1, 1, 1}, 0.002f);
    render_expect(r, 95, 45, (kd_vec3){0.48f, 0.768f, 0.96f}, 0.004f);
    render_expect(r, 95, 70, (kd_vec3){0.48f * 0.48f, 0.768f * 0.768f, 0.96f * 0.96f}, 0.004f);
}

static void what_is_in_front_hides_panes(void **state)
{
    render *r = *state;
    kd_material_desc pane = glass((kd_vec3){0.8f, 0, 0}, 0.5f), white = lamp(1);
    add_plane(r, &pane, 2, (kd_vec3){0, 0, 0});
    add_plane(r, &white, 1, (kd_vec3){0, 1, 0});
    render_top_camera(r, 1.2f);
    render_frame(r, "hidden");
    render_expect(r, 80, 60, (kd_vec3){1, 1, 1}, 0.002f);
    render_expect(r, 45, 60, (kd_vec3){0.4f, 0, 0}, 0.002f);
}

/* Red above green above blue, half opaque each, over white: 0.5 of red, 0.25 of green, 0.125 of blue and as
 * much of white; made in all six orders, on two planes of one mesh's size and of another, the bytes are the
 * same. */
static void panes_blend_the_same_in_any_order(void **state)
{
    static const int orders[6][3] = {{0, 1, 2}, {0, 2, 1}, {1, 0, 2}, {1, 2, 0}, {2, 0, 1}, {2, 1, 0}};
    static const kd_vec3 colors[3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    float *first = NULL;
    size_t bytes = 0;
    (void)state;
    for (int o = 0; o < 6; o++) {
        render *r;
        render_setup((void **)&r);
        kd_material_desc white = lamp(1);
        add_plane(r, &white, 2, (kd_vec3){0, 0, 0});
        for (int i = 0; i < 3; i++) {
            int which = orders[o][i];
            kd_material_desc m = glass(colors[which], 0.5f);
            add_plane(r, &m, which == 1 ? 1.3f : 1.0f, (kd_vec3){0, 3.0f - (float)which, 0});
        }
        render_top_camera(r, 1.2f);
        render_frame(r, "order");
        render_expect(r, 80, 60, (kd_vec3){0.625f, 0.375f, 0.25f}, 0.002f);
        if (first == NULL) {
            bytes = (size_t)r->frame->width * r->frame->height * 4 * sizeof *first;
            first = malloc(bytes);
            assert_non_null(first);
            memcpy(first, r->hdr, bytes);
        }
        if (memcmp(first, r->hdr, bytes) != 0)
            fail_msg("order %d gives another picture", o);
        render_teardown((void **)&r);
    }
    free(first);
}

/* A pane takes light as other surfaces do: with an opacity of a quarter it shows a quarter of what the same
 * surface sends back when it is opaque, and its shadow side shows none. */
static void panes_are_lit(void **state)
{
    render *r = *state;
    kd_material_desc m = render_matte(0.6f);
    kd_entity opaque = render_shape(r, KD_SHAPE_PLANE, (kd_vec3){1, 1, 1}, &m, (kd_vec3){-0.6f, 0, 0},
                                    RENDER_UPRIGHT, RENDER_UNIT);
    m.alpha_mode = KD_ALPHA_BLEND;
    m.base_color.w = 0.25f;
    add_plane(r, &m, 1, (kd_vec3){0.6f, 0, 0});
    render_light(r, (kd_light){.type = KD_DIRECTIONAL, .color = {1, 0.5f, 0.25f}, .intensity = 3},
                 (kd_vec3){0, 5, 0}, (kd_vec3){0.2f, -1, 0});
    render_light(r, (kd_light){.type = KD_POINT, .color = {1, 1, 1}, .intensity = 2}, (kd_vec3){0, 2, 0},
                 (kd_vec3){0, -1, 0});
    render_top_camera(r, 1.2f);
    render_frame(r, "lit");
    const float *full = render_pixel(r, 50, 60), *part = render_pixel(r, 110, 60);
    assert_true(full[0] > 0.5f);
    assert_float_equal(part[1], full[1] / 4, 0.02f * full[1]);
    kd_entity lid = render_shape(r, KD_SHAPE_PLANE, (kd_vec3){9, 1, 9}, &m, (kd_vec3){0, 30, 0},
                                 RENDER_UPRIGHT, RENDER_UNIT);
    render_frame(r, "lid");
    assert_true(render_pixel(r, 50, 60)[0] > 0.5f); /* a pane of a quarter casts no shadow */
    kd_destroy(r->world, lid);
    kd_destroy(r->world, opaque);
}

/* Seen through the open bottom of a double-sided box: its rear wall comes before its front. */
static void both_sides_of_a_pane_are_seen(void **state)
{
    render *r = *state;
    kd_material_desc m = glass((kd_vec3){1, 1, 1}, 0.5f);
    m.double_sided = true;
    render_shape(r, KD_SHAPE_BOX, (kd_vec3){1, 1, 1}, &m, (kd_vec3){0, 0, 0}, RENDER_UPRIGHT, RENDER_UNIT);
    render_top_camera(r, 1.2f);
    render_frame(r, "both");
    render_expect(r, 80, 60, (kd_vec3){0.75f, 0.75f, 0.75f}, 0.002f);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        RENDER_TEST(half_a_pane_over_white_and_black),
        RENDER_TEST(the_screen_shows_panes),
        RENDER_TEST(what_is_in_front_hides_panes),
        RENDER_TEST(tinted_panes_let_their_colour_through),
        cmocka_unit_test(panes_blend_the_same_in_any_order),
        RENDER_TEST(panes_are_lit),
        RENDER_TEST(both_sides_of_a_pane_are_seen),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
