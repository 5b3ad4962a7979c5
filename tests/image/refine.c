/* Cones are traced at twice the spacing where light is smooth. That must not be seen: edges, contacts and
 * small things have cones of their own. */
#include "tests/image_fixture.h"

/* Boxes and thin posts on a floor in a lit room: smooth walls, contact shadows, silhouettes. */
static const char room[] =
    "kandil.scene { size = {192, 108} }\n"
    "local function box(size, position, color)\n"
    "    kandil.spawn { mesh = { shape = 'box', size = size }, transform = { position = position },\n"
    "                   material = { base_color = color } }\n"
    "end\n"
    "box({2.4, 0.2, 2.2}, {0, -0.1, 0}, {0.7, 0.7, 0.7})\n"
    "box({2.4, 1.8, 0.2}, {0, 0.9, -1}, {0.7, 0.7, 0.7})\n"
    "box({0.2, 1.8, 2}, {-1.1, 0.9, 0}, {0.7, 0.06, 0.05})\n"
    "box({0.4, 0.6, 0.4}, {-0.3, 0.3, -0.3}, {0.7, 0.7, 0.7})\n"
    "for i = 0, 5 do box({0.03, 0.5, 0.03}, {0.1 + 0.12 * i, 0.25, 0.2}, {0.2, 0.3, 0.8}) end\n"
    "kandil.spawn { light = { type = 'directional', intensity = 3 }, transform = { rotation_deg = {-40, 30, "
    "0} } }\n"
    "kandil.spawn { camera = { fov_y_deg = 40 }, transform = { position = {0, 0.95, 3.4} } }\n";

static image render(const char *refine, const char *output)
{
    image_render(image_scenario("refine.lua", room), "--frames", "1", "--view", "indirect", "--set", refine,
                 "--out", image_path(output));
    return image_read(output);
}

static void smooth_places_alone_are_interpolated(void **state)
{
    (void)state;
    image all = render("cones.refine=0", "all.png"), some = render("cones.refine=0.2", "some.png");
    image_error e = image_difference(all, some);
    assert_true(e.max > 0); /* something was interpolated */
    assert_double_below(e.mean, 0.004);
    assert_double_below(e.p99, 0.05);
    image_free(&all);
    image_free(&some);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(smooth_places_alone_are_interpolated)};
    return cmocka_run_group_tests(tests, image_setup, image_teardown);
}
