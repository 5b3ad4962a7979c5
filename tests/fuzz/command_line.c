/* The program against its surroundings: pipes, devices, full disks, limits, closed streams, a missing
 * encoder, signals. Each ends with the promised exit code, one message at most, and nothing half written. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "tests/folder_fixture.h"

#include <sys/stat.h>

#include "tests/program_fixture.h"

static const char scene[] =
    "kandil.scene { size = {64, 48}, fps = 10, seconds = 0.2, gi = 'none' }\n"
    "kandil.spawn { mesh = { shape = 'box' }, transform = { position = {0, 0.6, 0} } }\n"
    "kandil.spawn { light = { type = 'directional', intensity = 3 }, transform = { look_at = {0.3, -1, -0.4} "
    "} "
    "}\n"
    "kandil.spawn { camera = { fov_y_deg = 40 }, transform = { position = {0, 1, 4}, look_at = {0, 0, 0} } "
    "}\n";

static bool write_file(const char *name, const char *text)
{
    FILE *file = fopen(name, "wb");
    return file && fputs(text, file) >= 0 && fclose(file) == 0;
}

static int set_up(void **state)
{
    bool made = open_folder(state) == 0 && write_file("s.lua", scene);
    return made && symlink("/dev/full", "full.png") == 0 && symlink("/dev/full", "full.exr") == 0 &&
                   symlink("/dev/full", "full.mp4") == 0 && symlink("/dev/full", "full.json") == 0 &&
                   mkfifo("pipe.png", 0600) == 0 && mkdir("folder.png", 0700) == 0
               ? 0
               : -1;
}

/* Run `BEFORE; exec kandil ARGUMENTS AFTER` in a shell, so that limits and streams can be set. */
static int run(const char *before, const char *arguments, const char *after, program *out)
{
    char command[1024];
    *out = (program){.deadline = program_clock_s() + 6 * PROGRAM_LIMIT_S};
    strcpy(out->said_path, "said");
    snprintf(command, sizeof command, "%s; exec '%s' %s %s", before, PROGRAM_PATH, arguments, after);
    out->pid = fork();
    if (out->pid == 0) {
        if (!freopen("said", "wb", stderr))
            _exit(126);
        execl("/bin/bash", "bash", "-c", command, (char *)NULL);
        _exit(127);
    }
    assert_true(out->pid > 0);
    program_wait(out);
    return out->code;
}

static bool is_left_over(void)
{
    return system("ls -a | grep -qE '^[.]kandil-|[.]part'") == 0;
}

typedef struct row {
    const char *before, *arguments, *after;
    int code;
    const char *says; /* NULL: nothing at all */
} row;

static void check(const row *rows, size_t count)
{
    for (size_t i = 0; i < count; i++) {
        program p;
        int code = run(rows[i].before, rows[i].arguments, rows[i].after, &p);
        bool good = rows[i].says ? program_said_one_line(&p, rows[i].says) : program_said_only_warnings(&p);
        if (code != rows[i].code || !good || is_left_over())
            fail_msg("%s; kandil %s %s: gave %d, and said: %s", rows[i].before, rows[i].arguments,
                     rows[i].after, code, p.said);
    }
}

static void outputs_that_cannot_be_written_are_one_message(void **state)
{
    (void)state;
    static const row rows[] = {
        {":", "run s.lua --frames 1 --out full.png", "", 1, "no space left"},
        {":", "run s.lua --frames 1 --out full.exr", "", 1, "no space left"},
        {":", "run s.lua --frames 1 --stats full.json", "", 1, "no space left"},
        {":", "run s.lua --frames 1 --out full.mp4", "", 1, "full.mp4: is a pipe or device"},
        {":", "run s.lua --frames 1 --out pipe.png", "", 1, "nobody reads"},
        {":", "run s.lua --frames 1 --out folder.png", "", 1, "is a folder"},
        {"ulimit -f 1", "run s.lua --frames 1 --size 640x360 --out a.png", "", 1, "no space left"},
        {"PATH=", "run s.lua --frames 1 --out a.mp4", "", 1, "ffmpeg was not found"},
        {":", "run s.lua --out a.png --stats a.png", "", 2, "a.png is written by another option"},
        {":", "info missing.glb", "", 1, "missing.glb"},
        {":", "help", ">/dev/full", 1, "standard output"},
        {":", "run s.lua --frames 1 --profile table", ">/dev/full", 1, "standard output"},
    };
    check(rows, sizeof rows / sizeof *rows);
}

static void closed_streams_and_bare_environments_do_no_harm(void **state)
{
    (void)state;
    static const row rows[] = {
        {":", "run s.lua --frames 1 --out b.png", ">&-", 0, NULL},
        {":", "run s.lua --frames 1 --out b.png", "<&- >&- 2>&-", 0, NULL},
        {":", "run missing.lua", "<&- >&- 2>&-", 1, NULL},
        {"unset HOME TMPDIR XDG_CACHE_HOME", "run s.lua --frames 1 --out b.png", "", 0, NULL},
    };
    check(rows, sizeof rows / sizeof *rows);
    assert_int_equal(access("b.png", R_OK), 0);
}

/* Each signal that asks to end does so after the frame, with what is finished kept. */
static void signals_end_the_run_in_order(void **state)
{
    (void)state;
    static const int signals[] = {SIGTERM, SIGHUP};
    for (size_t i = 0; i < sizeof signals / sizeof *signals; i++) {
        program p;
        program_start(&p, "said",
                      (const char *const[]){"kandil", "run", "s.lua", "--frames", "1000000", "--out",
                                            "f_%06d.png", "--stats", "f.json", NULL},
                      6 * PROGRAM_LIMIT_S);
        while (access("f_000002.png", F_OK) != 0 && program_clock_s() < p.deadline)
            nanosleep(&(struct timespec){.tv_nsec = 20000000}, NULL);
        assert_int_equal(kill(p.pid, signals[i]), 0);
        program_wait(&p);
        assert_int_equal(p.code, 130);
        assert_true(program_said_one_line(&p, "interrupted"));
        assert_int_equal(access("f.json", F_OK), 0);
        assert_false(is_left_over());
        assert_int_equal(system("rm -f f_* f.json"), 0);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(outputs_that_cannot_be_written_are_one_message),
        cmocka_unit_test(closed_streams_and_bare_environments_do_no_harm),
        cmocka_unit_test(signals_end_the_run_in_order),
    };
    if (access(PROGRAM_PATH, X_OK) != 0) {
        puts("skipped: " PROGRAM_PATH " was not built");
        return 77;
    }
    return cmocka_run_group_tests(tests, set_up, close_folder);
}
