#include <dlfcn.h>
#include <pthread.h>

#include "context_use.h"

/* Open, use and close one way twice, so that what the first left behind would show. */
static void use_twice(kd_context_api api, const char *name)
{
    for (int i = 0; i < 2; i++) {
        kd_gpu *gpu = context_open(api, false);
        if (!gpu)
            fail_msg("%s", fixture_text);
        assert_string_equal(kd_gpu_get_info(gpu)->api, name);
        context_use(gpu);
        kd_gpu_close(gpu);
    }
}

static void surfaceless_context_is_used(void **state)
{
    (void)state;
    use_twice(KD_CONTEXT_EGL_SURFACELESS, "egl-surfaceless");
}

static void software_device_is_used(void **state)
{
    (void)state;
    use_twice(KD_CONTEXT_EGL_SOFTWARE, "egl-software");
}

static void hardware_device_is_used_or_refused_with_a_reason(void **state)
{
    (void)state;
    kd_gpu *gpu = context_open(KD_CONTEXT_EGL_DEVICE, false);
    if (!gpu) {
        assert_true(fixture_logged("egl-device: "));
        return;
    }
    assert_false(kd_gpu_get_info(gpu)->software);
    context_use(gpu);
    kd_gpu_close(gpu);
}

static void any_egl_context_is_found(void **state)
{
    const kd_context_api ways[] = {KD_CONTEXT_EGL, KD_CONTEXT_AUTO};
    (void)state;
    for (int i = 0; i < 2; i++) {
        kd_gpu *gpu = context_open(ways[i], false);
        assert_non_null(gpu);
        assert_memory_equal(kd_gpu_get_info(gpu)->api, "egl-", 4);
        context_compute(gpu);
        kd_gpu_close(gpu);
    }
}

static void two_contexts_live_side_by_side(void **state)
{
    (void)state;
    kd_gpu *first = context_open(KD_CONTEXT_EGL_SURFACELESS, false);
    kd_gpu *second = context_open(KD_CONTEXT_EGL_SURFACELESS, false);
    assert_non_null(first);
    assert_non_null(second);
    kd_gpu_buffer buffer =
        kd_gpu_make_buffer(second, &(kd_gpu_buffer_desc){.size = 4, .data = &(uint32_t){6}});
    kd_gpu_make_buffer(first, &(kd_gpu_buffer_desc){.size = 4});
    kd_gpu_close(first); /* must end neither the display that the second uses, nor its objects */
    assert_true(kd_gpu_make_current(second, true));
    uint32_t word = 0;
    kd_gpu_read_buffer(second, buffer, 0, &word, 4);
    assert_int_equal(word, 6);
    context_use(second);
    kd_gpu_close(second);
}

static void *use_elsewhere(void *gpu)
{
    assert_true(kd_gpu_make_current(gpu, true));
    context_use(gpu);
    assert_true(kd_gpu_make_current(gpu, false));
    return NULL;
}

static void context_moves_to_another_thread(void **state)
{
    pthread_t thread;
    (void)state;
    kd_gpu *gpu = context_open(KD_CONTEXT_EGL_SURFACELESS, false);
    assert_true(kd_gpu_make_current(gpu, false));
    assert_int_equal(pthread_create(&thread, NULL, use_elsewhere, gpu), 0);
    assert_int_equal(pthread_join(thread, NULL), 0);
    kd_gpu_close(gpu);
}

static void window_needs_glfw(void **state)
{
    (void)state;
    assert_null(context_open(KD_CONTEXT_EGL, true));
    assert_true(fixture_logged("a window needs a GLFW context, not egl"));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        CONTEXT_TEST(surfaceless_context_is_used),
        CONTEXT_TEST(software_device_is_used),
        CONTEXT_TEST(hardware_device_is_used_or_refused_with_a_reason),
        CONTEXT_TEST(any_egl_context_is_found),
        CONTEXT_TEST(two_contexts_live_side_by_side),
        CONTEXT_TEST(context_moves_to_another_thread),
        CONTEXT_TEST(window_needs_glfw),
    };
    if (!dlopen("libEGL.so.1", RTLD_NOW)) {
        fprintf(stderr, "skipped: libEGL.so.1 is missing\n");
        return FIXTURE_SKIP;
    }
    return cmocka_run_group_tests(tests, NULL, NULL);
}
