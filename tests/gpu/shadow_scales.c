/* Shadows do not depend on the unit a scene is made in, nor on how far its camera stands off. */

#include "tests/render_fixture.h"

static const kd_light lamps[] = {
    {.type = KD_DIRECTIONAL, .color = {1, 1, 1}, .intensity = 3},
    {.type = KD_SPOT, .color = {1, 1, 1}, .intensity = 20, .outer_cone = 0.7f},
    {.type = KD_POINT, .color = {1, 1, 1}, .intensity = 20},
    {.type = KD_POINT, .color = {1, 1, 1}, .intensity = 20, .range = 6},
};
static const char *const names[] = {"sun", "spot", "point", "ranged point"};
enum { LAMPS = sizeof lamps / sizeof *lamps };

static void add_shape(render *r, kd_shape shape, kd_vec3 size, kd_vec3 position, float s)
{
    kd_material_desc m = render_matte(0.8f);
    kd_quat turned = {0, 0.2588f, 0, 0.9659f};
    render_shape(r, shape, kd_vec3_scale(size, s), &m, kd_vec3_scale(position, s), turned, RENDER_UNIT);
}

/* A box and a ball on a floor of six units, lit from the upper right; all lengths times s. */
static kd_entity add_scene(render *r, kd_light lamp, float s)
{
    kd_vec3 position = {1, 1.5f, 1};
    float power = lamp.type == KD_DIRECTIONAL ? 1 : s * s; /* the same irradiance at s times the distance */
    lamp.intensity *= power;
    lamp.range *= s;
    add_shape(r, KD_SHAPE_PLANE, (kd_vec3){6, 1, 6}, (kd_vec3){0, 0, 0}, s);
    add_shape(r, KD_SHAPE_BOX, (kd_vec3){0.6f, 0.6f, 0.6f}, (kd_vec3){0, 0.3f, 0}, s);
    add_shape(r, KD_SHAPE_SPHERE, (kd_vec3){0.6f, 0.6f, 0.6f}, (kd_vec3){-0.9f, 0.3f, 0.4f}, s);
    return render_light(r, lamp, kd_vec3_scale(position, s), (kd_vec3){-1, -1.5f, -1});
}

static kd_entity add_camera(render *r, kd_vec3 eye, kd_vec3 target, kd_camera lens)
{
    return kd_spawn(r->world, (kd_value){&kd_camera_desc, &lens},
                    KD_VAL(kd_transform, {eye, render_camera_look(kd_vec3_sub(target, eye)), {1, 1, 1}}),
                    KD_TAG(kd_world_transform));
}

static float *read_red(const render *r)
{
    size_t pixels = (size_t)r->frame->width * r->frame->height;
    float *red = malloc(pixels * sizeof *red);
    assert_non_null(red);
    for (size_t i = 0; i < pixels; i++)
        red[i] = r->hdr[i * 4];
    return red;
}

/* The scene at one scale: `lit` without shadows, `shadowed` with. */
typedef struct pictures {
    float *lit, *shadowed;
} pictures;

static pictures draw_at(kd_light lamp, float s)
{
    render *r;
    render_setup((void **)&r);
    kd_entity light = add_scene(r, lamp, s);
    add_camera(r, (kd_vec3){0.4f * s, 1.6f * s, 2.4f * s}, (kd_vec3){-0.3f * s, 0.2f * s, 0},
               (kd_camera){.fov_y = 0.8f, .z_near = 0.05f * s, .z_far = 200 * s});
    r->frame->settings.light_shadow_distance *= s;
    kd_find_mut(r->world, light, kd_light)->no_shadow = true;
    render_frame(r, "scale_lit");
    pictures p = {.lit = read_red(r)};
    kd_find_mut(r->world, light, kd_light)->no_shadow = false;
    render_frame(r, "scale_shadowed");
    p.shadowed = read_red(r);
    render_teardown((void **)&r);
    return p;
}

/* Pixels of 160 x 120 that differ by more than a twentieth of the brighter. */
static int count_different(const float *a, const float *b)
{
    int count = 0;
    for (int i = 0; i < 160 * 120; i++)
        count += !(fabsf(a[i] - b[i]) <= 0.05f * fmaxf(a[i], b[i]) + 1e-3f);
    return count;
}

static void free_pictures(pictures *p)
{
    free(p->lit);
    free(p->shadowed);
}

/* Light alone must agree everywhere; shadows but for their borders, whose texels differ: the reach of a map
 * is a power of the square root of two. */
static void scenes_look_the_same_in_every_unit(void **state)
{
    static const float scales[] = {0.001f, 0.01f, 100};
    (void)state;
    for (int lamp = 0; lamp < LAMPS; lamp++) {
        pictures metre = draw_at(lamps[lamp], 1);
        int shaded = count_different(metre.lit, metre.shadowed);
        if (shaded < 200)
            fail_msg("%s: only %d pixels are shaded", names[lamp], shaded);
        for (int i = 0; i < 3; i++) {
            pictures other = draw_at(lamps[lamp], scales[i]);
            int lit = count_different(metre.lit, other.lit),
                shadowed = count_different(metre.shadowed, other.shadowed);
            if (lit > 10 || shadowed > 100)
                fail_msg("%s at scale %g: %d pixels differ without shadows, %d with", names[lamp],
                         (double)scales[i], lit, shadowed);
            free_pictures(&other);
        }
        free_pictures(&metre);
    }
}

/* No pixel of a bare floor may lose light to its own shadow. */
static void expect_no_acne(render *r, kd_entity light, const char *what)
{
    kd_find_mut(r->world, light, kd_light)->no_shadow = true;
    render_frame(r, "far_lit");
    float *lit = read_red(r);
    kd_find_mut(r->world, light, kd_light)->no_shadow = false;
    render_frame(r, "far");
    int dark = 0, seen = 0;
    for (int i = 0; i < 160 * 120; i++) {
        seen += lit[i] > 0.1f;
        dark += lit[i] > 0.1f && !(r->hdr[i * 4] > lit[i] * 0.98f);
    }
    free(lit);
    if (seen < 1000 || dark != 0)
        fail_msg("%s: %d of %d pixels are dark", what, dark, seen);
}

static kd_entity add_bare_floor(render *r, float size)
{
    kd_material_desc m = render_matte(0.8f);
    render_shape(r, KD_SHAPE_PLANE, (kd_vec3){size, 1, size}, &m, (kd_vec3){0, 0, 0}, RENDER_UPRIGHT,
                 RENDER_UNIT);
    r->frame->settings.light_shadow_distance = 3 * size;
    return render_light(r, (kd_light){.type = KD_DIRECTIONAL, .color = {1, 1, 1}, .intensity = 3},
                        (kd_vec3){0, 5, 0}, (kd_vec3){1, -0.5f, 0.3f});
}

/* A lens from 5 cm to 1000 km has depths some metres apart where the floor is. */
static void a_far_camera_with_a_near_lens_sees_no_acne(void **state)
{
    render *r = *state;
    kd_entity light = add_bare_floor(r, 700);
    add_camera(r, (kd_vec3){0, 1200, 2000}, (kd_vec3){0, 0, 0},
               (kd_camera){.fov_y = 0.31f, .z_near = 0.05f, .z_far = 1e6f});
    expect_no_acne(r, light, "far camera");
}

/* The same where the near plane must stay: the floor reaches under the camera. */
static void a_camera_over_a_wide_floor_sees_no_acne(void **state)
{
    render *r = *state;
    kd_entity light = add_bare_floor(r, 3000);
    add_camera(r, (kd_vec3){0, 300, 1000}, (kd_vec3){0, 0, 0},
               (kd_camera){.fov_y = 0.8f, .z_near = 0.05f, .z_far = 1e4f});
    expect_no_acne(r, light, "wide floor");
}

/* Nothing in front of the camera may be cut when the near plane is moved: the picture is that of a lens whose
 * near plane stood there from the start. */
static void a_moved_near_plane_cuts_nothing(void **state)
{
    float *first = NULL;
    (void)state;
    for (int i = 0; i < 2; i++) {
        render *r;
        render_setup((void **)&r);
        add_scene(r, lamps[0], 1);
        add_camera(r, (kd_vec3){2, 3, 9}, (kd_vec3){0, 0, 0},
                   (kd_camera){.fov_y = 0.6f, .z_near = i == 0 ? 0.01f : 2, .z_far = 50});
        render_frame(r, "near_plane");
        if (i == 0)
            first = read_red(r);
        else {
            float *second = read_red(r);
            assert_true(count_different(first, second) < 20);
            free(second);
        }
        render_teardown((void **)&r);
    }
    free(first);
}

/* A thing far away makes the scene's bounds large, and changes nothing else. */
static void one_thing_far_away_changes_no_light(void **state)
{
    (void)state;
    for (int i = 0; i < LAMPS; i++) {
        float *pictures_of[2];
        for (int far = 0; far < 2; far++) {
            render *r;
            render_setup((void **)&r);
            add_scene(r, lamps[i], 1);
            add_camera(r, (kd_vec3){0.4f, 1.6f, 2.4f}, (kd_vec3){-0.3f, 0.2f, 0},
                       (kd_camera){.fov_y = 0.8f, .z_near = 0.05f, .z_far = 200});
            if (far)
                add_shape(r, KD_SHAPE_BOX, (kd_vec3){1, 1, 1}, (kd_vec3){1e5f, 0, 0}, 1);
            render_frame(r, "far_thing");
            pictures_of[far] = read_red(r);
            render_teardown((void **)&r);
        }
        int different = count_different(pictures_of[0], pictures_of[1]);
        printf("%s: %d pixels differ\n", names[i], different);
        assert_in_range(different, 0, 400); /* edges of shadows: maps have other texels */
        free(pictures_of[0]);
        free(pictures_of[1]);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(scenes_look_the_same_in_every_unit),
        RENDER_TEST(a_far_camera_with_a_near_lens_sees_no_acne),
        RENDER_TEST(a_camera_over_a_wide_floor_sees_no_acne),
        cmocka_unit_test(a_moved_near_plane_cuts_nothing),
        cmocka_unit_test(one_thing_far_away_changes_no_light),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
