/* What comes and goes leaves nothing behind: caches, pages, deformed vertices and lists of the store are
 * given back. */

#include "tests/voxel_fixture.h"

#include "systems/scene/internal.h"

/* Frames after which everything that is not needed has been given back. */
enum { SETTLE = 140 };

static void settle(voxel_world *v)
{
    for (int i = 0; i < SETTLE; i++)
        voxel_frame(v);
}

typedef struct holdings {
    size_t gpu_bytes;
    uint64_t voxels, bindings, chunks;
    uint32_t vertices, deformed, deformed_primitives, joints, nodes, instances, pages;
} holdings;

/* Bytes of the scene, the caches and the pages; the octree keeps its own books. */
static size_t held_bytes(void)
{
    kd_gpu_memory_row rows[96];
    uint32_t count = kd_gpu_memory(voxel_gpu, rows, 96);
    size_t bytes = 0;
    for (uint32_t i = 0; i < count; i++)
        if (strncmp(rows[i].name, "svo.", 4) != 0 && strncmp(rows[i].name, "tree.", 5) != 0)
            bytes += rows[i].bytes;
    return bytes;
}

static holdings read_holdings(voxel_world *v)
{
    const kd_voxel_scene *s = voxel_scene(v);
    const kd_scene_store *store = kd_singleton(v->world, kd_scene_store);
    return (holdings){.gpu_bytes = held_bytes(),
                      .voxels = kd_ranges_taken(&s->voxel_places),
                      .bindings = kd_ranges_taken(&s->binding_places),
                      .chunks = kd_ranges_taken(&s->chunk_places),
                      .vertices = store->vertex_count,
                      .deformed = store->deformed_count,
                      .deformed_primitives = store->deformed_primitive_count,
                      .joints = store->joint_entity_count,
                      .nodes = store->node_entity_count,
                      .instances = ((const scene_internal *)store->internal)->instance_count,
                      .pages = s->pages[0].page_count + s->pages[1].page_count};
}

static void assert_as_before(const holdings *now, const holdings *before)
{
    assert_int_equal(now->voxels, before->voxels);
    assert_int_equal(now->bindings, before->bindings);
    assert_int_equal(now->chunks, before->chunks);
    assert_int_equal(now->vertices, before->vertices);
    assert_int_equal(now->deformed, before->deformed);
    assert_int_equal(now->deformed_primitives, before->deformed_primitives);
    assert_int_equal(now->joints, before->joints);
    assert_true(now->nodes <= before->nodes); /* what does not play needs no list of its nodes */
    assert_true(now->instances <= before->instances);
    assert_true(now->pages <= before->pages);
}

/* What is left of buffers that grow by half and are cut to a sixteenth: lists of a few hundred bytes an
 * object, and one of requests and one of ranks of what has been there most at a time. */
#define SMALL_CHANGE 32768

static void characters_that_come_and_go_leave_nothing(void **state)
{
    (void)state;
    enum { FRAMES = 240, LIVE = 3 };
    uint64_t random = 5;
    uint32_t number;
    kd_entity roots[LIVE] = {{0}};
    voxel_world v = voxel_open((voxel_options){.span = 0.15f});
    voxel_shape(&v, KD_SHAPE_PLANE, (kd_vec3){4, 0, 4}, NULL, voxel_at(0, -1, 0));
    assert_int_equal(kd_scene_add_model(v.world, fixture_character(2, 60, 9, 0, 3), &number), KD_OK);
    settle(&v);
    const holdings before = read_holdings(&v);
    holdings peak = before, early = before;
    for (int frame = 0; frame < FRAMES; frame++) {
        uint32_t k = fixture_random(&random) % LIVE;
        if (frame % 3 == 0 && roots[k].generation) {
            kd_destroy(v.world, roots[k]);
            roots[k] = KD_NO_ENTITY;
        } else if (frame % 3 == 0) { /* sizes differ, and so do the spans of their voxels */
            float scale = fixture_float(&random, 0.2f, 0.7f);
            assert_int_equal(kd_scene_instantiate(v.world, number, KD_NO_ENTITY, "one", &roots[k]), KD_OK);
            *kd_find_mut(v.world, roots[k], kd_transform) =
                (kd_transform){fixture_vec3(&random, -1, 1), {0, 0, 0, 1}, {scale, scale, scale}};
        }
        voxel_frame(&v);
        holdings now = read_holdings(&v);
        peak.voxels = now.voxels > peak.voxels ? now.voxels : peak.voxels;
        peak.vertices = now.vertices > peak.vertices ? now.vertices : peak.vertices;
        if (frame == FRAMES / 2)
            early = peak;
    }
    assert_true(peak.voxels > before.voxels && peak.vertices > before.vertices);
    assert_true(peak.voxels < 2 * early.voxels); /* it does not go on growing */
    assert_true(peak.vertices <= before.vertices + (LIVE + 1) * (60 + 67));
    for (int i = 0; i < LIVE; i++)
        if (roots[i].generation)
            kd_destroy(v.world, roots[i]);
    settle(&v);
    const holdings after = read_holdings(&v);
    assert_as_before(&after, &before);
    assert_in_range(after.gpu_bytes, 0, before.gpu_bytes + SMALL_CHANGE);
    voxel_close(&v);
}

/* A camera that passes many objects holds the voxels of those near it. */
static void what_a_camera_passes_is_given_back(void **state)
{
    (void)state;
    voxel_world v = voxel_open((voxel_options){.cascades = 1, .span = 0.02f});
    kd_model *ball;
    kd_material_desc grey = voxel_matte(0.5f, 0.5f, 0.5f);
    uint32_t number, most = 0;
    assert_int_equal(kd_model_make_shape(KD_SHAPE_SPHERE, (kd_vec3){0.5f, 0.5f, 0.5f}, 8, &grey, &ball),
                     KD_OK);
    assert_int_equal(kd_scene_add_model(v.world, ball, &number), KD_OK);
    for (int i = 0; i < 40; i++) { /* each lies otherwise on the lattice, so each has a cache of its own */
        kd_entity root;
        assert_int_equal(kd_scene_instantiate(v.world, number, KD_NO_ENTITY, "ball", &root), KD_OK);
        kd_find_mut(v.world, root, kd_transform)->position = (kd_vec3){1.0037f * (float)i, 0, 0};
    }
    for (int i = 0; i < 160; i++) {
        kd_find_mut(v.world, v.camera, kd_transform)->position = (kd_vec3){0.25f * (float)i, 0, 0};
        voxel_frame(&v);
        uint32_t live = 0;
        for (uint32_t c = 0; c < voxel_scene(&v)->cache_count; c++)
            live += voxel_scene(&v)->caches[c].alive;
        most = live > most ? live : most;
    }
    /* The grid is 2.56 m wide and 64 frames are 16 m: nineteen balls and their neighbours. */
    assert_in_range(most, 4, 26);
    voxel_close(&v);
}

/* A scene that was large once has no more pages than it needs. */
static void pages_shrink_to_what_is_left(void **state)
{
    (void)state;
    kd_entity crowd[24];
    voxel_world v = voxel_open((voxel_options){.cascades = 1, .span = 0.02f});
    kd_entity kept = voxel_shape(&v, KD_SHAPE_BOX, (kd_vec3){0.5f, 0.5f, 0.5f}, NULL, voxel_at(0, 0.9f, 0));
    for (int i = 0; i < 24; i++)
        crowd[i] = voxel_shape(&v, KD_SHAPE_BOX, (kd_vec3){1.1f, 1.2f, 1.3f}, NULL,
                               voxel_at(0.01f * (float)i, 0, 0.013f * (float)i));
    voxel_frame(&v);
    uint32_t full = voxel_scene(&v)->pages[KD_LAYER_STATIC].page_count, words = voxel_svo(&v)->layer_words;
    for (int i = 0; i < 24; i++)
        kd_destroy(v.world, crowd[i]);
    voxel_frame(&v);
    uint32_t *before = voxel_read_union(&v);
    settle(&v);
    uint32_t *after = voxel_read_union(&v);
    assert_true(full > 2);
    assert_int_equal(voxel_scene(&v)->pages[KD_LAYER_STATIC].page_count, 1);
    assert_true(voxel_count_bits(before, words) > 1000);
    assert_memory_equal(before, after, words * sizeof *before);
    assert_true(kd_alive(v.world, kept));
    free(before);
    free(after);
    voxel_close(&v);
}

/* A copy of an entity shares its vertices and joints: they stay until it is gone too. */
static void copies_keep_what_they_share(void **state)
{
    (void)state;
    uint32_t number;
    kd_entity root;
    voxel_world v = voxel_open((voxel_options){.span = 0.15f});
    const kd_scene_store *store = kd_singleton(v.world, kd_scene_store);
    assert_int_equal(kd_scene_add_model(v.world, fixture_character(1, 60, 4, 0, 3), &number), KD_OK);
    assert_int_equal(kd_scene_instantiate(v.world, number, KD_NO_ENTITY, "one", &root), KD_OK);
    voxel_frame(&v);
    const kd_entity owner = store->deformed[0].entity;
    const kd_mesh_instance mesh = *kd_find(v.world, owner, kd_mesh_instance);
    const kd_skin_instance skin = *kd_find(v.world, owner, kd_skin_instance);
    kd_entity copy = kd_spawn(v.world, KD_TAG(kd_transform), KD_TAG(kd_world_transform));
    kd_set_value(v.world, copy, (kd_value){&kd_mesh_instance_desc, &mesh});
    kd_set_value(v.world, copy, (kd_value){&kd_skin_instance_desc, &skin});
    kd_destroy(v.world, root);
    voxel_frame(&v);
    assert_int_equal(store->deformed_count, 1);
    assert_int_equal(store->joint_entity_count, 4);
    kd_destroy(v.world, copy);
    voxel_frame(&v);
    assert_int_equal(store->deformed_count, 0);
    assert_int_equal(store->joint_entity_count, 0);
    assert_int_equal(store->node_entity_count, 0);
    voxel_close(&v);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(characters_that_come_and_go_leave_nothing),
        cmocka_unit_test(what_a_camera_passes_is_given_back),
        cmocka_unit_test(pages_shrink_to_what_is_left),
        cmocka_unit_test(copies_keep_what_they_share),
    };
    return VOXEL_GROUP(tests);
}
