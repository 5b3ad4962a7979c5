/* Which joints voxels follow: those of the nearest surface, or those that are nearest through the inside of
 * the body. The character is a trunk from whose shoulder an arm hangs down its side, so close that they
 * touch. */

#include "tests/voxel_cells_fixture.h"

#include "systems/voxel_cache/geodesic.h"

#define SPAN 0.02f
enum { TRUNK, SHOULDER, ARM, HAND, JOINTS };

/* The outline seen from the front, a slit of 4 mm between trunk and arm: a fifth of a voxel. */
static const float outline[][2] = {{-0.2f, 0},     {0.2f, 0},     {0.2f, 0.85f},  {0.204f, 0.85f},
                                   {0.204f, 0.2f}, {0.36f, 0.2f}, {0.36f, 0.85f}, {0.36f, 1},
                                   {0.2f, 1},      {-0.2f, 1}};
/* Its pieces: trunk, shoulder, arm. */
static const struct {
    float low[2], high[2];
} pieces[] = {{{-0.2f, 0}, {0.2f, 1}}, {{0.2f, 0.85f}, {0.36f, 1}}, {{0.204f, 0.2f}, {0.36f, 0.85f}}};
enum { CORNERS = sizeof outline / sizeof *outline, SLICES = 20, STEPS = 12 };

static kd_vec3 corner(int i, float z)
{
    return (kd_vec3){outline[i][0], outline[i][1], z};
}

typedef struct mesh_maker {
    kd_vec3 *positions;
    uint32_t count;
} mesh_maker;

static void triangle(mesh_maker *m, kd_vec3 a, kd_vec3 b, kd_vec3 c)
{
    m->positions[m->count++] = a;
    m->positions[m->count++] = b;
    m->positions[m->count++] = c;
}

static void quad(mesh_maker *m, kd_vec3 a, kd_vec3 along, kd_vec3 up)
{
    kd_vec3 b = kd_vec3_add(a, along), c = kd_vec3_add(a, up);
    triangle(m, a, b, kd_vec3_add(b, up));
    triangle(m, a, kd_vec3_add(b, up), c);
}

/* In small parts, so that painted weights can differ along it. */
static void extrude(mesh_maker *m, bool open)
{
    for (int i = 0; i < CORNERS; i++) {
        kd_vec3 from = corner(i, 0.1f), to = corner((i + 1) % CORNERS, 0.1f);
        kd_vec3 step = kd_vec3_scale(kd_vec3_sub(to, from), 1.0f / SLICES);
        for (int s = 0; s < SLICES; s++)
            quad(m, kd_vec3_add(from, kd_vec3_scale(step, (float)s)), (kd_vec3){0, 0, -0.2f}, step);
    }
    for (size_t p = 0; p < sizeof pieces / sizeof *pieces; p++) {
        const float *low = pieces[p].low, *high = pieces[p].high;
        kd_vec3 x = {(high[0] - low[0]) / SLICES, 0, 0}, y = {0, (high[1] - low[1]) / SLICES, 0};
        for (int i = 0; i < SLICES * SLICES; i++) {
            kd_vec3 at = {low[0] + x.x * (float)(i % SLICES), low[1] + y.y * (float)(i / SLICES), 0.1f};
            quad(m, at, x, y);
            if (!open)
                quad(m, kd_vec3_sub(at, (kd_vec3){0, 0, 0.2f}), y, x);
        }
    }
}

static float distance_to_segment(kd_vec3 p, kd_vec3 a, kd_vec3 b)
{
    kd_vec3 ab = kd_vec3_sub(b, a), ap = kd_vec3_sub(p, a);
    float t = fminf(fmaxf(kd_vec3_dot(ap, ab) / kd_vec3_dot(ab, ab), 0), 1);
    return kd_vec3_length(kd_vec3_sub(ap, kd_vec3_scale(ab, t)));
}

static const kd_vec3 places[JOINTS + 1] = {
    {0, 0.05f, 0}, {0, 0.92f, 0}, {0.28f, 0.92f, 0}, {0.28f, 0.25f, 0}};

/* As automatic weights are often painted: by the nearest bone through the air. */
static uint16_t nearest_joint(kd_vec3 p)
{
    uint16_t best = 0;
    for (uint16_t j = 1; j < HAND; j++)
        if (distance_to_segment(p, places[j], places[j + 1]) <
            distance_to_segment(p, places[best], places[best + 1]))
            best = j;
    return best;
}

static kd_skin_desc *hang_up(kd_model *model)
{
    kd_node_desc *nodes = fixture_nodes(model, JOINTS + 1);
    kd_mat4 *inverse = FIXTURE_NEW(model, kd_mat4, JOINTS);
    uint32_t *numbers = FIXTURE_NEW(model, uint32_t, JOINTS);
    kd_skin_desc *skin = FIXTURE_NEW(model, kd_skin_desc, 1);
    for (uint32_t j = 0; j < JOINTS; j++) {
        nodes[j].parent = j ? j - 1 : KD_NONE;
        nodes[j].translation = j ? kd_vec3_sub(places[j], places[j - 1]) : places[0];
        inverse[j] =
            kd_mat4_from_trs(kd_vec3_scale(places[j], -1), (kd_quat){0, 0, 0, 1}, (kd_vec3){1, 1, 1});
        numbers[j] = j;
    }
    nodes[JOINTS].mesh = nodes[JOINTS].skin = 0;
    *skin = (kd_skin_desc){"skin", JOINTS, numbers, inverse};
    return skin;
}

static kd_model *character(bool open)
{
    kd_model *model = fixture_model();
    mesh_maker m = {FIXTURE_NEW(model, kd_vec3, (CORNERS * SLICES + 6 * SLICES * SLICES) * 6), 0};
    extrude(&m, open);
    kd_primitive_desc *p = FIXTURE_NEW(model, kd_primitive_desc, 1);
    uint32_t *indices = FIXTURE_NEW(model, uint32_t, m.count);
    kd_vec3 *normals = FIXTURE_NEW(model, kd_vec3, m.count);
    kd_vec4 *tangents = FIXTURE_NEW(model, kd_vec4, m.count), *weights = FIXTURE_NEW(model, kd_vec4, m.count);
    uint16_t(*joints)[4] = (uint16_t(*)[4])FIXTURE_NEW(model, uint16_t, 4 * m.count);
    for (uint32_t i = 0; i < m.count; i++) {
        indices[i] = i;
        normals[i] = (kd_vec3){0, 0, 1};
        tangents[i] = (kd_vec4){1, 0, 0, 1};
        weights[i] = (kd_vec4){1, 0, 0, 0};
        joints[i][0] = nearest_joint(m.positions[i]);
    }
    *p = (kd_primitive_desc){.material = KD_NONE,
                             .vertex_count = m.count,
                             .index_count = m.count,
                             .indices = indices,
                             .positions = m.positions,
                             .normals = normals,
                             .tangents = tangents,
                             .joints = (const uint16_t(*)[4])joints,
                             .weights = weights,
                             .bounds_min = {-0.2f, 0, -0.1f},
                             .bounds_max = {0.36f, 1, 0.1f}};
    kd_mesh_desc *mesh = FIXTURE_NEW(model, kd_mesh_desc, 1);
    *mesh = (kd_mesh_desc){.name = "figure", .primitive_count = 1, .primitives = p};
    model->meshes = mesh;
    model->mesh_count = 1;
    model->skins = hang_up(model);
    model->skin_count = 1;
    return model;
}

/* Of the voxels below the armpit and away from the slit: on the trunk's side, and those of them that the arm
 * leads; on the arm's side, and those that it does not. */
typedef struct shares {
    uint32_t trunk, led_by_arm, arm, led_by_others;
} shares;

static shares shares_of(voxel_world *v)
{
    shares s = {0};
    cells c = read_cells(v, 0);
    const kd_voxel_scene *scene = voxel_scene(v);
    uint32_t(*words)[KD_BINDING_WORDS] =
        voxel_read(scene->cache_binding, 0, (size_t)scene->binding_places.end * KD_BINDING_WORDS * 4);
    for (uint32_t i = 0; i < c.cache->chunk_count; i++) {
        const kd_voxel_chunk *chunk = &scene->chunks[c.cache->first_chunk + i];
        for (uint32_t n = 0; n < chunk->count; n++) {
            const uint32_t *w = words[chunk->first_binding + n], cell = c.shape[chunk->first + n][0];
            float x = chunk->origin.x + ((float)(cell & 1023u) + 0.5f) * chunk->span;
            float y = chunk->origin.y + ((float)(cell >> 10 & 1023u) + 0.5f) * chunk->span;
            uint32_t led = 0;
            for (int k = 0; k < 4; k++)
                led += (w[k / 2] >> (16 * (k % 2)) & 0xFFFFu) >= ARM ? w[2] >> (8 * k) & 255u : 0;
            if (y > 0.7f || y < 0.2f)
                continue;
            s.trunk += x < 0.2f - SPAN;
            s.led_by_arm += x < 0.2f - SPAN && led > 127;
            s.arm += x > 0.204f + SPAN;
            s.led_by_others += x > 0.204f + SPAN && led < 128;
        }
    }
    free(words);
    free_cells(&c);
    return s;
}

static shares bind_by(kd_binding binding)
{
    voxel_world v = voxel_open((voxel_options){.span = SPAN});
    v.frame->settings.voxels_binding = (int)binding;
    voxel_spawn(&v, character(false), voxel_at(0, 0, 0));
    voxel_frame(&v);
    assert_int_equal(voxel_scene(&v)->objects[0].kind, KD_VOXEL_SKINNED);
    shares s = shares_of(&v);
    voxel_close(&v);
    return s;
}

/* Bones are as near through the air from the trunk's side as from the arm; through the inside the trunk's own
 * is nearer by far. */
static void trunk_follows_the_arm_only_by_nearest_surface(void **state)
{
    (void)state;
    shares nearest = bind_by(KD_BINDING_NEAREST), geodesic = bind_by(KD_BINDING_GEODESIC);
    assert_int_equal(nearest.trunk, geodesic.trunk);
    assert_true(nearest.trunk > 500 && nearest.arm > 200);
    assert_true(nearest.led_by_arm > nearest.trunk / 20);
    assert_int_equal(geodesic.led_by_arm, 0);
    assert_int_equal(geodesic.led_by_others, 0);
}

/* Nothing is inside of an open mesh; one message says that its voxels are bound as by default. */
static void open_mesh_keeps_the_nearest_surface(void **state)
{
    (void)state;
    shares open[2];
    for (int binding = 0; binding < 2; binding++) {
        voxel_world v = voxel_open((voxel_options){.span = SPAN, .cascades = 2});
        v.frame->settings.voxels_binding = binding;
        voxel_spawn(&v, character(true), voxel_at(0, 0, 0));
        voxel_frame(&v);
        open[binding] = shares_of(&v);
        const char *said = strstr(voxel_warnings, "not closed");
        assert_int_equal(said != NULL, binding);
        assert_true(!said || !strstr(said + 1, "not closed"));
        voxel_warnings[0] = '\0';
        voxel_close(&v);
    }
    assert_memory_equal(&open[0], &open[1], sizeof open[0]);
}

/* Along the arm's axis weights go from joint to joint without jumps, and every point has some. */
static void weights_sum_to_one_everywhere(void **state)
{
    (void)state;
    kd_model *model = character(false);
    geodesic_body body;
    geodesic_bone *bones;
    uint32_t *first;
    kd_vec3 points[STEPS];
    uint16_t joints[STEPS][4];
    float weights[STEPS][4];
    assert_int_equal(geodesic_body_make(&model->meshes[0], SPAN, &body), KD_OK);
    assert_true(body.inside > 1000);
    assert_int_equal(geodesic_bones(model, &model->skins[0], &first, &bones), KD_OK);
    assert_int_equal(first[JOINTS], JOINTS);
    assert_true(bones[HAND].open_ended && !bones[ARM].open_ended);
    for (int i = 0; i < STEPS; i++)
        points[i] = (kd_vec3){0.28f, 0.95f - 0.06f * (float)i, 0.04f};
    assert_int_equal(geodesic_weights(&body, first, bones, JOINTS, points, STEPS, joints, weights), KD_OK);
    for (int i = 0; i < STEPS; i++) {
        float sum = 0, arm = 0;
        for (int k = 0; k < 4; k++) {
            sum += weights[i][k];
            arm += joints[i][k] >= ARM ? weights[i][k] : 0;
            assert_true(k == 0 || weights[i][k] <= weights[i][k - 1]);
        }
        assert_float_equal(sum, 1, 1e-5);
        assert_true(i < 3 || arm > 0.9f);
    }
    free(first);
    free(bones);
    geodesic_body_fini(&body);
    kd_model_destroy(model);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(trunk_follows_the_arm_only_by_nearest_surface),
        cmocka_unit_test(open_mesh_keeps_the_nearest_surface),
        cmocka_unit_test(weights_sum_to_one_everywhere),
    };
    return VOXEL_GROUP(tests);
}
