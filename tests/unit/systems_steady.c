/* A steady frame allocates nothing: the C library's allocator is stood in for by one that counts. Sanitizers
 * bring an allocator of their own; under them the test is skipped. */

#include "tests/deform_fixture.h"

#include "systems/animation/animation.h"
#include "systems/hierarchy/hierarchy.h"
#include "systems/scene/scene.h"

#if defined(__has_feature)
#if __has_feature(address_sanitizer) || __has_feature(thread_sanitizer)
#define SANITIZED
#endif
#endif
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__) || !defined(__GLIBC__)
#define SANITIZED
#endif

static long allocations;

#ifndef SANITIZED
extern void *__libc_malloc(size_t size);
extern void *__libc_calloc(size_t count, size_t size);
extern void *__libc_realloc(void *old, size_t size);
extern void *__libc_memalign(size_t alignment, size_t size);

void *malloc(size_t size)
{
    allocations++;
    return __libc_malloc(size);
}

void *calloc(size_t count, size_t size)
{
    allocations++;
    return __libc_calloc(count, size);
}

void *realloc(void *old, size_t size)
{
    allocations++;
    return __libc_realloc(old, size);
}

void *aligned_alloc(size_t alignment, size_t size)
{
    allocations++;
    return __libc_memalign(alignment, size);
}
#endif

static void add_swing(kd_model *model)
{
    static const float times[] = {0, 1}, values[] = {0, 0, 0, 1, 0, 0.7071068f, 0, 0.7071068f};
    static const kd_channel_desc channel = {1, KD_PATH_ROTATION, KD_INTERPOLATE_LINEAR, 2, 4, times, values};
    static const kd_clip_desc clip = {"swing", 1, 1, &channel, 0, NULL};
    model->clips = &clip;
    model->clip_count = 1;
}

static void animated_scene_allocates_only_in_its_first_frames(void **state)
{
    kd_world *w = kd_world_make();
    kd_schedule *s = kd_schedule_make(w, NULL, NULL);
    kd_model *model = fixture_character(2, 100, 6, 2, 4);
    uint32_t number;
    kd_entity root;
    (void)state;
    add_swing(model);
    assert_int_equal(kd_animation_import(s), KD_OK);
    assert_int_equal(kd_hierarchy_import(s), KD_OK);
    assert_int_equal(deform_register_joint_palette(s), KD_OK);
    assert_int_equal(scene_register_draw_list(s), KD_OK);
    assert_int_equal(scene_register_camera(s), KD_OK);
    assert_int_equal(kd_scene_add_model(w, model, &number), KD_OK);
    for (int i = 0; i < 20; i++)
        assert_int_equal(kd_scene_instantiate(w, number, KD_NO_ENTITY, "one of many", &root), KD_OK);
    kd_scene_store *store = kd_singleton(w, kd_scene_store);
    scene_internal *in = store->internal;
    store->uploaded_primitives = store->primitive_count;
    in->uploaded_deformed = store->deformed_count;
    for (int frame = 0; frame < 30; frame++) {
        long before = allocations;
        kd_status status = kd_schedule_run(s);
        long made = allocations - before;
        assert_int_equal(status, KD_OK);
        if (frame >= 4) /* two of each array that remembers its last frame have grown by then */
            assert_int_equal(made, 0);
    }
    assert_int_equal(kd_singleton(w, kd_draw_list)->draw_count, 40);
    kd_schedule_destroy(s);
    kd_world_destroy(w);
}

int main(void)
{
#ifdef SANITIZED
    fprintf(stderr, "skipped: the allocator is the sanitizer's\n");
    return 77;
#endif
    const struct CMUnitTest tests[] = {cmocka_unit_test(animated_scene_allocates_only_in_its_first_frames)};
    int failed = cmocka_run_group_tests(tests, NULL, NULL);
    if (allocations == 0) { /* the count itself must work */
        fprintf(stderr, "no allocation was seen at all\n");
        return 1;
    }
    return failed;
}
