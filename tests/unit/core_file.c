#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include <dirent.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>

#include "runtime/core/file.h"
#include "runtime/core/log.h"

static char folder[64];
static int messages;

static void count_message(void *user, kd_log_level level, const char *text)
{
    (void)user;
    (void)level;
    (void)text;
    messages++;
}

static int make_folder(void **state)
{
    (void)state;
    strcpy(folder, "/tmp/kandil_file_XXXXXX");
    messages = 0;
    kd_log_set_sink(count_message, NULL);
    return mkdtemp(folder) ? 0 : -1;
}

static int remove_folder(void **state)
{
    (void)state;
    char command[128];
    snprintf(command, sizeof command, "rm -rf '%s'", folder);
    return system(command);
}

static const char *in_folder(const char *name)
{
    static char paths[4][256];
    static int next;
    char *path = paths[next++ % 4];
    snprintf(path, sizeof paths[0], "%s/%s", folder, name);
    return path;
}

static int entries_in_folder(void)
{
    int count = 0;
    DIR *dir = opendir(folder);
    for (struct dirent *e; (e = readdir(dir)) != NULL;)
        count += strcmp(e->d_name, ".") != 0 && strcmp(e->d_name, "..") != 0;
    closedir(dir);
    return count;
}

static void assert_content(const char *path, const char *expected)
{
    void *data;
    size_t size;
    assert_int_equal(kd_file_read(path, KD_FILE_NO_LIMIT, &data, &size), KD_OK);
    assert_int_equal(size, strlen(expected));
    assert_string_equal(data, expected);
    free(data);
}

static void write_then_read_gives_the_same(void **state)
{
    (void)state;
    assert_int_equal(kd_file_write(in_folder("a"), "hello", 5), KD_OK);
    assert_content(in_folder("a"), "hello");
    assert_int_equal(kd_file_write(in_folder("a"), "", 0), KD_OK);
    assert_content(in_folder("a"), "");
    assert_int_equal(entries_in_folder(), 1);
    assert_int_equal(messages, 0);
}

static void read_says_why_it_failed(void **state)
{
    (void)state;
    void *data = &messages;
    size_t size = 7;
    assert_int_equal(kd_file_read(in_folder("none"), 10, &data, &size), KD_NOT_FOUND);
    assert_null(data);
    assert_int_equal(size, 0);
    assert_int_equal(kd_file_read(folder, 10, &data, &size), KD_UNSUPPORTED);
    assert_int_equal(kd_file_read(in_folder("none/deeper"), 10, &data, &size), KD_NOT_FOUND);
    assert_int_equal(kd_file_write(in_folder("a"), "12345", 5), KD_OK);
    assert_int_equal(kd_file_read(in_folder("a"), 4, &data, &size), KD_TOO_LARGE);
    assert_int_equal(kd_file_read(in_folder("a/b"), 4, &data, &size), KD_NOT_FOUND);
    assert_int_equal(messages, 5);
    assert_int_equal(kd_file_read(in_folder("a"), 5, &data, &size), KD_OK);
    free(data);
}

static void read_of_a_pipe_does_not_wait(void **state)
{
    (void)state;
    void *data;
    size_t size;
    assert_int_equal(mkfifo(in_folder("pipe"), 0600), 0);
    assert_int_equal(kd_file_read(in_folder("pipe"), 10, &data, &size), KD_UNSUPPORTED);
    assert_false(kd_file_exists(in_folder("pipe")));
}

static void read_without_permission_is_refused(void **state)
{
    (void)state;
    if (geteuid() == 0)
        skip(); /* nothing is forbidden to root */
    void *data;
    size_t size;
    assert_int_equal(kd_file_write(in_folder("a"), "x", 1), KD_OK);
    assert_int_equal(chmod(in_folder("a"), 0), 0);
    assert_int_equal(kd_file_read(in_folder("a"), 10, &data, &size), KD_NO_PERMISSION);
}

static void cancelled_write_leaves_the_old_file(void **state)
{
    (void)state;
    kd_file_out out;
    assert_int_equal(kd_file_write(in_folder("a"), "old", 3), KD_OK);
    assert_int_equal(kd_file_out_open(&out, in_folder("a")), KD_OK);
    fputs("new and longer", out.stream);
    fflush(out.stream);
    assert_content(in_folder("a"), "old");
    kd_file_out_cancel(&out);
    kd_file_out_cancel(&out);
    assert_content(in_folder("a"), "old");
    assert_int_equal(entries_in_folder(), 1);
}

static void open_for_writing_says_why_it_failed(void **state)
{
    (void)state;
    kd_file_out out;
    assert_int_equal(kd_file_out_open(&out, folder), KD_UNSUPPORTED);
    assert_int_equal(kd_file_out_open(&out, in_folder("none/a")), KD_NOT_FOUND);
    assert_int_equal(kd_file_out_open(&out, ""), KD_NOT_FOUND);
    assert_int_equal(messages, 3);
    kd_file_out_cancel(&out);
    assert_int_equal(entries_in_folder(), 0);
}

static void full_disk_is_reported(void **state)
{
    (void)state;
    static char data[1 << 20];
    assert_int_equal(kd_file_write("/dev/full", data, sizeof data), KD_DISK_FULL);
    assert_int_equal(kd_file_write("/dev/full", "x", 1), KD_DISK_FULL); /* noticed at the flush */
    assert_int_equal(kd_file_write("/dev/null", "x", 1), KD_OK);
    assert_int_equal(messages, 2);
}

/* A limit on file size stands for a disk that fills in mid-file. */
static void write_that_runs_out_of_space_leaves_nothing(void **state)
{
    (void)state;
    static char data[1 << 16];
    struct rlimit before, small;
    assert_int_equal(getrlimit(RLIMIT_FSIZE, &before), 0);
    signal(SIGXFSZ, SIG_IGN);
    assert_int_equal(kd_file_write(in_folder("a"), "old", 3), KD_OK);
    small = before;
    small.rlim_cur = 5000;
    assert_int_equal(setrlimit(RLIMIT_FSIZE, &small), 0);
    kd_status status = kd_file_write(in_folder("a"), data, sizeof data);
    kd_file_out out;
    kd_status opened = kd_file_out_open(&out, in_folder("b"));
    for (int i = 0; i < 64 && opened == KD_OK; i++)
        fwrite(data, 1, 1024, out.stream); /* errors are seen by the commit */
    kd_status committed = kd_file_out_commit(&out);
    setrlimit(RLIMIT_FSIZE, &before);
    assert_int_equal(status, KD_DISK_FULL);
    assert_int_equal(committed, KD_DISK_FULL);
    assert_content(in_folder("a"), "old");
    assert_int_equal(entries_in_folder(), 1);
}

static void write_through_a_link_keeps_the_link_and_the_mode(void **state)
{
    (void)state;
    struct stat info;
    assert_int_equal(kd_file_write(in_folder("target"), "old", 3), KD_OK);
    assert_int_equal(chmod(in_folder("target"), 0640), 0);
    assert_int_equal(symlink("target", in_folder("link")), 0);
    assert_int_equal(kd_file_write(in_folder("link"), "new", 3), KD_OK);
    assert_content(in_folder("target"), "new");
    assert_int_equal(lstat(in_folder("link"), &info), 0);
    assert_true(S_ISLNK(info.st_mode));
    assert_int_equal(stat(in_folder("target"), &info), 0);
    assert_int_equal(info.st_mode & 07777, 0640);
}

static void folder_make_makes_all_levels(void **state)
{
    (void)state;
    assert_int_equal(kd_folder_make(in_folder("x/y//z/")), KD_OK);
    assert_int_equal(kd_folder_make(in_folder("x/y/z")), KD_OK);
    assert_int_equal(kd_file_write(in_folder("x/y/z/f"), "1", 1), KD_OK);
    assert_int_not_equal(kd_folder_make(in_folder("x/y/z/f/g")), KD_OK);
}

static void path_parts_are_found(void **state)
{
    (void)state;
    static const char *const folders[][2] = {{"a/b.c", "a"}, {"b.c", "."}, {"/b", "/"},
                                             {"a//b", "a"},  {"a/", "a"},  {"//b", "/"}};
    static const char *const extensions[][2] = {
        {"a/b.tar.gz", ".gz"}, {"a.d/b", ""}, {".hidden", ""}, {"x.PNG", ".PNG"}};
    char out[32];
    for (size_t i = 0; i < sizeof folders / sizeof folders[0]; i++) {
        assert_int_equal(kd_path_folder(out, sizeof out, folders[i][0]), KD_OK);
        assert_string_equal(out, folders[i][1]);
    }
    for (size_t i = 0; i < sizeof extensions / sizeof extensions[0]; i++)
        assert_string_equal(kd_path_extension(extensions[i][0]), extensions[i][1]);
    assert_true(kd_path_has_extension("x.PNG", ".png"));
    assert_false(kd_path_has_extension("xpng", ".png"));
    assert_string_equal(kd_path_name("a/b.c"), "b.c");
}

static void path_join_fits_exactly_or_fails(void **state)
{
    (void)state;
    char out[6];
    assert_int_equal(kd_path_join(out, sizeof out, "ab", "cd"), KD_OK); /* 5 bytes and the NUL */
    assert_string_equal(out, "ab/cd");
    assert_int_equal(kd_path_join(out, sizeof out, "ab/", "cd"), KD_OK);
    assert_string_equal(out, "ab/cd");
    assert_int_equal(kd_path_join(out, sizeof out, "ab", "/cd"), KD_OK);
    assert_string_equal(out, "/cd");
    assert_int_equal(kd_path_join(out, sizeof out, ".", "cd"), KD_OK);
    assert_string_equal(out, "cd");
    assert_int_equal(kd_path_join(out, sizeof out, ".", ""), KD_OK);
    assert_string_equal(out, ".");
    assert_int_equal(kd_path_join(out, sizeof out, "ab", "cde"), KD_OUT_OF_RANGE);
    assert_string_equal(out, "");
}

static void is_below_resolves_links_and_dots(void **state)
{
    (void)state;
    assert_int_equal(kd_folder_make(in_folder("top/in")), KD_OK);
    assert_int_equal(kd_folder_make(in_folder("topple")), KD_OK);
    assert_int_equal(symlink("../topple", in_folder("top/out")), 0);
    assert_int_equal(symlink("in", in_folder("top/inner")), 0);
    const char *top = "top";
    char base[256];
    snprintf(base, sizeof base, "%s/%s", folder, top);
    assert_true(kd_path_is_below(base, base));
    assert_true(kd_path_is_below(base, in_folder("top/in")));
    assert_true(kd_path_is_below(base, in_folder("top/inner/new.png")));
    assert_true(kd_path_is_below(base, in_folder("top/none/deep/new.png")));
    assert_true(kd_path_is_below("/", in_folder("top")));
    assert_false(kd_path_is_below(base, in_folder("topple")));
    assert_false(kd_path_is_below(base, in_folder("top/out")));
    assert_false(kd_path_is_below(base, in_folder("top/out/new.png")));
    assert_false(kd_path_is_below(base, in_folder("top/../topple")));
    assert_false(kd_path_is_below(base, in_folder("top/none/../../topple/x")));
    assert_false(kd_path_is_below(base, "/etc/passwd"));
    assert_false(kd_path_is_below(in_folder("nowhere"), in_folder("nowhere/x")));
}

#define CASE(test) cmocka_unit_test_setup_teardown(test, make_folder, remove_folder)
int main(void)
{
    const struct CMUnitTest tests[] = {
        CASE(write_then_read_gives_the_same),
        CASE(read_says_why_it_failed),
        CASE(read_of_a_pipe_does_not_wait),
        CASE(read_without_permission_is_refused),
        CASE(cancelled_write_leaves_the_old_file),
        CASE(open_for_writing_says_why_it_failed),
        CASE(full_disk_is_reported),
        CASE(write_that_runs_out_of_space_leaves_nothing),
        CASE(write_through_a_link_keeps_the_link_and_the_mode),
        CASE(folder_make_makes_all_levels),
        CASE(path_parts_are_found),
        CASE(path_join_fits_exactly_or_fails),
        CASE(is_below_resolves_links_and_dots),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
