/* What GL itself objects to must be noticed, with debug output and without. */

#include "runtime/gpu/internal.h"
#include "tests/gpu_fixture.h"

static void provoke(bool debug)
{
    kd_gpu *gpu = NULL;
    assert_int_equal(kd_gpu_open(&(kd_gpu_desc){.debug = debug}, &gpu), KD_OK);
    kd_gpu_end_frame(gpu);
    assert_false(kd_gpu_failed(gpu));
    gpu->gl.Enable(0x1234); /* no such capability */
    kd_gpu_end_frame(gpu);
    assert_true(kd_gpu_failed(gpu));
    assert_true(fixture_logged("OpenGL"));
    kd_gpu_close(gpu);
}

static void error_is_noticed_with_debug_output(void **state)
{
    (void)state;
    fixture_text[0] = '\0';
    provoke(true);
}

static void error_is_noticed_without_debug_output(void **state)
{
    (void)state;
    fixture_text[0] = '\0';
    provoke(false);
}

static void repeated_complaints_end(void **state)
{
    kd_gpu *gpu = *state;
    size_t length = 0;
    for (int i = 0; i < 100; i++) {
        kd_gpu_dispatch(gpu, (kd_gpu_program){0}, 1, 1, 1);
        if (i == GPU_MAX_COMPLAINTS)
            length = strlen(fixture_text);
    }
    assert_int_equal(strlen(fixture_text), length);
    assert_true(fixture_logged("further GPU errors are not shown"));
}

static void offsets_that_are_not_aligned_are_named(void **state)
{
    kd_gpu *gpu = *state;
    kd_gpu_buffer buffer = kd_gpu_make_buffer(gpu, &(kd_gpu_buffer_desc){.size = 1024, .name = "rows"});
    kd_gpu_bind_storage_range(gpu, 0, buffer, 1, 64);
    assert_true(fixture_logged("bind_storage: offset 1 into rows is no multiple"));
    kd_gpu_bind_uniform_buffer(gpu, 0, buffer, 1, 64);
    assert_true(fixture_logged("bind_uniform_buffer: offset 1 into rows is no multiple"));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        FIXTURE_TEST(error_is_noticed_with_debug_output),
        FIXTURE_TEST(error_is_noticed_without_debug_output),
        FIXTURE_TEST(repeated_complaints_end),
        FIXTURE_TEST(offsets_that_are_not_aligned_are_named),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
