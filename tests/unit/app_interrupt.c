/* Interrupted once, the program keeps what is done; twice, it ends at once; out of space, it says so. Nothing
 * half written stays in any case. */
#include <dirent.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <sys/resource.h>
#include <sys/stat.h>

#include <cmocka.h>

#include "runtime/core/file.h"
#include "tests/program_fixture.h"

static char folder[64];

static const char *in_folder(const char *name)
{
    static char paths[4][160];
    static unsigned next;
    char *path = paths[next++ % 4];
    snprintf(path, sizeof paths[0], "%s/%s", folder, name);
    return path;
}

static int open_folder(void **state)
{
    static const char scene[] = "kandil.scene { size = {64, 36}, fps = 24, gi = 'none' }\n"
                                "local box = kandil.spawn { mesh = { shape = 'box', size = {1, 1, 1} } }\n"
                                "function kandil.update(t) box.transform.position = {t, 0, -5} end\n";
    (void)state;
    strcpy(folder, "/tmp/kandil-interrupt-XXXXXX");
    return mkdtemp(folder) && kd_file_write(in_folder("scene.lua"), scene, sizeof scene - 1) == KD_OK ? 0
                                                                                                      : -1;
}

static int close_folder(void **state)
{
    char command[128];
    (void)state;
    snprintf(command, sizeof command, "rm -rf '%s'", folder);
    return system(command);
}

/* Files whose name has `part` in it. */
static int count_files(const char *part)
{
    int count = 0;
    DIR *d = opendir(folder);
    assert_non_null(d);
    for (struct dirent *e = readdir(d); e; e = readdir(d))
        count += strstr(e->d_name, part) != NULL;
    closedir(d);
    return count;
}

static void start(program *p, const char *const *argv)
{
    assert_true(program_start(p, in_folder("said"), argv, 6 * PROGRAM_LIMIT_S));
}

/* Wait until the program has begun to write such a file. */
static bool appears(program *p, const char *part)
{
    while (!program_poll(p)) {
        if (count_files(part) > 0)
            return true;
        nanosleep(&(struct timespec){.tv_nsec = 2000000}, NULL);
    }
    return false;
}

/* A frame of 256 moments is under way when the second signal comes. */
static void the_second_interrupt_ends_it_at_once(void **state)
{
    (void)state;
    program p;
    const char *const argv[] = {"kandil", "run",   in_folder("scene.lua"), "--frames", "2000", "--subframes",
                                "256",    "--out", in_folder("twice.mp4"), NULL};
    start(&p, argv);
    assert_true(appears(&p, "twice.mp4.part"));
    assert_int_equal(kill(p.pid, SIGINT), 0);
    assert_int_equal(kill(p.pid, SIGTERM), 0);
    program_wait(&p);
    assert_false(p.timed_out);
    assert_true(p.code == 1000 + SIGINT || p.code == 1000 + SIGTERM); /* whichever was taken second */
    assert_int_equal(count_files("twice"), 0);
    assert_int_equal(count_files(".tmp"), 0);
}

static bool said_so_far(const char *text)
{
    char said[256] = "";
    FILE *file = fopen(in_folder("said"), "rb");
    size_t size = file ? fread(said, 1, sizeof said - 1, file) : 0;
    said[size] = '\0';
    if (file)
        fclose(file);
    return strstr(said, text) != NULL;
}

/* Copies take long and few instructions. Errors are caught. Every step begins anew, so that it never ends. */
static void a_scenario_busy_with_copies_is_interrupted(void **state)
{
    (void)state;
    program p;
    const char *const argv[] = {"kandil", "run", in_folder("busy.lua"), NULL};
    FILE *file = fopen(in_folder("busy.lua"), "w");
    assert_non_null(file);
    fputs("kandil.scene { size = {16, 16}, seconds = 1e6, gi = 'none' }\n"
          "local top = kandil.spawn {}\nfor i = 1, 10000 do kandil.spawn { parent = top } end\n"
          "function kandil.update()\n  kandil.log('busy')\n"
          "  for i = 1, 20 do pcall(function() top:clone():destroy() end) end\nend\n",
          file);
    assert_int_equal(fclose(file), 0);
    start(&p, argv);
    while (!program_poll(&p) && !said_so_far("busy"))
        nanosleep(&(struct timespec){.tv_nsec = 2000000}, NULL);
    assert_int_equal(kill(p.pid, SIGTERM), 0);
    program_wait(&p);
    assert_int_equal(p.code, 130);
    assert_non_null(strstr(p.said, "interrupted after "));
}

static void the_first_interrupt_keeps_what_is_done(void **state)
{
    (void)state;
    program p;
    const char *const argv[] = {"kandil",
                                "run",
                                in_folder("scene.lua"),
                                "--frames",
                                "100000",
                                "--out",
                                in_folder("once_%d.png"),
                                "--out",
                                in_folder("once.mp4"),
                                NULL};
    start(&p, argv);
    assert_true(appears(&p, "once_3.png"));
    assert_int_equal(kill(p.pid, SIGINT), 0);
    program_wait(&p);
    assert_int_equal(p.code, 130);
    assert_non_null(strstr(p.said, "what was finished is kept"));
    assert_int_equal(count_files("once.mp4"), 1);
    assert_int_equal(count_files(".part"), 0);
    assert_int_equal(count_files(".tmp"), 0);
}

/* A limit on the size of files stands for a disk without space: both refuse to write on. */
static void run_without_space(program *p, const char *out, const char *more)
{
    struct rlimit before, small;
    assert_int_equal(getrlimit(RLIMIT_FSIZE, &before), 0);
    small = (struct rlimit){.rlim_cur = 1000, .rlim_max = before.rlim_max};
    const char *const argv[] = {"kandil",  "run",   in_folder("scene.lua"), "--frames", "40", "--size",
                                "320x180", "--out", in_folder(out),         more,       NULL};
    assert_int_equal(setrlimit(RLIMIT_FSIZE, &small), 0);
    start(p, argv);
    setrlimit(RLIMIT_FSIZE, &before);
    program_wait(p);
}

static void a_full_disk_is_said_and_leaves_no_half_file(void **state)
{
    (void)state;
    program p;
    run_without_space(&p, "full_%d.exr", "--layers");
    assert_int_equal(p.code, 1);
    assert_non_null(strstr(p.said, "no space left"));
    const char *const films[] = {"full.mp4", "full.webm"}; /* their encoder may find out at the very end */
    for (int i = 0; i < 2; i++) {
        run_without_space(&p, films[i], NULL);
        assert_int_equal(p.code, 1);
        assert_non_null(strstr(p.said, films[i]));
    }
    assert_int_equal(count_files("full"), 0);
    assert_int_equal(count_files(".tmp"), 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_second_interrupt_ends_it_at_once),
        cmocka_unit_test(a_scenario_busy_with_copies_is_interrupted),
        cmocka_unit_test(the_first_interrupt_keeps_what_is_done),
        cmocka_unit_test(a_full_disk_is_said_and_leaves_no_half_file),
    };
    return cmocka_run_group_tests(tests, open_folder, close_folder);
}
