/* A scenario that is written anew fills the world that is on: its picture has to be that of a fresh start. */
#include "tests/window_fixture.h"

static const area inside = {260, 20, 470, 230};
static picture seen, fresh;

/* A box between a white floor and a coloured wall, whose colour the floor shows by its bounced light. */
static const char room[] =
    "kandil.scene { size = {480, 240}, settings = { ['voxels.resolution'] = 128, ['voxels.cascades'] = 1,\n"
    "               ['cones.resolution'] = 4 } }\n"
    "kandil.log('made anew')\n"
    "kandil.spawn { mesh = { shape = 'plane', size = 4 } }\n"
    "kandil.spawn { mesh = { shape = 'box', size = {4, 2, 0.2} }, material = { base_color = {%s} },\n"
    "               transform = { position = {0, 1, -0.5} } }\n"
    "kandil.spawn { name = 'thing', mesh = { shape = 'box', size = 0.4 } }\n"
    "kandil.spawn { light = { type = 'point', intensity = 6 }, transform = { position = {0.5, 1.5, 1} } }\n"
    "kandil.spawn { camera = {}, transform = { position = {0, 1.2, 3}, look_at = {0, 0.4, 0} } }\n"
    "kandil.at(0, function() kandil.find('thing').transform.position = {%s, 0.2, 0} end)\n";

static void write_room(const char *color, const char *place)
{
    char text[2048];
    snprintf(text, sizeof text, room, color, place);
    window_write("scene.lua", text);
}

static void wait_for_times(int count)
{
    double deadline = program_clock_s() + WINDOW_PATIENCE_S;
    while (window_times_said("made anew") < count) {
        assert_true(program_clock_s() < deadline);
        window_rest(0.02);
    }
}

static double mean(int channel)
{
    return picture_mean(&seen, inside, channel);
}

static void start_paused(void)
{
    window_start("scene.lua");
    WINDOW_UNTIL(&seen, mean(0) + mean(1) > 30);
    window_key(KEY_F1);
    window_key(' ');
}

static void a_world_filled_anew_shows_what_a_fresh_start_shows(void **state)
{
    (void)state;
    write_room("0.1, 0.7, 0.1", "0.6");
    start_paused();
    for (int i = 0; i < 40; i++) /* light that is reflected again and again has settled then */
        window_key('.');
    window_settle(&fresh);
    assert_string_equal(window_finish(), "kandil: scene.lua: made anew\n");

    write_room("0.7, 0.1, 0.1", "-0.6");
    start_paused();
    window_settle(&seen);
    assert_true(picture_difference(&seen, &fresh) > 5);
    write_room("0.1, 0.7, 0.1", "0.6");
    WINDOW_UNTIL(&seen, mean(1) > mean(0) * 1.5);
    window_settle(&seen);
    assert_true(picture_difference(&seen, &fresh) < 0.2); /* light settles to a step of 8 bits */
    assert_string_equal(window_finish(), "kandil: scene.lua: made anew\nkandil: scene.lua: made anew\n");
}

/* More often than one world is filled: it is exchanged on the way. Each time the messages come once. */
static void a_scenario_may_be_written_often(void **state)
{
    (void)state;
    write_room("0.7, 0.1, 0.1", "0.6");
    start_paused();
    for (int i = 1; i <= 20; i++) {
        write_room(i % 2 ? "0.1, 0.7, 0.1" : "0.7, 0.1, 0.1", "0.6");
        wait_for_times(i + 1);
        assert_int_equal(window_times_said("made anew"), i + 1);
    }
    WINDOW_UNTIL(&seen, mean(0) > mean(1) * 1.5);
    window_write("scene.lua", "kandil.spawn { mesh = 'none' }\n");
    for (double deadline = program_clock_s() + WINDOW_PATIENCE_S; !window_said("mesh"); window_rest(0.02))
        assert_true(program_clock_s() < deadline);
    window_settle(&fresh); /* what was on stays */
    assert_true(picture_mean(&fresh, inside, 0) > picture_mean(&fresh, inside, 1) * 1.5);
    (void)window_finish();
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        WINDOW_TEST(a_world_filled_anew_shows_what_a_fresh_start_shows),
        WINDOW_TEST(a_scenario_may_be_written_often),
    };
    return WINDOW_RUN(tests);
}
