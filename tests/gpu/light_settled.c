/* Light of a scene in which nothing changes finds its level, and then costs nothing: leaves and entries are
 * what they would be if all were made anew in every frame, then and after something has changed. */

#include "components/bounce.h"
#include "tests/tree_fixture.h"

enum { LONG_ENOUGH = 120, OVER_A_TURN = 11 };

typedef struct lit_world {
    voxel_world v;
    kd_entity lamp, box;
} lit_world;

static lit_world open_lit(void)
{
    lit_world l = {.v = voxel_open((voxel_options){.lit = true})};
    kd_material_desc grey = voxel_matte(0.3f, 0.25f, 0.2f);
    l.v.frame->settings.light_bounces = KD_BOUNCES_INF;
    voxel_shape(&l.v, KD_SHAPE_PLANE, (kd_vec3){1, 0, 1}, &grey, voxel_at(0, 0, 0));
    l.box = voxel_shape(&l.v, KD_SHAPE_BOX, (kd_vec3){0.3f, 0.3f, 0.3f}, &grey, voxel_at(0.1f, 0.2f, 0));
    l.lamp = kd_spawn(l.v.world, KD_VAL(kd_light, {.type = KD_POINT, .color = {1, 1, 1}, .intensity = 3}),
                      KD_VAL(kd_transform, {{-0.3f, 0.5f, 0.2f}, {0, 0, 0, 1}, {1, 1, 1}}),
                      KD_TAG(kd_world_transform));
    return l;
}

/* A frame; `awake`: as if lights had just changed, so that nothing is left out. */
static void run(lit_world *l, bool awake)
{
    kd_singleton(l->v.world, kd_lighting)->version += awake;
    voxel_frame(&l->v);
}

static bool settled(lit_world *l)
{
    return kd_singleton(l->v.world, kd_bounce)->settled;
}

static void assert_same_light(lit_world *a, lit_world *b)
{
    const kd_bounce *x = kd_singleton(a->v.world, kd_bounce), *y = kd_singleton(b->v.world, kd_bounce);
    tree_copy s = tree_read(&a->v), t = tree_read(&b->v);
    size_t size = kd_gpu_buffer_size(voxel_gpu, x->entries);
    uint32_t *p = voxel_read(x->entries, 0, size), *q = voxel_read(y->entries, 0, size);
    tree_assert_same(&s, &t, true);
    assert_memory_equal(p, q, size);
    free(p);
    free(q);
    tree_free(&s);
    tree_free(&t);
}

static void light_that_has_settled_is_left_alone(void **state)
{
    (void)state;
    lit_world sleeps = open_lit(), awake = open_lit();
    int frames = 0;
    for (; frames < LONG_ENOUGH && !settled(&sleeps); frames++) {
        run(&sleeps, false);
        run(&awake, true);
    }
    printf("settled after %d frames\n", frames);
    assert_true(settled(&sleeps));
    for (int i = 0; i < OVER_A_TURN; i++) {
        run(&sleeps, false);
        run(&awake, true);
        assert_true(settled(&sleeps));
        assert_false(settled(&awake));
    }
    assert_same_light(&sleeps, &awake);
    voxel_close(&sleeps.v);
    voxel_close(&awake.v);
}

static void change(lit_world *l, int what)
{
    if (what == 0)
        kd_find_mut(l->v.world, l->lamp, kd_light)->intensity *= 1.05f;
    if (what == 1)
        l->v.frame->settings.cones_step *= 0.9f;
    if (what == 2) /* what has moved once is made anew in every frame */
        kd_find_mut(l->v.world, l->box, kd_transform)->position.x += 0.05f;
}

static void light_wakes_when_anything_changes(void **state)
{
    (void)state;
    lit_world sleeps = open_lit(), awake = open_lit();
    int frames = 0;
    for (int what = 0; what < 3; what++) {
        for (int i = 0; i < LONG_ENOUGH && !settled(&sleeps); i++, frames++)
            run(&sleeps, false);
        assert_true(settled(&sleeps));
        for (; frames > 0; frames--)
            run(&awake, true);
        change(&sleeps, what);
        change(&awake, what);
        for (int i = 0; i < 3; i++) {
            run(&sleeps, false);
            run(&awake, true);
            assert_false(settled(&sleeps));
        }
        assert_same_light(&sleeps, &awake);
    }
    voxel_close(&sleeps.v);
    voxel_close(&awake.v);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(light_that_has_settled_is_left_alone),
        cmocka_unit_test(light_wakes_when_anything_changes),
    };
    return VOXEL_GROUP(tests);
}
