/* GPU time by timestamps: every frame's arrive, systems hold their passes, what lies between systems is idle.
 */
#include "runtime/app/gpu_timing.h"
#include "tests/gpu_fixture.h"
#include "tests/pftrace.h"

enum { FRAMES = 30, FRAME_ROW = 2, IDLE_ROW = 3 };

static const kd_profile_system rows[] = {
    {"first", "cull", true}, {"second", "view", true}, {"gpu_frame", "", true}, {"gpu_idle", "", true}};

static void dispatch(kd_gpu *gpu, kd_gpu_program program, kd_gpu_buffer buffer)
{
    kd_gpu_bind_storage(gpu, 0, buffer);
    kd_gpu_dispatch(gpu, program, 64, 1, 1);
    kd_gpu_barrier(gpu, KD_BARRIER_STORAGE);
}

static size_t count_zones(const pf_trace *t, const char *name, uint32_t depth)
{
    size_t count = 0;
    for (size_t i = 0; i < t->zone_count; i++)
        count += strcmp(t->zones[i].name, name) == 0 && t->zones[i].depth == depth;
    return count;
}

#define SHADER(body)                                                                                         \
    "layout(local_size_x = 64) in;\n"                                                                        \
    "layout(std430, binding = 0) buffer values { uint v[]; };\n"                                             \
    "void main() { " body " }\n"

static kd_gpu_program program(kd_gpu *gpu, const char *name, const char *text)
{
    fixture_write(name, text);
    char path[64];
    snprintf(path, sizeof path, "shaders/t/%s", name);
    return kd_gpu_make_program(gpu, &(kd_gpu_program_desc){.compute = path, .name = name});
}

static void record(kd_gpu *gpu, bool sync, const char *path)
{
    kd_gpu_program a = program(gpu, "a.comp", SHADER("v[gl_GlobalInvocationID.x] = 1u;"));
    kd_gpu_program b = program(gpu, "b.comp", SHADER("v[gl_GlobalInvocationID.x] += 2u;"));
    kd_gpu_buffer buffer = kd_gpu_make_buffer(gpu, &(kd_gpu_buffer_desc){.size = 64 * 64 * 4});
    kd_profile *p = kd_profile_make(rows, 4);
    assert_int_equal(kd_profile_trace(p, 1), KD_OK);
    app_gpu_timing *g = app_gpu_timing_make(gpu, p, FRAME_ROW, IDLE_ROW, sync, true);
    for (int frame = 0; frame < FRAMES; frame++) {
        kd_profile_frame_begin(p);
        dispatch(gpu, a, buffer); /* outside of systems: no pass */
        app_gpu_timing_begin(g, 0);
        dispatch(gpu, a, buffer);
        dispatch(gpu, a, buffer); /* the same pass */
        dispatch(gpu, b, buffer);
        app_gpu_timing_end(g, 0);
        app_gpu_timing_begin(g, 1);
        dispatch(gpu, b, buffer);
        app_gpu_timing_end(g, 1);
        kd_gpu_end_frame(gpu);
        app_gpu_timing_collect(g, false);
        kd_profile_frame_end(p);
    }
    app_gpu_timing_collect(g, true);
    assert_int_equal(kd_profile_system_stats(p, FRAME_ROW).runs, FRAMES);
    assert_int_equal(kd_profile_write_trace(p, path), KD_OK);
    app_gpu_timing_destroy(g);
    kd_profile_destroy(p);
}

static void every_frame_is_told_apart(kd_gpu *gpu, bool sync)
{
    char path[128];
    snprintf(path, sizeof path, "%s/%d.pftrace", fixture_folder, sync);
    record(gpu, sync, path);
    pf_trace t = pf_decode(path);
    unlink(path);
    if (t.mistake)
        fail_msg("%s", t.mistake);
    assert_int_equal(count_zones(&t, "gpu_frame", 0), FRAMES);
    assert_int_equal(count_zones(&t, "first", 1), FRAMES);
    assert_int_equal(count_zones(&t, "second", 1), FRAMES);
    assert_int_equal(count_zones(&t, "a.comp", 2), FRAMES);
    assert_int_equal(count_zones(&t, "b.comp", 2), 2 * FRAMES);
    assert_true(count_zones(&t, "gpu_idle", 1) <= FRAMES);
    free(t.zones);
    fixture_assert_clean(gpu);
}

static void timestamps_of_every_frame_arrive(void **state)
{
    if (!kd_gpu_get_info(*state)->timestamp_bits)
        skip();
    every_frame_is_told_apart(*state, false);
}

static void finishing_tells_the_same(void **state)
{
    every_frame_is_told_apart(*state, true);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        FIXTURE_TEST(timestamps_of_every_frame_arrive),
        FIXTURE_TEST(finishing_tells_the_same),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
