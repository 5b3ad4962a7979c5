/* The command line: what is accepted, and the one message for what is not. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

#include "components/frame.h"
#include "runtime/app/options.h"
#include "runtime/core/log.h"

#define MAX_ARGUMENTS 64

static char last_message[1024];
static int message_count;

static void remember(void *user, kd_log_level level, const char *text)
{
    (void)user;
    (void)level;
    strncpy(last_message, text, sizeof last_message - 1);
    message_count++;
}

/* Parse a line split at blanks. The words live as long as the next call. */
static kd_status parse(const char *line, app_options *out)
{
    static char words[1024];
    char *argv[MAX_ARGUMENTS] = {(char *)"kandil"};
    int argc = 1;
    strcpy(words, line);
    for (char *word = strtok(words, " "); word; word = strtok(NULL, " "))
        argv[argc++] = word;
    message_count = 0;
    last_message[0] = '\0';
    return app_options_parse(argc, argv, out);
}

static void options_are_read_when_right(void **state)
{
    (void)state;
    app_options o;
    assert_int_equal(parse("run a.lua --frames 8 --seconds=2.5 --fps 24 --size 641x16384 --seed 7 --threads "
                           "2 --gi none --view ao "
                           "--level 3 --out x.png --out y_%04d.exr --out z.mp4 --set voxels.span=0.05 "
                           "--quiet --context osmesa",
                           &o),
                     KD_OK);
    assert_int_equal(o.command, APP_RUN);
    assert_string_equal(o.subject, "a.lua");
    assert_int_equal(o.frames, 8);
    assert_true(o.seconds == 2.5 && o.fps == 24);
    assert_int_equal(o.width, 641);
    assert_int_equal(o.height, 16384);
    assert_int_equal(o.seed, 7);
    assert_int_equal(o.threads, 2);
    assert_int_equal(o.gi, KD_GI_NONE);
    assert_int_equal(o.view, KD_VIEW_AO);
    assert_int_equal(o.context, KD_CONTEXT_OSMESA);
    assert_int_equal(o.output_count, 3);
    assert_true(!o.outputs[0].every_frame && o.outputs[1].every_frame && o.outputs[2].every_frame);
    assert_int_equal(o.outputs[2].kind, APP_OUTPUT_FILM);
    assert_int_equal(o.set_count, 2);
    assert_string_equal(o.sets[0], "view.level=3");
    assert_true(o.quiet);
    assert_int_equal(message_count, 0);
    app_options_fini(&o);
}

static void nothing_said_is_told_apart(void **state)
{
    (void)state;
    app_options o;
    assert_int_equal(parse("run a.glb", &o), KD_OK);
    assert_true(o.frames == -1 && o.seconds < 0 && o.fps == 0 && o.width == 0 && o.gi == -1 && o.view == -1);
    app_options_fini(&o);
    assert_int_equal(parse("run -- --odd.glb", &o), KD_OK);
    assert_string_equal(o.subject, "--odd.glb");
    app_options_fini(&o);
}

static void bench_takes_its_own_options(void **state)
{
    (void)state;
    app_options o;
    assert_int_equal(parse("bench", &o), KD_OK);
    assert_int_equal(o.command, APP_BENCH);
    assert_true(o.bench == APP_BENCH_ALL && o.bench_n == 0 && !o.bench_case && !o.json);
    app_options_fini(&o);
    assert_int_equal(parse("bench jobs --json rows.json --threads 2 --n 100 --case dag", &o), KD_OK);
    assert_true(o.bench == APP_BENCH_JOBS && o.bench_n == 100 && o.threads == 2);
    assert_string_equal(o.bench_case, "dag");
    assert_string_equal(o.json, "rows.json");
    app_options_fini(&o);
    assert_int_equal(parse("bench voxels hall.lua --frames 3 --model man.glb --set voxels.span=1", &o),
                     KD_OK);
    assert_true(o.bench == APP_BENCH_VOXELS && o.frames == 3 && o.set_count == 1 && !o.dump);
    assert_string_equal(o.second, "hall.lua");
    assert_string_equal(o.bench_model, "man.glb");
    app_options_fini(&o);
    assert_int_equal(parse("bench svo --dump folder", &o), KD_OK);
    assert_true(o.bench == APP_BENCH_SVO && !o.second);
    assert_string_equal(o.dump, "folder");
    app_options_fini(&o);
}

static void help_is_found_everywhere(void **state)
{
    (void)state;
    app_options o;
    static const char *const lines[] = {"--help",     "-h", "help", "run --help", "run a.glb --frames 3 -h",
                                        "info --help"};
    for (size_t i = 0; i < sizeof lines / sizeof *lines; i++) {
        assert_int_equal(parse(lines[i], &o), KD_OK);
        assert_int_equal(o.command, APP_HELP);
        app_options_fini(&o);
    }
    assert_int_equal(parse("--version", &o), KD_OK);
    assert_int_equal(o.command, APP_VERSION);
}

static void mistakes_give_one_message_that_helps(void **state)
{
    (void)state;
    static const struct {
        const char *line, *says;
    } rows[] = {
        {"", "kandil help"},
        {"rnu a.lua", "did you mean 'run'?"},
        {"scene.lua", "kandil run scene.lua"},
        {"frobnicate", "kandil help"},
        {"run", "needs a SCENE"},
        {"run a.lua b.lua", "unexpected argument 'b.lua'"},
        {"run a.lua --framse 3", "did you mean --frames?"},
        {"run a.lua --xyzzy", "kandil help run"},
        {"run a.lua --frames", "needs a value"},
        {"run a.lua --frames x", "not a whole number"},
        {"run a.lua --frames 3.5", "not a whole number"},
        {"run a.lua --frames -1", "out of range"},
        {"run a.lua --frames 99999999999999999999", "not a whole number"},
        {"run a.lua --seconds nan", "not a number"},
        {"run a.lua --seconds -1", "out of range"},
        {"run a.lua --fps 0", "out of range"},
        {"run a.lua --size 640", "WIDTHxHEIGHT"},
        {"run a.lua --size 640x", "WIDTHxHEIGHT"},
        {"run a.lua --size 640x360x2", "WIDTHxHEIGHT"},
        {"run a.lua --size 0x360", "out of range"},
        {"run a.lua --size 640x16385", "16384"},
        {"run a.lua --size -1x5", "WIDTHxHEIGHT"},
        {"run a.lua --threads 65", "out of range"},
        {"run a.lua --context elg", "did you mean 'egl'?"},
        {"run a.lua --gi cone", "did you mean 'cones'?"},
        {"run a.lua --view octre", "did you mean 'octree'?"},
        {"run a.lua --level 16", "out of range"},
        {"run a.lua --out picture.jpg", ".exr, .mp4 or .webm"},
        {"run a.lua --out p_%s.png", "%04d"},
        {"run a.lua --out p_%04d_%d.png", "%04d"},
        {"run a.lua --out p_%n.png", "%04d"},
        {"run a.lua --out film_%04d.mp4", "one file"},
        {"run a.lua --out a.png --out a.png", "twice"},
        {"run a.lua --set voxels.span", "KEY=VALUE"},
        {"run a.lua --set voxels.spam=3", "voxels.span"},
        {"run a.lua --set voxels.span=-3", "voxels.span"},
        {"run a.lua --profile trace.txt", "FILE.pftrace"},
        {"run a.lua --quiet=1", "takes no value"},
        {"run a.lua --graph g.png", ".dot or .svg"},
        {"info a.glb --frames 3", "takes none"},
        {"bench esc", "did you mean 'ecs'?"},
        {"bench ecs jobs", "unexpected argument 'jobs'"},
        {"bench --jsn f.json", "did you mean --json?"},
        {"bench --xyzzy", "kandil help bench"},
        {"bench --size 3x3", "unknown option --size"},
        {"bench svo a.lua b.lua", "unexpected argument 'b.lua'"},
        {"bench --n 0", "out of range"},
        {"bench --threads 65", "out of range"},
        {"run a.lua --json f.json", "unknown option --json"},
        {"doctor now", "takes none"},
        {"info", "needs a FILE"},
    };
    for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
        app_options o;
        kd_status status = parse(rows[i].line, &o);
        if (status != KD_USAGE || message_count != 1 || !strstr(last_message, rows[i].says))
            fail_msg("'%s' gave status %d and %d messages: %s", rows[i].line, (int)status, message_count,
                     last_message);
    }
}

static void entity_fields_are_told_from_settings(void **state)
{
    (void)state;
    assert_true(app_is_entity_field("lamp.light.intensity=5"));
    assert_true(app_is_entity_field("my.lamp.light.intensity=5"));
    assert_false(app_is_entity_field("voxels.span=0.1.2"));
    assert_false(app_is_entity_field("voxels.spam=1"));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(options_are_read_when_right),
        cmocka_unit_test(nothing_said_is_told_apart),
        cmocka_unit_test(bench_takes_its_own_options),
        cmocka_unit_test(help_is_found_everywhere),
        cmocka_unit_test(mistakes_give_one_message_that_helps),
        cmocka_unit_test(entity_fields_are_told_from_settings),
    };
    kd_log_set_sink(remember, NULL);
    return cmocka_run_group_tests(tests, NULL, NULL);
}
