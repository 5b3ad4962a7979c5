/* Singletons that hold handles of a device are no part of a snapshot: a restored world keeps its own. */
#include "tests/systems_fixture.h"

#include "components/bounce.h"
#include "components/render_targets.h"
#include "components/svo.h"
#include "components/voxel_scene.h"
#include "runtime/ecs/snapshot.h"

static void handles_survive_a_restore(void **state)
{
    (void)state;
    kd_world *w = kd_world_make();
    assert_non_null(w);
    kd_singleton(w, kd_gbuffer)->albedo.id = 7;
    kd_snapshot s = {0};
    assert_int_equal(kd_snapshot_write(w, &s), KD_OK);
    kd_singleton(w, kd_gbuffer)->albedo.id = 8; /* made anew since */
    kd_singleton(w, kd_svo)->masks.id = 9;      /* made since */
    kd_singleton(w, kd_tree)->radiance.id = 10;
    kd_singleton(w, kd_bounce)->entries.id = 11;
    assert_int_equal(kd_snapshot_restore(w, s.data, s.size), KD_OK);
    assert_int_equal(kd_singleton(w, kd_gbuffer)->albedo.id, 8);
    assert_int_equal(kd_singleton(w, kd_svo)->masks.id, 9);
    assert_int_equal(kd_singleton(w, kd_tree)->radiance.id, 10);
    assert_int_equal(kd_singleton(w, kd_bounce)->entries.id, 11);
    kd_snapshot_fini(&s);
    kd_world_destroy(w);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(handles_survive_a_restore)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
