#include "tests/gpu_fixture.h"

static kd_gpu_buffer make_word(kd_gpu *gpu, uint32_t word)
{
    return kd_gpu_make_buffer(gpu, &(kd_gpu_buffer_desc){.size = 4, .data = &word});
}

static void readback_arrives_some_frames_later_without_waiting(void **state)
{
    enum { FRAMES = 12 };
    uint64_t next = 0;
    kd_gpu *gpu = *state;
    kd_gpu_buffer buffer = make_word(gpu, 0);
    kd_gpu_readback ring = kd_gpu_make_readback(gpu, 4, 4, "words");
    for (uint32_t frame = 0; frame < FRAMES; frame++) {
        uint64_t tag = 0;
        size_t size = 0;
        kd_gpu_fill_buffer(gpu, buffer, 0, 4, 100 + frame);
        assert_int_equal(kd_gpu_readback_buffer(gpu, ring, buffer, 0, 4, frame), KD_OK);
        kd_gpu_end_frame(gpu);
        /* Let the driver catch up once two frames are behind, as a frame's other work would. */
        if (frame >= 2)
            usleep(2000);
        for (const uint32_t *word;
             (word = kd_gpu_readback_poll(gpu, ring, frame == FRAMES - 1, &tag, &size));) {
            assert_int_equal(tag, next);
            assert_int_equal(size, 4);
            assert_int_equal(*word, 100 + next);
            next++;
        }
    }
    assert_int_equal(next, FRAMES);
    fixture_assert_clean(gpu);
}

static void readback_that_is_full_says_so(void **state)
{
    uint64_t tag;
    kd_gpu *gpu = *state;
    kd_gpu_buffer buffer = make_word(gpu, 5);
    kd_gpu_readback ring = kd_gpu_make_readback(gpu, 4, 2, "small");
    assert_int_equal(kd_gpu_readback_buffer(gpu, ring, buffer, 0, 4, 1), KD_OK);
    assert_int_equal(kd_gpu_readback_buffer(gpu, ring, buffer, 0, 4, 2), KD_OK);
    assert_int_equal(kd_gpu_readback_buffer(gpu, ring, buffer, 0, 4, 3), KD_OUT_OF_RANGE);
    const uint32_t *held = kd_gpu_readback_poll(gpu, ring, true, &tag, NULL);
    assert_int_equal(tag, 1);
    /* The area that is lent out is not overwritten: it counts until the next poll. */
    assert_int_equal(kd_gpu_readback_buffer(gpu, ring, buffer, 0, 4, 3), KD_OUT_OF_RANGE);
    assert_int_equal(*held, 5);
    assert_non_null(kd_gpu_readback_poll(gpu, ring, true, &tag, NULL));
    assert_int_equal(tag, 2);
    assert_int_equal(kd_gpu_readback_buffer(gpu, ring, buffer, 0, 4, 3), KD_OK);
    assert_non_null(kd_gpu_readback_poll(gpu, ring, true, &tag, NULL));
    assert_int_equal(tag, 3);
    assert_null(kd_gpu_readback_poll(gpu, ring, true, &tag, NULL));
    fixture_assert_clean(gpu);
}

static void readback_takes_textures(void **state)
{
    const uint8_t texels[2][3][4] = {{{1, 2, 3, 4}, {5, 6, 7, 8}, {9, 10, 11, 12}},
                                     {{13, 14, 15, 16}, {17, 18, 19, 20}, {21, 22, 23, 24}}};
    uint64_t tag = 0;
    size_t size = 0;
    kd_gpu *gpu = *state;
    kd_gpu_texture texture = kd_gpu_make_texture(
        gpu, &(kd_gpu_texture_desc){.format = KD_RGBA8, .width = 3, .height = 2, .data = texels});
    kd_gpu_readback ring = kd_gpu_make_readback(gpu, sizeof texels, 0, "picture");
    assert_int_equal(kd_gpu_readback_texture(gpu, ring, texture, 0, 77), KD_OK);
    const void *pixels = kd_gpu_readback_poll(gpu, ring, true, &tag, &size);
    assert_non_null(pixels);
    assert_int_equal(tag, 77);
    assert_int_equal(size, sizeof texels);
    assert_memory_equal(pixels, texels, sizeof texels);
    fixture_assert_clean(gpu);
}

static void readback_refuses_what_does_not_fit(void **state)
{
    kd_gpu *gpu = *state;
    kd_gpu_buffer buffer = kd_gpu_make_buffer(gpu, &(kd_gpu_buffer_desc){.size = 4096});
    kd_gpu_readback ring = kd_gpu_make_readback(gpu, 16, 0, "tiny");
    assert_int_equal(kd_gpu_readback_buffer(gpu, ring, buffer, 0, 4096, 0), KD_TOO_LARGE);
    assert_true(fixture_logged("tiny"));
    assert_int_equal(kd_gpu_readback_buffer(gpu, (kd_gpu_readback){0}, buffer, 0, 4, 0), KD_GPU);
    assert_null(kd_gpu_readback_poll(gpu, (kd_gpu_readback){0}, true, NULL, NULL));
    kd_gpu_destroy_readback(gpu, ring);
    assert_int_equal(kd_gpu_bytes(gpu), 4096);
    assert_int_equal(kd_gpu_readback_buffer(gpu, ring, buffer, 0, 4, 0), KD_GPU);
    assert_true(fixture_logged("destroyed before"));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        FIXTURE_TEST(readback_arrives_some_frames_later_without_waiting),
        FIXTURE_TEST(readback_that_is_full_says_so),
        FIXTURE_TEST(readback_takes_textures),
        FIXTURE_TEST(readback_refuses_what_does_not_fit),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
