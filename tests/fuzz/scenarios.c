/* Broken scenarios and command lines: every truncated length and thousands of mutations end in success or one
 * message. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "runtime/app/options.h"
#include "tests/script_fixture.h"

static const char seed_scene[] =
    "kandil.scene { size = {640, 360}, fps = 24, seconds = 4, settings = { voxels = { span = 0.05 } } }\n"
    "local e = kandil.spawn { name = 'a', mesh = { shape = 'box', size = {1, 2, 3} }, material = { "
    "base_color = {1, 0, 0} } }\n"
    "kandil.spawn { parent = e, light = { type = 'spot', outer_cone_deg = 40 }, transform = { look_at = "
    "{0.3, -1, 0} } }\n"
    "kandil.at(0.5, function() e:play('walk', { blend = 0.2 }) end)\n"
    "for i = 1, 3 do e.transform.position = {i, 0, ('x'):rep(i):find('x*') } end\n"
    "function kandil.update(t, dt) e:set('transform.rotation_deg', {0, t * 90, 0}) end\n";

static uint64_t random_state = 1;

static uint32_t next_random(void)
{
    random_state ^= random_state << 13;
    random_state ^= random_state >> 7;
    random_state ^= random_state << 17;
    return (uint32_t)(random_state >> 32);
}

static void run(const char *text)
{
    kd_world *w = fixture_world();
    kd_script *script;
    kd_status status = fixture_load(w, text, &script);
    for (int i = 0; i < 3 && status == KD_OK; i++)
        status = kd_script_step(script, i * 0.5, 0.5);
    if ((status == KD_OK) != (fixture_errors == 0) || fixture_errors > 1)
        fail_msg("status %d with %d messages (%s) from:\n%s", (int)status, fixture_errors, fixture_message,
                 text);
    kd_script_destroy(script);
    kd_world_destroy(w);
}

static void truncated_scenarios_end_well(void **state)
{
    (void)state;
    for (size_t length = 0; length < sizeof seed_scene; length++) {
        char *text =
            strndup(seed_scene, length); /* its own block, so that a sanitizer sees every byte beyond */
        assert_non_null(text);
        run(text);
        free(text);
    }
}

static void mutated_scenarios_end_well(void **state)
{
    (void)state;
    static const char alphabet[] = "(){}[]=,.:'\"-+*/%^#<>~ \n\tabcdeftilnrsoux0123456789";
    for (int round = 0; round < 1500; round++) {
        char text[sizeof seed_scene];
        memcpy(text, seed_scene, sizeof text);
        for (uint32_t i = 0; i < 1 + next_random() % 6; i++)
            text[next_random() % (sizeof text - 1)] = alphabet[next_random() % (sizeof alphabet - 1)];
        run(text);
    }
}

static void mutated_command_lines_end_well(void **state)
{
    (void)state;
    static const char *const pieces[] = {
        "run",     "info",       "help",   "a.lua",     "--frames",   "--size",
        "--out",   "x_%04d.png", "%n%s%d", "640x360",   "-1",         "99999999999999999999",
        "",        "--",         "-",      "=",         "--set",      "voxels.span=1",
        "a.b.c=d", "--view",     "ao",     "--fps=nan", "--threads=", "--out=%.png",
        "--level", "\xff\xfe",   "--quiet"};
    for (int round = 0; round < 20000; round++) {
        char *argv[12] = {(char *)"kandil"};
        int argc = 1 + (int)(next_random() % 11);
        for (int i = 1; i < argc; i++)
            argv[i] = (char *)(uintptr_t)pieces[next_random() % (sizeof pieces / sizeof *pieces)];
        app_options options;
        fixture_errors = 0;
        kd_status status = app_options_parse(argc, argv, &options);
        if ((status == KD_OK) != (fixture_errors == 0) || fixture_errors > 1)
            fail_msg("status %d with %d messages, last: %s", (int)status, fixture_errors, fixture_message);
        if (status == KD_OK)
            app_options_fini(&options);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(truncated_scenarios_end_well),
        cmocka_unit_test(mutated_scenarios_end_well),
        cmocka_unit_test(mutated_command_lines_end_well),
    };
    return cmocka_run_group_tests(tests, fixture_open, fixture_close);
}
