/* GLFW under an X server that the test starts itself, so that no screen is needed and none is disturbed. */

#include <dlfcn.h>

#include "context_use.h"
#include "runtime/gpu/internal.h"
#include "tests/xvfb_fixture.h"

static void hidden_window_is_used(void **state)
{
    (void)state;
    for (int i = 0; i < 2; i++) {
        kd_gpu *gpu = context_open(KD_CONTEXT_GLFW, false);
        if (!gpu)
            fail_msg("%s", fixture_text);
        assert_string_equal(kd_gpu_get_info(gpu)->api, "glfw");
        context_use(gpu);
        kd_gpu_close(gpu);
    }
}

static void window_shows_a_texture_with_row_zero_on_top(void **state)
{
    enum { SIDE = 16 };
    uint8_t texels[SIDE * SIDE][4], pixel[4] = {0};
    uint32_t width = 0, height = 0;
    (void)state;
    kd_gpu *gpu = context_open(KD_CONTEXT_AUTO, true);
    if (!gpu)
        fail_msg("%s", fixture_text);
    assert_string_equal(kd_gpu_get_info(gpu)->api, "glfw");
    assert_non_null(kd_gpu_window_native(gpu));
    assert_false(kd_gpu_window_should_close(gpu));
    kd_gpu_window_size(gpu, &width, &height);
    assert_int_equal(width, 64);
    assert_int_equal(height, 48);
    for (int i = 0; i < SIDE * SIDE; i++)
        memcpy(texels[i], i < SIDE ? (uint8_t[4]){255, 0, 0, 255} : (uint8_t[4]){0, 0, 255, 255}, 4);
    kd_gpu_texture texture = kd_gpu_make_texture(
        gpu, &(kd_gpu_texture_desc){.format = KD_RGBA8, .width = SIDE, .height = SIDE, .data = texels});
    kd_gpu_begin_raster(gpu, &(kd_gpu_raster){.clear_color = true, .color = {0, 1, 0, 1}});
    kd_gpu_blit_to_window(gpu, texture, width, height);
    /* GL counts a window's rows from the bottom: the texture's first row is its topmost. */
    PFNGLREADPIXELSPROC read_pixels;
    gl_function function = gpu->context.lookup("glReadPixels");
    memcpy(&read_pixels, &function, sizeof read_pixels);
    gpu->gl.BindFramebuffer(GL_FRAMEBUFFER, 0);
    read_pixels(32, 47, 1, 1, GL_RGBA, GL_UNSIGNED_BYTE, pixel);
    assert_int_equal(pixel[0], 255);
    read_pixels(32, 0, 1, 1, GL_RGBA, GL_UNSIGNED_BYTE, pixel);
    assert_int_equal(pixel[0], 0);
    assert_int_equal(pixel[2], 255);
    kd_gpu_window_present(gpu);
    fixture_assert_clean(gpu);
    kd_gpu_close(gpu);
}

static void window_without_a_display_is_refused_with_a_reason(void **state)
{
    char *display = strdup(getenv("DISPLAY"));
    (void)state;
    assert_int_equal(unsetenv("DISPLAY"), 0);
    assert_null(context_open(KD_CONTEXT_GLFW, true));
    assert_true(fixture_logged("DISPLAY is not set"));
    assert_int_equal(setenv("DISPLAY", display, 1), 0);
    free(display);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        CONTEXT_TEST(hidden_window_is_used),
        CONTEXT_TEST(window_shows_a_texture_with_row_zero_on_top),
        CONTEXT_TEST(window_without_a_display_is_refused_with_a_reason),
    };
    if (!dlopen("libglfw.so.3", RTLD_NOW)) {
        fprintf(stderr, "skipped: libglfw.so.3 is missing\n");
        return FIXTURE_SKIP;
    }
    if (!xvfb_start("640x480x24")) {
        xvfb_stop();
        fprintf(stderr, "skipped: Xvfb is missing or does not start\n");
        return FIXTURE_SKIP;
    }
    int failures = cmocka_run_group_tests(tests, NULL, NULL);
    xvfb_stop();
    return failures;
}
