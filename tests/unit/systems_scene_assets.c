/* Models from files: made into entities, played for a while, and drawn within bounds that hold every vertex.
 */

#include "tests/deform_fixture.h"

#include "systems/animation/animation.h"
#include "systems/hierarchy/hierarchy.h"
#include "systems/scene/scene.h"

typedef struct stage {
    kd_world *world;
    kd_schedule *schedule;
    const kd_model *model;
    kd_entity root;
} stage;

static stage begin(const char *asset)
{
    kd_model *model = fixture_asset(asset);
    stage s = {.world = kd_world_make(), .model = model};
    uint32_t number;
    s.schedule = kd_schedule_make(s.world, NULL, NULL);
    assert_int_equal(kd_animation_import(s.schedule), KD_OK);
    assert_int_equal(kd_hierarchy_import(s.schedule), KD_OK);
    assert_int_equal(deform_register_joint_palette(s.schedule), KD_OK);
    assert_int_equal(scene_register_draw_list(s.schedule), KD_OK);
    assert_int_equal(kd_schedule_init(s.schedule), KD_OK);
    assert_int_equal(kd_scene_add_model(s.world, model, &number), KD_OK);
    assert_int_equal(kd_scene_instantiate(s.world, number, KD_NO_ENTITY, "root", &s.root), KD_OK);
    assert_int_equal(kd_entity_count(s.world), model->node_count + 1);
    kd_scene_store *store = kd_singleton(s.world, kd_scene_store);
    scene_internal *in = store->internal;
    store->uploaded_primitives = store->primitive_count;
    in->uploaded_deformed = store->deformed_count;
    kd_singleton(s.world, kd_frame)->dt_s = 0.1f;
    return s;
}

static void end(stage *s)
{
    kd_schedule_destroy(s->schedule);
    kd_world_destroy(s->world);
}

static uint32_t vertices_outside(kd_world *w, const kd_draw *d, const deform_picture *picture)
{
    const kd_scene_store *store = kd_singleton(w, kd_scene_store);
    const kd_store_primitive *p =
        d->deformed ? &store->deformed_primitives[d->primitive] : &store->primitives[d->primitive];
    bool skinned = d->deformed && p->first_skin_vertex != KD_NONE;
    const kd_mat4 *world = &kd_find(w, d->entity, kd_world_transform)->matrix;
    float slack =
        1e-5f * (1 + kd_vec3_length(
                         d->bounds_max_ws)); /* a box turned as a whole rounds otherwise than its vertices */
    uint32_t outside = 0;
    for (uint32_t v = 0; v < p->vertex_count; v++) {
        kd_vec3 at = deform_position(picture, p->base_vertex + v);
        at = skinned ? at : kd_mat4_point(world, at);
        outside += at.x < d->bounds_min_ws.x - slack || at.x > d->bounds_max_ws.x + slack ||
                   at.y < d->bounds_min_ws.y - slack || at.y > d->bounds_max_ws.y + slack ||
                   at.z < d->bounds_min_ws.z - slack || at.z > d->bounds_max_ws.z + slack;
    }
    return outside;
}

/* Play `frames` steps; every vertex of every draw lies within its bounds. Returns in how many steps something
 * moved. */
static uint32_t play(stage *s, uint32_t frames)
{
    uint64_t last = 0;
    uint32_t moved = 0;
    for (uint32_t f = 0; f < frames; f++) {
        assert_int_equal(kd_schedule_run(s->schedule), KD_OK);
        const kd_draw_list *list = kd_singleton(s->world, kd_draw_list);
        deform_picture picture = deform_by_reference(s->world);
        assert_true(list->draw_count > 0);
        for (uint32_t i = 0; i < list->draw_count; i++)
            assert_int_equal(vertices_outside(s->world, &list->draws[i], &picture), 0);
        deform_picture_free(&picture);
        kd_find_mut(s->world, s->root, kd_animation)->blend_left_s =
            0; /* the time itself must not count as motion */
        kd_animation kept = *kd_find(s->world, s->root, kd_animation);
        kd_find_mut(s->world, s->root, kd_animation)->time_s = 0;
        uint64_t sum = kd_world_checksum(s->world);
        *kd_find_mut(s->world, s->root, kd_animation) = kept;
        moved += f && sum != last;
        last = sum;
    }
    return moved;
}

static void cesium_man_walks(void **state)
{
    stage s = begin("cesium_man/CesiumMan.glb");
    const kd_scene_store *store = kd_singleton(s.world, kd_scene_store);
    (void)state;
    assert_int_equal(store->skins[0].joint_count, 19);
    assert_int_equal(store->deformed_count, 1);
    assert_int_equal(play(&s, 12), 11);
    /* A man of 1.5 m: his box is neither flat nor huge. */
    const kd_draw_list *list = kd_singleton(s.world, kd_draw_list);
    assert_true(list->bounds_max_ws.y - list->bounds_min_ws.y > 1 &&
                list->bounds_max_ws.y - list->bounds_min_ws.y < 4);
    end(&s);
}

static void robot_plays_each_of_its_clips(void **state)
{
    stage s = begin("robot/robot.glb");
    (void)state;
    assert_true(s.model->clip_count > 2);
    for (uint32_t i = 0; i < s.model->clip_count; i++) {
        assert_int_equal(kd_scene_play(s.world, s.root, s.model->clips[i].name, true, 1, i % 2 ? 0.2f : 0),
                         KD_OK);
        play(&s, 3);
    }
    assert_int_equal(kd_scene_play(s.world, s.root, "Robot_Dance", true, 1, 0), KD_OK);
    assert_int_equal(play(&s, 6), 5);
    end(&s);
}

static void truck_turns_its_wheels(void **state)
{
    stage s = begin("cesium_milk_truck/CesiumMilkTruck.glb");
    (void)state;
    assert_int_equal(kd_singleton(s.world, kd_scene_store)->deformed_count, 0);
    assert_int_equal(play(&s, 6), 5);
    kd_entity wheels = kd_find_named(s.world, "Wheels");
    assert_true(wheels.generation);
    assert_true(fabsf(kd_find(s.world, wheels, kd_transform)->rotation.w) < 0.9999f);
    end(&s);
}

static void morph_cubes_change_shape(void **state)
{
    stage s = begin("animated_morph_cube/AnimatedMorphCube.gltf");
    (void)state;
    assert_int_equal(kd_singleton(s.world, kd_scene_store)->deformed_count, 1);
    assert_int_equal(play(&s, 6), 5);
    end(&s);
    s = begin("sparse_morph_cube/singleBlendshapeCube_sparse.glb");
    assert_int_equal(kd_singleton(s.world, kd_scene_store)->deformed_count, 1);
    end(&s);
}

/* SimpleSkin: joints at (0, 1, 0), inverse binds that move by (-0.5, -1, 0). At rest everything moves by
 * (-0.5, 0, 0); after one second the second joint is turned by 90 degrees about z, so that the vertex at (0,
 * 2, 0), which hangs on it alone, goes to (-0.5, 1, 0), turned to (-1, -0.5, 0), and ends at (-1, 0.5, 0). */
static void simple_skin_bends(void **state)
{
    static const kd_vec3 bind[] = {{0, 0, 0}, {0, 2, 0}};
    static const kd_vec3 rest[] = {{-0.5f, 0, 0}, {-0.5f, 2, 0}}, bent[] = {{-0.5f, 0, 0}, {-1, 0.5f, 0}};
    stage s = begin("simple_skin/SimpleSkin.gltf");
    const kd_scene_store *store = kd_singleton(s.world, kd_scene_store);
    uint32_t own = store->deformed_primitives[0].base_vertex;
    (void)state;
    kd_singleton(s.world, kd_frame)->dt_s = 0.25f;
    for (uint32_t f = 0; f < 5; f++) { /* times 0 to 1 */
        assert_int_equal(kd_schedule_run(s.schedule), KD_OK);
        deform_picture now = deform_by_reference(s.world);
        for (uint32_t k = 0; k < 2 && (f == 0 || f == 4); k++) {
            uint32_t v = 0; /* the file has no normals: its vertices were split and stand elsewhere */
            while (kd_vec3_length(kd_vec3_sub(deform_position(&now, v), bind[k])) > 0)
                assert_true(++v < store->primitives[0].vertex_count);
            kd_vec3 d = kd_vec3_sub(deform_position(&now, own + v), (f ? bent : rest)[k]);
            assert_true(kd_vec3_length(d) < 1e-5f);
        }
        deform_picture_free(&now);
    }
    assert_int_equal(kd_singleton(s.world, kd_joint_palette)->count, 2);
    end(&s);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(cesium_man_walks),       cmocka_unit_test(robot_plays_each_of_its_clips),
        cmocka_unit_test(truck_turns_its_wheels), cmocka_unit_test(morph_cubes_change_shape),
        cmocka_unit_test(simple_skin_bends),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
