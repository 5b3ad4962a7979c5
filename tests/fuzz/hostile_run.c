/* The program over every model of the hostile collection: each run ends in a picture and silence, or in one
 * message that names the file and no picture; never in a signal, a hang or a report of a sanitizer. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include <ftw.h>
#include <sys/stat.h>

#include "tests/program_fixture.h"

#define HOSTILE    KD_SOURCE_DIR "/../shared/assets/hostile"
#define MAX_FILES  2048
#define PARALLEL   2
#define MAX_REPORT 20

static char folder[64];
static char *files[MAX_FILES];
static size_t file_count;

static bool ends_with(const char *text, const char *end)
{
    size_t n = strlen(text), m = strlen(end);
    return n >= m && strcmp(text + n - m, end) == 0;
}

static int collect(const char *path, const struct stat *info, int kind)
{
    (void)info;
    if (kind == FTW_F && (ends_with(path, ".gltf") || ends_with(path, ".glb")) && file_count < MAX_FILES)
        files[file_count++] = strdup(path);
    return 0;
}

static int open_folder(void **state)
{
    (void)state;
    strcpy(folder, "/tmp/kandil-hostile-XXXXXX");
    return mkdtemp(folder) ? ftw(HOSTILE, collect, 16) : -1;
}

static int close_folder(void **state)
{
    (void)state;
    for (size_t i = 0; i < file_count; i++)
        free(files[i]);
    return rmdir(folder); /* which fails when a run left something behind */
}

/* ---- what is asked of one run; each returns what is wrong with it, or NULL ---- */

typedef struct job {
    program run;
    size_t file;
    char picture[128];
} job;

typedef struct task {
    void (*start)(job *j, const char *said_path);
    const char *(*judge)(const job *j);
} task;

static const char *judge_end(const job *j)
{
    if (j->run.timed_out)
        return "did not end in time";
    if (j->run.code != 0 && j->run.code != 1)
        return "neither exit code 0 nor 1";
    if (j->run.code == 1 && !program_said_one_line(&j->run, strrchr(files[j->file], '/') + 1))
        return "failed without exactly one message that names the file";
    if (j->run.code == 0 && !program_said_only_warnings(&j->run))
        return "succeeded, but complained";
    return NULL;
}

static void start_run(job *j, const char *said_path)
{
    snprintf(j->picture, sizeof j->picture, "%s.png", said_path);
    program_start(&j->run, said_path,
                  (const char *const[]){"kandil", "run", files[j->file], "--frames", "1", "--size", "32x32",
                                        "--out", j->picture, NULL},
                  PROGRAM_LIMIT_S);
}

static const char *judge_run(const job *j)
{
    struct stat info;
    bool picture = stat(j->picture, &info) == 0;
    const char *wrong = judge_end(j);
    unlink(j->picture);
    if (wrong)
        return wrong;
    if (picture != (j->run.code == 0))
        return picture ? "failed, but left a picture" : "succeeded without a picture";
    return picture && info.st_size == 0 ? "left an empty picture" : NULL;
}

static void start_info(job *j, const char *said_path)
{
    program_start(&j->run, said_path, (const char *const[]){"kandil", "info", files[j->file], NULL},
                  PROGRAM_LIMIT_S);
}

/* ---- all files, a few at a time ---- */

static bool finish(const task *t, job *j)
{
    const char *wrong = t->judge(j);
    if (wrong)
        print_error("%s: %s (code %d):\n%s\n", files[j->file] + sizeof HOSTILE, wrong, j->run.code,
                    j->run.said);
    return !wrong;
}

static void over_all_files(const task *t)
{
    static job jobs[PARALLEL];
    size_t next = 0, running = 0, bad = 0;
    memset(jobs, 0, sizeof jobs);
    while ((next < file_count && bad < MAX_REPORT) || running > 0) {
        for (size_t i = 0; i < PARALLEL; i++) {
            char said_path[96];
            job *j = &jobs[i];
            if (j->run.pid > 0 && program_poll(&j->run)) {
                running--;
                bad += !finish(t, j);
            }
            if (j->run.pid > 0 || next == file_count || bad >= MAX_REPORT)
                continue;
            j->file = next++;
            snprintf(said_path, sizeof said_path, "%s/%zu", folder, i);
            t->start(j, said_path);
            assert_true(j->run.pid > 0);
            running++;
        }
        nanosleep(&(struct timespec){.tv_nsec = 2000000}, NULL);
    }
    if (bad > 0)
        fail_msg("%zu of %zu files", bad, next);
}

static void every_file_gives_a_picture_or_one_message(void **state)
{
    (void)state;
    over_all_files(&(task){start_run, judge_run});
}

static void every_file_is_described_or_refused(void **state)
{
    (void)state;
    over_all_files(&(task){start_info, judge_end});
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_file_is_described_or_refused),
        cmocka_unit_test(every_file_gives_a_picture_or_one_message),
    };
    if (access(HOSTILE, R_OK) != 0) {
        puts("skipped: the hostile collection " HOSTILE " is not there");
        return 77;
    }
    if (access(PROGRAM_PATH, X_OK) != 0) {
        puts("skipped: " PROGRAM_PATH " was not built");
        return 77;
    }
    return cmocka_run_group_tests(tests, open_folder, close_folder);
}
