/* Ways to look, ways to hold time still, and values changed by hand, in a scene that stands still. */
#include "tests/window_fixture.h"

static const char scene[] =
    "kandil.scene { size = {480, 240}, gi = 'none', ambient = 0.05 }\n"
    "kandil.spawn { mesh = { shape = 'box', size = 1 }, material = { base_color = {0.9, 0.2, 0.1} },\n"
    "               transform = { position = {0, 0.5, 0} } }\n"
    "kandil.spawn { mesh = { shape = 'plane', size = {8, 1, 8} } }\n"
    "kandil.spawn { name = 'lamp', light = { type = 'directional', intensity = 2 },\n"
    "               transform = { look_at = {-0.4, -1, -0.5} } }\n"
    "kandil.spawn { camera = { fov_y_deg = 50 }, transform = { position = {2, 1.5, 3}, look_at = {0, 0.5, 0} "
    "} }\n";

static picture before, seen;

/* Start, with no panel over the picture. */
static void start_still(void)
{
    window_write("scene.lua", scene);
    window_start("scene.lua");
    WINDOW_UNTIL(&seen, picture_mean(&seen, whole, 3) > 20);
    window_key(KEY_F1);
    window_settle(&before);
}

static void orbit_turns_the_view_and_the_fixed_camera_comes_back(void **state)
{
    (void)state;
    start_still();
    window_drag(1, 240, 150, 300, 150); /* nothing may be turned yet */
    window_settle(&seen);
    assert_true(picture_difference(&seen, &before) == 0);
    window_key(KEY_F2);
    window_settle(&seen);
    assert_true(picture_difference(&seen, &before) < 1); /* the same view, by its own means */
    window_drag(1, 240, 150, 340, 150);
    WINDOW_UNTIL(&seen, picture_difference(&seen, &before) > 3);
    window_settle(&seen);
    /* The point of interest stays: the box, seen from elsewhere, is still in the middle. */
    const uint8_t *middle = seen.rgb[120 * WINDOW_WIDTH + 240];
    assert_true(middle[0] > 2 * middle[2]);
    static picture turned;
    turned = seen;
    x.button(x.display, 4, 1, 0); /* the wheel: nearer */
    x.button(x.display, 4, 0, 0);
    x.sync(x.display, 0);
    WINDOW_UNTIL(&seen, picture_difference(&seen, &turned) > 0.5);
    window_key(KEY_KP_2);
    WINDOW_UNTIL(&seen, picture_difference(&seen, &before) == 0);
    assert_string_equal(window_finish(), "");
}

static void keys_walk_while_they_are_held(void **state)
{
    (void)state;
    start_still();
    window_key(KEY_F2);
    window_key(KEY_F2);
    window_settle(&before);
    window_hold('s', true);
    WINDOW_UNTIL(&seen, picture_difference(&seen, &before) > 3);
    window_hold('s', false);
    window_settle(&before);
    window_rest(0.3);
    window_see(&seen);
    assert_true(picture_difference(&seen, &before) == 0);
    assert_string_equal(window_finish(), "");
}

/* Find the first row of widgets: opaque boxes of one colour. Returns the middle of the `number`-th. */
static bool find_box(const picture *p, int column, int number, int *row)
{
    int boxes = 0, inside = 0;
    for (int y = 40; y < WINDOW_HEIGHT; y++) {
        const uint8_t *rgb = p->rgb[y * WINDOW_WIDTH + column];
        bool is_box = abs(rgb[0] - 51) < 8 && abs(rgb[1] - 64) < 8 && abs(rgb[2] - 84) < 8;
        inside = is_box ? inside + 1 : 0;
        boxes += inside == 10;
        if (inside == 10 && boxes == number) {
            *row = y - 3;
            return true;
        }
    }
    return false;
}

static void editing_a_lamp_changes_the_picture(void **state)
{
    static const area picture_area = {4, 140, 170, 236}; /* the panel covers the rest */
    int row = 0;
    (void)state;
    start_still();
    window_key(KEY_F1);
    window_key(' '); /* panels count frames */
    window_control('1');
    window_control('3');
    window_move(100, 180); /* a box under the pointer has another colour */
    /* The first whose right end is a box: the intensity; a colour ends in its own patch. */
    WINDOW_UNTIL(&before, find_box(&before, 318, 1, &row));
    window_settle(&before);
    assert_true(find_box(&before, 318, 1, &row));
    double bright = picture_mean(&before, picture_area, 3);
    window_drag(1, 250, row, 190, row);
    WINDOW_UNTIL(&seen, picture_mean(&seen, picture_area, 3) < bright - 5);
    window_settle(&seen);
    double dark = picture_mean(&seen, picture_area, 3);
    window_drag(1, 250, row, 470, row);
    WINDOW_UNTIL(&seen, picture_mean(&seen, picture_area, 3) > dark + 5);
    assert_string_equal(window_finish(), "");
}

static void a_new_size_is_filled_and_a_screenshot_has_it(void **state)
{
    x_id root, parent, *children = NULL;
    unsigned count = 0;
    (void)state;
    start_still();
    assert_true(x.tree(x.display, x.root(x.display), &root, &parent, &children, &count) != 0);
    assert_true(count >= 1);
    x.resize(x.display, children[count - 1], 240, 180);
    x.sync(x.display, 0);
    x.destroy(children);
    /* The box is in the middle of the new window, where the floor was of the old one. */
    window_move(100, 100);
    static const area middle = {116, 90, 124, 98}, outside = {260, 30, 470, 230};
    WINDOW_UNTIL(&seen, picture_mean(&seen, middle, 0) > 2 * picture_mean(&seen, middle, 2) &&
                            picture_mean(&seen, outside, 3) == 0);
    window_key(KEY_F12);
    for (double deadline = program_clock_s() + WINDOW_PATIENCE_S; !window_said("wrote scene_");
         window_rest(0.02))
        assert_true(program_clock_s() < deadline);
    const char *said = window_finish();
    char path[64] = "";
    assert_int_equal(sscanf(strstr(said, "wrote "), "wrote %63s", path), 1);
    uint8_t head[24] = {0};
    FILE *file = fopen(path, "rb");
    assert_non_null(file);
    assert_int_equal(fread(head, 1, sizeof head, file), sizeof head);
    fclose(file);
    assert_memory_equal(head, "\x89PNG", 4);
    assert_int_equal(head[18] << 8 | head[19], 240); /* width and height of the IHDR chunk */
    assert_int_equal(head[22] << 8 | head[23], 180);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        WINDOW_TEST(orbit_turns_the_view_and_the_fixed_camera_comes_back),
        WINDOW_TEST(keys_walk_while_they_are_held),
        WINDOW_TEST(editing_a_lamp_changes_the_picture),
        WINDOW_TEST(a_new_size_is_filled_and_a_screenshot_has_it),
    };
    return WINDOW_RUN(tests);
}
