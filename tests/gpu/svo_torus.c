/* The kept tree against trees made at once: wherever the camera went, and whatever came, went or changed on
 * the way, it is the tree that a fresh run makes there. */

#include "tests/tree_fixture.h"

enum { THINGS = 14 };

/* What stands around, by number, so that a fresh world can be given the same. */
typedef struct place {
    kd_vec3 at, size;
    kd_quat turn;
    bool there;
} place;

typedef struct walk {
    voxel_world v;
    kd_entity things[THINGS];
} walk;

static voxel_options options_of(uint32_t resolution, uint32_t cascades, bool one_layer)
{
    return (voxel_options){.resolution = resolution,
                           .cascades = cascades,
                           .span = 2.1f / (float)resolution,
                           .one_layer = one_layer,
                           .lit = true};
}

static kd_entity add_thing(voxel_world *v, const place *p, uint32_t i)
{
    kd_material_desc m = voxel_matte(0.2f + 0.05f * (float)(i % 10), 0.5f, 0.9f - 0.06f * (float)(i % 10));
    if (i % 5 == 0)
        m.emissive = (kd_vec3){1 + 0.2f * (float)i, 1, 0.3f};
    kd_shape shape = i % 3 == 0 ? KD_SHAPE_BOX : i % 3 == 1 ? KD_SHAPE_SPHERE : KD_SHAPE_TORUS;
    kd_vec3 size = shape == KD_SHAPE_BOX ? p->size : (kd_vec3){p->size.x, p->size.x * 0.4f, 0};
    return voxel_shape(v, shape, size, &m, (kd_transform){p->at, p->turn, {1, 1, 1}});
}

/* A long hall round everything holds the bounds, and with them the cascades' way, whatever comes and goes. */
static voxel_world open_hall(voxel_options options)
{
    voxel_world v = voxel_open(options);
    kd_material_desc bright = voxel_matte(0.6f, 0.6f, 0.6f);
    bright.emissive = (kd_vec3){9, 9, 9}; /* the brightest: all other emission is relative to it */
    voxel_shape(&v, KD_SHAPE_BOX, (kd_vec3){13.03f, 5.1f, 9.07f}, NULL, voxel_at(0.01f, 0, 0.02f));
    voxel_shape(&v, KD_SHAPE_BOX, (kd_vec3){0.3f, 0.3f, 0.3f}, &bright, voxel_at(0.2f, 0.1f, 0.3f));
    kd_spawn(v.world,
             KD_VAL(kd_light, {.type = KD_POINT, .color = {1, 0.8f, 0.6f}, .intensity = 5, .range = 30}),
             KD_VAL(kd_transform, KD_TRANSFORM_IDENTITY), KD_TAG(kd_world_transform));
    return v;
}

static walk open_walk(voxel_options options, const place *places)
{
    walk w = {.v = open_hall(options)};
    for (uint32_t i = 0; i < THINGS; i++)
        w.things[i] = places[i].there ? add_thing(&w.v, &places[i], i) : KD_NO_ENTITY;
    return w;
}

static void look_from(voxel_world *v, kd_vec3 at)
{
    kd_find_mut(v->world, v->camera, kd_transform)->position = at;
}

static place random_place(uint64_t *random)
{
    return (place){.at = fixture_vec3(random, -4, 4),
                   .size = fixture_vec3(random, 0.2f, 0.9f),
                   .turn = fixture_random(random) % 2 ? fixture_quat(random) : (kd_quat){0, 0, 0, 1},
                   .there = true};
}

/* One step: the camera goes a little, far, or stays; now and then a thing comes or goes. */
static kd_vec3 step(walk *w, place *places, kd_vec3 eye, uint64_t *random)
{
    uint32_t kind = (uint32_t)(fixture_random(random) % 8), i = (uint32_t)(fixture_random(random) % THINGS);
    if (kind == 0)
        eye = fixture_vec3(random, -6, 6);
    else if (kind < 6)
        eye = kd_vec3_add(eye, fixture_vec3(random, -0.3f, 0.3f));
    look_from(&w->v, eye);
    if (fixture_random(random) % 2)
        return eye;
    if (places[i].there) {
        kd_destroy(w->v.world, w->things[i]);
        places[i].there = false;
    } else {
        places[i] = random_place(random);
        w->things[i] = add_thing(&w->v, &places[i], i);
    }
    return eye;
}

/* Returns how many nodes there are. */
static uint32_t assert_like_fresh(walk *w, voxel_options options, const place *places, kd_vec3 eye)
{
    walk fresh = open_walk(options, places);
    look_from(&fresh.v, eye);
    voxel_frame(&fresh.v);
    tree_copy a = tree_read(&w->v), b = tree_read(&fresh.v);
    tree_assert_same(&a, &b, true);
    uint32_t nodes = b.count[0];
    tree_free(&a);
    tree_free(&b);
    voxel_close(&fresh.v);
    return nodes;
}

static void wander(uint32_t resolution, uint32_t cascades, uint64_t seed, int steps)
{
    voxel_options options = options_of(resolution, cascades, false);
    place places[THINGS];
    uint64_t random = seed;
    uint32_t moved = 0, nodes = 0;
    for (uint32_t i = 0; i < THINGS; i++) {
        places[i] = random_place(&random);
        places[i].there = i % 3 != 0;
    }
    walk w = open_walk(options, places);
    kd_vec3 eye = {0.1f, 0.2f, 0.3f};
    for (int i = 0; i < steps; i++) {
        voxel_frame(&w.v);
        moved += voxel_scene(&w.v)->moved;
        if (i % 4 == 3)
            nodes += assert_like_fresh(&w, options, places, eye);
        eye = step(&w, places, eye, &random);
    }
    assert_true(moved > (uint32_t)steps / 3);
    assert_true(nodes > 1000);
    voxel_close(&w.v);
}

static void kept_tree_of_one_cascade_is_a_fresh_one(void **state)
{
    (void)state, wander(128, 1, 11, 12);
}
static void kept_tree_of_three_cascades_is_a_fresh_one(void **state)
{
    (void)state, wander(128, 3, 12, 16);
}
static void kept_tree_of_two_sparse_levels_is_a_fresh_one(void **state)
{
    (void)state, wander(256, 2, 13, 8);
}

/* Nested boxes come and go. What had their nodes goes back, and what is left gets other numbers: the tree
 * that stays, static cells and all, is that of a run without them. At last the cascades move where nothing
 * is: what is above them moves too. */
static void tree_in_less_room_is_the_same(void **state)
{
    enum { SHELLS = 2, QUIET = 64 };
    (void)state;
    voxel_options options = options_of(256, 2, false);
    walk w = {.v = open_hall(options)}, fresh = {.v = open_hall(options)};
    kd_entity shells[SHELLS];
    for (int i = 0; i < SHELLS; i++) {
        float edge = 0.6f + 0.13f * (float)i;
        shells[i] = voxel_shape(&w.v, KD_SHAPE_BOX, (kd_vec3){edge, edge, edge}, NULL, voxel_at(0, 0, 0));
    }
    voxel_frame(&w.v);
    uint32_t capacity = voxel_svo(&w.v)->node_capacity;
    for (int i = 0; i < SHELLS; i++)
        kd_destroy(w.v.world, shells[i]);
    for (int i = 0; i < QUIET + 2; i++)
        voxel_frame(&w.v);
    assert_true(voxel_svo(&w.v)->node_capacity < capacity / 2);
    look_from(&w.v, (kd_vec3){0.3f, 0.1f, 0});
    look_from(&fresh.v, (kd_vec3){0.3f, 0.1f, 0});
    voxel_frame(&w.v);
    voxel_frame(&fresh.v);
    tree_copy a = tree_read(&w.v), b = tree_read(&fresh.v);
    tree_assert_same(&a, &b, true);
    assert_true(b.count[1] > 1000);
    tree_free(&a);
    tree_free(&b);
    voxel_close(&w.v);
    voxel_close(&fresh.v);
}

/* Where nothing changes for long, masks and spare room go. What comes afterwards finds all as it was: a thing
 * comes, the cascades move, and the tree is that of a run that never rested. */
static void tree_that_slept_is_the_same(void **state)
{
    enum { QUIET = 64, COMES = 5 };
    (void)state;
    voxel_options options = options_of(256, 2, false);
    place places[THINGS];
    uint64_t random = 21;
    kd_vec3 eye = {0.4f, 0.1f, 0};
    for (uint32_t i = 0; i < THINGS; i++) {
        places[i] = random_place(&random);
        places[i].there = i != COMES;
    }
    walk w = open_walk(options, places);
    voxel_frame(&w.v);
    uint32_t leaves = voxel_svo(&w.v)->leaf_room;
    for (int i = 0; i < QUIET + 2; i++)
        voxel_frame(&w.v);
    assert_true(voxel_svo(&w.v)->asleep);
    assert_true(voxel_svo(&w.v)->leaf_room < leaves);
    places[COMES].there = true;
    w.things[COMES] = add_thing(&w.v, &places[COMES], COMES);
    look_from(&w.v, eye);
    voxel_frame(&w.v);
    assert_false(voxel_svo(&w.v)->asleep);
    assert_true(assert_like_fresh(&w, options, places, eye) > 1000);
    voxel_close(&w.v);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(kept_tree_of_one_cascade_is_a_fresh_one),
        cmocka_unit_test(kept_tree_of_three_cascades_is_a_fresh_one),
        cmocka_unit_test(kept_tree_of_two_sparse_levels_is_a_fresh_one),
        cmocka_unit_test(tree_in_less_room_is_the_same),
        cmocka_unit_test(tree_that_slept_is_the_same),
    };
    return VOXEL_GROUP(tests);
}
