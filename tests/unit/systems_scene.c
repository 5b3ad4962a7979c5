/* The store, instances and the draw list, without a GPU: the test itself says that everything has been
 * uploaded. */

#include "tests/deform_fixture.h"

#include "components/animation.h"
#include "components/camera.h"
#include "components/light.h"
#include "systems/hierarchy/hierarchy.h"
#include "systems/scene/scene.h"

typedef struct stage {
    kd_world *world;
    kd_schedule *schedule;
} stage;

static int setup(void **state)
{
    static stage s;
    s.world = kd_world_make();
    s.schedule = kd_schedule_make(s.world, NULL, NULL);
    assert_int_equal(kd_hierarchy_import(s.schedule), KD_OK);
    assert_int_equal(deform_register_joint_palette(s.schedule), KD_OK);
    assert_int_equal(scene_register_draw_list(s.schedule), KD_OK);
    assert_int_equal(scene_register_camera(s.schedule), KD_OK);
    assert_int_equal(kd_schedule_init(s.schedule), KD_OK);
    *state = &s;
    return 0;
}

static int teardown(void **state)
{
    stage *s = *state;
    kd_schedule_destroy(s->schedule);
    kd_world_destroy(s->world);
    return 0;
}

static const kd_draw_list *frame(stage *s)
{
    kd_scene_store *store = scene_store_get(s->world);
    scene_internal *in = store->internal;
    store->uploaded_primitives = store->primitive_count;
    in->uploaded_deformed = store->deformed_count;
    assert_int_equal(kd_schedule_run(s->schedule), KD_OK);
    return kd_singleton(s->world, kd_draw_list);
}

static uint32_t add(stage *s, kd_model *model)
{
    uint32_t number;
    assert_int_equal(kd_scene_add_model(s->world, model, &number), KD_OK);
    return number;
}

static kd_entity spawn(stage *s, uint32_t model)
{
    kd_entity root;
    assert_int_equal(kd_scene_instantiate(s->world, model, KD_NO_ENTITY, "thing", &root), KD_OK);
    return root;
}

static kd_model *box(kd_alpha_mode mode)
{
    kd_material_desc material = kd_material_default();
    kd_model *model = NULL;
    material.alpha_mode = mode;
    assert_int_equal(kd_model_make_shape(KD_SHAPE_BOX, (kd_vec3){2, 2, 2}, 0, &material, &model), KD_OK);
    return model;
}

/* ---- store ---- */

static void ranges_of_models_follow_each_other(void **state)
{
    stage *s = *state;
    uint32_t a =
        add(s, fixture_character(2, 10, 3, 0, 1)); /* primitives of 10 and 17 vertices, 30 and 51 indices */
    uint32_t b = add(s, fixture_character(1, 20, 0, 2, 2)); /* one of 20, morphing */
    const kd_scene_store *store = kd_singleton(s->world, kd_scene_store);
    assert_int_equal(store->models[a].first_mesh, 0);
    assert_int_equal(store->models[b].first_mesh, 1);
    assert_int_equal(store->primitives[1].base_vertex, 10);
    assert_int_equal(store->primitives[1].first_index, 30);
    assert_int_equal(store->primitives[1].first_skin_vertex, 10);
    assert_int_equal(store->primitives[1].first_morph_vertex, KD_NONE);
    assert_int_equal(store->primitives[2].base_vertex, 27);
    assert_int_equal(store->primitives[2].first_index, 81);
    assert_int_equal(store->primitives[2].first_skin_vertex, KD_NONE);
    assert_int_equal(store->primitives[2].first_morph_vertex, 0);
    assert_int_equal(store->vertex_count, 47);
    assert_int_equal(store->skin_vertex_count, 27);
    assert_int_equal(store->morph_vertex_count, 40);
    assert_int_equal(store->triangle_count,
                     47); /* a third of the indices, of which there are three a vertex */
    assert_true(store->meshes[0].skinned && !store->meshes[1].skinned);
    assert_int_equal(store->primitives[0].material, 0); /* none of its own: the default one */
}

static void deformed_instances_get_vertices_of_their_own(void **state)
{
    stage *s = *state;
    uint32_t model = add(s, fixture_character(2, 10, 3, 0, 1));
    spawn(s, model);
    spawn(s, model);
    const kd_scene_store *store = kd_singleton(s->world, kd_scene_store);
    assert_int_equal(store->deformed_count, 2);
    assert_int_equal(store->deformed_primitive_count, 4);
    assert_int_equal(store->deformed_primitives[0].base_vertex, 27);
    assert_int_equal(store->deformed_primitives[1].base_vertex, 37);
    assert_int_equal(store->deformed_primitives[2].base_vertex, 54);
    assert_int_equal(store->deformed_primitives[2].first_index, store->primitives[0].first_index);
    assert_int_equal(store->vertex_count, 81);
    assert_int_equal(store->joint_entity_count, 6);
    assert_false(kd_entity_equal(store->joint_entities[0], store->joint_entities[3]));
    assert_true(kd_alive(s->world, store->deformed[1].entity));
}

/* The copy of an instance has its joints, its vertices and its numbers in the store's lists; the original
 * keeps its own. */
static void a_copy_moves_on_its_own(void **state)
{
    stage *s = *state;
    kd_entity root = spawn(s, add(s, fixture_character(2, 10, 3, 0, 1))), copy;
    const kd_scene_store *store = kd_singleton(s->world, kd_scene_store);
    uint32_t entities = kd_entity_count(s->world), nodes = store->node_entity_count;
    assert_int_equal(kd_scene_clone(s->world, root, KD_NO_ENTITY, &copy), KD_OK);
    assert_int_equal(kd_entity_count(s->world), 2 * entities);
    assert_int_equal(store->deformed_count, 2);
    assert_int_equal(store->vertex_count, 81); /* as two instances, see above */
    assert_int_equal(store->joint_entity_count, 6);
    for (uint32_t i = 0; i < 3; i++) {
        kd_entity top = store->joint_entities[3 + i];
        assert_false(kd_entity_equal(store->joint_entities[i], top));
        while (kd_get_parent(s->world, top).generation)
            top = kd_get_parent(s->world, top);
        assert_true(kd_entity_equal(top, copy));
    }
    kd_entity skinned = store->deformed[1].entity;
    assert_true(kd_alive(s->world, skinned) && !kd_entity_equal(skinned, store->deformed[0].entity));
    assert_int_equal(kd_find(s->world, skinned, kd_skin_instance)->first_joint, 3);
    assert_int_equal(kd_find(s->world, skinned, kd_mesh_instance)->deformed, 2);
    const kd_animation *animation = kd_find(s->world, copy, kd_animation);
    if (animation)
        assert_int_equal(animation->first_node, nodes);
    assert_int_equal(kd_scene_clone(s->world, KD_NO_ENTITY, KD_NO_ENTITY, &copy), KD_NOT_FOUND);
}

static void packed_weights_sum_to_one(void **state)
{
    uint64_t random = 11;
    kd_model *model = fixture_model();
    kd_primitive_desc p = fixture_primitive(model, 500, 9, 0, &random);
    uint32_t words[500 * KD_SKIN_WORDS];
    (void)state;
    scene_pack_skin(&p, words);
    for (int v = 0; v < 500; v++) {
        const uint32_t *w = words + v * KD_SKIN_WORDS + 2;
        assert_int_equal((w[0] & 0xffff) + (w[0] >> 16) + (w[1] & 0xffff) + (w[1] >> 16), 65535);
    }
    kd_model_destroy(model);
}

static void overridden_material_reaches_every_mesh_below(void **state)
{
    stage *s = *state;
    kd_entity root = spawn(s, add(s, box(KD_ALPHA_OPAQUE)));
    kd_material_desc red = kd_material_default();
    red.base_color = (kd_vec4){1, 0, 0, 1};
    uint32_t number = kd_scene_add_material(s->world, &red);
    kd_scene_override_material(s->world, root, number);
    const kd_draw_list *list = frame(s);
    assert_int_equal(list->draw_count, 1);
    assert_int_equal(list->batches[0].material, number);
}

/* ---- draw list ---- */

static void draws_are_sorted_and_batched(void **state)
{
    stage *s = *state;
    uint32_t blend = add(s, box(KD_ALPHA_BLEND)), mask = add(s, box(KD_ALPHA_MASK)),
             opaque = add(s, box(KD_ALPHA_OPAQUE));
    kd_entity roots[7];
    for (int i = 0; i < 7; i++)
        roots[i] = spawn(s, i % 3 == 0 ? blend : i % 3 == 1 ? mask : opaque);
    kd_find_mut(s->world, roots[2], kd_transform)->scale.x = -1;
    const kd_draw_list *list = frame(s);
    const kd_scene_store *store = kd_singleton(s->world, kd_scene_store);
    assert_int_equal(list->draw_count, 7);
    assert_int_equal(list->object_count, 7);
    assert_int_equal(list->batch_count, 4); /* opaque, opaque mirrored, mask, blend */
    static const kd_alpha_mode modes[] = {KD_ALPHA_OPAQUE, KD_ALPHA_OPAQUE, KD_ALPHA_MASK, KD_ALPHA_BLEND};
    static const uint32_t counts[] = {1, 1, 2, 3};
    uint32_t first = 0;
    for (int b = 0; b < 4; b++) {
        assert_int_equal(store->materials[list->batches[b].material].desc.alpha_mode, modes[b]);
        assert_int_equal(list->batches[b].first_draw, first);
        assert_int_equal(list->batches[b].draw_count, counts[b]);
        assert_int_equal(list->batches[b].mirrored, b == 1);
        for (uint32_t i = 1; i < counts[b]; i++)
            assert_true(list->draws[first + i].entity.index > list->draws[first + i - 1].entity.index);
        first += counts[b];
    }
    for (uint32_t i = 0; i < 7; i++)
        assert_int_equal(list->draws[i].args.base_instance, i);
}

static void hidden_and_new_meshes_are_left_out(void **state)
{
    stage *s = *state;
    uint32_t model = add(s, box(KD_ALPHA_OPAQUE));
    kd_entity a = spawn(s, model);
    spawn(s, model);
    kd_find_mut(s->world, kd_first_child(s->world, a), kd_mesh_instance)->hidden = true;
    assert_int_equal(frame(s)->draw_count, 1);
    spawn(s, add(s, box(KD_ALPHA_OPAQUE))); /* registered, but not on the GPU yet */
    assert_int_equal(kd_schedule_run(s->schedule), KD_OK);
    assert_int_equal(kd_singleton(s->world, kd_draw_list)->draw_count, 1);
    assert_int_equal(frame(s)->draw_count, 2);
}

/* A box of edge 2 about the origin, turned by 45 degrees about y, scaled by 2 and moved to x = 10: its
 * corners are at 10 ± 2 sqrt 2 in x and ± 2 sqrt 2 in z, ± 2 in y. */
static void rigid_bounds_hold_the_turned_box(void **state)
{
    stage *s = *state;
    kd_entity root = spawn(s, add(s, box(KD_ALPHA_OPAQUE)));
    *kd_find_mut(s->world, root, kd_transform) =
        (kd_transform){{10, 0, 0}, {0, 0.38268343f, 0, 0.92387953f}, {2, 2, 2}};
    const kd_draw_list *list = frame(s);
    assert_float_equal(list->draws[0].bounds_min_ws.x, 10 - 2.8284271f, 1e-5f);
    assert_float_equal(list->draws[0].bounds_max_ws.x, 10 + 2.8284271f, 1e-5f);
    assert_float_equal(list->draws[0].bounds_max_ws.y, 2, 1e-5f);
    assert_float_equal(list->bounds_min_ws.z, -2.8284271f, 1e-5f);
}

/* ---- bounds of what deforms ---- */

static bool inside(kd_vec3 p, const kd_draw *d)
{
    return p.x >= d->bounds_min_ws.x && p.y >= d->bounds_min_ws.y && p.z >= d->bounds_min_ws.z &&
           p.x <= d->bounds_max_ws.x && p.y <= d->bounds_max_ws.y && p.z <= d->bounds_max_ws.z;
}

/* Each vertex as the reference leaves it lies in the bounds of its draw; and these are no larger than they
 * need be by more than the sum of the vertices' reach: at most `slack` times the box of the vertices
 * themselves. */
static void assert_bounds(stage *s, float slack)
{
    const kd_draw_list *list = frame(s);
    const kd_scene_store *store = kd_singleton(s->world, kd_scene_store);
    deform_picture picture = deform_by_reference(s->world);
    assert_true(list->draw_count > 0);
    for (uint32_t i = 0; i < list->draw_count; i++) {
        const kd_draw *d = &list->draws[i];
        assert_true(d->deformed);
        const kd_store_primitive *p = &store->deformed_primitives[d->primitive];
        bool skinned = p->first_skin_vertex != KD_NONE;
        const kd_mat4 *world = &kd_find(s->world, d->entity, kd_world_transform)->matrix;
        scene_box exact = SCENE_BOX_EMPTY;
        for (uint32_t v = 0; v < p->vertex_count; v++) {
            kd_vec3 at = deform_position(&picture, p->base_vertex + v);
            at = skinned ? at : kd_mat4_point(world, at);
            assert_true(inside(at, d));
            scene_box_add(&exact, at);
        }
        assert_true(d->bounds_max_ws.x - d->bounds_min_ws.x <= slack * (exact.max.x - exact.min.x));
    }
    deform_picture_free(&picture);
}

static void skinned_bounds_are_conservative(void **state)
{
    stage *s = *state;
    for (uint32_t seed = 1; seed <= 8; seed++)
        spawn(s, add(s, fixture_character(2, 200, 1 + seed * 3, seed % 3, seed)));
    assert_bounds(s, 8);
    const kd_scene_store *store = kd_singleton(s->world, kd_scene_store);
    uint64_t random = 5;
    for (uint32_t i = 0; i < store->joint_entity_count; i++)
        kd_find_mut(s->world, store->joint_entities[i], kd_transform)->rotation = fixture_quat(&random);
    for (uint32_t i = 0; i < store->deformed_count; i++) {
        kd_morph_weights *w = kd_find_mut(s->world, store->deformed[i].entity, kd_morph_weights);
        for (uint32_t t = 0; w && t < w->count; t++)
            w->weights[t] = fixture_float(&random, -2, 2);
    }
    assert_bounds(s, 8);
}

static void morph_bounds_are_conservative(void **state)
{
    stage *s = *state;
    kd_entity root = spawn(s, add(s, fixture_character(2, 200, 0, 5, 4)));
    kd_find_mut(s->world, root, kd_transform)->scale = (kd_vec3){1, 2, -3};
    kd_morph_weights *w = kd_find_mut(s->world, kd_first_child(s->world, root), kd_morph_weights);
    assert_int_equal(w->count, 5);
    for (int t = 0; t < 5; t++)
        w->weights[t] = (float)t - 2;
    assert_bounds(s, 8);
}

static void one_joint_moves_its_mesh_exactly(void **state)
{
    stage *s = *state;
    kd_model *model = fixture_character(1, 50, 1, 0, 6);
    *(kd_mat4 *)(uintptr_t)model->skins[0].inverse_bind = KD_MAT4_IDENTITY;
    kd_node_desc *joint = (kd_node_desc *)(uintptr_t)model->nodes;
    joint->translation = (kd_vec3){100, 0, 0};
    joint->rotation = (kd_quat){0, 0, 0, 1};
    joint->scale = (kd_vec3){1, 1, 1};
    spawn(s, add(s, model));
    frame(s);
    const kd_scene_store *store = kd_singleton(s->world, kd_scene_store);
    deform_picture picture = deform_by_reference(s->world);
    for (uint32_t v = 0; v < 50; v++) { /* the mesh node's own translation is ignored, as glTF asks */
        kd_vec3 rest = deform_position(&picture, v), moved = deform_position(&picture, 50 + v);
        assert_int_equal(store->deformed_primitives[0].base_vertex, 50);
        assert_float_equal(moved.x, rest.x + 100, 2e-5f); /* floats near 100 are 8e-6 apart; three terms */
        assert_float_equal(moved.y, rest.y, 1e-6f);
        assert_float_equal(moved.z, rest.z, 1e-6f);
    }
    deform_picture_free(&picture);
}

/* ---- camera ---- */

static void camera_looks_along_its_minus_z(void **state)
{
    stage *s = *state;
    const float quarter = 0.70710678f; /* a quarter turn about y: -z becomes -x */
    kd_camera lens = *(const kd_camera *)kd_camera_desc.default_value, off = lens;
    off.inactive = true;
    const kd_transform pose = {{1, 2, 3}, {0, quarter, 0, quarter}, {5, 5, 5}};
    const kd_value unused[] = {{&kd_camera_desc, &off}, {&kd_world_transform_desc, NULL}};
    const kd_value used[] = {
        {&kd_camera_desc, &lens}, {&kd_transform_desc, &pose}, {&kd_world_transform_desc, NULL}};
    kd_spawn_values(s->world, unused, 2);
    kd_spawn_values(s->world, used, 3);
    kd_frame *f = kd_singleton(s->world, kd_frame);
    f->width = 200;
    f->height = 100;
    frame(s);
    const kd_view *view = kd_singleton(s->world, kd_view);
    assert_float_equal(view->forward_ws.x, -1, 1e-6f);
    assert_float_equal(view->position_ws.y, 2, 0);
    assert_float_equal(view->tan_half_fov_y, 0.41421356f, 1e-6f); /* tan 22.5 degrees */
    /* Ten metres ahead, at the upper edge: half height 10 tan 22.5, so clip y / w is 1; z / w between -1
     * and 1. */
    const float p[4] = {1 - 10, 2 + 10 * 0.41421356f, 3, 1};
    float clip[4];
    for (int r = 0; r < 4; r++) {
        clip[r] = 0;
        for (int k = 0; k < 4; k++)
            clip[r] += view->view_projection.m[4 * k + r] * p[k];
    }
    assert_float_equal(clip[3], 10, 1e-4f);
    assert_float_equal(clip[0] / clip[3], 0, 1e-5f);
    assert_float_equal(clip[1] / clip[3], 1, 1e-5f);
    assert_true(clip[2] / clip[3] > -1 && clip[2] / clip[3] < 1);
    kd_mat4 one = kd_mat4_mul(&view->view_projection, &view->inverse_view_projection);
    for (int i = 0; i < 16; i++)
        assert_float_equal(one.m[i], (i % 5 == 0 ? 1 : 0),
                           1e-3f); /* near 0.05 and far 200: numbers up to 4000 cancel */
}

#define STAGED(name) cmocka_unit_test_setup_teardown(name, setup, teardown)

int main(void)
{
    const struct CMUnitTest tests[] = {
        STAGED(ranges_of_models_follow_each_other),
        STAGED(deformed_instances_get_vertices_of_their_own),
        STAGED(a_copy_moves_on_its_own),
        STAGED(packed_weights_sum_to_one),
        STAGED(overridden_material_reaches_every_mesh_below),
        STAGED(draws_are_sorted_and_batched),
        STAGED(hidden_and_new_meshes_are_left_out),
        STAGED(rigid_bounds_hold_the_turned_box),
        STAGED(skinned_bounds_are_conservative),
        STAGED(morph_bounds_are_conservative),
        STAGED(one_joint_moves_its_mesh_exactly),
        STAGED(camera_looks_along_its_minus_z),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
