/* Where walls meet, neither shades the other though the filter's texels reach over the edge; where a box
 * stands on the floor, no light creeps in below it; where light grazes a wall, shadows end where they should.
 */

#include "tests/render_fixture.h"

static const kd_light lamps[] = {
    {.type = KD_DIRECTIONAL, .color = {1, 1, 1}, .intensity = 3},
    {.type = KD_SPOT, .color = {1, 1, 1}, .intensity = 20, .inner_cone = 0.8f, .outer_cone = 0.9f},
    {.type = KD_POINT, .color = {1, 1, 1}, .intensity = 20},
};

static void add_box(render *r, kd_vec3 size, kd_vec3 position)
{
    kd_material_desc m = render_matte(0.8f);
    render_shape(r, KD_SHAPE_BOX, size, &m, position, RENDER_UPRIGHT, RENDER_UNIT);
}

static float *read_red(const render *r)
{
    size_t pixels = (size_t)r->frame->width * r->frame->height;
    float *red = malloc(pixels * sizeof *red);
    assert_non_null(red);
    for (size_t i = 0; i < pixels; i++)
        red[i] = r->hdr[i * 4];
    return red;
}

/* A floor and two walls that meet at (-1, 0, -1), all lit: next to none of the pixels may lose a twentieth of
 * its light. Without the lift towards the light 300 to 700 do. */
static void concave_corners_stay_lit(void **state)
{
    render *r = *state;
    r->frame->width = 640;
    r->frame->height = 360;
    add_box(r, (kd_vec3){4, 0.2f, 4}, (kd_vec3){0, -0.1f, 0});
    add_box(r, (kd_vec3){4, 4, 0.2f}, (kd_vec3){0, 2, -1.1f});
    add_box(r, (kd_vec3){0.2f, 4, 4}, (kd_vec3){-1.1f, 2, 0});
    render_camera(r, (kd_vec3){1, 1.2f, 2}, (kd_vec3){-0.9f, 0.5f, -0.9f}, 0.7f);
    for (int i = 0; i < 3; i++) {
        kd_entity light = render_light(r, lamps[i], (kd_vec3){-0.1f, 1.7f, 0.25f},
                                       i == 0 ? (kd_vec3){-1, -1, -0.8f} : (kd_vec3){-0.1f, -1.7f, -0.25f});
        kd_find_mut(r->world, light, kd_light)->no_shadow = true;
        render_frame(r, "corner_lit");
        float *lit = read_red(r);
        kd_find_mut(r->world, light, kd_light)->no_shadow = false;
        render_frame(r, "corner");
        int dark = 0, seen = 0;
        for (int p = 0; p < 640 * 360; p++) {
            seen += lit[p] > 0.2f;
            dark += lit[p] > 0.2f && !(r->hdr[p * 4] > lit[p] * 0.95f);
        }
        free(lit);
        kd_destroy(r->world, light);
        if (seen < 50000 || dark > 60)
            fail_msg("light %d: %d of %d pixels are dark", i, dark, seen);
    }
}

/* The floor right behind a box of 10 cm lies in its shadow, though the lift of some texels, a few millimetres
 * each, starts there from inside the box's foot. */
static void no_light_creeps_in_below_a_box(void **state)
{
    render *r = *state;
    add_box(r, (kd_vec3){4, 0.2f, 4}, (kd_vec3){0, -0.1f, 0});
    add_box(r, (kd_vec3){1, 0.1f, 1}, (kd_vec3){0, 0.05f, 0});
    render_top_camera(r, 0.6f); /* a pixel is 1 cm; the middle row crosses the edge x = 0.5 at pixel 130 */
    for (int i = 0; i < 3; i++) {
        kd_entity light = render_light(r, lamps[i], (kd_vec3){-1.5f, 0.9f, 0}, (kd_vec3){1, -0.5f, 0});
        render_frame(r, "foot");
        float brightest = 0;
        for (uint32_t x = 131; x < 140; x++)
            brightest = fmaxf(brightest, render_pixel(r, x, 60)[0]);
        float top = render_pixel(r, 100, 60)[0];
        kd_destroy(r->world, light);
        if (top < 0.2f || brightest > 0.01f * top)
            fail_msg("light %d: %g behind a box whose top has %g", i, (double)brightest, (double)top);
    }
}

/* A ledge of 30 cm on a wall, in a sun that falls five times as steeply as it comes forward: its lower edge,
 * at a height of 3 m, ends the shadow at 1.5 m. A texel is 1.5 cm wide there and so 7.5 cm high on the wall;
 * the filter reaches one to both sides. A lift along the normal by two texels would end the shadow 15 cm
 * higher. */
static void a_grazed_wall_is_shaded_down_to_where_the_ledge_says(void **state)
{
    render *r = *state;
    add_box(r, (kd_vec3){60, 0.2f, 60}, (kd_vec3){0, -0.1f, 0});
    add_box(r, (kd_vec3){6, 6, 1}, (kd_vec3){0, 3, -0.5f});
    add_box(r, (kd_vec3){4, 0.1f, 0.3f}, (kd_vec3){0, 3.05f, 0.15f});
    r->frame->settings.light_shadow_size = 1024;
    render_camera(r, (kd_vec3){0, 1.8f, 6}, (kd_vec3){0, 1.8f, 0},
                  0.5f); /* 6 * tan 0.25 = 1.53 m up and down */
    render_light(r, lamps[0], (kd_vec3){0, 5, 0}, (kd_vec3){0, -1, -0.2f});
    render_frame(r, "graze");
    for (uint32_t x = 20; x < 140; x += 4)
        for (uint32_t y = 0; y < 120; y++) {
            float height = 1.8f + 1.532f * (1 - 2 * ((float)y + 0.5f) / 120), red = render_pixel(r, x, y)[0];
            if (height > 1.6f && height < 2.9f && red > 0.005f)
                fail_msg("%g m: light of %g in the shadow", (double)height, (double)red);
            if (height > 0.5f && height < 1.4f && red < 0.1f)
                fail_msg("%g m: %g below the shadow", (double)height, (double)red);
        }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        RENDER_TEST(concave_corners_stay_lit),
        RENDER_TEST(no_light_creeps_in_below_a_box),
        RENDER_TEST(a_grazed_wall_is_shaded_down_to_where_the_ledge_says),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
