/* `kandil voxelize`, `kandil info` and `kandil run --voxels` as a user meets them. */

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include <dirent.h>
#include <sys/stat.h>

#include "runtime/asset/voxel_file.h"
#include "tests/program_fixture.h"

#define MODEL KD_SOURCE_DIR "/samples/assets/cornell.gltf"

static char folder[64], made[96], other[96], said[96];

static int open_folder(void **state)
{
    (void)state;
    strcpy(folder, "/tmp/kandil-voxelize-XXXXXX");
    if (!mkdtemp(folder))
        return -1;
    snprintf(made, sizeof made, "%s/made.kvox", folder);
    snprintf(other, sizeof other, "%s/other.kvox", folder);
    snprintf(said, sizeof said, "%s/said", folder);
    return 0;
}

static int close_folder(void **state)
{
    (void)state;
    unlink(made);
    unlink(other);
    return rmdir(folder); /* which fails when something was left behind */
}

static program run_program(const char *const *argv)
{
    program p;
    assert_true(program_start(&p, said, argv, 6 * PROGRAM_LIMIT_S));
    program_wait(&p);
    assert_false(p.timed_out);
    return p;
}

#define RUN(...) run_program((const char *const[]){"kandil", __VA_ARGS__, NULL})

static uint32_t files_in_folder(void)
{
    DIR *d = opendir(folder);
    uint32_t count = 0;
    for (const struct dirent *e; (e = readdir(d));)
        count += strcmp(e->d_name, ".") != 0 && strcmp(e->d_name, "..") != 0;
    closedir(d);
    return count;
}

static void voxelize_writes_what_info_lists_and_run_takes(void **state)
{
    (void)state;
    kd_voxel_file file;
    char why[KD_VOXEL_WHY];
    assert_int_equal(RUN("voxelize", MODEL, "-o", made, "--cascades", "2", "--quiet").code, 0);
    assert_int_equal(kd_voxel_file_open(&file, made, why), KD_OK);
    assert_true(file.level_count >= 2 && file.level_count % 2 == 0);
    float least = file.levels[0].span, most = least;
    for (uint32_t i = 0; i < file.level_count; i++) {
        least = file.levels[i].span < least ? file.levels[i].span : least;
        most = file.levels[i].span > most ? file.levels[i].span : most;
        assert_true(file.levels[i].voxel_count > 0);
    }
    assert_true(most > 1.9f * least);
    kd_voxel_file_close(&file);
    assert_int_equal(RUN("info", made).code, 0);
    program p = RUN("run", MODEL, "--voxels", made, "--frames", "1", "--size", "32x32", "--quiet");
    assert_int_equal(p.code, 0);
    assert_int_equal(files_in_folder(), 1);
}

static void options_change_what_is_voxelized(void **state)
{
    (void)state;
    uint64_t voxels[3];
    static const uint32_t flags[3] = {0, KD_VOXEL_LEVEL_THIN, KD_VOXEL_LEVEL_THIN | KD_VOXEL_LEVEL_FILLED};
    const char *extra[3][2] = {{"--separating", "26"}, {"--separating", "6"}, {"--fill", "--quiet"}};
    for (int i = 0; i < 3; i++) {
        kd_voxel_file file;
        char why[KD_VOXEL_WHY];
        assert_int_equal(RUN("voxelize", MODEL, "-o", made, "--cascades", "1", "--resolution", "48",
                             "--quiet", extra[i][0], extra[i][1])
                             .code,
                         0);
        assert_int_equal(kd_voxel_file_open(&file, made, why), KD_OK);
        voxels[i] = 0;
        assert_int_equal(file.levels[0].flags, flags[i]);
        for (uint32_t n = 0; n < file.level_count; n++)
            voxels[i] += file.levels[n].voxel_count;
        kd_voxel_file_close(&file);
    }
    assert_true(voxels[1] <= voxels[0]); /* thin is a part of what is touched: of boxes, all of it */
    assert_true(voxels[2] >= voxels[1]);
}

static void file_that_does_not_serve_is_refused_with_one_message(void **state)
{
    (void)state;
    assert_int_equal(RUN("voxelize", MODEL, "-o", made, "--cascades", "1", "--quiet").code, 0);
    assert_int_equal(RUN("voxelize", MODEL, "-o", other, "--cascades", "1", "--span", "0.3", "--quiet").code,
                     0);
    program p = RUN("run", MODEL, "--voxels", other, "--frames", "1", "--size", "32x32");
    assert_int_equal(p.code, 1);
    assert_true(program_said_one_line(&p, "stale"));
    assert_int_equal(truncate(made, 200), 0);
    const char *const commands[2][4] = {{"info", made, "--", NULL}, {"run", MODEL, "--voxels", made}};
    for (int i = 0; i < 2; i++) {
        p = RUN(commands[i][0], commands[i][1], commands[i][2], commands[i][3]);
        assert_int_equal(p.code, 1);
        assert_true(program_said_one_line(&p, "cut short"));
    }
    FILE *f = fopen(made, "wb");
    fputs("glTF, not voxels at all, and long enough for a header of either", f);
    fclose(f);
    p = RUN("info", made);
    assert_int_equal(p.code, 1);
    assert_true(program_said_one_line(&p, "no .kvox file"));
}

static void wrong_command_lines_are_told(void **state)
{
    (void)state;
    program p = RUN("voxelize", MODEL);
    assert_int_equal(p.code, 2);
    assert_true(program_said_one_line(&p, "-o FILE.kvox"));
    p = RUN("voxelize", MODEL, "-o", "voxels.bin");
    assert_int_equal(p.code, 2);
    assert_true(program_said_one_line(&p, "voxels.bin"));
    p = RUN("voxelize", MODEL, "-o", made, "--separating", "18");
    assert_int_equal(p.code, 2);
    assert_true(program_said_one_line(&p, "--separating"));
    p = RUN("voxelize", MODEL, "-o", "/nowhere/at/all.kvox");
    assert_int_equal(p.code, 1);
    assert_true(program_said_one_line(&p, "/nowhere/at/all.kvox"));
}

static void interrupted_voxelize_leaves_nothing(void **state)
{
    (void)state;
    program p;
    const char *const argv[] = {"kandil",       "voxelize", MODEL,        "-o", made,
                                "--resolution", "900",      "--cascades", "4",  NULL};
    assert_true(program_start(&p, said, argv, 6 * PROGRAM_LIMIT_S));
    for (int i = 0; i < 6000 && !program_poll(&p); i++) { /* until it has said that it works, then end it */
        nanosleep(&(struct timespec){.tv_nsec = 5000000}, NULL);
        struct stat info;
        if (stat(said, &info) == 0 && info.st_size > 0) {
            kill(p.pid, SIGINT);
            break;
        }
    }
    if (p.pid)
        program_wait(&p);
    assert_false(p.timed_out);
    assert_true(p.code == 130 || p.code == 0); /* it may have been done already */
    assert_int_equal(files_in_folder(), p.code == 0 ? 1 : 0);
}

int main(void)
{
#define IN_FOLDER(name) cmocka_unit_test_setup_teardown(name, open_folder, close_folder)
    const struct CMUnitTest tests[] = {
        IN_FOLDER(voxelize_writes_what_info_lists_and_run_takes),
        IN_FOLDER(options_change_what_is_voxelized),
        IN_FOLDER(file_that_does_not_serve_is_refused_with_one_message),
        IN_FOLDER(wrong_command_lines_are_told),
        IN_FOLDER(interrupted_voxelize_leaves_nothing),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
