/* Light on a plane, pixel by pixel, against what the formulas say. */

#include "tests/render_fixture.h"

static const float PI = 3.14159265f;

/* Reflected radiance of render_matte per unit of irradiance, seen along n (v = n), light from l. glTF 2.0
 * appendix B with alpha = 1: D = 1 / pi; V = 0.5 / (n.l + n.v), as both square roots are 1; F with f0 = 0.04
 * at v.h, h halfway. */
static float matte_brdf(float albedo, float n_dot_l)
{
    float v_dot_h = sqrtf((1 + n_dot_l) / 2); /* cosine of half the angle between v = n and l */
    float f = 0.04f + 0.96f * powf(1 - v_dot_h, 5);
    return (1 - f) * albedo / PI + f * (1 / PI) * 0.5f / (n_dot_l + 1);
}

static kd_vec3 grey(float x)
{
    return (kd_vec3){x, x, x};
}

static kd_light sun(float intensity)
{
    return (kd_light){.type = KD_DIRECTIONAL, .color = {1, 1, 1}, .intensity = intensity};
}

static void add_floor(render *r, float albedo)
{
    kd_material_desc m = render_matte(albedo);
    render_shape(r, KD_SHAPE_PLANE, (kd_vec3){20, 1, 20}, &m, (kd_vec3){0, 0, 0}, RENDER_UPRIGHT,
                 RENDER_UNIT);
}

/* E = 3 lx along a direction 60 degrees off the normal: n.l = 1/2, radiance = 3 * 1/2 * brdf. Tolerance: the
 * albedo keeps 8 bits of its root (0.4 %), half floats 0.1 %. */
static void directional_light_on_plane_is_lambert(void **state)
{
    render *r = *state;
    add_floor(r, 0.5f);
    render_top_camera(r, 2);
    render_light(r, sun(3), (kd_vec3){0, 5, 0}, (kd_vec3){sinf(PI / 3), -cosf(PI / 3), 0});
    render_frame(r, "directional");
    render_expect(r, 80, 60, grey(3 * 0.5f * matte_brdf(0.5f, 0.5f)), 0.01f);
    render_expect(r, 5, 5, grey(3 * 0.5f * matte_brdf(0.5f, 0.5f)), 0.01f);
}

/* A point light of 10 cd two metres above the plane. Under it E = 10 / 4. Beside it at x: d^2 = 4 + x^2, n.l
 * = 2 / d. The camera is orthographic with 60 pixels for 2 m, so the middle of pixel 110 lies at x = 30.5 /
 * 30, that of row 60 at z = 0.5 / 30. */
static void point_light_on_plane_falls_with_the_square(void **state)
{
    render *r = *state;
    add_floor(r, 0.8f);
    render_top_camera(r, 2);
    render_light(r, (kd_light){.type = KD_POINT, .color = {1, 0.5f, 0.25f}, .intensity = 10},
                 (kd_vec3){0, 2, 0}, (kd_vec3){0, 0, -1});
    render_frame(r, "point");
    for (uint32_t px = 80; px < 160; px += 30) {
        float x = ((float)px + 0.5f - 80) / 30, z = 0.5f / 30, d2 = 4 + x * x + z * z;
        float e = 10 / d2 * 2 / sqrtf(d2), l = e * matte_brdf(0.8f, 2 / sqrtf(d2));
        render_expect(r, px, 60, (kd_vec3){l, l * 0.5f, l * 0.25f}, 0.01f);
    }
}

/* KHR_lights_punctual's window (1 - (d / range)^4): at range 2.5 and d = 2 it is 1 - 0.4096. */
static void point_light_range_windows_the_light(void **state)
{
    render *r = *state;
    add_floor(r, 0.8f);
    render_top_camera(r, 2);
    render_light(r, (kd_light){.type = KD_POINT, .color = {1, 1, 1}, .intensity = 10, .range = 2.5f},
                 (kd_vec3){0, 2, 0}, (kd_vec3){0, 0, -1});
    render_frame(r, "range");
    render_expect(r, 80, 60, grey(10 / 4.0f * 0.5904f * matte_brdf(0.8f, 1)), 0.01f);
    /* d = sqrt(4 + 1.55^2 + …) = 2.53 > 2.5: dark */
    render_expect(r, 127, 60, grey(0), 0.01f);
}

/* Cones of 20 and 40 degrees: full light inside, none outside, and at 30 degrees ((cos 30 - cos 40) / (cos 20
 * - cos 40))^2. */
static void spot_light_fades_between_its_cones(void **state)
{
    render *r = *state;
    add_floor(r, 0.8f);
    render_top_camera(r, 2);
    render_light(r,
                 (kd_light){.type = KD_SPOT,
                            .color = {1, 1, 1},
                            .intensity = 10,
                            .inner_cone = PI / 9,
                            .outer_cone = 2 * PI / 9},
                 (kd_vec3){0, 2, 0}, (kd_vec3){0, -1, 0});
    render_frame(r, "spot");
    const uint32_t columns[] = {80, 95, 114, 125, 140};
    for (int i = 0; i < 5; i++) {
        float x = ((float)columns[i] + 0.5f - 80) / 30, z = 0.5f / 30, d2 = 4 + x * x + z * z,
              c = 2 / sqrtf(d2);
        float t = (c - cosf(2 * PI / 9)) / (cosf(PI / 9) - cosf(2 * PI / 9));
        t = fminf(fmaxf(t, 0), 1);
        render_expect(r, columns[i], 60, grey(10 / d2 * c * t * t * matte_brdf(0.8f, c)), 0.015f);
    }
}

/* Emission adds, unlit colour stays as it is, the sky lights everything without GI and shows behind. */
static void emission_and_sky_add_up(void **state)
{
    render *r = *state;
    kd_material_desc glow = render_matte(0), unlit = render_matte(1);
    glow.emissive = (kd_vec3){100, 10, 2000};
    unlit.base_color = (kd_vec4){0.25f, 0.5f, 1, 1};
    unlit.unlit = true;
    render_shape(r, KD_SHAPE_PLANE, (kd_vec3){1, 1, 1}, &glow, (kd_vec3){-1, 0, 0}, RENDER_UPRIGHT,
                 RENDER_UNIT);
    render_shape(r, KD_SHAPE_PLANE, (kd_vec3){1, 1, 1}, &unlit, (kd_vec3){1, 0, 0}, RENDER_UPRIGHT,
                 RENDER_UNIT);
    render_top_camera(r, 2);
    render_frame(r, "emission");
    render_expect(r, 50, 60, (kd_vec3){100, 10, 2000}, 0.002f);
    render_expect(r, 110, 60, (kd_vec3){0.25f, 0.5f, 1}, 0.002f);
    render_expect(r, 80, 10, grey(0), 0);
    r->frame->settings.light_ambient = 0.5f;
    render_frame(r, "sky");
    render_expect(r, 110, 60, (kd_vec3){0.25f, 0.5f, 1}, 0.002f);
    render_expect(r, 80, 10, grey(0.5f), 0.002f);
}

/* The picture's own row 0 is the top: a plane towards -z, which the camera sees above the middle, must be in
 * low rows. */
static void picture_has_row_0_on_top(void **state)
{
    render *r = *state;
    kd_material_desc unlit = render_matte(1);
    unlit.unlit = true;
    render_shape(r, KD_SHAPE_PLANE, (kd_vec3){1, 1, 1}, &unlit, (kd_vec3){1, 0, -1}, RENDER_UPRIGHT,
                 RENDER_UNIT);
    render_top_camera(r, 2);
    render_frame(r, "top");
    render_expect(r, 110, 30, grey(1), 0.001f);
    render_expect(r, 110, 90, grey(0), 0.001f);
    render_expect(r, 50, 30, grey(0), 0.001f);
    assert_int_equal(r->ldr[(30 * 160 + 110) * 4], 255);
    assert_int_equal(r->ldr[(90 * 160 + 110) * 4], 0);
}

/* Mean luminance to mid grey: a picture of one luminance comes out at 0.18 in linear terms, whatever it was.
 * sRGB of 0.18 is 1.055 * 0.18^(1/2.4) - 0.055 = 0.4613, 117.6 of 255. */
static void auto_exposure_puts_a_flat_picture_to_mid_grey(void **state)
{
    render *r = *state;
    r->frame->settings.view_auto_exposure = true;
    render_top_camera(r, 2);
    for (int i = -3; i <= 3; i++) {
        r->frame->settings.light_ambient = powf(10, (float)i);
        render_frame(r, "exposure");
        assert_in_range(r->ldr[0], 117, 118);
    }
    r->frame->settings.view_auto_exposure = false;
    r->frame->settings.light_ambient = 0.045f;
    r->frame->settings.view_exposure_ev = 2; /* 0.045 * 4 = 0.18 */
    render_frame(r, "exposure");
    assert_in_range(r->ldr[0], 117, 118);
}

/* Views that other systems draw into the picture after resolve go through the same exposure and curve: with
 * nobody drawing, the final picture must come out. */
static void late_views_are_tone_mapped_alike(void **state)
{
    render *r = *state;
    uint8_t *final = malloc(160 * 120 * 4);
    assert_non_null(final);
    r->frame->settings.view_tonemap = KD_TONEMAP_ACES;
    r->frame->settings.view_exposure_ev = 0.5f;
    add_floor(r, 0.5f);
    render_top_camera(r, 2);
    render_light(r, (kd_light){.type = KD_POINT, .color = {1, 0.7f, 0.4f}, .intensity = 9},
                 (kd_vec3){0, 1, 0}, (kd_vec3){0, 0, -1});
    render_frame(r, "final");
    memcpy(final, r->ldr, 160 * 120 * 4);
    r->frame->view = KD_VIEW_OCTREE;
    render_frame(r, "late");
    /* the two passes round a half float apart: a step of 255 at most */
    for (int i = 0; i < 160 * 120 * 4; i++)
        assert_in_range(r->ldr[i], final[i] > 0 ? final[i] - 1 : 0, final[i] < 255 ? final[i] + 1 : 255);
    free(final);
}

/* Whatever legal order the systems run in, and however often: the same bytes. */
static void any_legal_order_gives_the_same_picture(void **state)
{
    render *r = *state;
    kd_material_desc m = render_matte(0.7f);
    uint8_t *first = malloc(160 * 120 * 4);
    assert_non_null(first);
    add_floor(r, 0.5f);
    render_shape(r, KD_SHAPE_SPHERE, (kd_vec3){1, 1, 1}, &m, (kd_vec3){0, 0.5f, 0}, RENDER_UPRIGHT,
                 RENDER_UNIT);
    render_camera(r, (kd_vec3){1, 2, 3}, (kd_vec3){0, 0.3f, 0}, 0.8f);
    render_light(r, sun(2), (kd_vec3){0, 5, 0}, (kd_vec3){1, -1, 0.3f});
    render_light(r, (kd_light){.type = KD_POINT, .color = {1, 0.7f, 0.4f}, .intensity = 9},
                 (kd_vec3){-1, 1, 1}, (kd_vec3){0, 0, -1});
    render_frame(r, "order");
    memcpy(first, r->ldr, 160 * 120 * 4);
    for (uint64_t seed = 0; seed < 8; seed++) {
        kd_schedule_randomize(r->schedule, seed);
        render_frame(r, "order");
        assert_memory_equal(r->ldr, first, 160 * 120 * 4);
    }
    free(first);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        RENDER_TEST(directional_light_on_plane_is_lambert),
        RENDER_TEST(point_light_on_plane_falls_with_the_square),
        RENDER_TEST(point_light_range_windows_the_light),
        RENDER_TEST(spot_light_fades_between_its_cones),
        RENDER_TEST(emission_and_sky_add_up),
        RENDER_TEST(picture_has_row_0_on_top),
        RENDER_TEST(late_views_are_tone_mapped_alike),
        RENDER_TEST(any_legal_order_gives_the_same_picture),
        RENDER_TEST(auto_exposure_puts_a_flat_picture_to_mid_grey),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
