/* What follows changes alone ends where making everything anew does: world transforms and the draw list. */

#include "tests/deform_fixture.h"

#include "systems/hierarchy/hierarchy.h"
#include "systems/scene/scene.h"

enum { MOST = 60, FRAMES = 400 };

typedef struct stage {
    kd_world *world;
    kd_schedule *schedule;
    uint32_t models[3];
    kd_entity roots[MOST];
    uint64_t random;
} stage;

static uint32_t add_box(kd_world *w, kd_alpha_mode mode)
{
    kd_model *model;
    uint32_t number;
    kd_material_desc material = kd_material_default();
    material.alpha_mode = mode;
    assert_int_equal(kd_model_make_shape(KD_SHAPE_BOX, (kd_vec3){1, 2, 3}, 0, &material, &model), KD_OK);
    assert_int_equal(kd_scene_add_model(w, model, &number), KD_OK);
    return number;
}

static void open_stage(stage *s)
{
    *s = (stage){.world = kd_world_make(), .random = 11};
    s->schedule = kd_schedule_make(s->world, NULL, NULL);
    assert_int_equal(kd_hierarchy_import(s->schedule), KD_OK);
    assert_int_equal(deform_register_joint_palette(s->schedule), KD_OK);
    assert_int_equal(scene_register_draw_list(s->schedule), KD_OK);
    assert_int_equal(kd_schedule_init(s->schedule), KD_OK);
    s->models[0] = add_box(s->world, KD_ALPHA_OPAQUE);
    s->models[1] = add_box(s->world, KD_ALPHA_MASK);
    assert_int_equal(kd_scene_add_model(s->world, fixture_character(2, 40, 5, 1, 4), &s->models[2]), KD_OK);
}

static void run_frame(stage *s)
{
    kd_scene_store *store = scene_store_get(s->world);
    store->uploaded_primitives = store->primitive_count;
    ((scene_internal *)store->internal)->uploaded_deformed = store->deformed_count;
    assert_int_equal(kd_schedule_run(s->schedule), KD_OK);
}

static void random_pose(stage *s, kd_transform *t)
{
    t->position = fixture_vec3(&s->random, -20, 20);
    t->scale = fixture_vec3(&s->random, 0.5f, 2);
    t->scale.x *= fixture_random(&s->random) % 4 ? 1.0f : -1.0f; /* mirrored: elsewhere in the list */
}

/* One thing that scenarios do, to a random entity. */
static void change_something(stage *s)
{
    uint32_t k = fixture_random(&s->random) % MOST, what = fixture_random(&s->random) % 12;
    kd_entity e = s->roots[k], other = s->roots[fixture_random(&s->random) % MOST];
    if (!kd_alive(s->world, e)) { /* or it went with its parent */
        uint32_t model = s->models[fixture_random(&s->random) % 3];
        kd_entity parent = kd_alive(s->world, other) && what % 2 ? other : KD_NO_ENTITY;
        assert_int_equal(kd_scene_instantiate(s->world, model, parent, "thing", &s->roots[k]), KD_OK);
        random_pose(s, kd_find_mut(s->world, s->roots[k], kd_transform));
        return;
    }
    kd_entity child = kd_first_child(s->world, e);
    if (what == 0)
        kd_destroy(s->world, e);
    else if (what == 1 && child.generation && kd_has(s->world, child, kd_mesh_instance))
        kd_find_mut(s->world, child, kd_mesh_instance)->hidden ^= true;
    else if (what == 2 && child.generation && kd_has(s->world, child, kd_mesh_instance))
        kd_find_mut(s->world, child, kd_mesh_instance)->material = 1 + fixture_random(&s->random) % 3;
    else if (what == 3 && kd_has(s->world, e, kd_world_transform))
        kd_remove(s->world, e, kd_world_transform); /* it gets another */
    else
        random_pose(s, kd_find_mut(s->world, e, kd_transform));
}

static kd_mat4 world_of(const kd_world *w, kd_entity e)
{
    const kd_transform *t = kd_find(w, e, kd_transform);
    const kd_local_matrix *m = kd_find(w, e, kd_local_matrix);
    kd_entity parent = kd_get_parent(w, e);
    kd_mat4 local = m   ? m->matrix
                    : t ? kd_mat4_from_trs(t->position, t->rotation, t->scale)
                        : KD_MAT4_IDENTITY;
    if (!parent.generation)
        return local;
    kd_mat4 above = world_of(w, parent);
    return kd_mat4_mul(&above, &local);
}

static void assert_placed(stage *s, kd_query *placed)
{
    for (kd_iter it = kd_query_iter(placed); kd_iter_next(&it);) {
        const kd_world_transform *worlds = KD_COLUMN(&it, kd_world_transform, 0);
        for (uint32_t i = 0; i < it.count; i++) {
            kd_mat4 expected = world_of(s->world, it.entities[i]);
            for (int k = 0; k < 16; k++)
                assert_float_equal(worlds[i].matrix.m[k], expected.m[k],
                                   1e-4f * (1 + fabsf(expected.m[k]))); /* products in another order */
        }
    }
}

/* The list as it stands, and after all of it was made anew. */
static void assert_as_made_anew(stage *s)
{
    kd_draw_list *list = kd_singleton(s->world, kd_draw_list);
    const scene_draws *d = list->internal;
    uint32_t count = list->draw_count, batches = list->batch_count;
    kd_vec3 low = list->bounds_min_ws, high = list->bounds_max_ws;
    kd_box still = kd_box_tree_still(list->tree);
    kd_draw *draws = malloc((count + 1) * sizeof *draws);
    struct kd_object *objects = malloc((count + 1) * sizeof *objects);
    memcpy(draws, list->draws, count * sizeof *draws);
    memcpy(objects, d->objects, count * sizeof *objects);
    kd_singleton(s->world, kd_scene_store)->revision++;
    run_frame(s);
    assert_int_equal(list->draw_count, count);
    assert_int_equal(list->batch_count, batches);
    assert_memory_equal(d->objects, objects, count * sizeof *objects);
    for (uint32_t i = 0; i < count; i++) {
        assert_memory_equal(&list->draws[i].args, &draws[i].args, sizeof draws[i].args);
        assert_memory_equal(&list->draws[i].bounds_min_ws, &draws[i].bounds_min_ws, 2 * sizeof(kd_vec3));
        assert_true(kd_entity_equal(list->draws[i].entity, draws[i].entity));
        assert_int_equal(list->draws[i].moved, draws[i].moved);
    }
    kd_box still_anew = kd_box_tree_still(list->tree);
    assert_memory_equal(&list->bounds_min_ws, &low, sizeof low);
    assert_memory_equal(&list->bounds_max_ws, &high, sizeof high);
    assert_memory_equal(&still, &still_anew, sizeof still);
    free(draws);
    free(objects);
}

static void following_ends_where_making_anew_does(void **state)
{
    (void)state;
    stage s;
    open_stage(&s);
    kd_query *placed = kd_query_make(s.world, &(kd_query_desc){.terms = {KD_READ(kd_world_transform)}});
    uint32_t most = 0;
    for (int frame = 0; frame < FRAMES; frame++) {
        for (uint32_t i = fixture_random(&s.random) % 3; i-- > 0;)
            change_something(&s);
        run_frame(&s);
        run_frame(&s); /* what came without a place has one a frame later */
        assert_placed(&s, placed);
        assert_as_made_anew(&s);
        uint32_t count = kd_singleton(s.world, kd_draw_list)->draw_count;
        most = count > most ? count : most;
    }
    assert_true(most > 40);
    kd_query_destroy(placed);
    kd_schedule_destroy(s.schedule);
    kd_world_destroy(s.world);
}

/* In a large world one thing that moves is one draw that is sent, and nothing else is looked at. */
static void what_rests_is_not_touched(void **state)
{
    (void)state;
    enum { COUNT = 20000 };
    stage s;
    open_stage(&s);
    kd_entity e = KD_NO_ENTITY;
    const kd_scene_store *store = kd_singleton(s.world, kd_scene_store);
    uint32_t mesh = store->models[s.models[0]].first_mesh;
    for (int i = 0; i < COUNT; i++)
        e = kd_spawn(s.world, KD_VAL(kd_mesh_instance, {.mesh = mesh}),
                     KD_VAL(kd_transform, {{(float)(i % 200), 0, (float)(i / 200)}, {0, 0, 0, 1}, {1, 1, 1}}),
                     KD_TAG(kd_world_transform));
    run_frame(&s);
    scene_draws *d = kd_singleton(s.world, kd_draw_list)->internal;
    assert_int_equal(kd_singleton(s.world, kd_draw_list)->draw_count, COUNT);
    memset(d->dirty, 0, d->dirty_capacity * sizeof *d->dirty); /* as the upload leaves it */
    d->changed = false;
    run_frame(&s);
    assert_false(d->changed);
    kd_find_mut(s.world, e, kd_transform)->position.y = 3;
    run_frame(&s);
    assert_true(d->changed);
    uint32_t dirty = 0;
    for (uint32_t i = 0; i < d->dirty_capacity; i++)
        dirty += (uint32_t)__builtin_popcountll(d->dirty[i]);
    assert_int_equal(dirty, 1);
    assert_int_equal(d->tree.changes, 1);
    kd_schedule_destroy(s.schedule);
    kd_world_destroy(s.world);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(following_ends_where_making_anew_does),
        cmocka_unit_test(what_rests_is_not_touched),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
