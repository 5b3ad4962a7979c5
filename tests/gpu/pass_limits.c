/* What the driver cannot bind or dispatch at once: refused bindings let nothing run, long dispatches come in
 * rows. */

#include "runtime/gpu/internal.h"
#include "runtime/gpu/rank.h"
#include "tests/gpu_fixture.h"

enum { PROBE_BINDING = 2, PROBE_GROUP = 4, WORDS = 64, LIMIT = 4096 };

static kd_gpu_program make_probe(kd_gpu *gpu)
{
    setenv("KANDIL_SHADER_DIR", KD_SOURCE_DIR, 1);
    kd_gpu_program probe =
        kd_gpu_make_program(gpu, &(kd_gpu_program_desc){.compute = "tests/gpu/linear_probe.comp"});
    if (!probe.id)
        fail_msg("%s", fixture_text);
    return probe;
}

static kd_gpu_buffer make_zeros(kd_gpu *gpu, size_t bytes, const char *name)
{
    return kd_gpu_make_buffer(gpu, &(kd_gpu_buffer_desc){.size = bytes, .zeroed = true, .name = name});
}

/* Dispatch so that each of the first WORDS words counts one more, and read them. */
static void count_once(kd_gpu *gpu, kd_gpu_program probe, kd_gpu_buffer buffer, uint32_t out[WORDS])
{
    uint32_t pass[4] = {WORDS};
    kd_gpu_bind_uniform(gpu, 0, pass, sizeof pass);
    kd_gpu_dispatch(gpu, probe, WORDS / PROBE_GROUP, 1, 1);
    kd_gpu_barrier(gpu, KD_BARRIER_STORAGE | KD_BARRIER_BUFFER_UPDATE);
    kd_gpu_read_buffer(gpu, buffer, 0, out, WORDS * 4);
}

static void expect_all(const uint32_t words[WORDS], uint32_t expected)
{
    for (int i = 0; i < WORDS; i++)
        assert_int_equal(words[i], expected);
}

static void assert_refused(kd_gpu *gpu, kd_gpu_buffer refused)
{
    uint32_t words[WORDS];
    kd_gpu_program probe = make_probe(gpu);
    kd_gpu_buffer good = make_zeros(gpu, LIMIT, "good");
    kd_gpu_bind_storage(gpu, PROBE_BINDING, good);
    count_once(gpu, probe, good, words);
    expect_all(words, 1);
    assert_false(kd_gpu_failed(gpu));
    kd_gpu_bind_storage(gpu, PROBE_BINDING, refused);
    assert_true(kd_gpu_failed(gpu));
    count_once(gpu, probe, good, words);
    count_once(gpu, probe, good, words);
    expect_all(words, 1); /* what was bound before is not written */
    kd_gpu_bind_storage(gpu, PROBE_BINDING, good);
    count_once(gpu, probe, good, words);
    expect_all(words, 2);
}

static void binding_of_too_large_a_buffer_lets_nothing_run(void **state)
{
    kd_gpu *gpu = *state;
    gpu->info.max_ssbo_bytes = LIMIT;
    kd_gpu_buffer large = make_zeros(gpu, LIMIT + 4, "large");
    assert_refused(gpu, large);
    uint32_t word = 1;
    kd_gpu_read_buffer(gpu, large, 0, &word, 4);
    assert_int_equal(word, 0);
    const char *first = strstr(fixture_text, "4100 bytes of large at binding 2");
    assert_non_null(first);
    assert_null(strchr(strchr(first, '\n') + 1, '\n')); /* dispatches say nothing more */
}

static void binding_of_a_failed_buffer_lets_nothing_run(void **state)
{
    assert_refused(*state, (kd_gpu_buffer){0});
}

static void refused_range_lets_nothing_run(void **state)
{
    kd_gpu *gpu = *state;
    uint32_t words[WORDS];
    kd_gpu_program probe = make_probe(gpu);
    kd_gpu_buffer good = make_zeros(gpu, LIMIT, "good");
    kd_gpu_bind_storage(gpu, PROBE_BINDING, good);
    kd_gpu_bind_storage_range(gpu, PROBE_BINDING, good, LIMIT, 4);
    count_once(gpu, probe, good, words);
    expect_all(words, 0);
}

static void programs_without_the_refused_binding_run(void **state)
{
    kd_gpu *gpu = *state;
    uint32_t words[WORDS];
    kd_gpu_program probe = make_probe(gpu);
    kd_gpu_buffer good = make_zeros(gpu, LIMIT, "good");
    kd_gpu_bind_storage(gpu, PROBE_BINDING, good);
    kd_gpu_bind_storage(gpu, PROBE_BINDING + 1, (kd_gpu_buffer){0});
    kd_gpu_bind_storage(gpu, 1000, good);
    count_once(gpu, probe, good, words);
    expect_all(words, 1);
}

static void linear_dispatch_covers_every_index_once(void **state)
{
    static const uint32_t groups[] = {1, 65535, 65536, 131071, 200000};
    kd_gpu *gpu = *state;
    kd_gpu_program probe = make_probe(gpu);
    for (size_t g = 0; g < sizeof groups / sizeof *groups; g++) {
        uint32_t indices = groups[g] * PROBE_GROUP, pass[4] = {indices};
        kd_gpu_buffer seen = make_zeros(gpu, ((size_t)indices + 1) * 4, "seen");
        uint32_t *words = malloc(((size_t)indices + 1) * 4);
        assert_non_null(words);
        kd_gpu_bind_uniform(gpu, 0, pass, sizeof pass);
        kd_gpu_bind_storage(gpu, PROBE_BINDING, seen);
        kd_gpu_dispatch_linear(gpu, probe, groups[g]);
        kd_gpu_barrier(gpu, KD_BARRIER_STORAGE | KD_BARRIER_BUFFER_UPDATE);
        kd_gpu_read_buffer(gpu, seen, 0, words, ((size_t)indices + 1) * 4);
        for (uint32_t i = 0; i < indices; i++)
            if (words[i] != 1)
                fail_msg("%u groups: index %u came %u times", groups[g], i, words[i]);
        assert_true(words[indices] < 4 * PROBE_GROUP); /* less than a group a row too many */
        free(words);
        kd_gpu_destroy_buffer(gpu, seen);
    }
    kd_gpu_dispatch_linear(gpu, probe, 0);
    fixture_assert_clean(gpu);
}

/* More blocks of 32 words than 65535 groups of 64 invocations take would need a mask of half a gigabyte; what
 * is tested is the refusal. */
static void ranks_of_too_large_a_mask_are_refused(void **state)
{
    kd_gpu *gpu = *state;
    kd_gpu_rank rank = {0};
    uint32_t total = 7, start = 7;
    setenv("KANDIL_SHADER_DIR", KD_SOURCE_DIR, 1);
    assert_int_equal(kd_gpu_rank_init(gpu, &rank), KD_OK);
    kd_gpu_buffer mask = make_zeros(gpu, LIMIT + 4, "mask"), ranks = make_zeros(gpu, LIMIT, "ranks");
    kd_gpu_buffer counter = kd_gpu_make_buffer(gpu, &(kd_gpu_buffer_desc){.size = 4, .data = &start});
    kd_gpu_fill_buffer(gpu, mask, 0, LIMIT, 3);
    assert_int_equal(kd_gpu_rank_run(gpu, &rank, mask, 0, LIMIT / 4, ranks, 0, counter, 0), KD_OK);
    kd_gpu_read_buffer(gpu, counter, 0, &total, 4);
    assert_int_equal(total, LIMIT / 2);
    kd_gpu_read_buffer(gpu, ranks, LIMIT - 4, &total, 4);
    assert_int_equal(total, LIMIT / 2 - 2);
    assert_false(kd_gpu_failed(gpu));
    gpu->info.max_ssbo_bytes = LIMIT;
    assert_int_equal(kd_gpu_rank_run(gpu, &rank, mask, 0, LIMIT / 4, ranks, 0, counter, 0), KD_TOO_LARGE);
    kd_gpu_read_buffer(gpu, counter, 0, &total, 4);
    assert_int_equal(total, 0);
    assert_true(fixture_logged("rank: 4100 bytes"));
    kd_gpu_rank_fini(gpu, &rank);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        FIXTURE_TEST(binding_of_too_large_a_buffer_lets_nothing_run),
        FIXTURE_TEST(binding_of_a_failed_buffer_lets_nothing_run),
        FIXTURE_TEST(refused_range_lets_nothing_run),
        FIXTURE_TEST(programs_without_the_refused_binding_run),
        FIXTURE_TEST(linear_dispatch_covers_every_index_once),
        FIXTURE_TEST(ranks_of_too_large_a_mask_are_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
