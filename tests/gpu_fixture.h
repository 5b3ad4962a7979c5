#ifndef KD_TESTS_GPU_FIXTURE_H
#define KD_TESTS_GPU_FIXTURE_H

/* For tests of the GPU layer: a folder of shaders that the test writes itself, a device with debug output on,
 * and what was logged. Includes cmocka with what it needs. */

#include <setjmp.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cmocka.h>

#include "runtime/core/log.h"
#include "runtime/gpu/gpu.h"

enum { FIXTURE_MAX_FILES = 32, FIXTURE_SKIP = 77 };

static char fixture_folder[64];
static char fixture_files[FIXTURE_MAX_FILES][160];
static int fixture_file_count;
static char fixture_text[16384]; /* what was logged */

static inline void fixture_log(void *user, kd_log_level level, const char *text)
{
    size_t used = strlen(fixture_text);
    (void)user;
    if (level >= KD_LOG_WARNING)
        snprintf(fixture_text + used, sizeof fixture_text - used, "%s\n", text);
}

static inline bool fixture_logged(const char *text)
{
    return strstr(fixture_text, text) != NULL;
}

/* Write a file of shaders/t/ below the folder. */
static inline void fixture_write(const char *name, const char *text)
{
    char *path = fixture_files[fixture_file_count];
    assert_true(fixture_file_count < FIXTURE_MAX_FILES);
    snprintf(path, sizeof fixture_files[0], "%s/shaders/t/%s", fixture_folder, name);
    FILE *file = fopen(path, "wb");
    assert_non_null(file);
    assert_true(fputs(text, file) >= 0);
    assert_int_equal(fclose(file), 0);
    fixture_file_count++;
}

static inline void fixture_init(void)
{
    char path[128];
    fixture_file_count = 0;
    fixture_text[0] = '\0';
    snprintf(fixture_folder, sizeof fixture_folder, "/tmp/kandil_shaders_XXXXXX");
    assert_non_null(mkdtemp(fixture_folder));
    snprintf(path, sizeof path, "%s/shaders", fixture_folder);
    assert_int_equal(mkdir(path, 0700), 0);
    snprintf(path, sizeof path, "%s/shaders/t", fixture_folder);
    assert_int_equal(mkdir(path, 0700), 0);
    assert_int_equal(setenv("KANDIL_SHADER_DIR", fixture_folder, 1), 0);
    kd_log_set_sink(fixture_log, NULL);
}

static inline void fixture_fini(void)
{
    char path[128];
    for (int i = 0; i < fixture_file_count; i++)
        unlink(fixture_files[i]);
    snprintf(path, sizeof path, "%s/shaders/t", fixture_folder);
    rmdir(path);
    snprintf(path, sizeof path, "%s/shaders", fixture_folder);
    rmdir(path);
    rmdir(fixture_folder);
    kd_log_set_sink(NULL, NULL);
}

static inline int fixture_setup(void **state)
{
    kd_gpu *gpu = NULL;
    fixture_init();
    if (kd_gpu_open(&(kd_gpu_desc){.debug = true}, &gpu) != KD_OK) {
        fprintf(stderr, "skipped: %s", fixture_text);
        fixture_fini();
        exit(FIXTURE_SKIP);
    }
    *state = gpu;
    return 0;
}

static inline int fixture_teardown(void **state)
{
    kd_gpu_close(*state);
    fixture_fini();
    return 0;
}

/* Tests in which nothing may fail end with this. */
static inline void fixture_assert_clean(kd_gpu *gpu)
{
    kd_gpu_end_frame(gpu);
    if (kd_gpu_failed(gpu))
        fail_msg("the device failed: %s", fixture_text);
}

#define FIXTURE_TEST(name) cmocka_unit_test_setup_teardown(name, fixture_setup, fixture_teardown)

#endif
