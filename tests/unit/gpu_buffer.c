#include "tests/gpu_fixture.h"

enum { WORDS = 64, BYTES = WORDS * 4 };

static kd_gpu_buffer make(kd_gpu *gpu, kd_buffer_usage usage, const void *data)
{
    return kd_gpu_make_buffer(
        gpu, &(kd_gpu_buffer_desc){.size = BYTES, .data = data, .usage = usage, .name = "words"});
}

static void buffer_keeps_its_data_fills_and_copies(void **state)
{
    uint32_t words[WORDS], out[WORDS];
    kd_gpu *gpu = *state;
    for (uint32_t i = 0; i < WORDS; i++)
        words[i] = i;
    kd_gpu_buffer a = make(gpu, KD_BUFFER_STATIC, words), b = make(gpu, KD_BUFFER_STATIC, NULL);
    kd_gpu_fill_buffer(gpu, b, 0, BYTES, 0xabcd1234u);
    kd_gpu_copy_buffer(gpu, a, 8, b, 16, 12);
    kd_gpu_read_buffer(gpu, b, 0, out, BYTES);
    for (uint32_t i = 0; i < WORDS; i++)
        assert_int_equal(out[i], i >= 4 && i < 7 ? i - 2 : 0xabcd1234u);
    fixture_assert_clean(gpu);
}

static void buffer_is_zeroed_on_demand(void **state)
{
    uint8_t out[7] = {1, 1, 1, 1, 1, 1, 1};
    kd_gpu *gpu = *state;
    /* A size that is no multiple of a word. */
    kd_gpu_buffer buffer = kd_gpu_make_buffer(gpu, &(kd_gpu_buffer_desc){.size = 7, .zeroed = true});
    kd_gpu_read_buffer(gpu, buffer, 0, out, 7);
    for (int i = 0; i < 7; i++)
        assert_int_equal(out[i], 0);
    fixture_assert_clean(gpu);
}

static void buffer_of_any_usage_is_written(void **state)
{
    kd_gpu *gpu = *state;
    for (int usage = KD_BUFFER_STATIC; usage <= KD_BUFFER_STREAM; usage++) {
        uint32_t value = 99, out[2];
        kd_gpu_buffer buffer = make(gpu, (kd_buffer_usage)usage, NULL);
        kd_gpu_fill_buffer(gpu, buffer, 0, BYTES, 5);
        kd_gpu_write_buffer(gpu, buffer, 4, &value, 4);
        kd_gpu_read_buffer(gpu, buffer, 0, out, 8);
        assert_int_equal(out[0], 5);
        assert_int_equal(out[1], 99);
    }
    fixture_assert_clean(gpu);
}

static void ensure_grows_and_keeps(void **state)
{
    uint32_t words[WORDS], out[WORDS];
    kd_gpu *gpu = *state;
    for (uint32_t i = 0; i < WORDS; i++)
        words[i] = i * 3;
    kd_gpu_buffer buffer = make(gpu, KD_BUFFER_STATIC, words), same = buffer;
    assert_int_equal(kd_gpu_ensure_buffer(gpu, &buffer, BYTES / 2, 0, "words"), KD_OK);
    assert_int_equal(buffer.id, same.id);
    assert_int_equal(kd_gpu_ensure_buffer(gpu, &buffer, BYTES * 2, BYTES, "words"), KD_OK);
    assert_int_not_equal(buffer.id, same.id);
    assert_int_equal(kd_gpu_buffer_size(gpu, buffer), BYTES * 2);
    assert_int_equal(kd_gpu_buffer_size(gpu, same), 0);
    kd_gpu_read_buffer(gpu, buffer, 0, out, BYTES);
    assert_memory_equal(out, words, BYTES);
    kd_gpu_buffer none = {0};
    assert_int_equal(kd_gpu_ensure_buffer(gpu, &none, 16, 0, "first"), KD_OK);
    assert_int_equal(kd_gpu_buffer_size(gpu, none), 16);
    fixture_assert_clean(gpu);
}

static void memory_is_counted_by_name(void **state)
{
    kd_gpu_memory_row rows[8];
    kd_gpu *gpu = *state;
    size_t before = kd_gpu_bytes(gpu);
    kd_gpu_buffer a = make(gpu, KD_BUFFER_STATIC, NULL);
    make(gpu, KD_BUFFER_STATIC, NULL);
    kd_gpu_texture texture = kd_gpu_make_texture(
        gpu, &(kd_gpu_texture_desc){
                 .format = KD_RGBA8, .width = 4, .height = 4, .levels = UINT32_MAX, .name = "t"});
    /* Levels of 4x4, 2x2 and 1x1 texels of 4 bytes: 84. */
    assert_int_equal(kd_gpu_bytes(gpu), before + 2 * BYTES + 84);
    assert_int_equal(kd_gpu_memory(gpu, rows, 8), 2);
    assert_string_equal(rows[0].name, "words");
    assert_int_equal(rows[0].bytes, 2 * BYTES);
    assert_int_equal(rows[0].count, 2);
    assert_string_equal(rows[1].name, "t");
    assert_int_equal(rows[1].bytes, 84);
    kd_gpu_destroy_buffer(gpu, a);
    kd_gpu_destroy_texture(gpu, texture);
    assert_int_equal(kd_gpu_bytes(gpu), before + BYTES);
    fixture_assert_clean(gpu);
}

static void buffer_that_is_too_large_fails_with_name_and_bytes(void **state)
{
    kd_gpu *gpu = *state;
    /* 2^60 bytes: more than any driver can address. */
    kd_gpu_buffer buffer =
        kd_gpu_make_buffer(gpu, &(kd_gpu_buffer_desc){.size = (size_t)1 << 60, .name = "vast"});
    assert_int_equal(buffer.id, 0);
    assert_true(kd_gpu_failed(gpu));
    assert_true(fixture_logged("vast"));
    assert_true(fixture_logged("1152921504606846976 bytes"));
    assert_int_equal(kd_gpu_ensure_buffer(gpu, &buffer, (size_t)1 << 60, 0, "vast"), KD_GPU);
}

static void failed_buffer_is_harmless(void **state)
{
    uint32_t word = 1;
    kd_gpu *gpu = *state;
    kd_gpu_buffer none = {0}, good = make(gpu, KD_BUFFER_STATIC, NULL);
    kd_gpu_destroy_buffer(gpu, none);
    assert_false(kd_gpu_failed(gpu));
    kd_gpu_write_buffer(gpu, none, 0, &word, 4);
    kd_gpu_fill_buffer(gpu, none, 0, 4, 0);
    kd_gpu_copy_buffer(gpu, none, 0, good, 0, 4);
    kd_gpu_copy_buffer(gpu, good, 0, none, 0, 4);
    kd_gpu_bind_storage(gpu, 0, none);
    kd_gpu_bind_uniform_buffer(gpu, 0, none, 0, 4);
    kd_gpu_read_buffer(gpu, none, 0, &word, 4);
    assert_int_equal(word, 0);
    assert_true(kd_gpu_failed(gpu));
}

static void buffer_used_after_its_end_is_noticed(void **state)
{
    kd_gpu *gpu = *state;
    kd_gpu_buffer old = make(gpu, KD_BUFFER_STATIC, NULL);
    kd_gpu_destroy_buffer(gpu, old);
    kd_gpu_buffer young = make(gpu, KD_BUFFER_STATIC, NULL);
    assert_int_not_equal(young.id, old.id); /* the slot is reused, the generation is not */
    assert_false(kd_gpu_failed(gpu));
    kd_gpu_fill_buffer(gpu, old, 0, 4, 1);
    assert_true(kd_gpu_failed(gpu));
    assert_true(fixture_logged("fill_buffer: the buffer was destroyed before"));
    kd_gpu_destroy_buffer(gpu, old);
    assert_int_equal(kd_gpu_buffer_size(gpu, young), BYTES);
}

static void ranges_outside_of_a_buffer_are_refused(void **state)
{
    uint32_t words[2] = {1, 2};
    kd_gpu *gpu = *state;
    kd_gpu_buffer buffer = make(gpu, KD_BUFFER_STREAM, NULL);
    kd_gpu_write_buffer(gpu, buffer, BYTES - 4, words, 8);
    assert_true(kd_gpu_failed(gpu));
    assert_true(fixture_logged("bytes 252 to 260 lie outside of buffer words (256 bytes)"));
    kd_gpu_write_buffer(gpu, buffer, SIZE_MAX - 3, words, 8);
    kd_gpu_read_buffer(gpu, buffer, BYTES, words, 8);
    assert_int_equal(words[0], 0);
}

static void handles_stay_apart_over_many_lives(void **state)
{
    kd_gpu *gpu = *state;
    kd_gpu_buffer_desc desc = {.size = 4, .name = "short-lived"};
    kd_gpu_buffer first = kd_gpu_make_buffer(gpu, &desc);
    kd_gpu_destroy_buffer(gpu, first);
    /* Fewer lives than a generation of 12 bits can tell apart (two steps a life). */
    for (int i = 0; i < 2000; i++) {
        kd_gpu_buffer next = kd_gpu_make_buffer(gpu, &desc);
        assert_int_not_equal(next.id, 0);
        assert_int_not_equal(next.id, first.id);
        kd_gpu_destroy_buffer(gpu, next);
    }
    fixture_assert_clean(gpu);
}

static void uniforms_hold_many_blocks_of_a_frame_apart(void **state)
{
    enum { COUNT = 6000 };
    static uint32_t out[COUNT];
    kd_gpu *gpu = *state;
    fixture_write("u.comp", "layout(local_size_x = 1) in;\n"
                            "layout(std430, binding = 0) buffer Out { uint words[]; };\n"
                            "layout(std140, binding = 0) uniform Kept { uvec4 kept; };\n"
                            "layout(std140, binding = 1) uniform Each { uvec4 each; };\n"
                            "void main() { words[each.x] = each.x + kept.x; }\n");
    kd_gpu_program program = kd_gpu_make_program(gpu, &(kd_gpu_program_desc){.compute = "shaders/t/u.comp"});
    kd_gpu_buffer buffer = kd_gpu_make_buffer(gpu, &(kd_gpu_buffer_desc){.size = sizeof out, .zeroed = true});
    kd_gpu_bind_storage(gpu, 0, buffer);
    for (uint32_t frame = 0; frame < 8; frame++) {
        const uint32_t kept[4] = {(frame + 1) * 10};
        kd_gpu_bind_uniform(gpu, 0, kept, sizeof kept);
        /* 6000 blocks of at least 64 bytes are more than the first ring of 256 KiB a frame holds. */
        for (uint32_t i = 0; i < COUNT; i++) {
            const uint32_t each[16] = {i};
            kd_gpu_bind_uniform(gpu, 1, each, sizeof each);
            if (i % 500 == 499)
                kd_gpu_dispatch(gpu, program, 1, 1, 1);
        }
        kd_gpu_read_buffer(gpu, buffer, 0, out, sizeof out);
        for (uint32_t i = 499; i < COUNT; i += 500)
            assert_int_equal(out[i], i + (frame + 1) * 10);
        kd_gpu_end_frame(gpu);
    }
    fixture_assert_clean(gpu);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        FIXTURE_TEST(buffer_keeps_its_data_fills_and_copies),
        FIXTURE_TEST(buffer_is_zeroed_on_demand),
        FIXTURE_TEST(buffer_of_any_usage_is_written),
        FIXTURE_TEST(ensure_grows_and_keeps),
        FIXTURE_TEST(memory_is_counted_by_name),
        FIXTURE_TEST(buffer_that_is_too_large_fails_with_name_and_bytes),
        FIXTURE_TEST(failed_buffer_is_harmless),
        FIXTURE_TEST(buffer_used_after_its_end_is_noticed),
        FIXTURE_TEST(ranges_outside_of_a_buffer_are_refused),
        FIXTURE_TEST(handles_stay_apart_over_many_lives),
        FIXTURE_TEST(uniforms_hold_many_blocks_of_a_frame_apart),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
