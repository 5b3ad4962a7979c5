/* Deforming casters: their shadow is drawn when a joint or a weight has changed, and at no other time. */

#include "tests/shadow_fixture.h"

#include "systems/deform/deform.h"
#include "tests/systems_fixture.h"

typedef struct pose {
    bool skinned; /* else morphing */
    float bend;   /* rad about x of every joint, or the weight of every target */
} pose;

/* Joints are deep in the character: each turns what hangs from it. */
static void bend(render *r, const pose *p)
{
    const kd_scene_store *store = kd_singleton(r->world, kd_scene_store);
    for (uint32_t i = 0; i < store->joint_entity_count; i++)
        kd_find_mut(r->world, store->joint_entities[i], kd_transform)->rotation =
            (kd_quat){sinf(p->bend / 2), 0, 0, cosf(p->bend / 2)};
    for (uint32_t i = 0; i < store->deformed_count; i++) {
        kd_morph_weights *w = kd_find_mut(r->world, store->deformed[i].entity, kd_morph_weights);
        for (uint32_t t = 0; w != NULL && t < w->count; t++)
            w->weights[t] = p->bend;
    }
}

static void make_stage(render *r, const void *state)
{
    const pose *p = state;
    uint32_t number;
    kd_entity root;
    kd_material_desc m = render_matte(0.8f);
    kd_model *model = fixture_character(1, 120, p->skinned ? 4 : 0, p->skinned ? 0 : 3, 5);
    r->frame->settings.light_shadow_size = SHADOW_EDGE;
    assert_int_equal(kd_deform_import(r->schedule), KD_OK);
    assert_int_equal(kd_scene_add_model(r->world, model, &number), KD_OK);
    assert_int_equal(kd_scene_instantiate(r->world, number, KD_NO_ENTITY, "caster", &root), KD_OK);
    render_shape(r, KD_SHAPE_PLANE, (kd_vec3){8, 1, 8}, &m, (kd_vec3){0, -2, 0}, RENDER_UPRIGHT, RENDER_UNIT);
    render_camera(r, (kd_vec3){0, 2, 6}, (kd_vec3){0, 0, 0}, 0.8f);
    render_light(r, (kd_light){.type = KD_DIRECTIONAL, .color = {1, 1, 1}, .intensity = 3},
                 (kd_vec3){0, 5, 0}, (kd_vec3){0.2f, -1, 0.3f});
    bend(r, p);
}

static void deformed_caster(render *r, pose p)
{
    make_stage(r, &p);
    render_frame(r, "deformed");
    assert_true(shadow_state_of(r)->drawn_casters > 0);
    for (int i = 0; i < 4; i++) {
        render_frame(r, "deformed"); /* nothing has changed */
        assert_int_equal(shadow_state_of(r)->drawn_layers, 0);
        p.bend += 0.3f;
        bend(r, &p);
        render_frame(r, "deformed");
        assert_true(shadow_state_of(r)->drawn_casters > 0);
        shadow_expect_like_fresh(r, make_stage, &p);
    }
}

static void bent_joints_are_drawn_anew(void **state)
{
    deformed_caster(*state, (pose){.skinned = true});
}

static void changed_weights_are_drawn_anew(void **state)
{
    deformed_caster(*state, (pose){.skinned = false, .bend = 0.1f});
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        RENDER_TEST(bent_joints_are_drawn_anew),
        RENDER_TEST(changed_weights_are_drawn_anew),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
