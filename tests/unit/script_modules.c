/* What a scenario takes from elsewhere: require, and parameters of the command line. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "tests/script_fixture.h"

static void expect(const char *text, kd_status status, const char *says)
{
    kd_world *w = fixture_world();
    kd_script *script;
    kd_status got = fixture_load(w, text, &script);
    if (got != status || (says && !strstr(fixture_message, says)) ||
        (status && !strstr(fixture_message, "; ")))
        fail_msg("%s\ngave status %d: %s", text, (int)got, fixture_message);
    kd_script_destroy(script);
    kd_world_destroy(w);
}

static void write_text(const char *name, const char *text)
{
    fixture_write(name, text, strlen(text));
}

static void make_folder(const char *name)
{
    char path[128];
    snprintf(path, sizeof path, "%s/%s", fixture_folder, name);
    assert_true(mkdir(path, 0700) == 0 || access(path, X_OK) == 0);
}

static void modules_are_run_once(void **state)
{
    (void)state;
    make_folder("parts");
    write_text("parts/walls.lua",
               "count = (count or 0) + 1 local m = {} function m.height() return 3 end return m");
    write_text("plain.lua", "local w = require 'parts.walls' seen = w.height()");
    expect("local a, b = require 'parts.walls', require('parts/walls.lua') assert(a == b and a.height() == 3 "
           "and count == 1)\n"
           "assert(require 'plain' == true and seen == 3 and count == 1)",
           KD_OK, NULL);
}

static void mistakes_in_modules_name_their_file(void **state)
{
    (void)state;
    make_folder("parts");
    write_text("parts/bad.lua", "local x = 1\nlocal y = = 2");
    write_text("parts/fails.lua", "local m = {}\nfunction m.f()\n  return nothing.here\nend\nreturn m");
    write_text("a.lua", "require 'b'");
    write_text("b.lua", "require 'a'");
    write_text("endless.lua", "while true do end");
    write_text("binary.lua", "\27Lua");
    expect("require 'parts.bad'", KD_SCRIPT, "/parts/bad.lua:2: unexpected symbol");
    expect("require('parts.fails').f()", KD_SCRIPT, "/parts/fails.lua:3: attempt to index");
    expect("\nrequire 'missing'", KD_SCRIPT, "scene.lua:2: missing.lua: not found");
    expect("require 'a'", KD_SCRIPT, "/b.lua:1: require: 'a.lua' needs itself");
    expect("require 'endless'", KD_SCRIPT, "/endless.lua:1: ran for too long");
    expect("require 'binary'", KD_SCRIPT, "binary.lua");
    expect("kandil.run(function() kandil.wait() end) require('parts.fails').f()", KD_SCRIPT,
           "/parts/fails.lua:3:");
}

static void modules_lie_below_the_scenario(void **state)
{
    (void)state;
    char path[128];
    snprintf(path, sizeof path, "%s/link.lua", fixture_folder);
    assert_int_equal(symlink("/etc/passwd", path), 0);
    expect("require '/etc/passwd'", KD_SCRIPT, "outside the scenario's folder");
    expect("require '../../etc/passwd'", KD_SCRIPT, "outside the scenario's folder");
    expect("require 'link'", KD_SCRIPT, "outside the scenario's folder");
    expect("require ''", KD_SCRIPT, "no module name");
    expect("require(('x'):rep(5000))", KD_SCRIPT, "too long");
    expect("require '..'", KD_SCRIPT, "scene.lua");
}

static void parameters_come_from_the_command_line(void **state)
{
    (void)state;
    static const char *const given[] = {"count=7", "wide=on", "label=red=hot", "count=8", "share=0.5"};
    fixture_params = given;
    fixture_param_count = 5;
    expect("assert(kandil.param('count', 3) == 8 and kandil.param('wide', false) == true)\n"
           "assert(kandil.param('label', 'x') == 'red=hot' and kandil.param('share', 1.0) == 0.5)\n"
           "assert(kandil.param('other', 5) == 5)",
           KD_OK, NULL);
    expect("kandil.param('wide', false) kandil.param('label', 'x') kandil.param('share', 1) "
           "kandil.param('counts', 5)",
           KD_SCRIPT, "whole number");
    expect("kandil.param('wide', false) kandil.param('label', 'x') kandil.param('share', 1.0) "
           "kandil.param('counts', 5)",
           KD_USAGE, "no such parameter; did you mean 'counts'?");
    expect("kandil.param('label', 5)", KD_SCRIPT, "must be a number");
    expect("kandil.param('label', true)", KD_SCRIPT, "on or off");
    expect("kandil.param('count')", KD_SCRIPT, "the default must be");
    fixture_params = NULL;
    fixture_param_count = 0;
    expect("assert(kandil.param('count', 3) == 3)", KD_OK, NULL);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(modules_are_run_once),
        cmocka_unit_test(mistakes_in_modules_name_their_file),
        cmocka_unit_test(modules_lie_below_the_scenario),
        cmocka_unit_test(parameters_come_from_the_command_line),
    };
    return cmocka_run_group_tests(tests, fixture_open, fixture_close);
}
