#ifndef KD_TESTS_RENDER_FIXTURE_H
#define KD_TESTS_RENDER_FIXTURE_H

/* For tests that render: a world with the systems from draw list to picture, shapes and lights in one call
 * each, and the picture's pixels as floats, row 0 on top. With KD_TEST_PICTURES=FOLDER each picture is also
 * written there as a .ppm. */

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "components/camera.h"
#include "components/frame.h"
#include "components/light.h"
#include "components/mesh_instance.h"
#include "components/render_targets.h"
#include "components/scene_store.h"
#include "components/transform.h"
#include "runtime/core/log.h"
#include "runtime/ecs/system.h"
#include "runtime/gpu/gpu.h"
#include "runtime/jobs/jobs.h"
#include "systems/deferred/deferred.h"
#include "systems/hierarchy/hierarchy.h"
#include "systems/resolve/resolve.h"
#include "systems/scene/scene.h"
#include "systems/shadow/shadow.h"
#include "systems/sky/sky.h"

enum { RENDER_SKIP = 77 };

typedef struct render {
    kd_gpu *gpu;
    kd_jobs *jobs;
    kd_world *world;
    kd_schedule *schedule;
    kd_frame *frame;
    bool ready;
    float *hdr;   /* [height][width][4] of the last picture */
    uint8_t *ldr; /* [height][width][4] */
    char warnings[4096];
    int pictures;
} render;

static inline void render_log(void *user, kd_log_level level, const char *text)
{
    render *r = user;
    size_t used = strlen(r->warnings);
    if (level >= KD_LOG_WARNING)
        snprintf(r->warnings + used, sizeof r->warnings - used, "%s\n", text);
}

/* Tests have no application to map uses to barriers: every barrier is the whole one. */
static inline void render_barrier(void *user, kd_gpu *gpu, uint32_t uses)
{
    (void)user;
    if (uses != 0)
        kd_gpu_barrier(gpu, 1023);
}

static inline int render_setup(void **state)
{
    render *r = calloc(1, sizeof *r);
    assert_non_null(r);
    kd_log_set_sink(render_log, r);
    if (kd_gpu_open(&(kd_gpu_desc){.debug = true}, &r->gpu) != KD_OK) {
        fprintf(stderr, "skipped: %s", r->warnings);
        exit(RENDER_SKIP);
    }
    r->jobs = kd_jobs_make(2);
    r->world = kd_world_make();
    assert_true(r->jobs != NULL && r->world != NULL);
    r->frame = kd_singleton(r->world, kd_frame);
    *r->frame = (kd_frame){
        .width = 160, .height = 120, .dt_s = 1.0f / 30, .gi = KD_GI_NONE, .settings = kd_settings_defaults()};
    r->frame->settings.view_tonemap = KD_TONEMAP_LINEAR;
    r->schedule = kd_schedule_make(r->world, r->jobs, r->gpu);
    assert_non_null(r->schedule);
    kd_schedule_set_hooks(r->schedule, &(kd_schedule_hooks){.barrier = render_barrier});
    assert_int_equal(kd_hierarchy_import(r->schedule), KD_OK);
    assert_int_equal(kd_scene_import(r->schedule), KD_OK);
    assert_int_equal(kd_shadow_import(r->schedule), KD_OK);
    assert_int_equal(kd_sky_import(r->schedule), KD_OK);
    assert_int_equal(kd_deferred_import(r->schedule), KD_OK);
    assert_int_equal(kd_blend_import(r->schedule), KD_OK);
    assert_int_equal(kd_resolve_import(r->schedule), KD_OK);
    *state = r;
    return 0;
}

static inline int render_teardown(void **state)
{
    render *r = *state;
    kd_schedule_destroy(r->schedule);
    kd_world_destroy(r->world);
    kd_jobs_destroy(r->jobs);
    kd_gpu_close(r->gpu);
    kd_log_set_sink(NULL, NULL);
    free(r->hdr);
    free(r->ldr);
    free(r);
    return 0;
}
#define RENDER_TEST(name) cmocka_unit_test_setup_teardown(name, render_setup, render_teardown)

/* ---- what is in the picture ---- */

/* Shortest rotation that takes -Z, where cameras and lights look, to `direction`. */
static inline kd_quat render_look(kd_vec3 direction)
{
    kd_vec3 d = kd_vec3_normalize(direction, (kd_vec3){0, 0, -1}), from = {0, 0, -1};
    kd_vec3 axis = kd_vec3_cross(from, d);
    float w = 1 + kd_vec3_dot(from, d);
    if (w < 1e-5f)
        return (kd_quat){0, 1, 0, 0};
    float l = sqrtf(kd_vec3_dot(axis, axis) + w * w);
    return (kd_quat){axis.x / l, axis.y / l, axis.z / l, w / l};
}

/* Camera rotation without roll. */
static inline kd_quat render_camera_look(kd_vec3 d)
{
    d = kd_vec3_normalize(d, (kd_vec3){0, 0, -1});
    float yaw = atan2f(-d.x, -d.z), pitch = asinf(d.y);
    float cy = cosf(yaw / 2), sy = sinf(yaw / 2), cp = cosf(pitch / 2), sp = sinf(pitch / 2);
    return (kd_quat){cy * sp, sy * cp, -sy * sp, cy * cp};
}

static inline kd_entity render_camera(render *r, kd_vec3 eye, kd_vec3 target, float fov_y)
{
    return kd_spawn(r->world, KD_VAL(kd_camera, {.fov_y = fov_y, .z_near = 0.05f, .z_far = 200}),
                    KD_VAL(kd_transform, {eye, render_camera_look(kd_vec3_sub(target, eye)), {1, 1, 1}}),
                    KD_TAG(kd_world_transform));
}

/* An orthographic camera above the origin looks down; x to the right, -z up in the picture, `half_height`
 * metres each way. */
static inline kd_entity render_top_camera(render *r, float half_height)
{
    return kd_spawn(
        r->world,
        KD_VAL(kd_camera, {.orthographic = true, .y_mag = half_height, .z_near = 0.1f, .z_far = 40}),
        KD_VAL(kd_transform, {{0, 20, 0}, {-sqrtf(0.5f), 0, 0, sqrtf(0.5f)}, {1, 1, 1}}),
        KD_TAG(kd_world_transform));
}

static inline kd_entity render_light(render *r, kd_light light, kd_vec3 position, kd_vec3 direction)
{
    return kd_spawn(r->world, (kd_value){&kd_light_desc, &light},
                    KD_VAL(kd_transform, {position, render_look(direction), {1, 1, 1}}),
                    KD_TAG(kd_world_transform));
}

static inline kd_entity render_shape(render *r, kd_shape shape, kd_vec3 size,
                                     const kd_material_desc *material, kd_vec3 position, kd_quat rotation,
                                     kd_vec3 scale)
{
    kd_model *model;
    uint32_t number;
    kd_entity root;
    assert_int_equal(kd_model_make_shape(shape, size, 0, material, &model), KD_OK);
    assert_int_equal(kd_scene_add_model(r->world, model, &number), KD_OK);
    assert_int_equal(kd_scene_instantiate(r->world, number, KD_NO_ENTITY, "shape", &root), KD_OK);
    *kd_find_mut(r->world, root, kd_transform) = (kd_transform){position, rotation, scale};
    return root;
}
#define RENDER_UPRIGHT ((kd_quat){0, 0, 0, 1})
#define RENDER_UNIT    ((kd_vec3){1, 1, 1})

/* Grey and as rough as can be. */
static inline kd_material_desc render_matte(float albedo)
{
    kd_material_desc m = kd_material_default();
    m.base_color = (kd_vec4){albedo, albedo, albedo, 1};
    m.metallic = 0;
    m.roughness = 1;
    return m;
}

/* ---- the picture ---- */

static inline float render_half(uint16_t h)
{
    int exponent = h >> 10 & 31, mantissa = h & 1023;
    float v = exponent == 0    ? ldexpf((float)mantissa, -24)
              : exponent == 31 ? (mantissa != 0 ? NAN : INFINITY)
                               : ldexpf((float)(mantissa + 1024), exponent - 25);
    return h & 0x8000 ? -v : v;
}

static inline void render_write_ppm(render *r, const char *folder, const char *name)
{
    char path[256];
    snprintf(path, sizeof path, "%s/%s_%d.ppm", folder, name, r->pictures++);
    FILE *file = fopen(path, "wb");
    if (file == NULL)
        return;
    fprintf(file, "P6\n%u %u\n255\n", r->frame->width, r->frame->height);
    for (size_t i = 0; i < (size_t)r->frame->width * r->frame->height; i++)
        fwrite(r->ldr + i * 4, 1, 3, file);
    fclose(file);
}

/* Run one frame and read its picture. Anything that was logged, or that failed on the device, fails the test.
 */
static inline void render_frame(render *r, const char *name)
{
    if (!r->ready)
        assert_int_equal(kd_schedule_init(r->schedule), KD_OK);
    r->ready = true;
    assert_int_equal(kd_schedule_run(r->schedule), KD_OK);
    size_t pixels = (size_t)r->frame->width * r->frame->height;
    const kd_picture *picture = kd_singleton(r->world, kd_picture);
    uint16_t *half = malloc(pixels * 4 * sizeof *half);
    free(r->hdr);
    free(r->ldr);
    r->hdr = malloc(pixels * 4 * sizeof *r->hdr);
    r->ldr = malloc(pixels * 4);
    assert_true(half != NULL && r->hdr != NULL && r->ldr != NULL);
    kd_gpu_barrier(r->gpu, 1023);
    kd_gpu_read_texture(r->gpu, picture->hdr, 0, half, pixels * 4 * sizeof *half);
    kd_gpu_read_texture(r->gpu, picture->ldr, 0, r->ldr, pixels * 4);
    for (size_t i = 0; i < pixels * 4; i++)
        r->hdr[i] = render_half(half[i]);
    free(half);
    kd_gpu_end_frame(r->gpu);
    r->frame->index++;
    const char *folder = getenv("KD_TEST_PICTURES");
    if (folder != NULL)
        render_write_ppm(r, folder, name);
    if (kd_gpu_failed(r->gpu))
        fail_msg("the device failed: %s", r->warnings);
}

static inline const float *render_pixel(const render *r, uint32_t x, uint32_t y)
{
    assert_true(x < r->frame->width && y < r->frame->height);
    return r->hdr + ((size_t)y * r->frame->width + x) * 4;
}

/* Assert that a pixel's channels are within `tolerance` (relative to what is expected, at least 1e-3
 * absolute). */
static inline void render_expect(const render *r, uint32_t x, uint32_t y, kd_vec3 expected, float tolerance)
{
    const float *p = render_pixel(r, x, y), *e = &expected.x;
    for (int i = 0; i < 3; i++)
        if (!(fabsf(p[i] - e[i]) <= fmaxf(fabsf(e[i]) * tolerance, 1e-3f)))
            fail_msg("pixel %u %u channel %d is %g, expected %g", x, y, i, (double)p[i], (double)e[i]);
}

#endif
