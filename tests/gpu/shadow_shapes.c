/* Shadows: where they fall, what casts them, and that lit surfaces are free of their own. */

#include "tests/render_fixture.h"

static const float PI = 3.14159265f;

static kd_light sun(float intensity)
{
    return (kd_light){.type = KD_DIRECTIONAL, .color = {1, 1, 1}, .intensity = intensity};
}

static void add_floor(render *r)
{
    kd_material_desc m = render_matte(0.8f);
    render_shape(r, KD_SHAPE_PLANE, (kd_vec3){20, 1, 20}, &m, (kd_vec3){0, 0, 0}, RENDER_UPRIGHT,
                 RENDER_UNIT);
}

static kd_entity add_box(render *r, kd_vec3 size, kd_vec3 position)
{
    kd_material_desc m = render_matte(0.8f);
    return render_shape(r, KD_SHAPE_BOX, size, &m, position, RENDER_UPRIGHT, RENDER_UNIT);
}

/* Light on the floor at (x, 0, z) as a share of what it is at the same place without casters: read twice. */
typedef struct floor_map {
    float *lit;
    uint32_t width, height;
    float half_height;
} floor_map;

static floor_map read_unshadowed(render *r, float half_height)
{
    size_t pixels = (size_t)r->frame->width * r->frame->height;
    floor_map m = {malloc(pixels * sizeof(float)), r->frame->width, r->frame->height, half_height};
    assert_non_null(m.lit);
    for (size_t i = 0; i < pixels; i++)
        m.lit[i] = r->hdr[i * 4];
    return m;
}

static float share_at(const render *r, const floor_map *m, float x, float z)
{
    float scale = (float)m->height / (2 * m->half_height);
    uint32_t px = (uint32_t)floorf((float)m->width / 2 + x * scale),
             py = (uint32_t)floorf((float)m->height / 2 + z * scale);
    return render_pixel(r, px, py)[0] / m->lit[py * m->width + px];
}

static void expect_lit(const render *r, const floor_map *m, float x, float z)
{
    if (!(fabsf(share_at(r, m, x, z) - 1) < 0.01f))
        fail_msg("floor at %g %g has %g of its light, expected all", (double)x, (double)z,
                 (double)share_at(r, m, x, z));
}

static void expect_dark(const render *r, const floor_map *m, float x, float z)
{
    if (!(share_at(r, m, x, z) < 0.01f))
        fail_msg("floor at %g %g has %g of its light, expected none", (double)x, (double)z,
                 (double)share_at(r, m, x, z));
}

/* A box of 1 m on the floor, sun at 45 degrees towards +x: its top edge at x = 0.5, y = 1 throws shadow to x
 * = 1.5; in z the shadow is as wide as the box. The border is sharp to one filter width: 2 texels of 5.66 m /
 * 1024 are 11 mm, pixels are 33. */
static void directional_shadow_of_box_falls_where_it_must(void **state)
{
    render *r = *state;
    add_floor(r);
    render_top_camera(r, 2);
    render_light(r, sun(3), (kd_vec3){0, 5, 0}, (kd_vec3){1, -1, 0});
    render_frame(r, "shadow_sun_open");
    floor_map open = read_unshadowed(r, 2);
    add_box(r, (kd_vec3){1, 1, 1}, (kd_vec3){0, 0.5f, 0});
    render_frame(r, "shadow_sun");
    expect_dark(r, &open, 0.56f, 0);
    expect_dark(r, &open, 1.4f, 0);
    expect_dark(r, &open, 1.0f, 0.44f);
    expect_dark(r, &open, 1.0f, -0.44f);
    expect_lit(r, &open, 1.6f, 0);
    expect_lit(r, &open, 1.0f, 0.58f);
    expect_lit(r, &open, 1.0f, -0.58f);
    expect_lit(r, &open, -0.6f, 0);
    free(open.lit);
}

/* Lamp at 3 m above the middle, a box of 0.5 m at heights of 1.25 to 1.75 m: of its edges the upper ones,
 * 0.25 off the middle, throw the widest shadow, to 0.25 * 3 / (3 - 1.75) = 0.6. */
static void local_shadow_of_box(render *r, kd_light light, const char *name)
{
    add_floor(r);
    render_top_camera(r, 2);
    render_light(r, light, (kd_vec3){0, 3, 0}, (kd_vec3){0, -1, 0});
    render_frame(r, name);
    floor_map open = read_unshadowed(r, 2);
    kd_entity box = add_box(r, (kd_vec3){0.5f, 0.5f, 0.5f}, (kd_vec3){0, 1.5f, 0});
    render_frame(r, name);
    for (int side = 0; side < 4; side++) {
        float x = side == 0 ? 1.0f : side == 1 ? -1.0f : 0, z = side == 2 ? 1.0f : side == 3 ? -1.0f : 0;
        expect_dark(r, &open, x * 0.54f, z * 0.54f);
        expect_lit(r, &open, x * 0.68f, z * 0.68f);
        expect_lit(r, &open, x * 1.1f, z * 1.1f);
    }
    kd_find_mut(r->world, box, kd_transform)->position.x =
        5; /* gone, and so is the shadow, in the same frame */
    render_frame(r, name);
    expect_lit(r, &open, 0.4f, 0);
    free(open.lit);
}

static void spot_shadow_of_box_falls_where_it_must(void **state)
{
    local_shadow_of_box(
        *state,
        (kd_light){
            .type = KD_SPOT, .color = {1, 1, 1}, .intensity = 30, .inner_cone = 0.5f, .outer_cone = 0.6f},
        "shadow_spot");
}

static void point_shadow_of_box_falls_where_it_must(void **state)
{
    local_shadow_of_box(*state, (kd_light){.type = KD_POINT, .color = {1, 1, 1}, .intensity = 30},
                        "shadow_point");
}

/* Each face of a point light's cube: a small lit panel on each of six sides, and a blocker half way to it. */
static void point_light_casts_into_all_six_directions(void **state)
{
    render *r;
    (void)state;
    kd_material_desc m = render_matte(0.8f);
    m.double_sided = true;
    for (int side = 0; side < 6; side++) {
        float s = side % 2 == 0 ? 1.0f : -1.0f;
        kd_vec3 d = {side / 2 == 0 ? s : 0, side / 2 == 1 ? s : 0, side / 2 == 2 ? s : 0};
        kd_vec3 turned = {d.y, -d.x, d.z}; /* any direction at right angles will do to look from the side */
        if (side / 2 == 2)
            turned = (kd_vec3){0, d.z, 0};
        render_setup((void **)&r);
        render_shape(r, KD_SHAPE_BOX, (kd_vec3){0.5f, 0.5f, 0.5f}, &m, kd_vec3_scale(d, 2), RENDER_UPRIGHT,
                     RENDER_UNIT);
        render_light(r, (kd_light){.type = KD_POINT, .color = {1, 1, 1}, .intensity = 30}, (kd_vec3){0, 0, 0},
                     (kd_vec3){0, 0, -1});
        /* looks at the lit face from beside the lamp */
        render_camera(r, kd_vec3_add(kd_vec3_scale(turned, 0.7f), (kd_vec3){0.01f, 0, 0.013f}),
                      kd_vec3_scale(d, 1.75f), 0.5f);
        render_frame(r, "six_open");
        float open = render_pixel(r, 80, 60)[0];
        render_shape(r, KD_SHAPE_BOX, (kd_vec3){0.3f, 0.3f, 0.3f}, &m, kd_vec3_scale(d, 0.6f), RENDER_UPRIGHT,
                     RENDER_UNIT);
        render_frame(r, "six");
        float shadowed = render_pixel(r, 80, 60)[0];
        render_teardown((void **)&r);
        assert_true(open > 0.3f);
        if (!(shadowed < open * 0.01f))
            fail_msg("side %d: %g of %g", side, (double)shadowed, (double)open);
    }
}

/* What is told not to cast does not. */
static void no_shadow_casts_none(void **state)
{
    render *r = *state;
    add_floor(r);
    render_top_camera(r, 2);
    kd_entity light = render_light(r, sun(3), (kd_vec3){0, 5, 0}, (kd_vec3){1, -1, 0});
    render_frame(r, "no_shadow");
    floor_map open = read_unshadowed(r, 2);
    kd_entity box = add_box(r, (kd_vec3){1, 1, 1}, (kd_vec3){0, 0.5f, 0});
    render_frame(r, "no_shadow");
    expect_dark(r, &open, 1, 0);
    kd_find_mut(r->world, light, kd_light)->no_shadow = true;
    render_frame(r, "no_shadow");
    expect_lit(r, &open, 1, 0);
    kd_find_mut(r->world, light, kd_light)->no_shadow = false;
    kd_query *q = kd_query_make(r->world, &(kd_query_desc){.terms = {KD_WRITE(kd_mesh_instance)}});
    for (kd_iter it = kd_query_iter(q); kd_iter_next(&it);)
        for (uint32_t i = 0; i < it.count; i++)
            KD_COLUMN_MUT(&it, kd_mesh_instance, 0)[i].no_shadow = true;
    render_frame(r, "no_shadow");
    expect_lit(r, &open, 1, 0);
    assert_true(kd_alive(r->world, box));
    free(open.lit);
}

static void add_sphere_on_floor(render *r)
{
    kd_material_desc m = render_matte(0.8f);
    add_floor(r);
    render_shape(r, KD_SHAPE_SPHERE, (kd_vec3){1, 1, 1}, &m, (kd_vec3){0, 0.5f, 0}, RENDER_UPRIGHT,
                 RENDER_UNIT);
}

/* The ball's facets are 11 degrees wide: where the light comes in flatter than half of that, sin 5.6 degrees
 * = 0.1 of the full 3 * 0.8 / pi, neighbouring facets may shade one another: -1. */
static float pixel_share(const render *r, const floor_map *open, uint32_t x, uint32_t y)
{
    float lit = open->lit[y * open->width + x];
    return lit > 0.076f ? render_pixel(r, x, y)[0] / lit : -1;
}

/* Pixels that have lost more than half of the light that all four pixels two off have. */
static int count_isolated(const render *r, const floor_map *open)
{
    int isolated = 0;
    for (uint32_t y = 2; y + 2 < r->frame->height; y++)
        for (uint32_t x = 2; x + 2 < r->frame->width; x++) {
            float across = fminf(pixel_share(r, open, x - 2, y), pixel_share(r, open, x + 2, y));
            float along = fminf(pixel_share(r, open, x, y - 2), pixel_share(r, open, x, y + 2));
            float own = pixel_share(r, open, x, y);
            isolated += own >= 0 && own < fminf(across, along) * 0.5f;
        }
    return isolated;
}

/* Acne shows as pixels that differ from all round them. A smooth ball on a plain floor has none, from a sun
 * that barely grazes the floor to a high one. From the sides and from ahead: from behind, the ball's own
 * shadow peeps out as a sliver. */
static void grazing_light_leaves_no_acne(void **state)
{
    render *r = *state;
    r->frame->width = 320;
    r->frame->height = 240;
    add_sphere_on_floor(r);
    render_camera(r, (kd_vec3){0.5f, 1.6f, 3.0f}, (kd_vec3){0, 0.3f, 0}, 0.8f);
    kd_entity light = render_light(r, sun(3), (kd_vec3){0, 5, 0}, (kd_vec3){1, -1, 0});
    for (int turn = 0; turn < 6; turn++) {
        float a = (float)turn * 0.6f, low = 0.12f + 0.1f * (float)turn;
        kd_find_mut(r->world, light, kd_transform)->rotation = render_look((kd_vec3){cosf(a), -low, sinf(a)});
        kd_find_mut(r->world, light, kd_light)->no_shadow = true;
        render_frame(r, "acne_open");
        floor_map open = read_unshadowed(r, 2);
        kd_find_mut(r->world, light, kd_light)->no_shadow = false;
        render_frame(r, "acne");
        int isolated = count_isolated(r, &open);
        free(open.lit);
        if (isolated != 0)
            fail_msg("turn %d: %d isolated dark pixels", turn, isolated);
    }
}

/* A floor point is in the ball's shadow when the line from it to the sun passes the centre (0, 0.5, 0) nearer
 * than the radius 0.5. Borders may be off by 5 cm: a pixel is 3.3 cm, the filter and the lift are a
 * centimetre each. */
static void grazing_shadow_of_sphere_is_where_it_must_be(void **state)
{
    render *r = *state;
    add_sphere_on_floor(r);
    render_top_camera(r, 2);
    for (int turn = 0; turn < 6; turn++) {
        float a = (float)turn * 1.1f, low = 0.08f + 0.1f * (float)turn;
        kd_vec3 to_sun = kd_vec3_normalize((kd_vec3){-cosf(a), low, -sinf(a)}, (kd_vec3){0, 1, 0});
        kd_entity light = render_light(r, sun(3), (kd_vec3){0, 5, 0}, kd_vec3_scale(to_sun, -1));
        kd_find_mut(r->world, light, kd_light)->no_shadow = true;
        render_frame(r, "graze_open");
        floor_map open = read_unshadowed(r, 2);
        kd_find_mut(r->world, light, kd_light)->no_shadow = false;
        render_frame(r, "graze");
        for (int i = 0; i < 160 * 120; i += 7) {
            float x = ((float)(i % 160) + 0.5f - 80) / 30, z = ((float)(i / 160 % 120) + 0.5f - 60) / 30;
            kd_vec3 to_centre = {-x, 0.5f, -z};
            float passing = kd_vec3_length(kd_vec3_cross(to_centre, to_sun));
            if (sqrtf(x * x + z * z) < 0.55f)
                continue; /* the ball itself */
            if (passing < 0.45f && kd_vec3_dot(to_centre, to_sun) > 0)
                expect_dark(r, &open, x, z);
            else if (passing > 0.55f || kd_vec3_dot(to_centre, to_sun) < 0)
                expect_lit(r, &open, x, z);
        }
        free(open.lit);
        kd_destroy(r->world, light);
    }
}

/* A bare floor under a low lamp is lit wherever its light reaches, over all faces of the point light's cube
 * and out to the rim of the spot's cone: no pixel may lose any of it. */
static void lamps_over_a_bare_floor_leave_no_acne(void **state)
{
    render *r = *state;
    const kd_light lamps[] = {{.type = KD_POINT, .color = {1, 1, 1}, .intensity = 3},
                              {.type = KD_SPOT, .color = {1, 1, 1}, .intensity = 3, .outer_cone = 1.3f},
                              {.type = KD_SPOT, .color = {1, 1, 1}, .intensity = 3, .outer_cone = 0.6f}};
    const kd_vec3 aims[] = {{0, 0, -1}, {0.3f, -1, 0.1f}, {1, -0.4f, 0.5f}};
    add_floor(r);
    render_top_camera(r, 4);
    for (int i = 0; i < 3; i++) {
        kd_entity lamp = render_light(r, lamps[i], (kd_vec3){0.1f, 0.4f + 0.3f * (float)i, -0.2f}, aims[i]);
        kd_find_mut(r->world, lamp, kd_light)->no_shadow = true;
        render_frame(r, "lamp_open");
        floor_map open = read_unshadowed(r, 4);
        kd_find_mut(r->world, lamp, kd_light)->no_shadow = false;
        render_frame(r, "lamp");
        for (uint32_t p = 0; p < r->frame->width * r->frame->height; p++)
            if (open.lit[p] > 1e-3f && !(r->hdr[p * 4] > open.lit[p] * 0.99f))
                fail_msg("lamp %d pixel %u %u: %g of %g", i, p % 160, p / 160, (double)r->hdr[p * 4],
                         (double)open.lit[p]);
        free(open.lit);
        kd_destroy(r->world, lamp);
    }
}

/* A box below the cutoff shows nowhere and casts no shadow; one above it does both. */
static void material_below_cutoff_is_cut_from_picture_and_shadow(void **state)
{
    render *r = *state;
    kd_material_desc m = render_matte(0.8f);
    m.alpha_mode = KD_ALPHA_MASK;
    m.alpha_cutoff = 0.4f;
    m.base_color.w = 0.3f;
    add_floor(r);
    render_top_camera(r, 2);
    render_light(r, sun(3), (kd_vec3){0, 5, 0}, (kd_vec3){1, -1, 0});
    render_frame(r, "mask");
    floor_map open = read_unshadowed(r, 2);
    render_shape(r, KD_SHAPE_BOX, (kd_vec3){1, 1, 1}, &m, (kd_vec3){0, 0.5f, 0}, RENDER_UPRIGHT, RENDER_UNIT);
    render_frame(r, "mask");
    expect_lit(r, &open, 1, 0);
    expect_lit(r, &open, 0, 0);
    m.base_color.w = 0.5f;
    render_shape(r, KD_SHAPE_BOX, (kd_vec3){1, 1, 1}, &m, (kd_vec3){0, 0.5f, -1.2f}, RENDER_UPRIGHT,
                 RENDER_UNIT);
    render_frame(r, "mask");
    expect_dark(r, &open, 1, -1.2f);
    expect_lit(r, &open, 1, 0);
    free(open.lit);
}

/* More shadow casters than there are maps: one warning, the rest unshadowed, no failure. */
static void too_many_shadow_casters_warn_once(void **state)
{
    render *r = *state;
    add_floor(r);
    add_box(r, (kd_vec3){1, 1, 1}, (kd_vec3){0, 0.5f, 0});
    render_top_camera(r, 2);
    r->frame->settings.light_shadow_size = 64;
    for (int i = 0; i < 52; i++)
        render_light(r, (kd_light){.type = KD_SPOT, .color = {1, 1, 1}, .intensity = 1, .outer_cone = PI / 4},
                     (kd_vec3){0, 3, 0}, (kd_vec3){0, -1, 0});
    render_frame(r, "many");
    const char *first = strstr(r->warnings, "shadow maps");
    assert_non_null(first);
    render_frame(r, "many");
    assert_null(strstr(first + 1, "shadow maps"));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        RENDER_TEST(directional_shadow_of_box_falls_where_it_must),
        RENDER_TEST(spot_shadow_of_box_falls_where_it_must),
        RENDER_TEST(point_shadow_of_box_falls_where_it_must),
        cmocka_unit_test(point_light_casts_into_all_six_directions),
        RENDER_TEST(no_shadow_casts_none),
        RENDER_TEST(grazing_light_leaves_no_acne),
        RENDER_TEST(grazing_shadow_of_sphere_is_where_it_must_be),
        RENDER_TEST(lamps_over_a_bare_floor_leave_no_acne),
        RENDER_TEST(material_below_cutoff_is_cut_from_picture_and_shadow),
        RENDER_TEST(too_many_shadow_casters_warn_once),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
