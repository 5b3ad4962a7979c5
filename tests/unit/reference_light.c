/* Light whose amount is known: each case has its formula in a comment. */

#include "tests/reference_fixture.h"

static const kd_vec3 origin = {0, 0, 0}, down = {0, -1, 0};

/* The plane y = 0, seen from straight above through one pixel. */
static void look_at_plane(fixture *f, const kd_material_desc *material)
{
    fixture_shape(f, KD_SHAPE_PLANE, (kd_vec3){2, 1, 2}, material, FIXTURE_AT(0, 0, 0));
    fixture_camera(f, (kd_vec3){0, 3, 0}, origin);
}

/* Lambert: E cos(t) albedo / pi. One light and no bounce leave nothing to chance. */
static void directional_light_on_lambert_is_exact(void **state)
{
    fixture *f = *state;
    kd_material_desc m = fixture_material(0.6f, 0, 1);
    f->desc.lambert = true;
    f->desc.spp = 1;
    look_at_plane(f, &m);
    fixture_light(f, (kd_light){.type = KD_DIRECTIONAL, .color = {1, 1, 1}, .intensity = 5}, origin,
                  (kd_vec3){3, -4, 0});
    fixture_expect(fixture_mean(f, KD_REFERENCE_DIRECT), 5 * 0.8 * 0.6 / FIXTURE_PI, 1e-5);
    fixture_expect(fixture_mean(f, KD_REFERENCE_FINAL), 5 * 0.8 * 0.6 / FIXTURE_PI, 1e-5);
}

/* Lambert: I / d^2 albedo / pi below the lamp; d = 2, then 4. */
static void point_light_falls_with_the_square_of_distance(void **state)
{
    fixture *f = *state;
    kd_material_desc m = fixture_material(0.5f, 0, 1);
    f->desc.lambert = true;
    f->desc.spp = 1;
    look_at_plane(f, &m);
    kd_entity lamp =
        kd_spawn(f->world, KD_VAL(kd_light, {.type = KD_POINT, .color = {1, 1, 1}, .intensity = 7}),
                 KD_VAL(kd_transform, KD_TRANSFORM_IDENTITY), KD_TAG(kd_world_transform));
    for (float d = 2; d <= 4; d *= 2) {
        kd_find_mut(f->world, lamp, kd_transform)->position = (kd_vec3){0, d, 0};
        fixture_expect(fixture_mean(f, KD_REFERENCE_DIRECT), 7.0 / (double)(d * d) * 0.5 / FIXTURE_PI, 1e-5);
    }
}

/* KHR_lights_punctual: with inner 0 and outer 60 degrees, cosine c off the axis gives ((c - 0.5) / 0.5)^2; at
 * 1 / 2 of the range the window is (1 - 1/16). */
static void spot_light_fades_by_cone_and_range(void **state)
{
    fixture *f = *state;
    kd_material_desc m = fixture_material(1, 0, 1);
    f->desc.lambert = true;
    f->desc.spp = 1;
    look_at_plane(f, &m);
    kd_light spot = {.type = KD_SPOT,
                     .color = {1, 1, 1},
                     .intensity = 1,
                     .outer_cone = (float)(FIXTURE_PI / 3),
                     .range = 4};
    fixture_light(f, spot, (kd_vec3){0, 2, 0}, (kd_vec3){0.6f, -0.8f, 0});
    double cone = (0.8 - 0.5) / 0.5, window = 1 - 1.0 / 16;
    fixture_expect(fixture_mean(f, KD_REFERENCE_DIRECT), cone * cone * window / 4 / FIXTURE_PI, 1e-4);
}

/* A box between lamp and plane takes all; with no_shadow nothing, be it the light's or the box's. */
static void shadow_is_cast_unless_switched_off(void **state)
{
    fixture *f = *state;
    kd_material_desc m = fixture_material(1, 0, 1);
    f->desc.lambert = true;
    f->desc.bounces = 0;
    f->desc.spp = 1;
    look_at_plane(f, &m);
    kd_entity box = fixture_shape(f, KD_SHAPE_BOX, (kd_vec3){1, 1, 1}, &m, FIXTURE_AT(2, 2, 0));
    kd_light sun = {.type = KD_DIRECTIONAL, .color = {1, 1, 1}, .intensity = 1};
    kd_entity light = kd_spawn(f->world, (kd_value){&kd_light_desc, &sun},
                               KD_VAL(kd_transform, {origin, fixture_look((kd_vec3){-1, -1, 0}), {1, 1, 1}}),
                               KD_TAG(kd_world_transform));
    const double lit = sqrt(0.5) / FIXTURE_PI;
    assert_true(fixture_mean(f, KD_REFERENCE_DIRECT) == 0);
    kd_entity mesh = kd_first_child(f->world, box);
    kd_find_mut(f->world, mesh, kd_mesh_instance)->no_shadow = true;
    fixture_expect(fixture_mean(f, KD_REFERENCE_DIRECT), lit, 1e-5);
    kd_find_mut(f->world, mesh, kd_mesh_instance)->no_shadow = false;
    kd_find_mut(f->world, light, kd_light)->no_shadow = true;
    fixture_expect(fixture_mean(f, KD_REFERENCE_DIRECT), lit, 1e-5);
}

/* Form factor of a small patch to a parallel rectangle, one corner above it, edges a and b, height 1:
 * F = (A atan B + C atan D) / 2 pi with A = a / sqrt(1 + a^2), B = b / sqrt(1 + a^2), C and D with a and b
 * exchanged. Four such quarters make the lamp. Radiance is albedo F L. Source  Howell, A Catalog of Radiation
 * Heat Transfer Configuration Factors, B-3 */
static void area_light_agrees_with_its_form_factor(void **state)
{
    fixture *f = *state;
    kd_material_desc m = fixture_material(0.5f, 0, 1), lamp = fixture_material(0, 0, 1);
    lamp.emissive = (kd_vec3){3, 3, 3};
    f->desc.lambert = true;
    f->desc.spp = 4096;
    fixture_shape(f, KD_SHAPE_PLANE, (kd_vec3){2, 1, 2}, &m, FIXTURE_AT(0, 0, 0));
    kd_transform above = FIXTURE_AT(0, 1, 0);
    above.rotation = (kd_quat){1, 0, 0, 0}; /* faces down */
    fixture_shape(f, KD_SHAPE_PLANE, (kd_vec3){1, 1, 2}, &lamp, above);
    fixture_camera(f, (kd_vec3){1.2f, 0.8f, 0}, origin);
    double a = 0.5, b = 1, A = a / sqrt(1 + a * a), B = b / sqrt(1 + a * a), C = b / sqrt(1 + b * b),
           D = a / sqrt(1 + b * b);
    double factor = 4 * (A * atan(B) + C * atan(D)) / (2 * FIXTURE_PI);
    fixture_expect(fixture_mean(f, KD_REFERENCE_FINAL), 0.5 * factor * 3, 0.002);
    assert_int_equal(f->info.emitters, 2);
}

static void one_sided_lamp_shines_from_its_front_alone(void **state)
{
    fixture *f = *state;
    kd_material_desc m = fixture_material(0.5f, 0, 1), lamp = fixture_material(0, 0, 1);
    lamp.emissive = (kd_vec3){3, 3, 3};
    lamp.double_sided = false;
    f->desc.spp = 64;
    fixture_shape(f, KD_SHAPE_PLANE, (kd_vec3){2, 1, 2}, &m, FIXTURE_AT(0, 0, 0));
    fixture_shape(f, KD_SHAPE_PLANE, (kd_vec3){1, 1, 2}, &lamp, FIXTURE_AT(0, 1, 0)); /* faces up */
    fixture_camera(f, (kd_vec3){1.2f, 0.8f, 0}, origin);
    assert_true(fixture_mean(f, KD_REFERENCE_FINAL) == 0);
}

/* A closed room whose walls send out 1 and reflect 1/2: 1 + 1/2 + 1/4 … = 2 everywhere; up to bounce n, where
 * bounce 0 is the light straight from the walls, 2 - 2^-(n+1). */
static void furnace_is_equally_bright_after_every_bounce(void **state)
{
    fixture *f = *state;
    kd_material_desc m = fixture_material(0.5f, 0, 1);
    m.emissive = (kd_vec3){1, 1, 1};
    f->desc.lambert = true;
    f->desc.spp = 1024;
    f->frame->width = f->frame->height = 8;
    fixture_shape(f, KD_SHAPE_BOX, (kd_vec3){2, 3, 4}, &m, FIXTURE_AT(0, 0, 0));
    fixture_camera(f, (kd_vec3){0.3f, 0.2f, 1}, (kd_vec3){-0.5f, -1, -2});
    for (int32_t n = 0; n < 4; n++) {
        f->desc.bounces = n;
        fixture_expect(fixture_mean(f, KD_REFERENCE_FINAL), 2 - pow(0.5, n + 1), 0.003);
    }
    f->desc.gathered = true; /* light of emitters bounces once less */
    for (int32_t n = 0; n < 3; n++) {
        f->desc.bounces = n;
        fixture_expect(fixture_mean(f, KD_REFERENCE_FINAL), 2 - pow(0.5, n), 0.003);
    }
    f->desc.bounces = KD_REFERENCE_ENDLESS;
    fixture_expect(fixture_mean(f, KD_REFERENCE_FINAL), 2, 0.003);
    assert_int_equal(f->info.bad_samples, 0);
}

/* A convex Lambert body under a sky of 1 reflects its albedo, exactly: every path's weight is the albedo. */
static void sky_on_a_convex_body_gives_its_albedo(void **state)
{
    fixture *f = *state;
    kd_material_desc m = fixture_material(0.7f, 0, 1);
    f->desc.lambert = true;
    f->desc.spp = 16;
    f->frame->settings.light_ambient = 1;
    fixture_shape(f, KD_SHAPE_BOX, (kd_vec3){1, 1, 1}, &m, FIXTURE_AT(0, 0, 0));
    fixture_camera(f, (kd_vec3){2, 2, 3}, origin);
    fixture_expect(fixture_mean(f, KD_REFERENCE_FINAL), 0.7, 1e-5);
    fixture_expect(fixture_mean(f, KD_REFERENCE_DIFFUSE), 0.7, 1e-5);
}

/* Many lights: one of them is asked a sample, chosen by what it gives; the mean is their sum. */
static void many_lights_add_up(void **state)
{
    fixture *f = *state;
    kd_material_desc m = fixture_material(1, 0, 1);
    double sum = 0;
    f->desc.lambert = true;
    f->desc.spp = 4096;
    look_at_plane(f, &m);
    for (int i = 0; i < 100; i++) {
        float x = (float)(i % 10) * 0.3f - 1.2f, z = (float)(i / 10) * 0.4f - 1.5f, d2 = x * x + z * z + 1;
        fixture_light(f, (kd_light){.type = KD_POINT, .color = {1, 1, 1}, .intensity = (float)(1 + i % 3)},
                      (kd_vec3){x, 1, z}, down);
        sum += (double)(1 + i % 3) / pow((double)d2, 1.5) / FIXTURE_PI;
    }
    /* Lights are chosen by just what they add: no noise beyond rounding. */
    fixture_expect(fixture_mean(f, KD_REFERENCE_DIRECT), sum, 1e-3);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        FIXTURE_TEST(directional_light_on_lambert_is_exact),
        FIXTURE_TEST(point_light_falls_with_the_square_of_distance),
        FIXTURE_TEST(spot_light_fades_by_cone_and_range),
        FIXTURE_TEST(shadow_is_cast_unless_switched_off),
        FIXTURE_TEST(area_light_agrees_with_its_form_factor),
        FIXTURE_TEST(one_sided_lamp_shines_from_its_front_alone),
        FIXTURE_TEST(furnace_is_equally_bright_after_every_bounce),
        FIXTURE_TEST(sky_on_a_convex_body_gives_its_albedo),
        FIXTURE_TEST(many_lights_add_up),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
