/* Channels, clips, looping and cross-fades, against values worked out by hand. */

#include "tests/systems_fixture.h"

#include "systems/animation/animation.h"
#include "systems/animation/sample.h"
#include "systems/scene/scene.h"

/* Values here are sums of few float products: an error of some units in the last place. */
#define EPSILON 1e-6f

static float sample_x(const kd_channel_desc *channel, float t)
{
    float out[4] = {0};
    animation_sample(channel, t, out, 4);
    return out[0];
}

static void step_holds_a_key_until_the_next(void **state)
{
    static const float times[] = {0, 1, 2}, values[] = {10, 0, 0, 20, 0, 0, 30, 0, 0};
    const kd_channel_desc c = {.path = KD_PATH_TRANSLATION,
                               .interpolation = KD_INTERPOLATE_STEP,
                               .key_count = 3,
                               .width = 3,
                               .times = times,
                               .values = values};
    (void)state;
    assert_float_equal(sample_x(&c, -1), 10, 0);
    assert_float_equal(sample_x(&c, 0.5f), 10, 0);
    assert_float_equal(sample_x(&c, 1), 20, 0);
    assert_float_equal(sample_x(&c, 1.999f), 20, 0);
    assert_float_equal(sample_x(&c, 2), 30, 0);
    assert_float_equal(sample_x(&c, 9), 30, 0);
}

static void linear_meets_keys_and_goes_straight_between(void **state)
{
    static const float times[] = {1, 2, 4}, values[] = {10, 0, 0, 20, 0, 0, 40, 0, 0};
    const kd_channel_desc c = {.path = KD_PATH_SCALE,
                               .interpolation = KD_INTERPOLATE_LINEAR,
                               .key_count = 3,
                               .width = 3,
                               .times = times,
                               .values = values};
    (void)state;
    assert_float_equal(sample_x(&c, 0), 10, 0);
    assert_float_equal(sample_x(&c, 1.25f), 12.5f, EPSILON);
    assert_float_equal(sample_x(&c, 2), 20, 0);
    assert_float_equal(sample_x(&c, 3), 30, EPSILON); /* 20 + (40 - 20) * (3 - 2) / 2 */
    assert_float_equal(sample_x(&c, 4), 40, 0);
}

static void rotation_takes_the_short_way(void **state)
{
    const float s = 0.70710678f; /* a quarter turn about y, and the same one with its sign turned */
    const float times[] = {0, 1}, there[] = {0, 0, 0, 1, 0, s, 0, s}, turned[] = {0, 0, 0, 1, 0, -s, 0, -s};
    kd_channel_desc c = {.path = KD_PATH_ROTATION,
                         .interpolation = KD_INTERPOLATE_LINEAR,
                         .key_count = 2,
                         .width = 4,
                         .times = times,
                         .values = there};
    (void)state;
    for (int k = 0; k < 2; k++) {
        float q[4];
        c.values = k ? turned : there;
        animation_sample(&c, 1.0f / 3, q, 4); /* 30 degrees: half angle 15 */
        assert_float_equal(q[1], 0.25881905f, EPSILON);
        assert_float_equal(q[3], 0.96592583f, EPSILON);
        animation_sample(&c, 0.5f, q, 4); /* 45 degrees: half angle 22.5 */
        assert_float_equal(q[1], 0.38268343f, EPSILON);
        assert_float_equal(q[3], 0.92387953f, EPSILON);
    }
}

static void nearly_equal_rotations_stay_unit(void **state)
{
    const kd_quat a = {0, 0, 0, 1}, b = {0, 1e-4f, 0, 1};
    kd_quat q = kd_quat_slerp(a, b, 0.5f);
    (void)state;
    assert_float_equal(q.y, 0.5e-4f, 1e-9f);
    assert_float_equal(q.x * q.x + q.y * q.y + q.z * q.z + q.w * q.w, 1, EPSILON);
}

/* Interval 2 s, values 1 and 3, leaving with 4 per second, arriving with -2 per second. In the middle the
 * Hermite weights are 1/2, 1/8, 1/2, -1/8: 0.5*1 + 0.125*2*4 + 0.5*3 - 0.125*2*(-2) = 3.5. At a quarter:
 * 27/32, 9/64, 5/32, -3/64: 0.84375 + 0.140625*8 + 0.46875 + 0.046875*4 = 2.625. */
static void cubic_scales_tangents_by_the_interval(void **state)
{
    static const float times[] = {1, 3};
    static const float values[] = {99, 0, 0, 1, 0, 0, 4, 0, 0, -2, 0, 0, 3, 0, 0, 99, 0, 0};
    const kd_channel_desc c = {.path = KD_PATH_TRANSLATION,
                               .interpolation = KD_INTERPOLATE_CUBIC,
                               .key_count = 2,
                               .width = 3,
                               .times = times,
                               .values = values};
    (void)state;
    assert_float_equal(sample_x(&c, 0), 1, 0);
    assert_float_equal(sample_x(&c, 1), 1, 0);
    assert_float_equal(sample_x(&c, 1.5f), 2.625f, EPSILON);
    assert_float_equal(sample_x(&c, 2), 3.5f, EPSILON);
    assert_float_equal(sample_x(&c, 3), 3, 0);
    assert_float_equal(sample_x(&c, 8), 3, 0);
}

static void cubic_rotation_is_unit(void **state)
{
    static const float times[] = {0, 1};
    static const float values[] = {0, 0, 0, 0, 0, 0,    0, 1,    0, 1, 0, 0,
                                   0, 1, 0, 0, 0, 0.6f, 0, 0.8f, 0, 0, 0, 0};
    const kd_channel_desc c = {.path = KD_PATH_ROTATION,
                               .interpolation = KD_INTERPOLATE_CUBIC,
                               .key_count = 2,
                               .width = 4,
                               .times = times,
                               .values = values};
    (void)state;
    for (float t = 0; t <= 1; t += 0.125f) {
        float q[4];
        animation_sample(&c, t, q, 4);
        assert_float_equal(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3], 1, EPSILON);
    }
}

static void one_key_is_held(void **state)
{
    static const float times[] = {0.5f}, values[] = {7, 0, 0};
    const kd_channel_desc c = {.path = KD_PATH_TRANSLATION,
                               .interpolation = KD_INTERPOLATE_LINEAR,
                               .key_count = 1,
                               .width = 3,
                               .times = times,
                               .values = values};
    (void)state;
    assert_float_equal(sample_x(&c, 0), 7, 0);
    assert_float_equal(sample_x(&c, 0.5f), 7, 0);
    assert_float_equal(sample_x(&c, 3), 7, 0);
}

static void wrap_loops_and_holds(void **state)
{
    (void)state;
    assert_float_equal(animation_wrap(2.5, 1, true), 0.5f, 0);
    assert_float_equal(animation_wrap(-0.25, 1, true), 0.75f, 0);
    assert_float_equal(animation_wrap(1, 1, true), 0, 0);
    assert_float_equal(animation_wrap(-1e-12, 1, true), 0, 0); /* rounds to the end, which is the start */
    assert_float_equal(animation_wrap(2.5, 1, false), 1, 0);
    assert_float_equal(animation_wrap(-3, 1, false), 0, 0);
    assert_float_equal(animation_wrap(5, 0, true), 0, 0);
    assert_float_equal(animation_wrap((double)NAN, 1, true), 0, 0);
}

/* ---- the system ---- */

/* Node 0 goes along x from 0 to 4 in clip "walk" (1 s), node 1 stands at y = 8 in clip "jump" (1 s); clip
 * "smile" brings the two weights of node 2 from (0, 1) to (1, 0). At rest all nodes are at the origin, the
 * weights at (0.5, 0.25). */
static kd_model *make_model(void)
{
    static const float times[] = {0, 1}, walk[] = {0, 0, 0, 4, 0, 0}, jump[] = {0, 8, 0, 0, 8, 0};
    static const float smile[] = {0, 1, 1, 0}, rest[] = {0.5f, 0.25f};
    static const kd_channel_desc channels[] = {
        {0, KD_PATH_TRANSLATION, KD_INTERPOLATE_LINEAR, 2, 3, times, walk},
        {1, KD_PATH_TRANSLATION, KD_INTERPOLATE_STEP, 2, 3, times, jump},
        {2, KD_PATH_WEIGHTS, KD_INTERPOLATE_LINEAR, 2, 2, times, smile},
    };
    static const kd_clip_desc clips[] = {
        {"walk", 1, 1, &channels[0], 0, NULL},
                                         {"jump", 1, 1, &channels[1], 0, NULL},
                                         {"smile", 1, 1, &channels[2], 0, NULL}};
    uint64_t random = 3;
    kd_model *model = fixture_model();
    kd_node_desc *nodes = fixture_nodes(model, 3);
    nodes[0].name = "body";
    nodes[1].name = "arm";
    nodes[2].name = "face";
    nodes[1].parent = 0;
    nodes[2].mesh = 0;
    kd_primitive_desc *primitive = FIXTURE_NEW(model, kd_primitive_desc, 1);
    *primitive = fixture_primitive(model, 12, 0, 2, &random);
    kd_mesh_desc *mesh = FIXTURE_NEW(model, kd_mesh_desc, 1);
    *mesh = (kd_mesh_desc){.name = "face",
                           .primitive_count = 1,
                           .primitives = primitive,
                           .morph_count = 2,
                           .morph_weights = rest};
    model->meshes = mesh;
    model->mesh_count = 1;
    model->clips = clips;
    model->clip_count = 3;
    return model;
}

typedef struct stage {
    kd_jobs *jobs;
    kd_world *world;
    kd_schedule *schedule;
    kd_entity root;
    uint32_t model;
} stage;

static void stage_init(stage *s, uint32_t threads)
{
    s->jobs = kd_jobs_make(threads);
    s->world = kd_world_make();
    s->schedule = kd_schedule_make(s->world, s->jobs, NULL);
    assert_int_equal(kd_animation_import(s->schedule), KD_OK);
    assert_int_equal(kd_schedule_init(s->schedule), KD_OK);
    kd_singleton(s->world, kd_frame)->dt_s = 0.25f;
    assert_int_equal(kd_scene_add_model(s->world, make_model(), &s->model), KD_OK);
    assert_int_equal(kd_scene_instantiate(s->world, s->model, KD_NO_ENTITY, "hero", &s->root), KD_OK);
}

static void stage_fini(stage *s)
{
    kd_schedule_destroy(s->schedule);
    kd_world_destroy(s->world);
    kd_jobs_destroy(s->jobs);
}

static int setup(void **state)
{
    static stage s;
    stage_init(&s, 1);
    *state = &s;
    return 0;
}

static int teardown(void **state)
{
    stage_fini(*state);
    return 0;
}

static kd_entity node(const stage *s, uint32_t number)
{
    const kd_animation *a = kd_find(s->world, s->root, kd_animation);
    return kd_singleton(s->world, kd_scene_store)->node_entities[a->first_node + number];
}

/* Run a frame; where node `number` is then. */
static kd_vec3 step(const stage *s, uint32_t number)
{
    assert_int_equal(kd_schedule_run(s->schedule), KD_OK);
    return kd_find(s->world, node(s, number), kd_transform)->position;
}

static void first_clip_plays_from_its_start_and_loops(void **state)
{
    static const float x[] = {0, 1, 2, 3, 0, 1};
    for (int i = 0; i < 6; i++)
        assert_float_equal(step(*state, 0).x, x[i], EPSILON);
}

static void without_loop_the_end_is_held(void **state)
{
    static const float x[] = {0, 1, 2, 3, 4, 4, 4};
    stage *s = *state;
    kd_find_mut(s->world, s->root, kd_animation)->loop = false;
    for (int i = 0; i < 7; i++)
        assert_float_equal(step(s, 0).x, x[i], EPSILON);
}

static void negative_speed_plays_backwards(void **state)
{
    static const float x[] = {1, 0, 3, 2};
    stage *s = *state;
    *kd_find_mut(s->world, s->root, kd_animation) =
        (kd_animation){.clip = 1, .model = s->model + 1, .speed = -1, .loop = true, .time_s = 0.25f};
    for (int i = 0; i < 4; i++)
        assert_float_equal(step(s, 0).x, x[i], EPSILON);
}

static void paused_and_stopped_hold_the_pose(void **state)
{
    stage *s = *state;
    step(s, 0);
    step(s, 0);
    kd_find_mut(s->world, s->root, kd_animation)->paused = true;
    for (int i = 0; i < 3; i++)
        assert_float_equal(step(s, 0).x, 2, EPSILON); /* the time that came next when it was paused */
    kd_find_mut(s->world, s->root, kd_animation)->clip = 0;
    kd_find_mut(s->world, node(s, 0), kd_transform)->position.x = 77; /* no clip: nobody writes over this */
    assert_float_equal(step(s, 0).x, 77, 0);
}

/* Shown so far: times 0 and 0.25, so 0.5 comes next (x = 2). Over 0.5 s in steps of 0.25 the old clip weighs
 * 1, 1/2, 0, at its times 0.5, 0.75: x = 2, then (0 at rest + 3) / 2, then 0. The new one stands at y = 8,
 * from the rest pose's 0. */
static void cross_fade_goes_from_the_old_clip_to_the_new(void **state)
{
    static const float x[] = {2, 1.5f, 0, 0}, y[] = {0, 4, 8, 8};
    stage *s = *state;
    step(s, 0);
    step(s, 0);
    assert_int_equal(kd_scene_play(s->world, s->root, "jump", true, 1, 0.5f), KD_OK);
    for (int i = 0; i < 4; i++) {
        assert_float_equal(step(s, 0).x, x[i], EPSILON);
        assert_float_equal(kd_find(s->world, node(s, 1), kd_transform)->position.y, y[i], EPSILON);
    }
    assert_int_equal(kd_find(s->world, s->root, kd_animation)->previous_clip, 0);
}

static void a_cut_leaves_nothing_of_the_old_clip(void **state)
{
    stage *s = *state;
    step(s, 0);
    step(s, 0);
    assert_int_equal(kd_scene_play(s->world, s->root, "jump", true, 1, 0), KD_OK);
    assert_float_equal(step(s, 0).x, 0, 0);
    assert_float_equal(kd_find(s->world, node(s, 1), kd_transform)->position.y, 8, 0);
}

/* "jump" at y = 8, laid over "walk": its share is its weight, and what it does not move walks on. */
static void layers_mix_into_the_pose(void **state)
{
    static const float x[] = {0, 1, 2, 3}, fading_in[] = {0, 4, 8, 8}, fading_out[] = {8, 4, 0, 0};
    stage *s = *state;
    kd_scene_layer jump = {
        .layer = 2, .clip = "jump", .loop = true, .speed = 1, .weight = 1, .blend_s = 0.5f};
    assert_int_equal(kd_scene_play_layer(s->world, s->root, &jump), KD_OK);
    for (int i = 0; i < 4; i++) {
        assert_float_equal(step(s, 0).x, x[i], EPSILON);
        assert_float_equal(kd_find(s->world, node(s, 1), kd_transform)->position.y, fading_in[i], EPSILON);
    }
    assert_int_equal(kd_scene_play_layer(s->world, s->root, &(kd_scene_layer){.layer = 2, .blend_s = 0.5f}),
                     KD_OK);
    for (int i = 0; i < 4; i++)
        assert_float_equal(step(s, 1).y, fading_out[i], EPSILON);
    assert_int_equal(kd_find(s->world, s->root, kd_animation_layers)->clip[1], 0);
    jump = (kd_scene_layer){.layer = 1, .clip = "jump", .loop = true, .speed = 1, .weight = 0.25f};
    assert_int_equal(kd_scene_play_layer(s->world, s->root, &jump), KD_OK);
    assert_float_equal(step(s, 1).y, 2, EPSILON);
}

static void a_layer_moves_what_hangs_below_its_node(void **state)
{
    static const struct {
        uint32_t from;
        float y;
    } rows[] = {{0, 8}, {1, 8}, {2, 0}}; /* node 1, which jumps, hangs below node 0 */
    stage *s = *state;
    for (size_t i = 0; i < 3; i++) {
        kd_scene_layer jump = {.layer = 1, .clip = "jump", .speed = 1, .weight = 1};
        kd_find_mut(s->world, node(s, 1), kd_transform)->position.y = 0;
        jump.from = kd_singleton(s->world, kd_scene_store)->models[s->model].model->nodes[rows[i].from].name;
        if (!jump.from || !*jump.from)
            fail_msg("node %u has no name", rows[i].from);
        assert_int_equal(kd_scene_play_layer(s->world, s->root, &jump), KD_OK);
        assert_float_equal(step(s, 1).y, rows[i].y, EPSILON);
    }
    assert_int_equal(kd_scene_play_layer(s->world, s->root, &(kd_scene_layer){.layer = 4, .clip = "jump"}),
                     KD_OUT_OF_RANGE);
    assert_int_equal(kd_scene_play_layer(s->world, s->root,
                                         &(kd_scene_layer){.layer = 1, .clip = "jump", .from = "nobody"}),
                     KD_NOT_FOUND);
}

/* Without a clip of its own the instance is laid over its rest. */
static void a_layer_needs_no_clip_below_it(void **state)
{
    stage *s = *state;
    kd_find_mut(s->world, s->root, kd_animation)->clip = 0;
    const kd_scene_layer jump = {.layer = 1, .clip = "jump", .speed = 1, .weight = 0.5f};
    assert_int_equal(kd_scene_play_layer(s->world, s->root, &jump), KD_OK);
    assert_float_equal(step(s, 1).y, 4, EPSILON);
    assert_float_equal(step(s, 0).x, 0, 0);
}

static void weights_follow_their_channel_and_fade(void **state)
{
    static const float first[] = {0, 0.25f, 0.5f}, second[] = {1, 0.75f, 0.5f};
    stage *s = *state;
    assert_int_equal(kd_scene_play(s->world, s->root, "smile", true, 1, 0), KD_OK);
    for (int i = 0; i < 3; i++) {
        step(s, 0);
        const kd_morph_weights *w = kd_find(s->world, node(s, 2), kd_morph_weights);
        assert_int_equal(w->count, 2);
        assert_float_equal(w->weights[0], first[i], EPSILON);
        assert_float_equal(w->weights[1], second[i], EPSILON);
    }
    /* Next comes 0.75: (0.75, 0.25). Faded half towards the rest (0.5, 0.25) in the second frame, at time 0
     * of the loop:
     * ((0 + 0.5) / 2, (1 + 0.25) / 2); at the end the rest itself. */
    assert_int_equal(kd_scene_play(s->world, s->root, "walk", true, 1, 0.5f), KD_OK);
    static const float out0[] = {0.75f, 0.25f, 0.5f}, out1[] = {0.25f, 0.625f, 0.25f};
    for (int i = 0; i < 3; i++) {
        step(s, 0);
        const kd_morph_weights *w = kd_find(s->world, node(s, 2), kd_morph_weights);
        assert_float_equal(w->weights[0], out0[i], EPSILON);
        assert_float_equal(w->weights[1], out1[i], EPSILON);
    }
}

static char logged[1024];
static void keep_log(void *user, kd_log_level level, const char *text)
{
    (void)user;
    (void)level;
    snprintf(logged, sizeof logged, "%s", text);
}

static void unknown_clip_is_refused_with_the_list(void **state)
{
    stage *s = *state;
    kd_log_set_sink(keep_log, NULL);
    assert_int_equal(kd_scene_play(s->world, s->root, "fly", true, 1, 0), KD_NOT_FOUND);
    kd_log_set_sink(NULL, NULL);
    assert_non_null(strstr(logged, "'fly'"));
    assert_non_null(strstr(logged, "'walk', 'jump', 'smile'"));
    assert_int_equal(kd_find(s->world, s->root, kd_animation)->clip, 1);
}

static void any_number_of_threads_gives_the_same_world(void **state)
{
    uint64_t sums[2];
    (void)state;
    for (uint32_t threads = 1; threads <= 2; threads++) {
        stage s;
        stage_init(&s, threads);
        for (int i = 0; i < 40; i++) {
            kd_entity e;
            assert_int_equal(kd_scene_instantiate(s.world, s.model, KD_NO_ENTITY, "copy", &e), KD_OK);
            kd_find_mut(s.world, e, kd_animation)->time_s = (float)i * 0.0173f;
        }
        for (int i = 0; i < 7; i++)
            assert_int_equal(kd_schedule_run(s.schedule), KD_OK);
        sums[threads - 1] = kd_world_checksum(s.world);
        stage_fini(&s);
    }
    assert_int_equal(sums[0], sums[1]);
}

#define STAGED(name) cmocka_unit_test_setup_teardown(name, setup, teardown)

/* Rounding each sum to a float lost 1.5 ms here, and more in longer clips. */
static void an_hour_of_steps_is_an_hour(void **state)
{
    const float duration_s = 1.3f;
    float time_s = 0, rest_s = 0, held_s = 3599.99f, held_rest_s = 0;
    (void)state;
    for (int i = 0; i < 3600 * 60; i++)
        animation_advance(&time_s, &rest_s, 1.0 / 60, duration_s, true);
    assert_float_equal(time_s, (float)fmod(3600, (double)duration_s), EPSILON);
    for (int i = 0; i < 60; i++)
        animation_advance(&held_s, &held_rest_s, 1.0 / 60, 3600, false);
    assert_float_equal(held_s, 3600, 0);
    assert_float_equal(held_rest_s, 0, 0);
    animation_advance(&time_s, &rest_s, (double)INFINITY, duration_s, true);
    assert_float_equal(time_s + rest_s, 0, 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(step_holds_a_key_until_the_next),
        cmocka_unit_test(linear_meets_keys_and_goes_straight_between),
        cmocka_unit_test(rotation_takes_the_short_way),
        cmocka_unit_test(nearly_equal_rotations_stay_unit),
        cmocka_unit_test(cubic_scales_tangents_by_the_interval),
        cmocka_unit_test(cubic_rotation_is_unit),
        cmocka_unit_test(one_key_is_held),
        cmocka_unit_test(wrap_loops_and_holds),
        cmocka_unit_test(an_hour_of_steps_is_an_hour),
        STAGED(layers_mix_into_the_pose),
        STAGED(a_layer_moves_what_hangs_below_its_node),
        STAGED(a_layer_needs_no_clip_below_it),
        STAGED(first_clip_plays_from_its_start_and_loops),
        STAGED(without_loop_the_end_is_held),
        STAGED(negative_speed_plays_backwards),
        STAGED(paused_and_stopped_hold_the_pose),
        STAGED(cross_fade_goes_from_the_old_clip_to_the_new),
        STAGED(a_cut_leaves_nothing_of_the_old_clip),
        STAGED(weights_follow_their_channel_and_fade),
        STAGED(unknown_clip_is_refused_with_the_list),
        cmocka_unit_test(any_number_of_threads_gives_the_same_world),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
