/* A moving box: its bounce and its occlusion are where it is now, and nothing is left where it was. A run in
 * which the box has moved is compared with one in which it has always stood there. */

#include "tests/image_fixture.h"

/* The box stands at x = -0.6 in frames 0 to 2 and at `x` = 0.6 from frame 3 on, or at `x` from the start. */
static const char scene[] =
    "kandil.scene { size = {96, 54}, fps = 10 }\n"
    "kandil.spawn { mesh = { shape = 'box', size = {3, 0.2, 2} }, transform = { position = {0, -0.1, 0} },\n"
    "               material = { base_color = {0.8, 0.8, 0.8} } }\n"
    "kandil.spawn { mesh = { shape = 'box', size = {3, 1.5, 0.2} }, transform = { position = {0, 0.75, -1.1} "
    "},\n"
    "               material = { base_color = {0.8, 0.8, 0.8} } }\n"
    "local box = kandil.spawn { mesh = { shape = 'box', size = 0.5 }, material = { base_color = {0.9, 0.05, "
    "0.05} },\n"
    "                           transform = { position = {%g, %g, -0.2} } }\n"
    "kandil.spawn { light = { type = 'spot', intensity = 12, outer_cone_deg = 70 },\n"
    "               transform = { position = {0, 2, 1}, look_at = {0, 0, -0.2} } }\n"
    "kandil.spawn { camera = { fov_y_deg = 40 }, transform = { position = {0, 1.4, 3}, look_at = {0, 0.4, 0} "
    "} }\n"
    "function kandil.update(t, dt)\n"
    "    if t > 0.25 then box.transform.position = {%g, %g, -0.2} end\n"
    "end\n";

static image render(const char *output, double height, double from, double to, const char *frames,
                    const char *view)
{
    image_render(image_scenario("box.lua", scene, from, height, to, height), "--frames", frames, "--set",
                 "light.bounces=1", "--view", view, "--out", image_path(output));
    return image_read(output);
}

/* Light of one bounce knows nothing of earlier frames, so the pictures must be equal. What is left is a half
 * float's last bit here and there: the voxels of things that move and things that stand are summed in another
 * order. Radiance here is below 2, where halfs are 1/1024 apart. */
static void compare_at(double height, const char *view, double most, double mean)
{
    image moved = render("moved.exr", height, -0.6, 0.6, "4", view);
    image fresh = render("fresh.exr", height, 0.6, 0.6, "1", view);
    image before = render("before.exr", height, -0.6, -0.6, "1", view);
    image_error same = image_difference(moved, fresh), other = image_difference(moved, before);
    assert_double_below(same.max, most);
    assert_double_below(same.mean, mean);
    assert_double_above(other.p99, 0.05); /* and the view does show the box */
    image_free(&moved);
    image_free(&fresh);
    image_free(&before);
}

/* Where the box stands on the floor cells hold both. Of what moves and what stands each is packed first:
 * whether a cell is thin is then known from less than the sums of all its voxels. */
static void compare(const char *view)
{
    compare_at(0.4, view, 1.5 / 1024, 1e-5);
    compare_at(0.25, view, 0.01, 0.001);
}

static void bounce_is_where_the_box_is_now(void **state)
{
    (void)state;
    compare("indirect");
}

static void occlusion_is_where_the_box_is_now(void **state)
{
    (void)state;
    compare("ao");
}

static void picture_is_of_the_box_now(void **state)
{
    (void)state;
    compare("final");
}

/* The floor's redness left and right of the middle, where the box's two places are. */
static void bounce_follows_the_box(void **state)
{
    (void)state;
    image left = render("left.exr", 0.25, -0.6, -0.6, "1", "indirect"),
          right = render("right.exr", 0.25, -0.6, 0.6, "4", "indirect");
    image pictures[2] = {left, right};
    double red[2][2];
    for (int i = 0; i < 2; i++)
        for (uint32_t side = 0; side < 2; side++)
            red[i][side] = image_mean(pictures[i], 0, 48 * side, 36, 48 * side + 48, 46) -
                           image_mean(pictures[i], 1, 48 * side, 36, 48 * side + 48, 46);
    assert_double_above(red[0][0], 2 * red[0][1]);
    assert_double_above(red[1][1], 2 * red[1][0]);
    image_free(&left);
    image_free(&right);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(bounce_is_where_the_box_is_now),
        cmocka_unit_test(occlusion_is_where_the_box_is_now),
        cmocka_unit_test(picture_is_of_the_box_now),
        cmocka_unit_test(bounce_follows_the_box),
    };
    return cmocka_run_group_tests(tests, image_setup, image_teardown);
}
