/* What comes from outside of the window: files of a model written anew, the focus that goes, a window that is
 * put away, a screen with small pixels. */
#include "tests/window_fixture.h"

static const area free_of_panels = {250, 30, 470, 100};
static picture seen, before;

/* A triangle far larger than the picture, unlit; its colour is that of a picture beside it. */
static const char model[] =
    "{\"asset\":{\"version\":\"2.0\"},\"nodes\":[{\"mesh\":0}],\"extensionsUsed\":[\"KHR_materials_unlit\"],"
    "\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0},\"material\":0}]}],"
    "\"materials\":[{\"extensions\":{\"KHR_materials_unlit\":{}},"
    "\"pbrMetallicRoughness\":{\"baseColorFactor\":[%s,1]}}],"
    "\"accessors\":[{\"bufferView\":0,\"componentType\":5126,\"count\":3,\"type\":\"VEC3\"}],"
    "\"bufferViews\":[{\"buffer\":0,\"byteLength\":36}],\"buffers\":[{\"uri\":\"wall.bin\",\"byteLength\":36}"
    "]}";

/* The corners of the triangle, of this size, in the plane z = 0. */
static void write_corners(float size)
{
    const float corners[9] = {-size, -size, 0, size, -size, 0, 0, size, 0};
    FILE *file = fopen("part", "wb");
    assert_non_null(file);
    assert_int_equal(fwrite(corners, sizeof corners, 1, file), 1);
    assert_int_equal(fclose(file), 0);
    assert_int_equal(rename("part", "wall.bin"), 0);
}

static void write_model(const char *color)
{
    char text[1024];
    snprintf(text, sizeof text, model, color);
    window_write("wall.gltf", text);
}

static const char scene[] =
    "kandil.scene { size = {480, 240}, gi = 'none' }\nkandil.log('made anew')\n"
    "kandil.spawn { camera = {}, transform = { position = {0, 0, 3}, look_at = {0, 0, 0} } }\n"
    "kandil.spawn { model = 'wall.gltf' }\n";

static int times_made(void)
{
    return window_times_said("made anew");
}

static double mean(int channel)
{
    return picture_mean(&seen, free_of_panels, channel);
}

static void start_wall(void)
{
    write_corners(100);
    write_model("1,0,0");
    window_write("scene.lua", scene);
    window_start("scene.lua");
    WINDOW_UNTIL(&seen, mean(0) > 80 && mean(1) < 20);
}

static void a_model_written_anew_is_shown_and_what_lies_beside_it_is_not_read(void **state)
{
    (void)state;
    start_wall();
    write_model("0,1,0");
    WINDOW_UNTIL(&seen, mean(1) > 80 && mean(0) < 20);
    assert_int_equal(times_made(), 2);
    window_write("beside.png", "a picture that no model names");
    window_write("other.gltf", "{}");
    window_rest(1);
    assert_int_equal(times_made(), 2);
    write_corners(0.01f); /* a file that the model does name */
    WINDOW_UNTIL(&seen, mean(1) < 20);
    assert_int_equal(times_made(), 3);
    (void)window_finish();
}

static x_id program_window(void)
{
    x_id root, parent, *children = NULL;
    unsigned count = 0;
    assert_true(x.tree(x.display, x.root(x.display), &root, &parent, &children, &count) != 0);
    assert_true(count >= 1);
    x_id window = children[count - 1];
    x.destroy(children);
    return window;
}

/* Whoever holds a key and goes to another window lets it go there: the walk ends. */
static void a_key_is_let_go_with_the_focus(void **state)
{
    enum { POINTER_ROOT = 1 };
    (void)state;
    window_write("scene.lua",
                 "kandil.scene { size = {480, 240}, gi = 'none', ambient = 1 }\n"
                 "kandil.spawn { mesh = { shape = 'box' }, material = { base_color = {1, 0, 0} } }\n"
                 "kandil.spawn { camera = {}, transform = { position = {0, 0, 2}, look_at = {0, 0, 0} } }\n");
    window_start("scene.lua");
    WINDOW_UNTIL(&seen, picture_mean(&seen, whole, 0) > 20);
    window_key(KEY_F1);
    window_key(KEY_F2);
    window_key(KEY_F2);
    x.focus(x.display, program_window(), POINTER_ROOT, 0);
    window_settle(&before);
    window_hold('s', true);
    WINDOW_UNTIL(&seen, picture_difference(&seen, &before) > 1);
    x.focus(x.display, x.root(x.display), POINTER_ROOT, 0);
    x.sync(x.display, 0);
    window_settle(&seen);                             /* never comes while the walk goes on */
    assert_true(picture_mean(&seen, whole, 0) > 0.2); /* and the box is still in sight */
    window_hold('s', false);
    x.focus(x.display, POINTER_ROOT, POINTER_ROOT, 0);
    assert_string_equal(window_finish(), "");
}

static void a_window_that_was_away_shows_what_happened_meanwhile(void **state)
{
    (void)state;
    start_wall();
    x_id window = program_window();
    x.unmap(x.display, window);
    WINDOW_UNTIL(&seen, picture_mean(&seen, whole, 3) == 0);
    write_model("0,1,0");
    window_rest(0.5);
    x.map(x.display, window);
    WINDOW_UNTIL(&seen, mean(1) > 80 && mean(0) < 20);
    (void)window_finish();
}

/* Pixels of the lower half that panels cover: those that are not the wall's red. */
static int covered(const picture *p)
{
    int count = 0;
    for (int i = 0; i < WINDOW_PIXELS; i++)
        count += p->rgb[i][0] < 200 || p->rgb[i][1] > 60;
    return count;
}

/* A screen of 192 dots an inch asks for letters of twice the size. */
static void panels_follow_the_scale_of_the_screen(void **state)
{
    enum { RESOURCE_MANAGER = 23, STRING = 31, REPLACE = 0 };
    static const unsigned char resources[] = "Xft.dpi:\t192\n";
    (void)state;
    start_wall();
    window_key(' ');
    window_settle(&before);
    (void)window_finish();
    x.change_property(x.display, x.root(x.display), RESOURCE_MANAGER, STRING, 8, REPLACE, resources,
                      (int)sizeof resources - 1);
    x.sync(x.display, 0);
    window_start("scene.lua");
    WINDOW_UNTIL(&seen, picture_mean(&seen, whole, 0) > 20);
    window_key(' ');
    window_settle(&seen);
    (void)window_finish();
    x.change_property(x.display, x.root(x.display), RESOURCE_MANAGER, STRING, 8, REPLACE, resources, 0);
    x.sync(x.display, 0);
    assert_true(covered(&before) > 1000);
    assert_true(covered(&seen) > covered(&before) * 3 / 2);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        WINDOW_TEST(a_model_written_anew_is_shown_and_what_lies_beside_it_is_not_read),
        WINDOW_TEST(a_key_is_let_go_with_the_focus),
        WINDOW_TEST(a_window_that_was_away_shows_what_happened_meanwhile),
        WINDOW_TEST(panels_follow_the_scale_of_the_screen),
    };
    return WINDOW_RUN(tests);
}
