/* `kandil bench` as a user runs it, at tiny sizes: exit codes, the table, the file. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cmocka.h>

#include "tests/folder_fixture.h"

static char text[65536];

static int kandil(const char *arguments)
{
    char command[1024];
    snprintf(command, sizeof command, "'%s/kandil' %s >out 2>said", KD_BINARY_DIR, arguments);
    int state = system(command);
    return WIFEXITED(state) ? WEXITSTATUS(state) : -1;
}

static const char *read_file(const char *name)
{
    FILE *file = fopen(name, "rb");
    size_t size = file ? fread(text, 1, sizeof text - 1, file) : 0;
    if (file)
        fclose(file);
    text[size] = '\0';
    return text;
}

static void rows_stand_in_the_table_and_in_the_file(void **state)
{
    (void)state;
    assert_int_equal(kandil("bench jobs --n 20 --threads 2 --case dag1000 --json rows.json"), 0);
    read_file("out");
    assert_non_null(strstr(text, "median"));
    assert_non_null(strstr(text, "dag1000_rebuilt"));
    assert_null(strstr(text, "saxpy"));
    read_file("rows.json");
    assert_ptr_equal(strstr(text, "{"), text);
    assert_non_null(strstr(text, "\"rows\": ["));
    assert_non_null(strstr(text, "\"bench\": \"jobs\""));
    assert_non_null(strstr(text, "\"case\": \"dag1000_work\""));
    assert_non_null(strstr(text, "\"limit\": null"));
    for (const char *key = "n\0threads\0unit\0median\0min\0max\0"; *key; key += strlen(key) + 1) {
        char quoted[16];
        snprintf(quoted, sizeof quoted, "\"%s\": ", key);
        assert_non_null(strstr(text, quoted));
    }
    assert_int_equal(kandil("bench ecs --n 20 --threads 1 --case iter2"), 0);
    assert_non_null(strstr(read_file("out"), "ns/entity"));
}

static void what_cannot_be_written_is_said(void **state)
{
    (void)state;
    assert_int_equal(kandil("bench ecs --n 5 --case tree_create --json missing/rows.json"), 1);
    assert_non_null(strstr(read_file("said"), "missing/rows.json"));
    assert_int_equal(kandil("bench esc"), 2);
    assert_non_null(strstr(read_file("said"), "did you mean 'ecs'"));
    assert_int_equal(kandil("help bench"), 0);
    assert_non_null(strstr(read_file("out"), "--json FILE"));
}

static void write_scene(void)
{
    FILE *file = fopen("scene.lua", "wb");
    assert_non_null(file);
    fputs("kandil.scene { size = {16, 16} }\n"
          "kandil.set('voxels.span', 0.05) kandil.set('voxels.cascades', 1)\n"
          "kandil.spawn { mesh = { shape = 'box', size = {1, 1, 1} } }\n"
          "kandil.spawn { camera = {}, transform = { position = {0, 1, 3}, look_at = {0, 0, 0} } }\n",
          file);
    fclose(file);
}

/* Stages of a scene: every stage has its row with what copying would take, and one layer and two see the same
 * voxels. */
static void stages_of_a_scene_are_measured(void **state)
{
    (void)state;
    write_scene();
    assert_int_equal(kandil("bench voxels scene.lua --frames 2 --case cascades/128 --json rows.json"), 0);
    read_file("out");
    assert_non_null(strstr(text, "3 x 128^3"));
    assert_null(strstr(text, "256^3"));
    read_file("rows.json");
    for (const char *stage = "io\0transform\0reconstruct\0average\0"; *stage; stage += strlen(stage) + 1) {
        char quoted[64];
        snprintf(quoted, sizeof quoted, "\"case\": \"cascades/128/%s\"", stage);
        assert_non_null(strstr(text, quoted));
    }
    assert_int_equal(kandil("bench svo scene.lua --frames 2 --case layers/two_rests_ --json rows.json"), 0);
    assert_non_null(strstr(read_file("out"), "two_rests_fine"));
    assert_non_null(strstr(read_file("rows.json"), "\"case\": \"layers/two_rests_coarse/transform\""));
    assert_int_equal(kandil("bench svo"), 1);
    assert_non_null(strstr(read_file("said"), "name one: `kandil bench svo SCENE`"));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(rows_stand_in_the_table_and_in_the_file),
        cmocka_unit_test(what_cannot_be_written_is_said),
        cmocka_unit_test(stages_of_a_scene_are_measured),
    };
    if (access(KD_BINARY_DIR "/kandil", X_OK) != 0)
        return 77; /* the program was not built */
    return cmocka_run_group_tests(tests, open_folder, close_folder);
}
