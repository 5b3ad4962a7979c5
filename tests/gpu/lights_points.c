/* Light and shadow at points in space, wherever the camera looks: what voxels ask for. */

#include "shaders/shared/bindings.h"
#include "shaders/shared/scene.h"
#include "tests/render_fixture.h"

typedef struct probe {
    kd_vec3 position_ws;
    float light;
    kd_vec3 normal_ws;
    float offset_m;
    kd_vec3 irradiance;
    float shadow;
    kd_vec3 to_light;
    float shadow_voxel;
} probe;

static void ask(render *r, probe *probes, uint32_t count)
{
    const kd_lighting *lighting = kd_singleton(r->world, kd_lighting);
    kd_gpu_program program =
        kd_gpu_make_program(r->gpu, &(kd_gpu_program_desc){.compute = "tests/gpu/lights_probe.comp"});
    kd_gpu_buffer buffer = kd_gpu_make_buffer(
        r->gpu, &(kd_gpu_buffer_desc){.size = count * sizeof *probes, .data = probes, .name = "probes"});
    kd_gpu_bind_storage(r->gpu, 0, buffer);
    kd_gpu_bind_uniform_buffer(r->gpu, KD_BIND_VIEW, lighting->view, 0, sizeof(struct kd_view_params));
    kd_gpu_bind_uniform_buffer(r->gpu, KD_BIND_LIGHTS, lighting->lights, 0, sizeof(struct kd_lights_params));
    kd_gpu_bind_texture(r->gpu, KD_UNIT_SHADOW_DIRECTIONAL, lighting->shadow_directional);
    kd_gpu_bind_texture(r->gpu, KD_UNIT_SHADOW_SPOT, lighting->shadow_spot);
    kd_gpu_dispatch(r->gpu, program, count, 1, 1);
    kd_gpu_barrier(r->gpu, KD_BARRIER_BUFFER_UPDATE);
    kd_gpu_read_buffer(r->gpu, buffer, 0, probes, count * sizeof *probes);
    kd_gpu_destroy_program(r->gpu, program);
    kd_gpu_destroy_buffer(r->gpu, buffer);
    assert_false(kd_gpu_failed(r->gpu));
}

static void expect_shadow(const probe *p, float expected)
{
    if (!(fabsf(p->shadow - expected) < 0.01f && fabsf(p->shadow_voxel - expected) < 0.01f))
        fail_msg("at %g %g %g: %g, voxel %g; expected %g", (double)p->position_ws.x, (double)p->position_ws.y,
                 (double)p->position_ws.z, (double)p->shadow, (double)p->shadow_voxel, (double)expected);
}

static void add_box_on_floor(render *r)
{
    kd_material_desc m = render_matte(0.8f);
    render_shape(r, KD_SHAPE_PLANE, (kd_vec3){30, 1, 30}, &m, (kd_vec3){0, 0, 0}, RENDER_UPRIGHT,
                 RENDER_UNIT);
    render_shape(r, KD_SHAPE_BOX, (kd_vec3){1, 1, 1}, &m, (kd_vec3){0, 0.5f, 0}, RENDER_UPRIGHT, RENDER_UNIT);
}

static probe up_probe(float x, float z, float light)
{
    return (probe){.position_ws = {x, 0, z}, .light = light, .normal_ws = {0, 1, 0}, .offset_m = 0.02f};
}

/* A sun at 45 degrees towards +x behind a camera that looks away from the box, 8 m off: the box is outside
 * the view and must shade all the same. */
static void points_behind_the_camera_are_shadowed(void **state)
{
    render *r = *state;
    add_box_on_floor(r);
    render_camera(r, (kd_vec3){0, 1, 8}, (kd_vec3){0, 1, 20}, 0.8f);
    render_light(r, (kd_light){.type = KD_DIRECTIONAL, .color = {1, 0.5f, 0.25f}, .intensity = 3},
                 (kd_vec3){0, 5, 0}, (kd_vec3){1, -1, 0});
    render_frame(r, "behind");
    probe probes[] = {up_probe(1, 0, 0),     up_probe(0.7f, 0.3f, 0), up_probe(1.75f, 0, 0),
                      up_probe(-0.8f, 0, 0), up_probe(1, 0.8f, 0),    up_probe(-10, 7, 0)};
    ask(r, probes, 6);
    for (int i = 0; i < 6; i++) {
        expect_shadow(&probes[i], i < 2 ? 0.0f : 1.0f);
        assert_float_equal(probes[i].irradiance.x, 3, 1e-4);
        assert_float_equal(probes[i].irradiance.z, 0.75, 1e-4);
        assert_float_equal(probes[i].to_light.x, -sqrtf(0.5f), 1e-4);
        assert_float_equal(probes[i].to_light.y, sqrtf(0.5f), 1e-4);
    }
}

/* Faces of the box itself: the one to the sun is lit, the top too, the one away is dark; the floor below it
 * is dark. */
static void faces_of_a_box_shade_themselves(void **state)
{
    render *r = *state;
    add_box_on_floor(r);
    render_camera(r, (kd_vec3){0, 2, 4}, (kd_vec3){0, 0, 0}, 0.8f);
    render_light(r, (kd_light){.type = KD_DIRECTIONAL, .color = {1, 1, 1}, .intensity = 1},
                 (kd_vec3){0, 5, 0}, (kd_vec3){1, -1, 0});
    render_frame(r, "faces");
    probe probes[] = {{.position_ws = {-0.5f, 0.6f, 0}, .normal_ws = {-1, 0, 0}, .offset_m = 0.02f},
                      {.position_ws = {0, 1, 0}, .normal_ws = {0, 1, 0}, .offset_m = 0.02f},
                      {.position_ws = {0.5f, 0.6f, 0}, .normal_ws = {1, 0, 0}, .offset_m = 0.02f},
                      up_probe(0, 0, 0)};
    ask(r, probes, 4);
    for (int i = 0; i < 4; i++)
        expect_shadow(&probes[i], i < 2 ? 1.0f : 0.0f);
}

/* No map reaches farther than light.shadow_distance, here 3 m from the camera at x = -10: the box at 0 casts
 * nothing. */
static void points_outside_every_map_are_lit(void **state)
{
    render *r = *state;
    add_box_on_floor(r);
    r->frame->settings.light_shadow_distance = 3;
    render_camera(r, (kd_vec3){-10, 1, 0}, (kd_vec3){0, 0, 0}, 0.8f);
    render_light(r, (kd_light){.type = KD_DIRECTIONAL, .color = {1, 1, 1}, .intensity = 1},
                 (kd_vec3){0, 5, 0}, (kd_vec3){1, -1, 0});
    render_frame(r, "outside");
    probe probes[] = {up_probe(1, 0, 0)};
    ask(r, probes, 1);
    expect_shadow(&probes[0], 1);
}

/* One light of each kind in mixed order: they are renumbered, directional first, and each has its own maps.
 * The lamp hangs at
 * (-2, 2, 0), the spot at (2, 3, 0): the box is between each and the floor beyond. */
static void kinds_of_light_do_not_mix_their_maps(void **state)
{
    render *r = *state;
    add_box_on_floor(r);
    render_camera(r, (kd_vec3){0, 3, 6}, (kd_vec3){0, 0, 0}, 0.8f);
    render_light(r, (kd_light){.type = KD_POINT, .color = {1, 1, 1}, .intensity = 8}, (kd_vec3){-2, 2, 0},
                 (kd_vec3){0, 0, -1});
    render_light(r, (kd_light){.type = KD_SPOT, .color = {1, 1, 1}, .intensity = 8, .outer_cone = 0.9f},
                 (kd_vec3){2, 3, 0}, (kd_vec3){-1, -1, 0});
    render_light(r, (kd_light){.type = KD_DIRECTIONAL, .color = {1, 1, 1}, .intensity = 1},
                 (kd_vec3){0, 5, 0}, (kd_vec3){0, -1, 1});
    render_light(r, (kd_light){.type = KD_DIRECTIONAL, .color = {1, 1, 1}, .intensity = 1},
                 (kd_vec3){0, 5, 0}, (kd_vec3){0, -1, -1});
    render_frame(r, "kinds");
    probe probes[16];
    const float places[4][2] = {{0, 1}, {0, -1}, {1, 0}, {-1, 0}}; /* +z, -z, +x, -x of the box */
    for (int light = 0; light < 4; light++)
        for (int place = 0; place < 4; place++)
            probes[light * 4 + place] = up_probe(places[place][0], places[place][1], (float)light);
    ask(r, probes, 16);
    /* The suns shade +z and -z; the lamp at -x shades +x, the spot at +x shades -x. */
    for (int i = 0; i < 16; i++)
        expect_shadow(&probes[i], i / 4 == i % 4 ? 0.0f : 1.0f);
    const probe *lamp = &probes[8]; /* at (0, 0, 1): d^2 = 4 + 4 + 1 */
    assert_float_equal(lamp->irradiance.x, 8.0f / 9, 1e-4);
    assert_float_equal(lamp->to_light.x, -2.0f / 3, 1e-4);
}

/* Small camera moves must not make the edge of a shadow crawl: a half-lit point keeps its share of light to
 * the texel. The maps move in whole texels with unchanged size, so a fixed point sees the same texels while
 * the camera turns and moves. */
static void shadow_edges_stand_still_when_the_camera_moves(void **state)
{
    render *r = *state;
    add_box_on_floor(r);
    kd_entity camera = render_camera(r, (kd_vec3){0, 2, 4}, (kd_vec3){0, 0, 0}, 0.8f);
    render_light(r, (kd_light){.type = KD_DIRECTIONAL, .color = {1, 1, 1}, .intensity = 1},
                 (kd_vec3){0, 5, 0}, (kd_vec3){1, -1.1f, 0.2f});
    probe first[32], moved[32];
    for (int step = 0; step < 4; step++) {
        for (int i = 0; i < 32; i++) /* across the edge near x = 0.5 + 1 / 1.1 */
            moved[i] = up_probe(1.38f + (float)i * 0.002f, 0.2f, 0);
        kd_transform *t = kd_find_mut(r->world, camera, kd_transform);
        t->position.x = 0.0137f * (float)step;
        t->rotation = render_camera_look((kd_vec3){(float)step * 0.4f, -0.3f, -1});
        render_frame(r, "still");
        ask(r, moved, 32);
        int between = 0;
        for (int i = 0; i < 32; i++) {
            between += moved[i].shadow > 0.1f && moved[i].shadow < 0.9f;
            if (step > 0) /* rounding may move a point by a hundredth of a texel */
                assert_float_equal(moved[i].shadow, first[i].shadow, 0.02);
        }
        assert_true(between > 0);
        if (step == 0)
            memcpy(first, moved, sizeof first);
    }
}

static int setup(void **state)
{
    setenv("KANDIL_SHADER_DIR", KD_SOURCE_DIR, 1);
    return render_setup(state);
}
#define TEST(name) cmocka_unit_test_setup_teardown(name, setup, render_teardown)

int main(void)
{
    const struct CMUnitTest tests[] = {
        TEST(points_behind_the_camera_are_shadowed),
        TEST(faces_of_a_box_shade_themselves),
        TEST(points_outside_every_map_are_lit),
        TEST(kinds_of_light_do_not_mix_their_maps),
        TEST(shadow_edges_stand_still_when_the_camera_moves),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
