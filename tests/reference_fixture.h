#ifndef KD_TESTS_REFERENCE_FIXTURE_H
#define KD_TESTS_REFERENCE_FIXTURE_H

/* For tests of the path tracer: a world without a GPU, shapes, lights and a camera in one call each, and
 * pictures as floats, row 0 on top. */

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "components/camera.h"
#include "components/deform.h"
#include "components/frame.h"
#include "components/light.h"
#include "components/mesh_instance.h"
#include "components/scene_store.h"
#include "components/transform.h"
#include "runtime/ecs/system.h"
#include "runtime/jobs/jobs.h"
#include "runtime/reference/reference.h"
#include "systems/hierarchy/hierarchy.h"
#include "systems/scene/scene.h"

#define FIXTURE_PI 3.14159265358979323846

typedef struct fixture {
    kd_world *world;
    kd_jobs *jobs;
    kd_schedule *schedule;
    kd_frame *frame;
    kd_reference_desc desc;
    kd_reference_info info;
    float *rgb;
} fixture;

static inline int fixture_setup(void **state)
{
    fixture *f = calloc(1, sizeof *f);
    f->world = kd_world_make();
    f->jobs = kd_jobs_make(2);
    f->frame = kd_singleton(f->world, kd_frame);
    *f->frame = (kd_frame){.width = 1, .height = 1, .dt_s = 1.0f / 30, .settings = kd_settings_defaults()};
    f->desc = (kd_reference_desc){.spp = 256, .bounces = KD_REFERENCE_ENDLESS, .centre = true};
    f->schedule = kd_schedule_make(f->world, f->jobs, NULL);
    kd_schedule_leave_out_gpu(f->schedule);
    assert_int_equal(kd_scene_import(f->schedule), KD_OK);
    assert_int_equal(kd_hierarchy_import(f->schedule), KD_OK);
    (void)kd_singleton(f->world, kd_scene_store);
    (void)kd_singleton(f->world, kd_joint_palette);
    *state = f;
    return 0;
}

static inline int fixture_teardown(void **state)
{
    fixture *f = *state;
    kd_schedule_destroy(f->schedule);
    kd_world_destroy(f->world);
    kd_jobs_destroy(f->jobs);
    free(f->rgb);
    free(f);
    return 0;
}
#define FIXTURE_TEST(name) cmocka_unit_test_setup_teardown(name, fixture_setup, fixture_teardown)

/* ---- what is in the picture ---- */

/* Rotation that takes -Z, where cameras and lights look, to `direction`. */
static inline kd_quat fixture_look(kd_vec3 direction)
{
    kd_vec3 d = kd_vec3_normalize(direction, (kd_vec3){0, 0, -1}), from = {0, 0, -1};
    kd_vec3 axis = kd_vec3_cross(from, d);
    float w = 1 + kd_vec3_dot(from, d);
    if (w < 1e-5f)
        return (kd_quat){0, 1, 0, 0};
    float l = sqrtf(kd_vec3_dot(axis, axis) + w * w);
    return (kd_quat){axis.x / l, axis.y / l, axis.z / l, w / l};
}

static inline void fixture_camera(fixture *f, kd_vec3 eye, kd_vec3 target)
{
    kd_spawn(f->world, KD_VAL(kd_camera, {.fov_y = 0.6f, .z_near = 1e-3f, .z_far = 1000}),
             KD_VAL(kd_transform, {eye, fixture_look(kd_vec3_sub(target, eye)), {1, 1, 1}}),
             KD_TAG(kd_world_transform));
}

static inline void fixture_light(fixture *f, kd_light light, kd_vec3 position, kd_vec3 direction)
{
    kd_spawn(f->world, (kd_value){&kd_light_desc, &light},
             KD_VAL(kd_transform, {position, fixture_look(direction), {1, 1, 1}}),
             KD_TAG(kd_world_transform));
}

static inline kd_entity fixture_model(fixture *f, kd_model *model, kd_transform at)
{
    uint32_t number;
    kd_entity root;
    assert_int_equal(kd_scene_add_model(f->world, model, &number), KD_OK);
    assert_int_equal(kd_scene_instantiate(f->world, number, KD_NO_ENTITY, "thing", &root), KD_OK);
    *kd_find_mut(f->world, root, kd_transform) = at;
    return root;
}

static inline kd_entity fixture_shape(fixture *f, kd_shape shape, kd_vec3 size,
                                      const kd_material_desc *material, kd_transform at)
{
    kd_model *model;
    assert_int_equal(kd_model_make_shape(shape, size, 64, material, &model), KD_OK);
    return fixture_model(f, model, at);
}
#define FIXTURE_AT(x, y, z)                                                                                  \
    ((kd_transform){.position = {x, y, z}, .rotation = {0, 0, 0, 1}, .scale = {1, 1, 1}})

static inline kd_material_desc fixture_material(float albedo, float metallic, float roughness)
{
    kd_material_desc m = kd_material_default();
    m.base_color = (kd_vec4){albedo, albedo, albedo, 1};
    m.metallic = metallic;
    m.roughness = roughness;
    m.double_sided = true;
    return m;
}

/* ---- the picture ---- */

static inline void fixture_step(fixture *f)
{
    assert_int_equal(kd_schedule_run(f->schedule), KD_OK);
}

/* Trace a frame and keep a term's picture. */
static inline const float *fixture_trace(fixture *f, kd_reference_term term)
{
    kd_reference *r;
    fixture_step(f);
    assert_int_equal(kd_reference_open(f->world, f->jobs, &f->desc, &r), KD_OK);
    assert_int_equal(kd_reference_render(r), KD_OK);
    f->info = kd_reference_get_info(r);
    free(f->rgb);
    f->rgb = malloc((size_t)f->info.width * f->info.height * 3 * sizeof *f->rgb);
    kd_reference_read(r, term, f->rgb);
    kd_reference_close(r);
    return f->rgb;
}

static inline double fixture_mean(fixture *f, kd_reference_term term)
{
    const float *rgb = fixture_trace(f, term);
    size_t count = (size_t)f->info.width * f->info.height * 3;
    double sum = 0;
    for (size_t i = 0; i < count; i++)
        sum += (double)rgb[i];
    return sum / (double)count;
}

static inline void fixture_expect(double value, double expected, double relative)
{
    if (!(fabs(value - expected) <= relative * fabs(expected) + 1e-12))
        fail_msg("%.9g, expected %.9g within %g", value, expected, relative);
}

#endif
