/* The world between two steps: what moved is on its way, and put back to the bit; systems run as often, and
 * at the same times, as when a frame is one moment. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include <cmocka.h>

#include "components/camera.h"
#include "components/light.h"
#include "components/mesh_instance.h"
#include "components/transform.h"
#include "runtime/app/exposure.h"
#include "runtime/app/extension.h"
#include "runtime/core/file.h"
#include "runtime/ecs/system.h"

/* ---- the world ---- */

static kd_transform at(float x)
{
    kd_transform t = KD_TRANSFORM_IDENTITY;
    t.position.x = x;
    return t;
}

static void what_moved_is_on_its_way_and_is_put_back(void **state)
{
    (void)state;
    kd_world *w = kd_world_make();
    app_exposure *x;
    assert_non_null(w);
    (void)KD_ID(w, kd_transform);
    kd_entity still = kd_spawn(w, KD_TAG(kd_transform)), moves = kd_spawn(w, KD_TAG(kd_transform));
    kd_entity lamp = kd_spawn(w, KD_TAG(kd_light)), eye = kd_spawn(w, KD_TAG(kd_camera));
    kd_entity face = kd_spawn(w, KD_TAG(kd_morph_weights));
    *kd_find_mut(w, still, kd_transform) = at(7);
    *kd_find_mut(w, moves, kd_transform) = at(1);
    kd_find_mut(w, lamp, kd_light)->intensity = 10;
    kd_find_mut(w, eye, kd_camera)->fov_y = 0.5f;
    kd_find_mut(w, face, kd_morph_weights)->weights[2] = 0;
    assert_int_equal(app_exposure_make(w, &x), KD_OK);
    assert_int_equal(app_exposure_note(x), KD_OK);

    *kd_find_mut(w, moves, kd_transform) = at(3);
    kd_find_mut(w, moves, kd_transform)->rotation = (kd_quat){0, 1, 0, 0}; /* half a turn */
    kd_find_mut(w, lamp, kd_light)->intensity = 20;
    kd_find_mut(w, eye, kd_camera)->fov_y = 1;
    kd_find_mut(w, face, kd_morph_weights)->weights[2] = 1;
    kd_entity comes = kd_spawn(w, KD_TAG(kd_transform));
    *kd_find_mut(w, comes, kd_transform) = at(5);
    assert_int_equal(app_exposure_note(x), KD_OK);
    uint64_t checksum = kd_world_checksum(w);

    app_exposure_show(x, 0.25f);
    assert_float_equal(kd_find(w, moves, kd_transform)->position.x, 1.5f, 1e-6f);
    assert_float_equal(kd_find(w, moves, kd_transform)->rotation.y, 0.3826834f, 1e-5f); /* sin 22.5 degrees */
    assert_float_equal(kd_find(w, lamp, kd_light)->intensity, 12.5f, 1e-5f);
    assert_float_equal(kd_find(w, eye, kd_camera)->fov_y, 0.625f, 1e-6f);
    assert_float_equal(kd_find(w, face, kd_morph_weights)->weights[2], 0.25f, 1e-6f);
    assert_float_equal(kd_find(w, still, kd_transform)->position.x, 7, 0);
    assert_float_equal(kd_find(w, comes, kd_transform)->position.x, 5, 0);
    assert_int_not_equal(kd_world_checksum(w), checksum);
    app_exposure_show(x, 1);
    assert_int_equal(kd_world_checksum(w), checksum);

    kd_destroy(w, moves); /* who is gone is left alone */
    app_exposure_show(x, 0.5f);
    assert_int_equal(app_exposure_note(x), KD_OK);
    app_exposure_show(x, 0.5f); /* nothing moved in this step, but the lens and so on came back */
    app_exposure_show(x, 1);
    app_exposure_destroy(x);
    kd_world_destroy(w);
}

/* ---- systems ---- */

typedef struct runs {
    uint32_t count;
    double time_s, dt_s; /* sums */
} runs;
enum { STEPPED, FIXED, RARE, LATE, SYSTEM_COUNT };
static runs counted[SYSTEM_COUNT];

static void count_run(kd_system_context *c)
{
    runs *r = c->user;
    if (c->dt_s > 0) { /* a moment of a frame: no time passes */
        r->count++;
        r->time_s += c->time_s;
        r->dt_s += c->dt_s;
    }
}

static kd_status import_counters(kd_schedule *s)
{
    static const kd_system_desc systems[SYSTEM_COUNT] = {
        {.name = "stepped", .phase = KD_PHASE_ANIMATE},
        {.name = "fixed", .phase = KD_PHASE_SCRIPT, .rate = {.every_s = 0.015}},
        {.name = "rare", .phase = KD_PHASE_ANIMATE, .rate = {.every_frames = 3, .offset_frames = 1}},
        {.name = "late", .phase = KD_PHASE_CULL}};
    kd_status status = KD_OK;
    for (int i = 0; i < SYSTEM_COUNT && status == KD_OK; i++) {
        kd_system_desc desc = systems[i];
        desc.run = count_run;
        desc.user = &counted[i];
        status = kd_schedule_add(s, &desc);
    }
    return status;
}

static void film(const char *folder, const char *moments, runs out[SYSTEM_COUNT])
{
    static const kd_extension extension = {.name = "counters", .import_systems = import_counters};
    char scene[128], picture[128];
    snprintf(scene, sizeof scene, "%s/scene.lua", folder);
    snprintf(picture, sizeof picture, "%s/f_%%d.png", folder);
    const char *text = "kandil.scene { size = {16, 8}, fps = 50, gi = 'none' }\n"
                       "kandil.spawn { mesh = { shape = 'box', size = {1, 1, 1} } }\n";
    assert_int_equal(kd_file_write(scene, text, strlen(text)), KD_OK);
    char *argv[] = {"kandil",  "run",   scene,   "--frames",    "8",
                    "--quiet", "--out", picture, "--subframes", (char *)(uintptr_t)moments,
                    NULL};
    memset(counted, 0, sizeof counted);
    assert_int_equal(kd_main(10, argv, &extension), 0);
    memcpy(out, counted, sizeof counted);
}

static void systems_do_not_notice(void **state)
{
    (void)state;
    char folder[] = "/tmp/kandil-exposure-XXXXXX", command[64];
    runs whole[SYSTEM_COUNT], blurred[SYSTEM_COUNT];
    assert_non_null(mkdtemp(folder));
    film(folder, "1", whole);
    film(folder, "5", blurred);
    assert_int_equal(whole[STEPPED].count, 8);
    assert_int_equal(whole[FIXED].count, 10); /* 8 steps of 20 ms hold ten of 15 */
    assert_int_equal(whole[RARE].count, 3);
    assert_memory_equal(whole, blurred, sizeof whole);
    snprintf(command, sizeof command, "rm -rf '%s'", folder);
    assert_int_equal(system(command), 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(what_moved_is_on_its_way_and_is_put_back),
        cmocka_unit_test(systems_do_not_notice),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
