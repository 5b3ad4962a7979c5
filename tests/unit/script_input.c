/* What a scenario is told of keys and the mouse: in order, at the beginning of a step, and what is held. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "tests/script_fixture.h"

static kd_world *w;
static kd_script *script;

static void begin(const char *text)
{
    w = fixture_world();
    if (fixture_load(w, text, &script) != KD_OK)
        fail_msg("%s\ngave: %s", text, fixture_message);
}

static void end(void)
{
    kd_script_destroy(script);
    kd_world_destroy(w);
}

static void key(const char *name, bool down)
{
    kd_script_push_input(script, &(kd_script_input){.kind = KD_SCRIPT_ON_KEY, .name = name, .down = down});
}

static void input_is_told_in_order_at_the_next_step(void **state)
{
    (void)state;
    begin("local told = {}\n"
          "local function say(...) told[#told + 1] = table.concat({...}, ' ') end\n"
          "function kandil.on_key(k, down) say('key', k, tostring(down)) end\n"
          "function kandil.on_mouse(b, down, x, y) say('mouse', b, tostring(down), x, y) end\n"
          "function kandil.on_mouse_move(x, y) say('move', x, y) end\n"
          "function kandil.on_scroll(x, y) say('scroll', x, y) end\n"
          "function kandil.update() say('step', tostring(kandil.key('a'))) print(table.concat(told, '|')) "
          "end\n");
    assert_true(kd_script_listens(script, KD_SCRIPT_ON_KEY));
    key("a", true);
    kd_script_push_input(script, &(kd_script_input){KD_SCRIPT_ON_MOUSE, "left", true, 0.5f, 0.25f});
    kd_script_push_input(script, &(kd_script_input){KD_SCRIPT_ON_MOUSE_MOVE, NULL, false, 1, 0});
    kd_script_push_input(script, &(kd_script_input){KD_SCRIPT_ON_SCROLL, NULL, false, 0, -1});
    assert_int_equal(kd_script_step(script, 0, 0.1), KD_OK);
    key("a", false);
    assert_int_equal(kd_script_step(script, 0.1, 0.1), KD_OK);
    const char *expected = "key a true|mouse left true 0.5 0.25|move 1.0 0.0|scroll 0.0 -1.0|step true|"
                           "key a false|step false";
    if (!strstr(fixture_said, expected))
        fail_msg("said: %s", fixture_said);
    end();
}

static void more_than_fits_drops_the_oldest(void **state)
{
    static const char *const names[] = {"a", "b"};
    (void)state;
    begin("local n, last = 0\nfunction kandil.on_key(k) n, last = n + 1, k end\n"
          "function kandil.update() print('keys ' .. n .. ' ' .. last) end\n");
    for (int i = 0; i < 1000; i++)
        key(names[i % 2], true);
    assert_int_equal(kd_script_step(script, 0, 0.1), KD_OK);
    assert_non_null(strstr(fixture_said, "keys 256 b"));
    end();
}

static void a_callback_that_fails_ends_the_step_with_its_line(void **state)
{
    (void)state;
    begin("\nfunction kandil.on_key() error('no keys') end\n");
    key("a", true);
    assert_int_equal(kd_script_step(script, 0, 0.1), KD_SCRIPT);
    assert_non_null(strstr(fixture_message, ":2: no keys"));
    end();
}

static void only_functions_can_be_told(void **state)
{
    (void)state;
    w = fixture_world();
    assert_int_equal(fixture_load(w, "kandil.on_key = 3\n", &script), KD_SCRIPT);
    assert_non_null(strstr(fixture_message, "kandil.on_key must be a function, not a number"));
    assert_int_equal(fixture_load(w, "function kandil.on_kye() end\n", &script), KD_SCRIPT);
    assert_non_null(strstr(fixture_message, "did you mean kandil.on_key?"));
    kd_world_destroy(w);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(input_is_told_in_order_at_the_next_step),
        cmocka_unit_test(more_than_fits_drops_the_oldest),
        cmocka_unit_test(a_callback_that_fails_ends_the_step_with_its_line),
        cmocka_unit_test(only_functions_can_be_told),
    };
    return cmocka_run_group_tests(tests, fixture_open, fixture_close);
}
