/* Shapes made in memory: closed, facing outwards, of the right size. */

#include <math.h>

#include "tests/unit/asset_support.h"

#define PI 3.14159265358979

static const kd_primitive_desc *only_primitive(const kd_model *m)
{
    assert_int_equal(m->node_count, 1);
    assert_int_equal(m->mesh_count, 1);
    assert_int_equal(m->material_count, 1);
    return &m->meshes[0].primitives[0];
}

static kd_model *make(kd_shape shape, kd_vec3 size, uint32_t segments)
{
    kd_model *m = NULL;
    assert_int_equal(kd_model_make_shape(shape, size, segments, NULL, &m), KD_OK);
    return m;
}

static kd_vec3 corner(const kd_primitive_desc *p, uint32_t i)
{
    return p->positions[p->indices[i]];
}

static kd_vec3 face(const kd_primitive_desc *p, uint32_t i)
{
    kd_vec3 a = corner(p, i);
    return kd_vec3_cross(kd_vec3_sub(corner(p, i + 1), a), kd_vec3_sub(corner(p, i + 2), a));
}

static double area(const kd_primitive_desc *p)
{
    double sum = 0;
    for (uint32_t i = 0; i < p->index_count; i += 3)
        sum += (double)kd_vec3_length(face(p, i)) / 2;
    return sum;
}

/* Gauss: a sixth of the sum of triple products. Positive only if triangles face outwards. */
static double volume(const kd_primitive_desc *p)
{
    double sum = 0;
    for (uint32_t i = 0; i < p->index_count; i += 3)
        sum += (double)kd_vec3_dot(corner(p, i), kd_vec3_cross(corner(p, i + 1), corner(p, i + 2))) / 6;
    return sum;
}

static bool same_place(kd_vec3 a, kd_vec3 b)
{
    return kd_vec3_length(kd_vec3_sub(a, b)) < 1e-5f; /* seams are computed by one formula, rims by two */
}

/* Each edge must be met by exactly one other that runs the other way. */
static void assert_closed(const kd_primitive_desc *p)
{
    for (uint32_t i = 0; i < p->index_count; i++) {
        uint32_t next = i % 3 == 2 ? i - 2 : i + 1, partners = 0;
        for (uint32_t j = 0; j < p->index_count; j++) {
            uint32_t after = j % 3 == 2 ? j - 2 : j + 1;
            partners +=
                same_place(corner(p, i), corner(p, after)) && same_place(corner(p, next), corner(p, j));
        }
        assert_int_equal(partners, 1);
    }
}

static void assert_frames(const kd_primitive_desc *p)
{
    for (uint32_t i = 0; i < p->vertex_count; i++) {
        kd_vec3 n = p->normals[i], t = {p->tangents[i].x, p->tangents[i].y, p->tangents[i].z};
        NEAR(kd_vec3_length(n), 1, 1e-5f);
        NEAR(kd_vec3_length(t), 1, 1e-5f);
        NEAR(kd_vec3_dot(n, t), 0, 1e-5f);
        assert_true(p->uv0[i].x >= 0 && p->uv0[i].x <= 1 && p->uv0[i].y >= 0 && p->uv0[i].y <= 1);
    }
    for (uint32_t i = 0; i < p->index_count; i++) /* shading and geometric normals agree in side */
        assert_true(kd_vec3_dot(p->normals[p->indices[i]], face(p, i / 3 * 3)) > 0);
}

static void box_has_24_vertices_and_its_size(void **state)
{
    (void)state;
    kd_model *m = make(KD_SHAPE_BOX, (kd_vec3){1, 2, 3}, 0);
    const kd_primitive_desc *p = only_primitive(m);
    assert_int_equal(p->vertex_count, 24);
    assert_int_equal(m->triangle_count, 12);
    NEAR(area(p), 2 * (1 * 2 + 2 * 3 + 1 * 3), 1e-4);
    NEAR(volume(p), 6, 1e-4);
    assert_vec3(m->bounds_min, -0.5f, -1, -1.5f, 0);
    assert_vec3(m->bounds_max, 0.5f, 1, 1.5f, 0);
    assert_closed(p);
    assert_frames(p);
    kd_model_destroy(m);
}

static void sphere_is_closed_and_round(void **state)
{
    (void)state;
    kd_model *m = make(KD_SHAPE_SPHERE, (kd_vec3){2, 2, 2}, 24);
    const kd_primitive_desc *p = only_primitive(m);
    for (uint32_t i = 0; i < p->vertex_count; i++) {
        NEAR(kd_vec3_length(p->positions[i]), 1, 1e-5f);
        assert_vec3(kd_vec3_sub(p->positions[i], p->normals[i]), 0, 0, 0,
                    1e-5f); /* a unit sphere's normal is its place */
    }
    /* 24 by 12: a chord of 15 degrees loses 1 - cos(7.5 deg) = 0.9 % of the radius each way, so about 3 % of
     * the volume. */
    assert_true(volume(p) < 4.0 / 3 * PI && volume(p) > 4.0 / 3 * PI * 0.96);
    assert_true(area(p) < 4 * PI && area(p) > 4 * PI * 0.97);
    assert_closed(p);
    assert_frames(p);
    kd_model_destroy(m);
}

static void plane_faces_up(void **state)
{
    (void)state;
    kd_model *m = make(KD_SHAPE_PLANE, (kd_vec3){4, 0, 2}, 0);
    const kd_primitive_desc *p = only_primitive(m);
    NEAR(area(p), 8, 1e-5);
    for (uint32_t i = 0; i < p->vertex_count; i++)
        assert_vec3(p->normals[i], 0, 1, 0, 0);
    assert_frames(p);
    kd_model_destroy(m);
}

static void cylinder_is_a_closed_prism(void **state)
{
    (void)state;
    uint32_t n = 16;
    kd_model *m = make(KD_SHAPE_CYLINDER, (kd_vec3){2, 3, 0}, n);
    const kd_primitive_desc *p = only_primitive(m);
    /* A regular prism over the unit circle: base n/2 sin(2 pi/n), side 2 sin(pi/n) times the height. */
    double base = n / 2.0 * sin(2 * PI / n), side = n * 2 * sin(PI / n) * 3;
    NEAR(volume(p), base * 3, 1e-4);
    NEAR(area(p), 2 * base + side, 1e-4);
    assert_closed(p);
    assert_frames(p);
    kd_model_destroy(m);
}

static void torus_is_closed_and_as_wide_as_said(void **state)
{
    (void)state;
    kd_model *m = make(KD_SHAPE_TORUS, (kd_vec3){4, 1, 0}, 32);
    const kd_primitive_desc *p = only_primitive(m);
    NEAR(m->bounds_max.x, 2, 1e-5f);
    NEAR(m->bounds_max.y, 0.5f, 1e-5f);
    /* Pappus: 2 pi R times pi r^2 with R 1.5, r 0.5; 16 and 32 edges lose 2.6 % and 0.6 %. */
    double pappus = 2 * PI * 1.5 * PI * 0.25;
    assert_true(volume(p) < pappus && volume(p) > pappus * 0.95);
    assert_closed(p);
    assert_frames(p);
    kd_model_destroy(m);
}

static void coarsest_shapes_are_closed_too(void **state)
{
    (void)state;
    static const kd_shape round[] = {KD_SHAPE_SPHERE, KD_SHAPE_CYLINDER, KD_SHAPE_TORUS};
    for (int i = 0; i < 3; i++) {
        kd_model *m = make(round[i], (kd_vec3){2, 1, 2}, 3);
        assert_closed(only_primitive(m));
        assert_true(volume(only_primitive(m)) > 0);
        kd_model_destroy(m);
    }
}

static void shapes_refuse_what_cannot_be_made(void **state)
{
    (void)state;
    static const struct {
        kd_shape shape;
        kd_vec3 size;
        uint32_t segments;
    } bad[] = {
        {KD_SHAPE_BOX, {0, 1, 1}, 0},      {KD_SHAPE_BOX, {1, -1, 1}, 0},
        {KD_SHAPE_SPHERE, {NAN, 1, 1}, 0}, {KD_SHAPE_TORUS, {1, 2, 0}, 0},
        {KD_SHAPE_SPHERE, {1, 1, 1}, 2},   {KD_SHAPE_SPHERE, {1, 1, 1}, 100000},
        {(kd_shape)77, {1, 1, 1}, 0},      {KD_SHAPE_PLANE, {1, 0, INFINITY}, 0},
    };
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++) {
        kd_model *m = NULL;
        watch_messages();
        assert_int_equal(kd_model_make_shape(bad[i].shape, bad[i].size, bad[i].segments, NULL, &m),
                         KD_OUT_OF_RANGE);
        assert_null(m);
        assert_int_equal(seen_messages.errors, 1);
    }
}

static void shape_keeps_a_copy_of_its_material(void **state)
{
    (void)state;
    char name[] = "glow";
    kd_material_desc material = kd_material_default();
    kd_model *m = NULL;
    material.name = name;
    material.roughness = 0.25f;
    assert_int_equal(kd_model_make_shape(KD_SHAPE_BOX, (kd_vec3){1, 1, 1}, 0, &material, &m), KD_OK);
    name[0] = 'x';
    assert_string_equal(m->materials[0].name, "glow");
    assert_float_equal(m->materials[0].roughness, 0.25f, 0);
    assert_int_equal(m->materials[0].base_color_map.image, KD_NONE);
    kd_model_destroy(m);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(box_has_24_vertices_and_its_size),
        cmocka_unit_test(sphere_is_closed_and_round),
        cmocka_unit_test(plane_faces_up),
        cmocka_unit_test(cylinder_is_a_closed_prism),
        cmocka_unit_test(torus_is_closed_and_as_wide_as_said),
        cmocka_unit_test(coarsest_shapes_are_closed_too),
        cmocka_unit_test(shapes_refuse_what_cannot_be_made),
        cmocka_unit_test(shape_keeps_a_copy_of_its_material),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
