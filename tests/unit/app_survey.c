/* What the viewer makes of a model: rooms are entered, solids are circled, open boxes are looked into. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "runtime/app/model_survey.h"

static const uint32_t quad_order[6] = {0, 1, 2, 0, 2, 3};

/* A box of triangles; `inwards` turns its faces to the inside; wall `open` (0 … 5, as +X -X +Y -Y +Z -Z) is
 * left out. */
typedef struct box {
    kd_vec3 positions[24];
    uint32_t indices[36];
    kd_primitive_desc primitive;
    kd_mesh_desc mesh;
    kd_node_desc node;
    kd_model model;
} box;

static void make_box(box *b, kd_vec3 low, kd_vec3 high, bool inwards, int open)
{
    uint32_t vertices = 0, indices = 0;
    for (int face = 0; face < 6; face++) {
        int axis = face / 2, u = (axis + 1) % 3, v = (axis + 2) % 3;
        const float *lo = &low.x, *hi = &high.x;
        if (face == open)
            continue;
        /* u × v is the axis: counter-clockwise in (u, v) faces along +axis. */
        for (int corner = 0; corner < 4; corner++) {
            float p[3];
            p[axis] = face % 2 == 0 ? hi[axis] : lo[axis];
            p[u] = corner == 1 || corner == 2 ? hi[u] : lo[u];
            p[v] = corner >= 2 ? hi[v] : lo[v];
            b->positions[vertices + (uint32_t)corner] = (kd_vec3){p[0], p[1], p[2]};
        }
        bool flip = (face % 2 == 1) != inwards;
        for (uint32_t i = 0; i < 6; i++)
            b->indices[indices++] = vertices + quad_order[flip ? 5 - i : i];
        vertices += 4;
    }
    b->primitive = (kd_primitive_desc){
        .vertex_count = vertices, .index_count = indices, .indices = b->indices, .positions = b->positions};
    b->mesh = (kd_mesh_desc){.name = "box", .primitive_count = 1, .primitives = &b->primitive};
    b->node = (kd_node_desc){.name = "box",
                             .parent = KD_NONE,
                             .rotation = {0, 0, 0, 1},
                             .scale = {1, 1, 1},
                             .skin = KD_NONE,
                             .camera = KD_NONE,
                             .light = KD_NONE};
    b->model = (kd_model){.path = "box",
                          .mesh_count = 1,
                          .meshes = &b->mesh,
                          .node_count = 1,
                          .nodes = &b->node,
                          .bounds_min = low,
                          .bounds_max = high};
}

static app_survey survey(kd_vec3 low, kd_vec3 high, bool inwards, int open)
{
    static box b;
    app_survey out;
    make_box(&b, low, high, inwards, open);
    assert_int_equal(app_survey_model(&b.model, &out), KD_OK);
    return out;
}

static void a_large_room_is_a_hall(void **state)
{
    (void)state;
    app_survey s = survey((kd_vec3){-20, 0, -6}, (kd_vec3){20, 8, 6}, true, -1);
    assert_true(s.hall);
    assert_true(s.eye.y > 1.6f && s.eye.y < 1.8f); /* eye height above the floor at 0 */
    assert_true(s.eye.x < -15 && s.eye.x > -20);   /* near one end … */
    assert_true(s.target.x > 19);                  /* … looking along the length */
    assert_true(s.eye.z > -6 && s.eye.z < 6);
    s = survey((kd_vec3){-6, 0, -20}, (kd_vec3){6, 8, 20}, true, -1);
    assert_true(s.hall && s.eye.z < -15 && s.target.z > 19);
    assert_true(s.roof > 6.2f && s.roof < 6.4f);
    s = survey((kd_vec3){-20, 0, -6}, (kd_vec3){20, 8, 6}, true, 2); /* no roof */
    assert_true(s.hall && s.roof == 0);
}

static void a_closed_room_is_entered_however_small(void **state)
{
    (void)state;
    app_survey s = survey((kd_vec3){-2.5f, 0, -2}, (kd_vec3){2.5f, 2.6f, 2}, true, -1);
    assert_true(s.hall && s.eye.y > 1.5f && s.eye.y < 1.75f);
    assert_false(survey((kd_vec3){-2.5f, 0, -2}, (kd_vec3){2.5f, 2.6f, 2}, true, 2).hall);  /* a crate */
    assert_false(survey((kd_vec3){-2.5f, 0, -2}, (kd_vec3){2.5f, 1.4f, 2}, true, -1).hall); /* a car */
}

/* What can be seen from both sides may be a room or a hollow solid: things inside make it a room. */
static void walls_with_two_sides_need_something_between_them(void **state)
{
    (void)state;
    static box walls, pillars[9];
    kd_primitive_desc primitives[10];
    kd_material_desc both = kd_material_default();
    app_survey out;
    both.double_sided = true;
    make_box(&walls, (kd_vec3){-20, 0, -6}, (kd_vec3){20, 8, 6}, false, -1);
    walls.model.material_count = 1;
    walls.model.materials = &both;
    primitives[0] = walls.primitive;
    for (int i = 0; i < 9; i++) {
        float x = -16 + 4 * (float)i, z = i % 2 ? 3 : -3;
        make_box(&pillars[i], (kd_vec3){x - 1, 0, z - 1}, (kd_vec3){x + 1, 7, z + 1}, false, -1);
        primitives[1 + i] = pillars[i].primitive;
    }
    walls.mesh.primitives = primitives;
    walls.mesh.primitive_count = 1;
    assert_int_equal(app_survey_model(&walls.model, &out), KD_OK);
    assert_false(out.hall);
    walls.mesh.primitive_count = 10;
    assert_int_equal(app_survey_model(&walls.model, &out), KD_OK);
    assert_true(out.hall);
    both.double_sided = false; /* now the walls face outwards alone */
    assert_int_equal(app_survey_model(&walls.model, &out), KD_OK);
    assert_false(out.hall);
}

enum { ROUND = 24, RINGS = 12 };

/* The inside of a ball has no floor to walk on. */
static void the_inside_of_a_ball_is_no_hall(void **state)
{
    (void)state;
    static box b;
    static kd_vec3 positions[(RINGS + 1) * ROUND];
    static uint32_t indices[RINGS * ROUND * 6];
    uint32_t count = 0;
    app_survey out;
    make_box(&b, (kd_vec3){-8, -8, -8}, (kd_vec3){8, 8, 8}, true, -1);
    for (uint32_t i = 0; i < (RINGS + 1) * ROUND; i++) {
        float down = (float)(i / ROUND) * 3.1415927f / RINGS,
              around = (float)(i % ROUND) * 6.2831853f / ROUND;
        positions[i] =
            (kd_vec3){8 * sinf(down) * cosf(around), 8 * cosf(down), 8 * sinf(down) * sinf(around)};
    }
    for (uint32_t i = 0; i < RINGS * ROUND; i++) {
        uint32_t next = i / ROUND * ROUND + (i + 1) % ROUND;
        uint32_t quad[4] = {i, i + ROUND, next + ROUND, next}; /* counter-clockwise from the middle */
        for (uint32_t k = 0; k < 6; k++)
            indices[count++] = quad[quad_order[k]];
    }
    b.primitive.positions = positions;
    b.primitive.indices = indices;
    b.primitive.vertex_count = (RINGS + 1) * ROUND;
    b.primitive.index_count = count;
    assert_int_equal(app_survey_model(&b.model, &out), KD_OK);
    assert_true(out.closed_box); /* its faces are turned inwards */
    assert_false(out.hall);
}

static void a_large_solid_is_no_hall(void **state)
{
    (void)state;
    app_survey s = survey((kd_vec3){-20, 0, -6}, (kd_vec3){20, 8, 6}, false, -1);
    assert_false(s.hall || s.open_box);
}

static void a_small_room_open_on_one_side_is_an_open_box(void **state)
{
    (void)state;
    app_survey s = survey((kd_vec3){-1, 0, -1}, (kd_vec3){1, 2, 1}, true, 4);
    assert_true(s.open_box && !s.hall);
    assert_true(s.open_side.z == 1);
    s = survey((kd_vec3){-1, 0, -1}, (kd_vec3){1, 2, 1}, true, 1);
    assert_true(s.open_box && s.open_side.x == -1);
    s = survey((kd_vec3){-1, 0, -1}, (kd_vec3){1, 2, 1}, true, -1);
    assert_false(s.open_box);
    s = survey((kd_vec3){-1, 0, -1}, (kd_vec3){1, 2, 1}, false, -1);
    assert_false(s.open_box);
}

/* A lamp lights the room it stands in; a label that glows does not light what carries it. */
static void rooms_alone_are_lit_by_what_shines_in_them(void **state)
{
    (void)state;
    static box b;
    static const struct {
        kd_vec3 low, high;
        bool inwards;
        int open;
        bool lit;
    } rows[] = {
        {{-20, 0, -6}, {20, 8, 6}, true, -1, true}, {{-1, 0, -1}, {1, 2, 1}, true, 4, true},
        {{-1, 0, -1}, {1, 2, 1}, true, -1, true},   {{-1, 0, -1}, {1, 2, 1}, false, -1, false},
        {{-1, 0, -1}, {1, 2, 1}, false, 4, false},
    };
    kd_material_desc glowing = kd_material_default();
    glowing.emissive = (kd_vec3){0, 3, 0};
    for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
        app_survey out;
        make_box(&b, rows[i].low, rows[i].high, rows[i].inwards, rows[i].open);
        b.primitive.material = KD_NONE;
        b.model.material_count = 1;
        b.model.materials = &glowing;
        assert_int_equal(app_survey_model(&b.model, &out), KD_OK);
        assert_false(out.has_emissive || app_survey_lit_by_itself(&out)); /* no triangle uses it */
        b.primitive.material = 0;
        assert_int_equal(app_survey_model(&b.model, &out), KD_OK);
        assert_true(out.has_emissive);
        assert_int_equal(app_survey_lit_by_itself(&out), rows[i].lit);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_large_room_is_a_hall),
        cmocka_unit_test(a_closed_room_is_entered_however_small),
        cmocka_unit_test(walls_with_two_sides_need_something_between_them),
        cmocka_unit_test(the_inside_of_a_ball_is_no_hall),
        cmocka_unit_test(a_large_solid_is_no_hall),
        cmocka_unit_test(a_small_room_open_on_one_side_is_an_open_box),
        cmocka_unit_test(rooms_alone_are_lit_by_what_shines_in_them),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
