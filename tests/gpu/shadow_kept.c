/* Shadow maps are drawn when something that they show has changed, and at no other time. What a frame leaves
 * in them is compared, byte for byte, with the maps of a world that was made in that state. */

#include "tests/shadow_fixture.h"

/* A small stage: floor, a box, a masked screen; a sun and a spot. What tests change stands here. */
typedef struct stage_state {
    kd_vec3 box, lamp, eye;
    kd_quat turn;  /* of the box */
    float opacity; /* of the screen; it is cut out below 0.5 */
    bool hide_box;
} stage_state;

static const stage_state START = {
    .box = {0, 0.5f, 0}, .lamp = {0.5f, 3, 0.4f}, .eye = {0, 2, 4}, .turn = {0, 0, 0, 1}, .opacity = 1};

typedef struct stage {
    render *r;
    kd_entity box, lamp, camera, screen;
} stage;

static kd_entity child_with_mesh(render *r, kd_entity root)
{
    kd_query *q = kd_query_make(r->world, &(kd_query_desc){.terms = {KD_READ(kd_mesh_instance)}});
    kd_entity found = KD_NO_ENTITY;
    for (kd_iter it = kd_query_iter(q); kd_iter_next(&it);)
        for (uint32_t i = 0; i < it.count; i++)
            if (it.entities[i].index >= root.index &&
                (found.generation == 0 || it.entities[i].index < found.index))
                found = it.entities[i];
    kd_query_destroy(q);
    assert_true(found.generation != 0);
    return found;
}

static void apply(const stage *s, const stage_state *state)
{
    kd_world *w = s->r->world;
    *kd_find_mut(w, s->box, kd_transform) = (kd_transform){state->box, state->turn, {1, 1, 1}};
    kd_find_mut(w, s->lamp, kd_transform)->position = state->lamp;
    kd_find_mut(w, s->camera, kd_transform)->position = state->eye;
    kd_find_mut(w, child_with_mesh(s->r, s->box), kd_mesh_instance)->hidden = state->hide_box;
    kd_scene_store *store = kd_singleton(w, kd_scene_store);
    for (uint32_t i = 0; i < store->material_count; i++)
        if (store->materials[i].desc.alpha_mode == KD_ALPHA_MASK)
            store->materials[i].desc.base_color.w = state->opacity;
}

static stage make_stage(render *r, const stage_state *state)
{
    kd_material_desc m = render_matte(0.8f), mask = render_matte(0.8f);
    stage s = {.r = r};
    mask.alpha_mode = KD_ALPHA_MASK;
    mask.alpha_cutoff = 0.5f;
    r->frame->settings.light_shadow_size = SHADOW_EDGE;
    render_shape(r, KD_SHAPE_PLANE, (kd_vec3){8, 1, 8}, &m, (kd_vec3){0, 0, 0}, RENDER_UPRIGHT, RENDER_UNIT);
    s.screen = render_shape(r, KD_SHAPE_BOX, (kd_vec3){0.6f, 0.6f, 0.1f}, &mask, (kd_vec3){1, 0.8f, 0.3f},
                            RENDER_UPRIGHT, RENDER_UNIT);
    s.box = render_shape(r, KD_SHAPE_BOX, (kd_vec3){0.8f, 0.8f, 0.8f}, &m, state->box, RENDER_UPRIGHT,
                         RENDER_UNIT);
    s.camera = render_camera(r, state->eye, (kd_vec3){0, 0, 0}, 0.8f);
    render_light(r, (kd_light){.type = KD_DIRECTIONAL, .color = {1, 1, 1}, .intensity = 3},
                 (kd_vec3){0, 5, 0}, (kd_vec3){1, -1, 0.3f});
    s.lamp =
        render_light(r, (kd_light){.type = KD_SPOT, .color = {1, 1, 1}, .intensity = 30, .outer_cone = 0.7f},
                     state->lamp, (kd_vec3){0, -1, 0});
    apply(&s, state);
    return s;
}

/* The maps are what a world shows that was in this state from its first frame on. */
static void make_fresh(render *fresh, const void *state)
{
    make_stage(fresh, state);
}

static void expect_like_fresh(const stage *s, const stage_state *state)
{
    shadow_expect_like_fresh(s->r, make_fresh, state);
}

/* A settled stage: its maps are drawn. */
static stage settle(render *r, const stage_state *state)
{
    stage s = make_stage(r, state);
    render_frame(r, "kept");
    assert_true(shadow_state_of(r)->drawn_casters > 0);
    render_frame(r, "kept");
    return s;
}

static void steady_frame_draws_nothing(void **state)
{
    render *r = *state;
    stage s = settle(r, &START);
    for (int i = 0; i < 3; i++) {
        assert_int_equal(shadow_state_of(r)->drawn_layers, 0);
        assert_int_equal(shadow_state_of(r)->drawn_casters, 0);
        assert_int_equal(shadow_state_of(r)->copied_layers, 0);
        assert_int_equal(shadow_state_of(r)->bytes_moved, 0);
        render_frame(r, "kept");
    }
    expect_like_fresh(&s, &START);
}

/* Every frame moves or turns the box: first it leaves the resting casters, then only it is drawn. */
static void moved_caster_gives_the_maps_of_a_fresh_world(void **state)
{
    render *r = *state;
    stage_state now = START;
    stage s = settle(r, &now);
    for (int i = 1; i <= 5; i++) {
        now.box = (kd_vec3){0.1f * (float)i, 0.5f + 0.03f * (float)i, -0.07f * (float)i};
        now.turn = render_look((kd_vec3){0.2f * (float)i, 0, -1});
        apply(&s, &now);
        render_frame(r, "kept");
        const shadow_state *shadow = shadow_state_of(r);
        assert_true(shadow->drawn_casters > 0);
        /* from the second time on it is drawn over the others' depth, from the third on nothing else is drawn
         */
        if (i >= 2)
            assert_true(shadow->copied_layers >= 2); /* the spot's and the widest cascade's at least */
        if (i >= 3)
            assert_int_equal(shadow->drawn_casters, shadow->copied_layers);
        expect_like_fresh(&s, &now);
    }
    render_frame(r, "kept");
    assert_int_equal(shadow_state_of(r)->drawn_layers, 0);
    expect_like_fresh(&s, &now);
}

/* The highest of all casters rises by a tenth of a millimetre a frame: depth ranges follow the scene's bounds
 * in steps of centimetres, so that they hold still in most frames, and the rest is not drawn again. */
static void caster_that_sets_the_bounds_moves_alone(void **state)
{
    render *r = *state;
    stage_state now = START;
    uint32_t alone = 0;
    now.box.y = 1.7f;
    stage s = settle(r, &now);
    for (int i = 0; i < 10; i++) {
        now.box.y += 1e-4f;
        apply(&s, &now);
        render_frame(r, "kept");
        alone += i >= 2 && shadow_state_of(r)->drawn_casters == shadow_state_of(r)->copied_layers;
    }
    assert_true(alone >= 5);
    expect_like_fresh(&s, &now);
}

static void moved_light_redraws_its_maps_alone(void **state)
{
    render *r = *state;
    stage_state now = START;
    stage s = settle(r, &now);
    for (int i = 1; i <= 3; i++) {
        now.lamp.x += 0.1f;
        apply(&s, &now);
        render_frame(r, "kept");
        assert_int_equal(shadow_state_of(r)->drawn_layers, 1);
        assert_int_equal(shadow_state_of(r)->copied_layers, 0);
        expect_like_fresh(&s, &now);
    }
}

/* Cascades follow in whole texels: a step of a tenth of the finest cascade's texel may or may not pass one, a
 * metre does. The spot's map does not depend on the camera. */
static void moved_camera_draws_cascades_that_snap(void **state)
{
    render *r = *state;
    stage_state now = START;
    stage s = settle(r, &now);
    uint32_t moved = 0;
    for (int i = 1; i <= 4; i++) {
        now.eye.x = i < 4 ? 1e-4f * (float)i : 1.3f;
        apply(&s, &now);
        render_frame(r, "kept");
        moved = shadow_state_of(r)->drawn_layers;
        assert_true(moved < shadow_state_of(r)->layer_count);
        expect_like_fresh(&s, &now);
    }
    assert_true(moved > 0);
}

static void hidden_caster_leaves_and_comes_back(void **state)
{
    render *r = *state;
    stage_state now = START;
    stage s = settle(r, &now);
    for (int i = 0; i < 4; i++) {
        now.hide_box = i % 2 == 0;
        now.box.x += 0.1f; /* so that it is a moving one from its second coming on */
        apply(&s, &now);
        render_frame(r, "kept");
        assert_true(shadow_state_of(r)->drawn_layers + shadow_state_of(r)->copied_layers > 0);
        expect_like_fresh(&s, &now);
    }
}

static void destroyed_caster_leaves_no_shadow(void **state)
{
    render *r = *state;
    stage_state now = START;
    stage s = settle(r, &now);
    for (int i = 0; i < 3; i++) { /* its depth is drawn over that of the others */
        now.box.x += 0.1f;
        apply(&s, &now);
        render_frame(r, "kept");
    }
    kd_destroy(r->world, s.box);
    render_frame(r, "kept");
    assert_true(shadow_state_of(r)->copied_layers >= 2);
    assert_int_equal(shadow_state_of(r)->drawn_casters, 0);
    now.hide_box = true;
    expect_like_fresh(&s, &now);
}

static void changed_mask_is_drawn_anew(void **state)
{
    render *r = *state;
    stage_state now = START;
    stage s = settle(r, &now);
    now.opacity = 0.3f;
    apply(&s, &now);
    render_frame(r, "kept");
    assert_true(shadow_state_of(r)->drawn_layers > 0);
    expect_like_fresh(&s, &now);
    now.opacity = 0.7f;
    apply(&s, &now);
    render_frame(r, "kept");
    assert_true(shadow_state_of(r)->drawn_layers > 0);
    expect_like_fresh(&s, &now);
    render_frame(r, "kept");
    assert_int_equal(shadow_state_of(r)->drawn_layers, 0);
}

/* A second lamp makes the array grow, which loses what the maps held. */
static void new_light_fills_all_maps_of_its_kind(void **state)
{
    render *r = *state;
    stage s = settle(r, &START);
    kd_entity second =
        render_light(r, (kd_light){.type = KD_SPOT, .color = {1, 1, 1}, .intensity = 30, .outer_cone = 0.7f},
                     (kd_vec3){0, 4, 0}, (kd_vec3){0, -1, 0});
    render_frame(r, "kept");
    assert_int_equal(shadow_state_of(r)->drawn_layers, 2);
    kd_destroy(r->world, second);
    render_frame(r, "kept");
    assert_int_equal(shadow_state_of(r)->drawn_layers, 0); /* the first lamp's map still stands */
    kd_destroy(r->world, s.lamp);
    render_frame(r, "kept");
    assert_int_equal(shadow_state_of(r)->drawn_layers, 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        RENDER_TEST(steady_frame_draws_nothing),
        RENDER_TEST(moved_caster_gives_the_maps_of_a_fresh_world),
        RENDER_TEST(caster_that_sets_the_bounds_moves_alone),
        RENDER_TEST(moved_light_redraws_its_maps_alone),
        RENDER_TEST(moved_camera_draws_cascades_that_snap),
        RENDER_TEST(hidden_caster_leaves_and_comes_back),
        RENDER_TEST(destroyed_caster_leaves_no_shadow),
        RENDER_TEST(changed_mask_is_drawn_anew),
        RENDER_TEST(new_light_fills_all_maps_of_its_kind),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
