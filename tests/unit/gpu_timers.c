#include "runtime/core/clock.h"
#include "tests/gpu_fixture.h"

static void work(kd_gpu *gpu, kd_gpu_buffer buffer)
{
    kd_gpu_fill_buffer(gpu, buffer, 0, kd_gpu_buffer_size(gpu, buffer), 1);
}

static void timestamps_come_in_order_on_the_clock_of_the_cpu(void **state)
{
    uint64_t ns[4] = {0}, start = kd_clock_ns(), got = UINT64_MAX, end = 0;
    kd_gpu *gpu = *state;
    kd_gpu_buffer buffer = kd_gpu_make_buffer(gpu, &(kd_gpu_buffer_desc){.size = 16 << 20});
    if (!kd_gpu_get_info(gpu)->timestamp_bits)
        skip();
    for (int frame = 0; frame < 8; frame++) {
        kd_gpu_timestamp(gpu, 0);
        work(gpu, buffer);
        kd_gpu_timestamp(gpu, 1);
        work(gpu, buffer);
        kd_gpu_timestamp(gpu, 3);
        kd_gpu_end_frame(gpu);
    }
    kd_gpu_finish(gpu);
    end = kd_clock_ns();
    got = kd_gpu_read_timestamps(gpu, ns, 4);
    assert_int_equal(got, 7); /* the newest frame, since all are finished */
    assert_true(ns[0] <= ns[1] && ns[1] <= ns[3]);
    assert_true(ns[3] > ns[0]);
    assert_int_equal(ns[2], 0); /* not used */
    /* The clocks are matched to better than a millisecond. */
    assert_true(ns[0] + 1000000 > start && ns[3] < end + 1000000);
    fixture_assert_clean(gpu);
}

static void frames_without_timestamps_are_passed_over(void **state)
{
    uint64_t ns[1];
    kd_gpu *gpu = *state;
    assert_int_equal(kd_gpu_read_timestamps(gpu, ns, 1), UINT64_MAX);
    kd_gpu_end_frame(gpu);
    assert_int_equal(kd_gpu_read_timestamps(gpu, ns, 1), UINT64_MAX);
    assert_int_equal(kd_gpu_frame(gpu), 1);
    fixture_assert_clean(gpu);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        FIXTURE_TEST(timestamps_come_in_order_on_the_clock_of_the_cpu),
        FIXTURE_TEST(frames_without_timestamps_are_passed_over),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
