/* Thin voxelization, filling, and chunks that are cut until they fit. */

#include "runtime/gpu/internal.h"
#include "tests/voxel_cells_fixture.h"

#include "systems/voxel_cache/fill.h"

#define SPAN 0.03f

static const struct {
    kd_shape shape;
    kd_vec3 size, inside, hole; /* hole: a point outside that is round about enclosed in no voxelization */
    float volume;               /* m^3 */
} shapes[] = {
    {KD_SHAPE_BOX, {0.91f, 0.52f, 0.7f}, {0, 0, 0}, {1, 1, 1}, 0.91f * 0.52f * 0.7f},
    {KD_SHAPE_SPHERE, {1, 1, 1}, {0, 0, 0}, {1, 1, 1}, 0.5236f},
    {KD_SHAPE_TORUS, {1.4f, 0.4f, 0}, {0.5f, 0, 0}, {0, 0, 0}, 0.3948f}, /* 2 pi^2 R r^2, R = 0.5, r = 0.2 */
};
enum { SHAPES = sizeof shapes / sizeof *shapes };

static cells cells_of(voxel_world *v, int shape, int32_t separating, bool fill)
{
    *v = voxel_open((voxel_options){.span = SPAN});
    v->frame->settings.voxels_separating = separating;
    v->frame->settings.voxels_fill = fill;
    voxel_shape(v, shapes[shape].shape, shapes[shape].size, NULL, voxel_at(0.0037f, 0.011f, -0.006f));
    voxel_frame(v);
    return read_cells(v, 0);
}

static size_t index_at(const cells *c, kd_vec3 p)
{
    int64_t cell[3];
    for (int k = 0; k < 3; k++) {
        cell[k] = (int64_t)floorf(((&p.x)[k] - (&c->cache->phase.x)[k]) / c->cache->span);
        int64_t high = c->low[k] + (int64_t)c->size[k] - 1;
        cell[k] = cell[k] < c->low[k] ? c->low[k] : cell[k] > high ? high : cell[k];
    }
    return cell_at(c, cell);
}

static void assert_closed(const cells *c, int shape)
{
    uint8_t *outside = calloc((size_t)c->size[0] * c->size[1] * c->size[2], 1);
    assert_non_null(outside);
    voxel_flood(c->wall, c->size, outside);
    assert_int_equal(outside[index_at(c, shapes[shape].inside)], 0);
    assert_int_equal(outside[index_at(c, shapes[shape].hole)], 1);
    free(outside);
}

/* Every thin voxel is one of those that the surface touches, there are fewer of them, and no flood by faces
 * gets in. */
static void thin_voxels_are_fewer_and_still_closed(void **state)
{
    (void)state;
    for (int i = 0; i < SHAPES; i++) {
        voxel_world a, b;
        cells all = cells_of(&a, i, 26, false), thin = cells_of(&b, i, 6, false);
        bool flat = shapes[i].shape == KD_SHAPE_BOX; /* sides along the lattice, and edges that are kept */
        assert_in_range(thin.total, all.total / 3, flat ? all.total : all.total - 1);
        assert_memory_equal(thin.low, all.low, sizeof all.low);
        for (size_t n = 0; n < (size_t)thin.size[0] * thin.size[1] * thin.size[2]; n++)
            assert_true(all.wall[n] >= thin.wall[n]);
        assert_closed(&all, i);
        assert_closed(&thin, i);
        free_cells(&all);
        free_cells(&thin);
        voxel_close(&a);
        voxel_close(&b);
    }
}

/* A filled shape has no free cell inside, as many voxels as its volume has between shell counted in and out,
 * and those inside have a colour and no side. */
static void filled_shapes_are_solid(void **state)
{
    (void)state;
    for (int i = 0; i < SHAPES; i++) {
        voxel_world a, b;
        cells shell = cells_of(&a, i, 26, false), solid = cells_of(&b, i, 26, true);
        size_t count = (size_t)solid.size[0] * solid.size[1] * solid.size[2];
        uint8_t *outside = calloc(count, 1);
        uint32_t inner = 0;
        float volume = shapes[i].volume / (SPAN * SPAN * SPAN);
        assert_non_null(outside);
        voxel_flood(solid.wall, solid.size, outside);
        for (size_t n = 0; n < count; n++) {
            assert_int_equal(solid.wall[n], !outside[n]);
            if (!solid.wall[n] || shell.wall[n])
                continue;
            const uint32_t *shape = solid.shape[solid.voxel[n]];
            assert_int_equal(shape[1], 0);
            assert_int_equal(solid.color[solid.voxel[n]] & 0xFFFFFF, shell.color[0] & 0xFFFFFF);
            inner++;
        }
        assert_true((float)inner < volume && (float)solid.total > volume);
        free(outside);
        free_cells(&shell);
        free_cells(&solid);
        voxel_close(&a);
        voxel_close(&b);
    }
}

/* How often a primitive's surface goes round a point: 1 inside of a closed one, 0 outside.
 * Source: van Oosterom, Strackee 1983, for the solid angle of a triangle */
static double winding(const kd_primitive_desc *p, kd_vec3 at)
{
    double sum = 0;
    for (uint32_t t = 0; t < p->index_count; t += 3) {
        kd_vec3 v[3];
        double l[3];
        for (uint32_t k = 0; k < 3; k++) {
            v[k] = kd_vec3_sub(p->positions[p->indices[t + k]], at);
            l[k] = (double)kd_vec3_length(v[k]);
        }
        double volume = (double)kd_vec3_dot(v[0], kd_vec3_cross(v[1], v[2]));
        double flat = l[0] * l[1] * l[2] + (double)kd_vec3_dot(v[0], v[1]) * l[2] +
                      (double)kd_vec3_dot(v[1], v[2]) * l[0] + (double)kd_vec3_dot(v[2], v[0]) * l[1];
        sum += 2 * atan2(volume, flat);
    }
    return sum / (4 * 3.14159265358979);
}

/* Wherever the mesh goes round the centre of a cell, no flood from outside comes. Returns centres looked at.
 */
static uint32_t assert_none_inside_is_reached(const cells *c)
{
    const kd_primitive_desc *p = c->cache->desc;
    uint8_t *outside = calloc((size_t)c->size[0] * c->size[1] * c->size[2], 1);
    uint64_t random = 17;
    uint32_t inside = 0;
    assert_non_null(outside);
    voxel_flood(c->wall, c->size, outside);
    for (int i = 0; i < 1500; i++) {
        kd_vec3 at = {fixture_float(&random, p->bounds_min.x, p->bounds_max.x),
                      fixture_float(&random, p->bounds_min.y, p->bounds_max.y),
                      fixture_float(&random, p->bounds_min.z, p->bounds_max.z)};
        size_t cell = index_at(c, at);
        for (int k = 0; k < 3; k++) { /* the cell's centre: thin voxels part those */
            float phase = (&c->cache->phase.x)[k], span = c->cache->span;
            (&at.x)[k] =
                (floorf(((&at.x)[k] - phase) / span) + 0.5f - (float)KD_VOXELIZE_NUDGE) * span + phase;
        }
        if (c->wall[cell] || winding(p, at) < 0.99)
            continue;
        inside++;
        assert_int_equal(outside[cell], 0);
    }
    free(outside);
    return inside;
}

static void character_is_closed(void **state)
{
    (void)state;
    for (int32_t separating = 6; separating <= 26; separating += 20) {
        voxel_world v = voxel_open((voxel_options){.span = 0.01f});
        uint32_t inside = 0;
        v.frame->settings.voxels_separating = separating;
        voxel_load(&v, "samples/assets/walker.gltf", voxel_at(0, 0, 0));
        voxel_frame(&v);
        for (uint32_t i = 0; i < voxel_scene(&v)->object_count; i++) {
            cells c = read_cells(&v, i);
            inside += assert_none_inside_is_reached(&c);
            free_cells(&c);
        }
        assert_true(inside > 50);
        voxel_close(&v);
    }
}

/* Against a flood cell by cell, in random grids of odd sizes. */
static void fill_agrees_with_a_flood(void **state)
{
    (void)state;
    uint64_t random = 9;
    for (int round = 0; round < 60; round++) {
        uint32_t size[3], density = fixture_random(&random) % 100;
        for (int k = 0; k < 3; k++)
            size[k] = 1 + fixture_random(&random) % 40;
        size_t count = (size_t)size[0] * size[1] * size[2];
        uint8_t *wall = calloc(count, 1), *outside = calloc(count, 1);
        uint32_t *mask = calloc(count / 32 + 1, 4);
        for (size_t i = 0; i < count; i++) {
            wall[i] = fixture_random(&random) % 100 < density;
            mask[i / 32] |= (uint32_t)wall[i] << (i % 32);
        }
        voxel_flood(wall, size, outside);
        assert_int_equal(fill_enclosed(mask, size), KD_OK);
        for (size_t i = 0; i < count; i++)
            assert_int_equal(mask[i / 32] >> (i % 32) & 1u, !outside[i]);
        free(wall);
        free(outside);
        free(mask);
    }
}

/* Bytes of two words; positions count from the chunk's corner, so their rounding may differ by the last bit.
 */
static void assert_near(uint32_t a, uint32_t b)
{
    for (int k = 0; k < 4; k++)
        assert_true(abs((int8_t)(a >> (8 * k)) - (int8_t)(b >> (8 * k))) <= 1);
}

/* A driver with small buffers makes several chunks of what others make one, and the voxels are the same. */
static void chunks_are_cut_until_they_fit(void **state)
{
    (void)state;
    voxel_world a, b;
    cells whole = cells_of(&a, 1, 26, false);
    int64_t driver = voxel_gpu->info.max_ssbo_bytes;
    b = voxel_open((voxel_options){.span = SPAN});
    b.frame->settings.voxels_separating = 26;
    voxel_shape(&b, shapes[1].shape, shapes[1].size, NULL, voxel_at(0.0037f, 0.011f, -0.006f));
    for (uint32_t i = 0; i < kd_schedule_count(b.schedule); i++) { /* what comes later would not fit either */
        const kd_system_desc *system = kd_schedule_system(b.schedule, i);
        if (system->phase > KD_PHASE_VOXEL_IO || strncmp(system->name, "svo", 3) == 0)
            kd_schedule_enable(b.schedule, system->name, false);
    }
    voxel_gpu->info.max_ssbo_bytes = (int64_t)whole.total * 64 / 3; /* sums of a third of them */
    assert_int_equal(kd_schedule_run(b.schedule), KD_OK);
    voxel_gpu->info.max_ssbo_bytes = driver;
    cells parts = read_cells(&b, 0);
    assert_int_equal(whole.cache->chunk_count, 1);
    assert_true(parts.cache->chunk_count >= 3);
    assert_int_equal(parts.total, whole.total);
    for (size_t n = 0; n < (size_t)whole.size[0] * whole.size[1] * whole.size[2]; n++)
        if (whole.wall[n]) {
            size_t x = n % whole.size[0], y = n / whole.size[0] % whole.size[1],
                   z = n / ((size_t)whole.size[0] * whole.size[1]);
            size_t m = cell_at(&parts, (int64_t[3]){whole.low[0] + (int64_t)x, whole.low[1] + (int64_t)y,
                                                    whole.low[2] + (int64_t)z});
            assert_int_equal(parts.wall[m], 1);
            assert_near(parts.color[parts.voxel[m]], whole.color[whole.voxel[n]]);
            assert_near(parts.shape[parts.voxel[m]][1], whole.shape[whole.voxel[n]][1]);
        }
    free_cells(&whole);
    free_cells(&parts);
    voxel_close(&a);
    voxel_warnings[0] = '\0';
    kd_schedule_destroy(b.schedule);
    kd_world_destroy(b.world);
}

static uint32_t times_told(const char *what)
{
    uint32_t n = 0;
    for (const char *at = voxel_warnings; (at = strstr(at, what)) != NULL; at++)
        n++;
    return n;
}

/* Buffers and caches follow from some settings for good: who changes them is told, once each. */
static void settings_that_come_late_are_told(void **state)
{
    (void)state;
    voxel_world v = voxel_open((voxel_options){.span = SPAN});
    voxel_shape(&v, shapes[0].shape, shapes[0].size, NULL, voxel_at(0, 0, 0));
    voxel_frame(&v);
    v.frame->settings.voxels_resolution = 256;
    v.frame->settings.svo_layers = KD_SVO_LAYERS_ONE;
    v.frame->settings.cones_step *= 0.5f; /* takes effect */
    for (int i = 0; i < 3; i++)
        voxel_frame(&v);
    assert_int_equal(times_told("voxels.resolution stays 128"), 1);
    assert_int_equal(times_told("svo.layers stays two"), 1);
    assert_int_equal(times_told("stays"), 2);
    assert_int_equal(voxel_scene(&v)->resolution, 128);
    voxel_warnings[0] = '\0';
    voxel_close(&v);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(thin_voxels_are_fewer_and_still_closed),
        cmocka_unit_test(filled_shapes_are_solid),
        cmocka_unit_test(character_is_closed),
        cmocka_unit_test(fill_agrees_with_a_flood),
        cmocka_unit_test(settings_that_come_late_are_told),
        cmocka_unit_test(chunks_are_cut_until_they_fit),
    };
    return VOXEL_GROUP(tests);
}
