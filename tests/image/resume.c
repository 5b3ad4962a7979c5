/* What is rendered later joins what was there: a resumed sequence has the bytes of one made at once; films
 * have every frame at its time. */
#include <setjmp.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include <cmocka.h>

#include "tests/folder_fixture.h"

#define SCENE KD_SOURCE_DIR "/samples/02_timeline.lua"

static void run(const char *arguments)
{
    char command[1024];
    snprintf(command, sizeof command,
             "'%s/kandil' run '" SCENE
             "' --size 64x36 --frames 12 --set light.bounces=1 --set view.steady=off %s > out 2>&1",
             KD_BINARY_DIR, arguments);
    assert_int_equal(system(command), 0);
}

static bool said(const char *text)
{
    char command[256];
    snprintf(command, sizeof command, "grep -qF '%s' out", text);
    return system(command) == 0;
}

/* With one bounce and unmixed a picture depends on its frame alone. Frame 11 is missing, 6 is empty. Before
 * each two are rendered to warm up, and the first in any case: 12 less 0, 4, 5, 6, 9, 10, 11 leaves out 5. */
static void a_resumed_sequence_is_the_same(void **state)
{
    (void)state;
    run("--out a_%02d.png --out a_%02d.exr --out last.png");
    assert_int_equal(system("mkdir whole && cp *.png *.exr whole && rm a_11.exr last.png && : > a_06.png"),
                     0);
    run("--out a_%02d.png --out a_%02d.exr --out last.png --resume");
    assert_true(said("resumed: 5 of 12 frames"));
    assert_int_equal(system("for f in whole/*; do cmp $f $(basename $f) || exit 1; done"), 0);
    /* Nothing is missing now. */
    run("--out a_%02d.png --resume");
    assert_true(said("resumed: 11 of 12 frames"));
    /* Another output wants all of them. */
    run("--out a_%02d.png --out b_%02d.png --resume");
    assert_false(said("resumed"));
    assert_int_equal(system("for f in b_*; do cmp $f whole/a${f#b} || exit 1; done"), 0);
}

/* Another program may have been cut in the middle of an .exr: its beginning says nothing. */
static void a_cut_exr_is_made_again(void **state)
{
    (void)state;
    run("--out c_%02d.exr --layers");
    assert_int_equal(system("mkdir cut && cp c_*.exr cut && head -c -1 cut/c_11.exr > c_11.exr && "
                            "head -c 2000 cut/c_06.exr > c_06.exr"),
                     0);
    run("--out c_%02d.exr --layers --resume");
    assert_true(said("resumed: 5 of 12 frames"));
    assert_int_equal(system("for f in cut/*; do cmp $f $(basename $f) || exit 1; done"), 0);
    run("--out c_%02d.exr --layers --resume");
    assert_true(said("resumed: 11 of 12 frames"));
}

static void films_have_every_frame_at_its_time(void **state)
{
    (void)state;
    if (system("ffprobe -version > /dev/null 2>&1") != 0)
        skip();
    run("--fps 24 --out f.mp4 --out f.webm");
    for (int i = 0; i < 2; i++) {
        char command[512];
        snprintf(command, sizeof command,
                 "ffprobe -v error -select_streams v -count_frames -show_entries "
                 "stream=nb_read_frames,r_frame_rate:frame=pts_time -of csv %s > probe",
                 i ? "f.webm" : "f.mp4");
        assert_int_equal(system(command), 0);
        FILE *file = fopen("probe", "r");
        char line[256];
        int frames = 0;
        bool counted = false;
        while (file && fgets(line, sizeof line, file)) {
            double time_s;
            if (sscanf(line, "frame,%lf", &time_s) == 1) {
                /* containers keep milliseconds, or finer */
                double wanted_s = frames++ / 24.0;
                assert_true(time_s > wanted_s - 0.001 && time_s < wanted_s + 0.001);
            }
            counted = counted || strncmp(line, "stream,24/1,12", 14) == 0;
        }
        if (file)
            fclose(file);
        assert_int_equal(frames, 12);
        assert_true(counted);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_resumed_sequence_is_the_same),
        cmocka_unit_test(a_cut_exr_is_made_again),
        cmocka_unit_test(films_have_every_frame_at_its_time),
    };
    return cmocka_run_group_tests(tests, open_folder, close_folder);
}
