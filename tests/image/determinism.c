/* The same command gives the same bytes: run to run, with one thread or two, however the frames are written.
 */

#include "tests/image_fixture.h"

#define DEMO   KD_SOURCE_DIR "/samples/01_cornell_walker.lua"
#define SIZE   "96x54"
#define FRAMES 5

/* Write every frame of the demo as <name>0000.png and on. */
static void render(const char *name, const char *threads)
{
    char pattern[64];
    snprintf(pattern, sizeof pattern, "%s%%04d.png", name);
    image_render(DEMO, "--size", SIZE, "--frames", "5", "--threads", threads, "--out", image_path(pattern));
}

static void assert_same_frames(const char *a, const char *b)
{
    for (int i = 0; i < FRAMES; i++) {
        char names[2][64];
        snprintf(names[0], sizeof names[0], "%s%04d.png", a, i);
        snprintf(names[1], sizeof names[1], "%s%04d.png", b, i);
        assert_same_file(names[0], names[1]);
    }
}

/* The run to which the others are compared, with two threads. */
static int render_plain(void **state)
{
    int rc = image_setup(state);
    if (rc == 0)
        render("plain", "2");
    return rc;
}

static void two_runs_give_the_same_bytes(void **state)
{
    (void)state;
    render("second", "2");
    assert_same_frames("plain", "second");
}

static void one_thread_gives_the_bytes_of_two(void **state)
{
    (void)state;
    render("one", "1");
    assert_same_frames("plain", "one");
}

/* The frames of one run differ, or the tests above would compare nothing. */
static void frames_of_the_demo_differ(void **state)
{
    (void)state;
    image first = image_read("plain0000.png"), last = image_read("plain0004.png");
    assert_double_above(image_difference(first, last).mean, 1e-3);
    image_free(&first);
    image_free(&last);
}

/* What is written besides, measured or watched does not touch the picture. */
static void other_outputs_change_no_frame(void **state)
{
    (void)state;
    image_render(DEMO, "--size", SIZE, "--frames", "5", "--out", image_path("last.png"), "--out",
                 image_path("last.exr"));
    assert_same_file("plain0004.png", "last.png");
    image_render(DEMO, "--size", SIZE, "--frames", "5", "--profile-sync", "--stats", image_path("stats.json"),
                 "--out", image_path("timed%04d.png"));
    assert_same_frames("plain", "timed");
}

/* Frame n is what it is, whatever comes after it. */
static void a_shorter_run_gives_the_same_frames(void **state)
{
    (void)state;
    image_render(DEMO, "--size", SIZE, "--frames", "3", "--out", image_path("short.png"));
    assert_same_file("plain0002.png", "short.png");
}

/* The program stops with a message otherwise. */
static void systems_of_the_demo_touch_what_they_declare(void **state)
{
    (void)state;
    image_render(DEMO, "--size", SIZE, "--frames", "5", "--set", "debug.access=on", "--out",
                 image_path("watched%04d.png"));
    assert_same_frames("plain", "watched");
}

/* Systems one by one, in orders that their declarations allow: were one missing, some order would show. */
static void any_legal_order_of_systems_gives_the_same_bytes(void **state)
{
    (void)state;
    for (int seed = 1; seed <= 3; seed++) {
        char set[32];
        snprintf(set, sizeof set, "debug.shuffle=%d", seed);
        image_render(DEMO, "--size", SIZE, "--frames", "5", "--set", set, "--out",
                     image_path("shuffled%04d.png"));
        assert_same_frames("plain", "shuffled");
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(two_runs_give_the_same_bytes),
        cmocka_unit_test(one_thread_gives_the_bytes_of_two),
        cmocka_unit_test(frames_of_the_demo_differ),
        cmocka_unit_test(other_outputs_change_no_frame),
        cmocka_unit_test(a_shorter_run_gives_the_same_frames),
        cmocka_unit_test(systems_of_the_demo_touch_what_they_declare),
        cmocka_unit_test(any_legal_order_of_systems_gives_the_same_bytes),
    };
    return cmocka_run_group_tests(tests, render_plain, image_teardown);
}
