/* A flying camera finds the voxels of what it comes to made already, a few in each frame before. */

#include "tests/voxel_fixture.h"

enum { BALLS = 40, FRAMES = 60, START = 12 };

/* A row of balls, each of its own size so that none shares voxels with another, over a plane in tiles. */
static void build_row(voxel_world *v)
{
    for (int i = 0; i < BALLS; i++) {
        float size = 0.3f + 0.005f * (float)i;
        voxel_shape(v, KD_SHAPE_SPHERE, (kd_vec3){size, size, size}, NULL, voxel_at((float)i, 0, 0.2f));
    }
    voxel_shape(v, KD_SHAPE_PLANE, (kd_vec3){100, 0, 100}, NULL, voxel_at(0, -0.5f, 0));
}

static void look_from(voxel_world *v, float x)
{
    *kd_find_mut(v->world, v->camera, kd_transform) =
        (kd_transform){{x, 0.3f, 0}, {0, -0.70710678f, 0, 0.70710678f}, {1, 1, 1}}; /* along x */
}

/* Caches that objects need in this frame and that had not been made when the frame before ended. */
static uint32_t count_late(const kd_voxel_scene *s, const bool *made_before, uint32_t count_before)
{
    uint32_t late = 0;
    for (uint32_t i = 0; i < s->object_count; i++)
        for (uint32_t c = 0; s->objects[i].alive && c < s->cascade_count; c++) {
            uint32_t cache = s->objects[i].caches[c];
            if (!cache)
                continue;
            assert_true(s->caches[cache - 1].made);
            late += cache > count_before || !made_before[cache - 1];
        }
    return late;
}

static uint32_t note_made(const kd_voxel_scene *s, bool *made)
{
    uint32_t count = 0;
    assert_true(s->cache_count <= 1024);
    for (uint32_t i = 0; i < s->cache_count; i++)
        count += made[i] = s->caches[i].alive && s->caches[i].made;
    return count;
}

static void flight_finds_what_it_comes_to(void **state)
{
    (void)state;
    voxel_world v = voxel_open((voxel_options){.cascades = 2, .span = 0.04f});
    bool made[1024] = {false};
    uint32_t known = 0, count = 0, most = 0;
    build_row(&v);
    for (int frame = 0; frame < FRAMES; frame++) {
        look_from(&v, 0.3f * (float)(frame < 3 ? 0 : frame - 3));
        voxel_frame(&v);
        const kd_voxel_scene *s = voxel_scene(&v);
        if (frame >= START)
            assert_int_equal(count_late(s, made, known), 0);
        known = s->cache_count;
        uint32_t now = note_made(s, made);
        if (frame >= START && now > count)
            most = now - count > most ? now - count : most;
        count = now;
    }
    assert_in_range(most, 1, 12); /* in one frame; a ball comes every third, with a cache for each cascade */
    voxel_close(&v);
}

static void camera_that_stands_or_jumps_asks_for_nothing_ahead(void **state)
{
    (void)state;
    voxel_world v = voxel_open((voxel_options){.cascades = 2, .span = 0.04f});
    build_row(&v);
    for (int frame = 0; frame < 6; frame++) {
        look_from(&v, frame < 3 ? 0.0f : 30.0f); /* three times as far as the outermost cascade is wide */
        voxel_frame(&v);
        const kd_voxel_scene *s = voxel_scene(&v);
        assert_int_equal(s->unmade, 0);
        for (uint32_t i = 0; i < s->cache_count; i++)
            assert_true(!s->caches[i].alive || s->caches[i].due == 0);
    }
    voxel_close(&v);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(flight_finds_what_it_comes_to),
        cmocka_unit_test(camera_that_stands_or_jumps_asks_for_nothing_ahead),
    };
    return VOXEL_GROUP(tests);
}
