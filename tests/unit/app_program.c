/* The program as a user runs it: exit codes, one message a failure, what stays after Ctrl+C, the same bytes
 * every time. */
#include <setjmp.h>
#include <signal.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

#include <cmocka.h>

#include "tests/folder_fixture.h"

static char said[8192]; /* standard error of the last run */

static void read_said(void)
{
    FILE *file = fopen("said", "rb");
    size_t size = file ? fread(said, 1, sizeof said - 1, file) : 0;
    said[size] = '\0';
    if (file)
        fclose(file);
}

/* Run `kandil ARGUMENTS` in the folder and return its exit code. */
static int kandil(const char *arguments)
{
    char command[1024];
    snprintf(command, sizeof command, "'%s/kandil' %s >out 2>said", KD_BINARY_DIR, arguments);
    int state = system(command);
    read_said();
    return WIFEXITED(state) ? WEXITSTATUS(state) : -1;
}

static void write_file(const char *name, const char *text)
{
    FILE *file = fopen(name, "wb");
    assert_non_null(file);
    assert_true(fputs(text, file) >= 0);
    assert_int_equal(fclose(file), 0);
}

static bool same_files(const char *a, const char *b)
{
    char command[256];
    snprintf(command, sizeof command, "cmp -s '%s' '%s'", a, b);
    return system(command) == 0;
}

static bool exists(const char *name)
{
    return access(name, F_OK) == 0;
}

/* A ball above a floor, turning; small and without voxels, so that a software driver is quick. */
static const char scene[] =
    "kandil.scene { size = {64, 48}, fps = 10, seconds = 0.5, gi = 'none' }\n"
    "kandil.spawn { mesh = { shape = 'plane', size = {4, 1, 4} } }\n"
    "local ball = kandil.spawn { name = 'ball', mesh = { shape = 'box' }, material = { base_color = {1, 0.2, "
    "0.1} },\n"
    "  transform = { position = {0, 0.6, 0} } }\n"
    "kandil.spawn { name = 'sun', light = { type = 'directional', intensity = 3 }, transform = { look_at = "
    "{0.3, -1, -0.4} } }\n"
    "kandil.spawn { camera = { fov_y_deg = 40 }, transform = { position = {0, 1.5, 4}, look_at = {0, 0.5, 0} "
    "} }\n"
    "function kandil.update(t) ball:set('transform.rotation_deg', {0, 90 * t, 0}) end\n";

static void exit_codes_and_messages_are_as_promised(void **state)
{
    (void)state;
    static const struct {
        const char *arguments;
        int code;
        const char *says;
    } rows[] = {
        {"", 2, "kandil help"},
        {"--version", 0, ""},
        {"help", 0, ""},
        {"help run", 0, ""},
        {"help settings", 0, ""},
        {"help nothing", 2, "kandil help"},
        {"run", 2, "SCENE"},
        {"run scene.lua --bogus", 2, "--bogus"},
        {"run missing.lua", 1, "missing.lua"},
        {"run missing.glb", 1, "missing.glb"},
        {"run scene.txt", 2, ".lua"},
        {"run scene.lua --out missing/a.png", 1, "missing/a.png"},
        {"run scene.lua --stats missing/a.json", 1, "missing/a.json"},
        {"run syntax.lua", 1, "syntax.lua:2: "},
        {"run loop.lua", 1, "loop.lua:1: ran for too long"},
        {"run scene.lua --frames 1 --set ball.transform.nothing=1", 2, "ball.transform.nothing"},
        {"run scene.lua --frames 1 --set nobody.transform.position=1,2,3", 2, "nobody"},
        {"run scene.lua --frames 1 --set ball.mesh_instance.mesh=99", 2, "mesh_instance.mesh"},
        {"run shapes.lua", 1, "shapes.lua:1: all shapes together have more than"},
        {"run copies.lua", 1, "copies.lua:2: more than 250000 entities would be in the scene"},
        {"run copies.lua --set script.entities=9", 1, "more than 9 entities would be in the scene"},
        {"run crowd.lua --set script.entities=99", 1, "crowd.lua:1: more than 99 entities"},
        {"run raise.lua", 1,
         "raise.lua:3: settings: script.entities may be lowered here, but not raised above "
         "250000; "},
        {"run raise.lua --set script.entities=300000", 0, ""},
        {"run deep.lua", 1, "deep.lua:2: the entity would hang more than 65535 deep"},
        {"run deeper.lua", 1, "deeper.lua:3: an entity cannot hang below itself, nor more than 65535 deep"},
        {"info scene.lua", 2, ".glb"},
    };
    write_file("scene.lua", scene);
    write_file("scene.txt", "x");
    write_file("syntax.lua", "local a = 1\nlocal b = = 2\n");
    write_file("loop.lua", "while true do end\n");
    write_file("copies.lua", "local e = kandil.spawn {}\nfor i = 1, 40 do local top = kandil.spawn {}; "
                             "e.parent = top; e:clone { parent = top }; e = top end\n");
    write_file("deep.lua",
               "local e = kandil.spawn {}\nfor i = 1, 65536 do e = kandil.spawn { parent = e } end\n");
    write_file("deeper.lua",
               "local e = kandil.spawn {}\nfor i = 1, 65535 do e = kandil.spawn { parent = e } end\n"
               "kandil.spawn {}.parent = e\n");
    write_file("raise.lua", "kandil.scene { size = {16, 16}, fps = 10, seconds = 0.1, gi = 'none' }\n"
                            "kandil.set('script.entities', 9) kandil.set('script.entities', 250000)\n"
                            "kandil.set('script.entities', 300000)\n");
    write_file("crowd.lua", "for i = 1, 100 do kandil.spawn {} end\n");
    write_file(
        "shapes.lua",
        "for i = 1, 1000 do kandil.spawn { mesh = { shape = 'sphere', size = i, segments = 1024 } } end\n");
    for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
        int code = kandil(rows[i].arguments);
        char *newline = strchr(said, '\n');
        bool one_line =
            rows[i].code == 0 ? !*said : strncmp(said, "kandil: ", 8) == 0 && newline && !newline[1];
        if (code != rows[i].code || !strstr(said, rows[i].says) || !one_line)
            fail_msg("kandil %s gave %d and said: %s", rows[i].arguments, code, said);
    }
}

static void no_frames_write_no_picture(void **state)
{
    (void)state;
    char text[8192] = "";
    write_file("scene.lua", scene);
    assert_int_equal(kandil("run scene.lua --frames 0 --out zero.png --out zero.mp4 --stats zero.json"), 0);
    assert_false(exists("zero.png") || exists("zero.mp4"));
    assert_non_null(strstr(said, "zero.png was not written"));
    assert_null(strstr(strstr(said, "was not written") + 1, "was not written")); /* once */
    assert_int_equal(kandil("run scene.lua --frames 0 --out zero.png --quiet"), 0);
    assert_string_equal(said, "");
    FILE *file = fopen("zero.json", "rb");
    assert_non_null(file);
    assert_true(fread(text, 1, sizeof text - 1, file) > 0);
    fclose(file);
    assert_non_null(strstr(text, "\"frames\": 0"));
}

static bool printed(const char *text)
{
    char command[128];
    snprintf(command, sizeof command, "grep -qF -- '%s' out", text);
    return system(command) == 0;
}

static void help_lists_what_there_is(void **state)
{
    (void)state;
    assert_int_equal(kandil("help run"), 0);
    assert_true(printed("one of: final direct indirect ao specular albedo normal depth light caches pages "
                        "octree lookup cost"));
    assert_false(printed("octree light") || printed("octree, light"));
    assert_int_equal(kandil("help settings"), 0);
    assert_true(printed("default 60)") && printed("on|off; default on)") && printed("on|off; default off)"));
    assert_false(printed("e+0") || printed("true") || printed("false"));
}

/* What cannot be drawn can still be listed: nodes that move, without a mesh. */
static void info_lists_files_without_triangles(void **state)
{
    (void)state;
    const float times_and_places[8] = {0, 1};
    FILE *file = fopen("moves.bin", "wb");
    assert_non_null(file);
    assert_int_equal(fwrite(times_and_places, sizeof times_and_places, 1, file), 1);
    assert_int_equal(fclose(file), 0);
    write_file("moves.gltf",
               "{\"asset\":{\"version\":\"2.0\"},\"nodes\":[{\"name\":\"hand\"}],"
               "\"animations\":[{\"name\":\"wave\",\"samplers\":[{\"input\":0,\"output\":1}],\"channels\":["
               "{\"sampler\":0,\"target\":{\"node\":0,\"path\":\"translation\"}}]}],"
               "\"accessors\":[{\"bufferView\":0,\"componentType\":5126,\"count\":2,\"type\":\"SCALAR\","
               "\"min\":[0],\"max\":[1]},{\"bufferView\":1,\"componentType\":5126,\"count\":2,"
               "\"type\":\"VEC3\"}],\"bufferViews\":[{\"buffer\":0,\"byteLength\":8},"
               "{\"buffer\":0,\"byteOffset\":8,\"byteLength\":24}],"
               "\"buffers\":[{\"uri\":\"moves.bin\",\"byteLength\":32}]}");
    assert_int_equal(kandil("info moves.gltf"), 0);
    assert_string_equal(said, "");
    assert_true(printed("nothing of it can be drawn"));
    assert_false(printed("bounds"));
    assert_true(printed(": 1.000 s, 1 channels"));
    assert_true(printed("hand"));
    assert_int_equal(kandil("run moves.gltf --frames 1"), 1);
    assert_non_null(strstr(said, "moves.gltf: the model holds no triangles"));
}

static void messages_name_the_entity_and_plain_paths(void **state)
{
    (void)state;
    write_file("clip.lua", "local b = kandil.spawn { mesh = { shape = 'box' } }\nb:play('walk')\n");
    assert_int_equal(kandil("run clip.lua --frames 0"), 1);
    assert_non_null(strstr(said, "clip.lua:2: entity "));
    write_file("bad.gltf", "{");
    write_file("bad.lua", "kandil.spawn { model = 'bad.gltf' }\n");
    assert_int_equal(kandil("run bad.lua --frames 0"), 1);
    assert_non_null(strstr(said, "bad.lua:1: bad.gltf: "));
    assert_null(strstr(said, "./"));
}

static void pictures_do_not_depend_on_threads_or_runs(void **state)
{
    (void)state;
    write_file("scene.lua", scene);
    assert_int_equal(kandil("run scene.lua --threads 1 --out a_%02d.png --out a.exr"), 0);
    assert_int_equal(kandil("run scene.lua --threads 2 --out b_%02d.png --out b.exr"), 0);
    assert_int_equal(kandil("run scene.lua --threads 2 --out c_%02d.png --out c_last.png"), 0);
    assert_true(exists("a_04.png") && !exists("a_05.png")); /* 0.5 s at 10 steps a second */
    for (int i = 0; i < 5; i++) {
        char a[16], b[16], c[16];
        snprintf(a, sizeof a, "a_%02d.png", i);
        snprintf(b, sizeof b, "b_%02d.png", i);
        snprintf(c, sizeof c, "c_%02d.png", i);
        assert_true(same_files(a, b) && same_files(b, c));
    }
    assert_true(same_files("a.exr", "b.exr") && same_files("c_04.png", "c_last.png"));
    assert_false(same_files("a_00.png", "a_04.png")); /* the box turns */
}

static void entity_fields_and_order_of_precedence(void **state)
{
    (void)state;
    write_file("scene.lua", scene);
    assert_int_equal(kandil("run scene.lua --seconds 9 --frames 2 --size 32x16 --out p_%02d.png"), 0);
    assert_true(exists("p_01.png") && !exists("p_02.png"));
    assert_int_equal(kandil("run scene.lua --frames 1 --out bright.png"), 0);
    assert_int_equal(kandil("run scene.lua --frames 1 --set sun.light.intensity=0.2 --out dim.png"), 0);
    assert_false(same_files("bright.png", "dim.png"));
}

static int count_film_frames(const char *path)
{
    char command[256];
    int frames = -1;
    snprintf(command, sizeof command,
             "ffprobe -v error -count_frames -select_streams v -show_entries stream=nb_read_frames -of "
             "csv=p=0 '%s'",
             path);
    FILE *out = popen(command, "r");
    assert_non_null(out);
    if (fscanf(out, "%d", &frames) != 1)
        frames = -1;
    pclose(out);
    return frames;
}

static int count_pictures(const char *prefix)
{
    char command[128];
    int count = -1;
    snprintf(command, sizeof command, "ls | grep -c '^%s.*png$'", prefix);
    FILE *out = popen(command, "r");
    assert_non_null(out);
    if (fscanf(out, "%d", &count) != 1)
        count = -1;
    pclose(out);
    return count;
}

static void a_film_has_exactly_its_frames(void **state)
{
    (void)state;
    write_file("scene.lua", scene);
    assert_int_equal(kandil("run scene.lua --frames 13 --size 33x17 --out film.mp4"), 0);
    assert_int_equal(count_film_frames("film.mp4"), 13);
}

/* Start a long run, interrupt it once its first pictures stand, and look at what is left. */
static void interrupting_keeps_finished_frames(void **state)
{
    (void)state;
    int status;
    write_file("scene.lua", scene);
    pid_t child = fork();
    if (child == 0) {
        if (!freopen("said", "wb", stderr))
            _exit(99);
        execl(KD_BINARY_DIR "/kandil", "kandil", "run", "scene.lua", "--frames", "1000000", "--out",
              "i_%06d.png", "--out", "i.mp4", "--out", "last.png", (char *)NULL);
        _exit(98);
    }
    assert_true(child > 0);
    for (int i = 0; i < 600 && !exists("i_000005.png"); i++)
        nanosleep(&(struct timespec){.tv_nsec = 100000000}, NULL);
    assert_true(exists("i_000005.png"));
    assert_int_equal(kill(child, SIGINT), 0);
    assert_int_equal(waitpid(child, &status, 0), child);
    read_said();
    assert_true(WIFEXITED(status));
    assert_int_equal(WEXITSTATUS(status), 130);
    int pictures = count_pictures("i_");
    assert_true(pictures >= 6);
    assert_int_equal(count_film_frames("i.mp4"), pictures);
    assert_true(exists("last.png"));
    char last[32];
    snprintf(last, sizeof last, "i_%06d.png", pictures - 1);
    assert_true(same_files(last, "last.png"));
    assert_int_not_equal(system("ls | grep -q part"), 0); /* no unfinished file */
}

static void a_scenario_that_fails_in_the_middle_keeps_its_frames(void **state)
{
    (void)state;
    char text[2048];
    snprintf(text, sizeof text, "%s", scene);
    char *update = strstr(text, "function kandil.update");
    assert_non_null(update);
    strcpy(update, "function kandil.update(t)\n  if t > 0.25 then error('stop here') end\nend\n");
    write_file("fails.lua", text);
    assert_int_equal(kandil("run fails.lua --out f_%02d.png --out f.mp4"), 1);
    assert_non_null(strstr(said, "fails.lua:8: stop here"));
    /* steps 0, 0.1 and 0.2 s */
    assert_int_equal(count_pictures("f_"), 3);
    assert_int_equal(count_film_frames("f.mp4"), 3);
}

static void odd_sizes_are_pictures_too(void **state)
{
    (void)state;
    static const char *const sizes[] = {"1x1", "3x7", "4096x16", "641x359"};
    write_file("scene.lua", scene);
    for (size_t i = 0; i < sizeof sizes / sizeof *sizes; i++) {
        char arguments[128];
        snprintf(arguments, sizeof arguments, "run scene.lua --frames 1 --size %s --out size.png", sizes[i]);
        if (kandil(arguments) != 0)
            fail_msg("kandil %s said: %s", arguments, said);
        assert_true(exists("size.png"));
        unlink("size.png");
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(exit_codes_and_messages_are_as_promised),
        cmocka_unit_test(no_frames_write_no_picture),
        cmocka_unit_test(help_lists_what_there_is),
        cmocka_unit_test(info_lists_files_without_triangles),
        cmocka_unit_test(messages_name_the_entity_and_plain_paths),
        cmocka_unit_test(pictures_do_not_depend_on_threads_or_runs),
        cmocka_unit_test(entity_fields_and_order_of_precedence),
        cmocka_unit_test(a_film_has_exactly_its_frames),
        cmocka_unit_test(interrupting_keeps_finished_frames),
        cmocka_unit_test(a_scenario_that_fails_in_the_middle_keeps_its_frames),
        cmocka_unit_test(odd_sizes_are_pictures_too),
    };
    if (!exists(KD_BINARY_DIR "/kandil"))
        return 77; /* the program was not built */
    return cmocka_run_group_tests(tests, open_folder, close_folder);
}
