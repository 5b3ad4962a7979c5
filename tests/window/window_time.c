/* Time held still, stepped and slowed; files written anew while the window is open; keys given to a scenario.
 */
#include "tests/window_fixture.h"

/* A plane that fills the picture, unlit, in one colour; what follows decides how it changes. */
#define WALL                                                                                                 \
    "kandil.scene { size = {480, 240}, fps = 30, gi = 'none', settings = { ['view.tonemap'] = 'linear' } "   \
    "}\n"                                                                                                    \
    "kandil.spawn { camera = {}, transform = { position = {0, 5, 0.01}, look_at = {0, 0, 0} } }\n"           \
    "local function wall(r, g, b, y)\n"                                                                      \
    "    return kandil.spawn { mesh = { shape = 'plane', size = 40 }, transform = { position = {0, y or 0, " \
    "0} },\n"                                                                                                \
    "        material = { base_color = {r, g, b}, unlit = true } }\n"                                        \
    "end\n"

static const area inside = {100, 120, 470, 230};
static picture seen, before;

static double mean(int channel)
{
    return picture_mean(&seen, inside, channel);
}

/* A blue lid moves in front of a red wall by the step: at even seconds it is away. */
static const char blinking[] =
    WALL "wall(0.5, 0, 0)\nlocal lid = wall(0, 0, 0.5, -1)\n"
         "function kandil.update(t)\n"
         "    lid.transform.position = {0, (t * 30) % 20 < 10 and -1 or 1, 0}\nend\n";

static void pause_holds_still_and_a_step_goes_on(void **state)
{
    (void)state;
    window_write("scene.lua", blinking);
    window_start("scene.lua");
    WINDOW_UNTIL(&seen, mean(0) > 80);
    WINDOW_UNTIL(&seen, mean(2) > 80); /* it runs */
    window_key(KEY_F1);
    window_key(' ');
    window_settle(&before);
    window_rest(1);
    window_see(&seen);
    assert_true(picture_difference(&seen, &before) == 0);
    for (int i = 0; i < 10; i++) /* ten steps later the other colour is seen */
        window_key('.');
    bool blue = picture_mean(&before, inside, 2) > 80;
    WINDOW_UNTIL(&seen, mean(blue ? 0 : 2) > 80);
    window_settle(&before);
    window_key(' ');
    WINDOW_UNTIL(&seen, mean(blue ? 2 : 0) > 80);
    assert_string_equal(window_finish(), "");
}

static void a_scenario_written_anew_is_shown_and_a_broken_one_is_not(void **state)
{
    (void)state;
    window_write("scene.lua", WALL "wall(0.5, 0, 0)\n");
    window_start("scene.lua");
    WINDOW_UNTIL(&seen, mean(0) > 80 && mean(1) < 20);
    window_write("scene.lua", WALL "wall(0, 0.5, 0)\n");
    WINDOW_UNTIL(&seen, mean(1) > 80 && mean(0) < 20);
    window_write("scene.lua", WALL "wall(0, 0,\n");
    for (double deadline = program_clock_s() + WINDOW_PATIENCE_S; !window_said("scene.lua:");
         window_rest(0.02))
        assert_true(program_clock_s() < deadline);
    window_see(&seen);
    static const area free_of_panels = {250, 30, 470, 100}; /* the message covers the rest */
    assert_true(picture_mean(&seen, free_of_panels, 1) > 80);
    window_write("scene.lua",
                 WALL "wall(0, 0, 0.5)\nfunction kandil.update(t) if t > 1 then error('late') end end\n");
    WINDOW_UNTIL(&seen, picture_mean(&seen, free_of_panels, 2) > 80);
    for (double deadline = program_clock_s() + WINDOW_PATIENCE_S; !window_said("late"); window_rest(0.02))
        assert_true(program_clock_s() < deadline);
    window_write("scene.lua", WALL "wall(0.5, 0, 0.5)\n"); /* a step that failed is mended */
    WINDOW_UNTIL(&seen, picture_mean(&seen, free_of_panels, 0) > 80);
    assert_non_null(strstr(window_finish(), "scene.lua:"));
}

static void a_scenario_is_told_of_keys_and_the_mouse(void **state)
{
    (void)state;
    window_write("scene.lua",
                 WALL "wall(0.5, 0, 0)\nlocal lid = wall(0, 0, 0.5, -1)\nlocal top = wall(0, 0.5, 0, -2)\n"
                      "function kandil.on_key(key, down)\n"
                      "    if key == 'space' and down then lid.transform.position = {0, 1, 0} end\nend\n"
                      "function kandil.on_mouse(button, down, x, y)\n"
                      "    if button == 'right' and down and x > 0.4 and x < 0.6 and y > 0.5 then\n"
                      "        top.transform.position = {0, 2, 0}\n    end\nend\n");
    window_start("scene.lua");
    WINDOW_UNTIL(&seen, mean(0) > 80);
    window_key(' ');
    WINDOW_UNTIL(&seen, mean(2) > 80);
    window_drag(3, 240, 160, 240, 160);
    WINDOW_UNTIL(&seen, mean(1) > 80);
    assert_string_equal(window_finish(), "");
}

static void the_next_scene_takes_the_place_of_the_first(void **state)
{
    (void)state;
    window_write("a.lua", WALL "wall(0.5, 0, 0)\n");
    window_write("b.lua", WALL "wall(0, 0.5, 0)\n");
    window_start("a.lua");
    WINDOW_UNTIL(&seen, mean(0) > 80);
    window_control(0xff56); /* Page Down */
    WINDOW_UNTIL(&seen, mean(1) > 80 && mean(0) < 20);
    window_control(0xff55);
    WINDOW_UNTIL(&seen, mean(0) > 80 && mean(1) < 20);
    assert_string_equal(window_finish(), "");
}

#define RESOLVE "shaders/resolve/resolve.comp"

static void a_shader_written_anew_is_used_and_a_broken_one_is_not(void **state)
{
    (void)state;
    assert_int_equal(system("cp -r '" KD_SOURCE_DIR "/shaders' ."), 0);
    assert_int_equal(setenv("KANDIL_SHADER_DIR", window_folder, 1), 0);
    window_write("scene.lua", WALL "wall(0.5, 0, 0)\n");
    window_start("scene.lua");
    WINDOW_UNTIL(&seen, mean(0) > 80);
    assert_int_equal(system("cp " RESOLVE " kept && echo 'this is no GLSL' >> kept && mv kept " RESOLVE), 0);
    for (double deadline = program_clock_s() + WINDOW_PATIENCE_S; !window_said("resolve.comp");
         window_rest(0.02))
        assert_true(program_clock_s() < deadline);
    static const area free_of_panels = {250, 30, 470, 100};
    window_see(&seen);
    assert_true(picture_mean(&seen, free_of_panels, 0) > 80);
    /* Mended, and black. */
    assert_int_equal(system("sed '/this is no GLSL/d; s/vec4(screen_view/0.0 * vec4(screen_view/' " RESOLVE
                            " > kept && mv kept " RESOLVE),
                     0);
    WINDOW_UNTIL(&seen, picture_mean(&seen, free_of_panels, 0) < 10);
    assert_int_equal(unsetenv("KANDIL_SHADER_DIR"), 0);
    (void)window_finish();
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        WINDOW_TEST(pause_holds_still_and_a_step_goes_on),
        WINDOW_TEST(a_scenario_written_anew_is_shown_and_a_broken_one_is_not),
        WINDOW_TEST(a_scenario_is_told_of_keys_and_the_mouse),
        WINDOW_TEST(the_next_scene_takes_the_place_of_the_first),
        WINDOW_TEST(a_shader_written_anew_is_used_and_a_broken_one_is_not),
    };
    return WINDOW_RUN(tests);
}
