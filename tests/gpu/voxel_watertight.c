/* Closed surfaces stay closed however they are posed: no flood through the tree's free leaves gets from
 * outside to where the posed mesh has its inside. 64 poses of each body. */

#include "tests/posed_fixture.h"

enum { POSES = 64, CELLS = 14 };
#define SPAN 0.02f

/* ---- bodies ---- */

static kd_primitive_desc *primitive_of(const kd_model *model)
{
    return (kd_primitive_desc *)(uintptr_t)model->meshes[0].primitives;
}

/* A cube is a sphere blown up to its box: with vertices all over its faces, so that it can bend. */
static kd_model *shape_of(kd_shape shape, kd_vec3 size)
{
    kd_material_desc grey = voxel_matte(0.5f, 0.5f, 0.5f);
    kd_model *model;
    bool cube = shape == KD_SHAPE_BOX;
    assert_int_equal(kd_model_make_shape(cube ? KD_SHAPE_SPHERE : shape, size, 32, &grey, &model), KD_OK);
    kd_vec3 *at = (kd_vec3 *)(uintptr_t)primitive_of(model)->positions;
    for (uint32_t i = 0; cube && i < primitive_of(model)->vertex_count; i++) {
        float furthest = fmaxf(fabsf(at[i].x), fmaxf(fabsf(at[i].y), fabsf(at[i].z)));
        at[i] = kd_vec3_scale(at[i], 0.5f * size.x / furthest);
    }
    return model;
}

/* Three joints along x, at the low end, in the middle and at the high end; weights are tents. */
static kd_model *with_skin(kd_model *model)
{
    kd_primitive_desc *p = primitive_of(model);
    uint16_t(*joints)[4] = (uint16_t(*)[4])FIXTURE_NEW(model, uint16_t, 4 * p->vertex_count);
    kd_vec4 *weights = FIXTURE_NEW(model, kd_vec4, p->vertex_count);
    kd_node_desc *nodes = fixture_nodes(model, 4);
    kd_mat4 *inverse = FIXTURE_NEW(model, kd_mat4, 3);
    uint32_t *numbers = FIXTURE_NEW(model, uint32_t, 3);
    kd_skin_desc *skin = FIXTURE_NEW(model, kd_skin_desc, 1);
    float reach = p->bounds_max.x;
    for (uint32_t j = 0; j < 3; j++) {
        float x = ((float)j - 1) * reach;
        nodes[j].translation = (kd_vec3){j ? reach : -reach, 0, 0};
        nodes[j].parent = j ? j - 1 : KD_NONE;
        inverse[j] = kd_mat4_from_trs((kd_vec3){-x, 0, 0}, (kd_quat){0, 0, 0, 1}, (kd_vec3){1, 1, 1});
        numbers[j] = j;
    }
    for (uint32_t i = 0; i < p->vertex_count; i++) {
        float t = p->positions[i].x / reach;
        joints[i][0] = t < 0 ? 0 : 2;
        joints[i][1] = 1;
        weights[i] = (kd_vec4){fabsf(t), 1 - fabsf(t), 0, 0};
    }
    *skin = (kd_skin_desc){"skin", 3, numbers, inverse};
    nodes[3].mesh = nodes[3].skin = 0;
    p->joints = (const uint16_t(*)[4])joints;
    p->weights = weights;
    model->skins = skin;
    model->skin_count = 1;
    return model;
}

/* Two targets: the ends bend upwards; the whole is twisted about x. */
static kd_model *with_morph(kd_model *model)
{
    kd_primitive_desc *p = primitive_of(model);
    kd_mesh_desc *mesh = (kd_mesh_desc *)(uintptr_t)model->meshes;
    kd_vec3 *bend = FIXTURE_NEW(model, kd_vec3, p->vertex_count),
            *twist = FIXTURE_NEW(model, kd_vec3, p->vertex_count);
    const kd_vec3 **targets = FIXTURE_NEW(model, const kd_vec3 *, 2);
    for (uint32_t i = 0; i < p->vertex_count; i++) {
        kd_vec3 at = p->positions[i];
        float t = at.x / p->bounds_max.x;
        bend[i] = (kd_vec3){0, 0.5f * p->bounds_max.x * t * t, 0};
        twist[i] = (kd_vec3){0, -0.5f * t * at.z, 0.5f * t * at.y};
    }
    targets[0] = bend, targets[1] = twist;
    p->morph_count = mesh->morph_count = 2;
    p->morph_positions = targets;
    p->morph_normals = FIXTURE_NEW(model, const kd_vec3 *, 2);
    mesh->morph_weights = FIXTURE_NEW(model, float, 2);
    return model;
}

/* ---- poses ---- */

typedef struct body {
    voxel_world v;
    kd_entity parent, root; /* the parent's scale and the root's turn are a shear together */
} body;

static body body_open(kd_model *model, voxel_options options)
{
    uint32_t number;
    body b = {.v = voxel_open(options)};
    if (options.cascades == 0) /* masks are all it takes */
        assert_int_equal(kd_schedule_enable(b.v.schedule, "svo_filter", false), KD_OK);
    b.parent = kd_spawn(b.v.world, KD_VAL(kd_transform, KD_TRANSFORM_IDENTITY), KD_TAG(kd_world_transform));
    assert_int_equal(kd_scene_add_model(b.v.world, model, &number), KD_OK);
    assert_int_equal(kd_scene_instantiate(b.v.world, number, b.parent, "body", &b.root), KD_OK);
    voxel_frame(&b.v);
    return b;
}

static float scale_of(uint64_t *random)
{
    return exp2f(fixture_float(random, -1, 1));
}

/* Turned; scaled alike, by axes, or sheared; every fourth mirrored. */
static void place(body *b, int pose, uint64_t *random)
{
    kd_transform *t = kd_find_mut(b->v.world, b->parent, kd_transform);
    t->position = fixture_vec3(random, -0.05f, 0.05f);
    t->rotation = fixture_quat(random);
    float s = scale_of(random);
    t->scale =
        pose % 3 ? (kd_vec3){scale_of(random), scale_of(random), scale_of(random)} : (kd_vec3){s, s, s};
    if (pose % 4 == 3)
        t->scale.x = -t->scale.x;
    kd_find_mut(b->v.world, b->root, kd_transform)->rotation =
        pose % 3 == 2 ? fixture_quat(random) : (kd_quat){0, 0, 0, 1};
}

static kd_entity drawn(body *b)
{
    const kd_draw_list *list = kd_singleton(b->v.world, kd_draw_list);
    assert_true(list->draw_count > 0);
    return list->draws[0].entity;
}

/* Up to 50 degrees at either end. */
static void bend(body *b, uint64_t *random)
{
    const kd_skin_instance *skin = kd_find(b->v.world, drawn(b), kd_skin_instance);
    const kd_scene_store *store = kd_singleton(b->v.world, kd_scene_store);
    for (uint32_t j = 0; j < 3; j++) {
        float half = fixture_float(random, -0.43f, 0.43f);
        kd_vec3 axis = fixture_unit(random);
        kd_find_mut(b->v.world, store->joint_entities[skin->first_joint + j], kd_transform)->rotation =
            (kd_quat){axis.x * sinf(half), axis.y * sinf(half), axis.z * sinf(half), cosf(half)};
    }
}

static void morph(body *b, uint64_t *random)
{
    kd_morph_weights *w = kd_find_mut(b->v.world, drawn(b), kd_morph_weights);
    w->weights[0] = fixture_float(random, -1, 1);
    w->weights[1] = fixture_float(random, -1, 1);
}

static size_t check(body *b, const char *name, int pose)
{
    size_t inside = 0;
    voxel_frame(&b->v);
    posed p = posed_read(&b->v);
    size_t leaks = posed_leaks(&p, &inside);
    posed_free(&p);
    if (leaks)
        print_error("%s, pose %d: a flood reaches %zu of %zu cells inside\n", name, pose, leaks, inside);
    return leaks;
}

static void pose_all(kd_shape shape, kd_vec3 size, const char *name)
{
    size_t leaks = 0;
    uint64_t random = 21;
    body rigid = body_open(shape_of(shape, size), (voxel_options){.span = SPAN});
    body skinned = body_open(with_skin(shape_of(shape, size)), (voxel_options){.span = SPAN});
    body morphing = body_open(with_morph(shape_of(shape, size)), (voxel_options){.span = SPAN});
    body *const bodies[3] = {&rigid, &skinned, &morphing};
    for (int pose = 0; pose < POSES; pose++) {
        body *b = bodies[pose / 4 % 3];
        place(b, pose, &random);
        if (b == &skinned)
            bend(b, &random);
        if (b == &morphing)
            morph(b, &random);
        leaks += check(b, name, pose);
    }
    for (int i = 0; i < 3; i++)
        voxel_close(&bodies[i]->v);
    assert_int_equal(leaks, 0);
}

/* Larger than the finest cascade: its surface goes from cascade to cascade, without a seam and in every pose.
 */
static void straddle(kd_shape shape, kd_vec3 size, const char *name)
{
    size_t leaks = 0;
    uint64_t random = 4;
    float span = size.x / 140;
    body rigid = body_open(shape_of(shape, size), (voxel_options){.span = span, .cascades = 2});
    body skinned = body_open(with_skin(shape_of(shape, size)), (voxel_options){.span = span, .cascades = 2});
    leaks += check(&rigid, name, 0); /* as it stands, on the lattice */
    for (int pose = 1; pose < 4; pose++) {
        body *b = pose == 1 ? &skinned : &rigid;
        kd_transform *t = kd_find_mut(b->v.world, b->parent, kd_transform);
        t->rotation = fixture_quat(&random);
        t->position = fixture_vec3(&random, -4 * span, 4 * span);
        t->scale.x = pose == 3 ? -1 : 1;
        if (b == &skinned)
            bend(b, &random);
        leaks += check(b, name, pose);
    }
    voxel_close(&rigid.v);
    voxel_close(&skinned.v);
    assert_int_equal(leaks, 0);
}

/* A beam of 6000 cells that bends: voxels of the cascade's own span, in chunks, and none missing on the way.
 */
static void long_skin_has_voxels_everywhere(void **state)
{
    enum { RESOLUTION = 128 };
    const float span = 0.01f;
    kd_material_desc grey = voxel_matte(0.5f, 0.5f, 0.5f);
    kd_model *model;
    (void)state;
    assert_int_equal(
        kd_model_make_shape(KD_SHAPE_BOX, (kd_vec3){6000 * span, 6 * span, 6 * span}, 0, &grey, &model),
        KD_OK);
    body b = body_open(with_skin(model), (voxel_options){.span = span, .resolution = RESOLUTION});
    const kd_voxel_scene *scene = voxel_scene(&b.v);
    const kd_voxel_cache *cache = &scene->caches[scene->objects[0].caches[0] - 1];
    assert_true(cache->span <= span * 1.001f);
    assert_true(cache->chunk_count >= 6);
    for (uint32_t i = 0; i < cache->chunk_count; i++)
        assert_in_range(scene->chunks[cache->first_chunk + i].size[0], 1, 1024);
    bool taken[RESOLUTION] = {false};
    uint32_t *mask = voxel_read_union(&b.v), cell[3];
    for (uint32_t bit = 0; bit < RESOLUTION * RESOLUTION * RESOLUTION; bit++) {
        svo_morton_cell(bit, cell);
        taken[cell[0]] = taken[cell[0]] || (mask[bit / 32] >> bit % 32 & 1) != 0;
    }
    for (uint32_t x = 0; x < RESOLUTION; x++)
        assert_true(taken[x]);
    free(mask);
    voxel_close(&b.v);
}

static void torus_over_two_cascades_is_closed(void **state)
{
    (void)state;
    straddle(KD_SHAPE_TORUS, (kd_vec3){1, 0.3f, 0}, "torus over two cascades");
}

static void posed_cube_is_closed(void **state)
{
    (void)state;
    pose_all(KD_SHAPE_BOX, (kd_vec3){CELLS * SPAN, CELLS * SPAN, CELLS * SPAN}, "cube");
}

static void posed_sphere_is_closed(void **state)
{
    (void)state;
    pose_all(KD_SHAPE_SPHERE, (kd_vec3){CELLS * SPAN, CELLS * SPAN, CELLS * SPAN}, "sphere");
}

static void posed_torus_is_closed(void **state)
{
    (void)state;
    pose_all(KD_SHAPE_TORUS, (kd_vec3){CELLS * 1.5f * SPAN, CELLS * 0.5f * SPAN, 0}, "torus");
}

/* ---- characters ---- */

static void pose_character(kd_model *model, const char *name)
{
    uint64_t random = 8;
    size_t leaks = 0;
    float height = model->bounds_max.y - model->bounds_min.y;
    body b = body_open(model, (voxel_options){.span = height / 40});
    const kd_scene_store *store = kd_singleton(b.v.world, kd_scene_store);
    for (int pose = 0; pose < POSES; pose++) {
        kd_animation *a = kd_find_mut(b.v.world, b.root, kd_animation);
        uint32_t clip = (uint32_t)pose % store->clip_count;
        a->clip = clip + 1;
        a->time_s = store->clips[clip].desc->duration * fixture_float(&random, 0, 1);
        if (pose >= 16)
            place(&b, pose, &random);
        leaks += check(&b, name, pose);
    }
    voxel_close(&b.v);
    assert_int_equal(leaks, 0);
}

static void posed_walker_is_closed(void **state)
{
    kd_model *model;
    (void)state;
    assert_int_equal(kd_model_load(KD_SOURCE_DIR "/samples/assets/walker.gltf", &model), KD_OK);
    pose_character(model, "walker");
}

static void posed_robot_is_closed(void **state)
{
    const char *path = KD_SOURCE_DIR "/../shared/assets/robot/robot.glb";
    kd_model *model;
    (void)state;
    if (!kd_file_exists(path))
        skip();
    assert_int_equal(kd_model_load(path, &model), KD_OK);
    pose_character(model, "robot");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(posed_cube_is_closed),
        cmocka_unit_test(posed_sphere_is_closed),
        cmocka_unit_test(posed_torus_is_closed),
        cmocka_unit_test(posed_walker_is_closed),
        cmocka_unit_test(posed_robot_is_closed),
        cmocka_unit_test(torus_over_two_cascades_is_closed),
        cmocka_unit_test(long_skin_has_voxels_everywhere),
    };
    return VOXEL_GROUP(tests);
}
