/* Which barrier stands before which GPU system. Rules (OpenGL 4.5, 7.12.2): what shaders write (storage,
 * image) is seen by a later use only behind a barrier for that use; one barrier serves all resources written
 * before it; a shader write needs a barrier of its own kind behind earlier reads; rendering and copies order
 * themselves. Each case is worked out by hand for a first frame and for a steady one, in which last frame's
 * accesses count. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include <string.h>

#include "runtime/ecs/system.h"
#include "runtime/jobs/jobs.h"

enum {
    SR = KD_USE_STORAGE_READ,
    SW = KD_USE_STORAGE_WRITE,
    IR = KD_USE_IMAGE_READ,
    IW = KD_USE_IMAGE_WRITE,
    SAMPLED = KD_USE_SAMPLED,
    INDIRECT = KD_USE_INDIRECT,
    TARGET = KD_USE_TARGET,
    COPY_R = KD_USE_COPY_READ,
    COPY_W = KD_USE_COPY_WRITE,
    MAX_STEPS = 8,
};

typedef struct step {
    kd_resource_use uses[4];
    uint32_t first, steady; /* barrier expected before this system in the first and in every later frame */
} step;

static uint32_t issued[MAX_STEPS], running;
static struct kd_gpu *const some_gpu = (struct kd_gpu *)&issued;

static void begin(void *user, uint32_t system, uint32_t worker)
{
    (void)user;
    (void)worker;
    running = system;
}

static void barrier(void *user, struct kd_gpu *gpu, uint32_t uses)
{
    (void)user;
    assert_ptr_equal(gpu, some_gpu);
    assert_int_not_equal(uses, 0);
    issued[running] |= uses;
}

static void nothing(kd_system_context *c)
{
    assert_ptr_equal(c->gpu, some_gpu);
}

static uint32_t skip_mask;
static bool not_skipped(kd_system_context *c)
{
    return !(skip_mask >> (uintptr_t)c->user & 1);
}

static kd_schedule *make(kd_world *w, kd_jobs *jobs, const step *steps, uint32_t count)
{
    kd_schedule *s = kd_schedule_make(w, jobs, some_gpu);
    for (uint32_t i = 0; i < count; i++) {
        kd_system_desc desc = {.name = "step",
                               .where = KD_ON_GPU,
                               .run = nothing,
                               .run_if = not_skipped,
                               .user = (void *)(uintptr_t)i};
        memcpy(desc.resources, steps[i].uses, sizeof steps[i].uses);
        assert_int_equal(kd_schedule_add(s, &desc), KD_OK);
    }
    kd_schedule_set_hooks(s, &(kd_schedule_hooks){.begin = begin, .barrier = barrier});
    return s;
}

static void check(const step *steps, uint32_t count)
{
    kd_world *w = kd_world_make();
    kd_jobs *jobs = kd_jobs_make(2);
    kd_schedule *s = make(w, jobs, steps, count);
    skip_mask = 0;
    for (int frame = 0; frame < 4; frame++) {
        memset(issued, 0, sizeof issued);
        assert_int_equal(kd_schedule_run(s), KD_OK);
        for (uint32_t i = 0; i < count; i++)
            if (issued[i] != (frame ? steps[i].steady : steps[i].first))
                fail_msg("frame %d, system %u: barrier %u", frame, (unsigned)i, (unsigned)issued[i]);
    }
    kd_schedule_destroy(s);
    kd_jobs_destroy(jobs);
    kd_world_destroy(w);
}
#define CHECK(...)                                                                                           \
    check((const step[]){__VA_ARGS__}, (uint32_t)(sizeof((const step[]){__VA_ARGS__}) / sizeof(step)))

/* The reader needs the bit of its own use. In the next frame the writer writes over what was read: a barrier
 * of the writer's kind. */
static void reader_gets_the_bit_of_its_use(void **state)
{
    (void)state;
    CHECK({{{"a", SW}}, 0, SW}, {{{"a", SAMPLED}}, SAMPLED, SAMPLED});
    CHECK({{{"a", IW}}, 0, IW}, {{{"a", INDIRECT}}, INDIRECT, INDIRECT});
    CHECK({{{"a", SW}}, 0, SW}, {{{"a", COPY_R}}, COPY_R, COPY_R});
}

/* The second reader with the same bit finds everything visible; one with another bit does not. */
static void second_reader_of_a_kind_needs_none(void **state)
{
    (void)state;
    CHECK({{{"a", SW}}, 0, SW}, {{{"a", SAMPLED}}, SAMPLED, SAMPLED}, {{{"a", SAMPLED}}, 0, 0},
          {{{"a", INDIRECT}}, INDIRECT, INDIRECT}, {{{"a", SAMPLED | INDIRECT}}, 0, 0});
}

/* a and b are both written before the barrier for a: it serves b too. c is written behind it. */
static void one_barrier_serves_all_earlier_writes(void **state)
{
    (void)state;
    CHECK({{{"a", IW}}, 0, IW}, /* steady: behind last frame's samples of a */
          {{{"b", IW}}, 0, 0},  /* steady: the barrier just before serves b's last samples as well */
          {{{"a", SAMPLED}}, SAMPLED, SAMPLED}, {{{"b", SAMPLED}}, 0, 0},
          {{{"c", IW}},
           0,
           0}, /* steady: c was sampled in the last frame, and step 0 has had an image barrier since */
          {{{"b", SAMPLED}, {"c", SAMPLED}}, SAMPLED, SAMPLED});
}

/* Storage reads and writes share one barrier bit: behind a barrier for a read, a write of the same kind is in
 * order too unless something was read since. Each of the two writers in a row needs a barrier. */
static void writes_after_writes_need_a_barrier(void **state)
{
    (void)state;
    CHECK({{{"a", SW}}, 0, SW}, {{{"a", SW}}, SW, SW});
    CHECK({{{"a", SW}}, 0, SW}, {{{"a", IW}}, IW, IW});
    CHECK({{{"a", SW}}, 0, SW}, {{{"a", COPY_W}}, COPY_W, COPY_W});
}

/* b is read through a sampler and written as storage later: the write needs a storage barrier, the sampling
 * none, since frame 1 has nothing written; from then on the sampling needs its own. */
static void writes_after_reads_need_a_barrier(void **state)
{
    (void)state;
    CHECK({{{"b", SAMPLED}}, 0, SAMPLED}, {{{"b", SW}}, SW, SW});
    /* A storage barrier between the two, for another resource, is enough. Steady: step 0 samples what step 3
     * wrote; step 1 writes what step 2 read; step 2 reads what step 1 wrote; step 3 finds a storage barrier
     * behind the sampling. */
    CHECK({{{"b", SAMPLED}}, 0, SAMPLED}, {{{"x", SW}}, 0, SW}, {{{"x", SR}}, SR, SR}, {{{"b", SW}}, 0, 0});
}

/* Rendering, then sampling, then rendering: GL keeps these in order. Likewise copies into what shaders read.
 */
static void rendering_and_copies_order_themselves(void **state)
{
    (void)state;
    CHECK({{{"p", TARGET}}, 0, 0}, {{{"p", SAMPLED}}, 0, 0}, {{{"p", TARGET}}, 0, 0});
    CHECK({{{"u", COPY_W}}, 0, 0}, {{{"u", KD_USE_UNIFORM}}, 0, 0}, {{{"u", SR}}, 0, 0});
    /* A shader image write into what is rendered over next frame needs the target bit there. */
    CHECK({{{"p", TARGET}}, 0, TARGET}, {{{"p", IW}}, 0, IW});
}

/* Last frame's writer (step 2) counts for the first reader of the next frame (step 0). The write to "out"
 * needs none: the image barrier before step 2 came after the last sampling of it. */
static void last_frame_counts(void **state)
{
    (void)state;
    CHECK({{{"history", SAMPLED}, {"out", IW}}, 0, SAMPLED}, {{{"out", SAMPLED}}, SAMPLED, SAMPLED},
          {{{"history", IW}}, IW, IW});
}

/* Read-modify-write in place, frame after frame: one barrier a frame, and none beyond it for a second
 * in-place pass of another resource that the same barrier serves. */
static void in_place_passes_follow_each_other(void **state)
{
    (void)state;
    CHECK({{{"a", SR | SW}}, 0, SR | SW});
    CHECK({{{"a", SR | SW}}, 0, SR | SW}, {{{"b", SR | SW}}, 0, 0});
    CHECK({{{"a", SR | SW}}, 0, SR | SW}, {{{"a", SR | SW}}, SR | SW, SR | SW});
}

/* Reading alone, in any way, needs nothing for ever. */
static void reads_alone_need_none(void **state)
{
    (void)state;
    CHECK({{{"a", SR | SAMPLED}}, 0, 0}, {{{"a", IR}, {"b", COPY_R}}, 0, 0}, {{{"a", KD_USE_VERTEX}}, 0, 0});
}

/* Clear by copy, count with atomics, use as indirect arguments: the usual chain.
 * steady: the clear comes after last frame's shader writes (copy bit), the count after last frame's indirect
 * read of the same memory (storage bit), the draw reads what shaders wrote (indirect bit). */
static void clear_count_draw(void **state)
{
    (void)state;
    CHECK({{{"args", COPY_W}}, 0, COPY_W}, {{{"args", SW}}, 0, SW},
          {{{"args", INDIRECT}}, INDIRECT, INDIRECT});
}

/* The reader that carried the barrier is skipped: the next reader of the kind must get it. And a writer that
 * is skipped leaves nothing to wait for. */
static void skipped_systems_pass_their_barrier_on(void **state)
{
    (void)state;
    const step steps[] = {{{{"a", SW}}, 0, 0}, {{{"a", SAMPLED}}, 0, 0}, {{{"a", SAMPLED}}, 0, 0}};
    kd_world *w = kd_world_make();
    kd_jobs *jobs = kd_jobs_make(1);
    kd_schedule *s = make(w, jobs, steps, 3);
    static const uint32_t skips[] = {0, 1 << 1, 1 << 0, 1 << 1 | 1 << 2, 1 << 0};
    static const uint32_t expected[][3] = {
        {0, SAMPLED, 0},  /* as usual */
        {SW, 0, SAMPLED}, /* 1 is skipped, 2 carries it */
        {0, 0, 0},        /* nobody writes: all is visible still */
        {SW, 0, 0},       /* written, read by nobody */
        {0, SAMPLED, 0},  /* and read in a later frame */
    };
    for (int frame = 0; frame < 5; frame++) {
        skip_mask = skips[frame];
        memset(issued, 0, sizeof issued);
        assert_int_equal(kd_schedule_run(s), KD_OK);
        for (int i = 0; i < 3; i++)
            assert_int_equal(issued[i], expected[frame][i]);
    }
    kd_schedule_destroy(s);
    kd_jobs_destroy(jobs);
    kd_world_destroy(w);
}

static kd_status init_ok(kd_system_context *c)
{
    (void)c;
    return KD_OK;
}

/* An init may dispatch: what its system writes counts as written before the first frame. */
static void init_counts_as_a_write(void **state)
{
    (void)state;
    kd_world *w = kd_world_make();
    kd_jobs *jobs = kd_jobs_make(1);
    kd_schedule *s = make(w, jobs, (const step[]){{{{"a", SAMPLED}}, 0, 0}}, 1);
    kd_system_desc writer = {.name = "writer",
                             .phase = KD_PHASE_VIEW,
                             .where = KD_ON_GPU,
                             .run = nothing,
                             .init = init_ok,
                             .resources = {{"a", IW}}};
    assert_int_equal(kd_schedule_add(s, &writer), KD_OK);
    skip_mask = 0;
    memset(issued, 0, sizeof issued);
    assert_int_equal(kd_schedule_run(s), KD_OK);
    assert_int_equal(issued[0], SAMPLED);
    kd_schedule_destroy(s);
    kd_jobs_destroy(jobs);
    kd_world_destroy(w);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(reader_gets_the_bit_of_its_use),
        cmocka_unit_test(second_reader_of_a_kind_needs_none),
        cmocka_unit_test(one_barrier_serves_all_earlier_writes),
        cmocka_unit_test(writes_after_writes_need_a_barrier),
        cmocka_unit_test(writes_after_reads_need_a_barrier),
        cmocka_unit_test(rendering_and_copies_order_themselves),
        cmocka_unit_test(last_frame_counts),
        cmocka_unit_test(in_place_passes_follow_each_other),
        cmocka_unit_test(reads_alone_need_none),
        cmocka_unit_test(clear_count_draw),
        cmocka_unit_test(skipped_systems_pass_their_barrier_on),
        cmocka_unit_test(init_counts_as_a_write),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
