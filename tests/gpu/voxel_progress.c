/* Voxelization tells how far it is, ends when it is asked to, and goes on where it was. */

#include "runtime/core/progress.h"
#include "tests/voxel_fixture.h"

enum { BALLS = 12 };

typedef struct listener {
    uint64_t calls, stop_at, total;
    bool ordered;
} listener;

static bool listen(void *user, uint64_t done, uint64_t total, const char *what)
{
    listener *l = user;
    l->ordered = l->ordered && done == l->calls && done < total && what[0];
    l->total = total;
    return l->calls++ < l->stop_at;
}

static uint32_t count_made(voxel_world *v)
{
    const kd_voxel_scene *s = voxel_scene(v);
    uint32_t made = 0;
    for (uint32_t i = 0; i < s->cache_count; i++)
        made += s->caches[i].alive && s->caches[i].made;
    return made;
}

static void voxelization_stops_when_asked_and_goes_on_later(void **state)
{
    (void)state;
    voxel_world v = voxel_open((voxel_options){.cascades = 1, .span = 0.04f});
    listener first = {.stop_at = 5, .ordered = true}, second = {.stop_at = UINT64_MAX, .ordered = true};
    for (int i = 0; i < BALLS; i++) {
        float size = 0.3f + 0.01f * (float)i; /* each of its own size: none shares voxels with another */
        voxel_shape(&v, KD_SHAPE_SPHERE, (kd_vec3){size, size, size}, NULL,
                    voxel_at(0.2f * (float)i - 1.2f, 0, 0));
    }
    kd_progress_set_sink(listen, &first);
    voxel_frame(&v);
    assert_true(first.ordered);
    assert_int_equal(first.total, BALLS);
    assert_int_equal(first.calls, 6);
    assert_int_equal(count_made(&v), 5);
    kd_progress_set_sink(listen, &second);
    voxel_frame(&v);
    kd_progress_set_sink(NULL, NULL);
    assert_true(second.ordered);
    assert_int_equal(second.calls, BALLS - 5);
    assert_int_equal(count_made(&v), BALLS);
    assert_true(voxel_scene(&v)->pages[KD_LAYER_STATIC].voxel_count > 1000);
    voxel_close(&v);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(voxelization_stops_when_asked_and_goes_on_later),
    };
    return cmocka_run_group_tests(tests, voxel_group_setup, voxel_group_teardown);
}
