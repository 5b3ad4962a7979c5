#ifndef KD_TESTS_STAGE_FIXTURE_H
#define KD_TESTS_STAGE_FIXTURE_H

/* A world with animation, hierarchy, scene and deform on a device, for tests that read back what the systems
 * leave there. */

#include "tests/deform_fixture.h"

#include "runtime/gpu/gpu.h"
#include "systems/animation/animation.h"
#include "systems/deform/deform.h"
#include "systems/hierarchy/hierarchy.h"
#include "systems/scene/scene.h"

typedef struct stage {
    kd_gpu *gpu;
    kd_world *world;
    kd_schedule *schedule;
    char ran[512]; /* names of the GPU systems of the last frame */
    char log[4096];
} stage;

static inline void stage_keep_log(void *user, kd_log_level level, const char *text)
{
    stage *s = user;
    size_t used = strlen(s->log);
    if (level >= KD_LOG_WARNING)
        snprintf(s->log + used, sizeof s->log - used, "%s\n", text);
}

static inline void stage_note_system(void *user, uint32_t system, uint32_t worker)
{
    stage *s = user;
    const kd_system_desc *desc = kd_schedule_system(s->schedule, system);
    size_t used = strlen(s->ran);
    (void)worker;
    if (desc->where == KD_ON_GPU)
        snprintf(s->ran + used, sizeof s->ran - used, "%s ", desc->name);
}

static inline void stage_barrier(void *user, kd_gpu *gpu, uint32_t uses)
{
    (void)user;
    if (uses)
        kd_gpu_barrier(gpu, KD_BARRIER_STORAGE | KD_BARRIER_BUFFER_UPDATE | KD_BARRIER_VERTEX);
}

static inline int stage_setup(void **state)
{
    stage *s = calloc(1, sizeof *s);
    kd_log_set_sink(stage_keep_log, s);
    if (kd_gpu_open(&(kd_gpu_desc){.debug = true}, &s->gpu) != KD_OK) {
        fprintf(stderr, "skipped: %s", s->log);
        exit(77);
    }
    s->world = kd_world_make();
    s->schedule = kd_schedule_make(s->world, NULL, s->gpu);
    kd_schedule_set_hooks(
        s->schedule, &(kd_schedule_hooks){.begin = stage_note_system, .barrier = stage_barrier, .user = s});
    assert_int_equal(kd_animation_import(s->schedule), KD_OK);
    assert_int_equal(kd_hierarchy_import(s->schedule), KD_OK);
    assert_int_equal(kd_scene_import(s->schedule), KD_OK);
    assert_int_equal(kd_deform_import(s->schedule), KD_OK);
    if (kd_schedule_init(s->schedule) != KD_OK)
        fail_msg("init: %s", s->log);
    *state = s;
    return 0;
}

static inline int stage_teardown(void **state)
{
    stage *s = *state;
    kd_schedule_destroy(s->schedule);
    kd_world_destroy(s->world);
    bool clean = !kd_gpu_failed(s->gpu);
    kd_gpu_close(s->gpu);
    if (!clean)
        fprintf(stderr, "%s", s->log);
    kd_log_set_sink(NULL, NULL);
    free(s);
    return clean ? 0 : -1;
}

static inline void stage_frame(stage *s)
{
    s->ran[0] = '\0';
    assert_int_equal(kd_schedule_run(s->schedule), KD_OK);
    kd_gpu_barrier(s->gpu, KD_BARRIER_BUFFER_UPDATE);
}

static inline kd_entity stage_spawn(stage *s, kd_model *model)
{
    uint32_t number;
    kd_entity root;
    assert_int_equal(kd_scene_add_model(s->world, model, &number), KD_OK);
    assert_int_equal(kd_scene_instantiate(s->world, number, KD_NO_ENTITY, "thing", &root), KD_OK);
    return root;
}

static inline void *stage_read_all(stage *s, kd_gpu_buffer buffer, size_t bytes)
{
    void *out = malloc(bytes ? bytes : 1);
    assert_non_null(out);
    if (bytes)
        kd_gpu_read_buffer(s->gpu, buffer, 0, out, bytes);
    return out;
}

#define STAGED(name) cmocka_unit_test_setup_teardown(name, stage_setup, stage_teardown)

#endif
