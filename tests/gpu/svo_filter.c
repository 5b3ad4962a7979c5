/* The filter: radiance and optical depth keep their meaning from leaves to the coarsest level, and nothing
 * stays behind. */

#include "tests/voxel_fixture.h"

typedef struct atlas {
    uint32_t width, depth, cascades;
    uint32_t corner[KD_MAX_CASCADES][3]; /* dense cells from the world's origin */
    uint32_t *radiance, *depths;         /* rgb9e5: six parts, two parts */
} atlas;

enum { SLICE = KD_DENSE * KD_DENSE };

static atlas read_atlas(voxel_world *v)
{
    atlas a = {.width = KD_DENSE, .cascades = voxel_scene(v)->cascade_count};
    a.depth = KD_ATLAS_SLICES(a.cascades, 6);
    for (uint32_t c = 0; c < a.cascades; c++)
        for (int k = 0; k < 3; k++)
            a.corner[c][k] = (uint32_t)(voxel_scene(v)->origin_cells[c][k] >>
                                        (voxel_scene(v)->resolution_log2 - KD_DENSE_LOG2));
    size_t radiance = (size_t)SLICE * a.depth * 4,
           depths = (size_t)SLICE * KD_ATLAS_SLICES(a.cascades, 2) * 4;
    a.radiance = malloc(radiance);
    a.depths = malloc(depths);
    assert_true(a.radiance && a.depths);
    kd_gpu_read_texture(voxel_gpu, voxel_svo(v)->atlas, 0, a.radiance, radiance);
    kd_gpu_read_texture(voxel_gpu, voxel_svo(v)->depths, 0, a.depths, depths);
    return a;
}

static void free_atlas(atlas *a)
{
    free(a->radiance);
    free(a->depths);
}

static void unpack_rgb9e5(uint32_t word, float out[3])
{
    for (int k = 0; k < 3; k++)
        out[k] = ldexpf((float)(word >> (9 * k) & 511), (int)(word >> 27) - 24);
}

/* (tau S, tau) of a texel of the radiance, by its slice: its depth lies in the slice of the same cells. */
static void load_texel(const atlas *a, size_t slice, size_t in_slice, float out[4])
{
    size_t blocks = (size_t)a->cascades * 6 * KD_ATLAS_BLOCK, above = slice >= blocks;
    size_t apart = above ? KD_DENSE / 2 : KD_ATLAS_BLOCK, part = (slice - above * blocks) / apart;
    size_t cascade = part / 6, direction = part % 6, within = (slice - above * blocks) % apart;
    size_t of_depth = (above ? (size_t)a->cascades * 2 * KD_ATLAS_BLOCK : cascade * 2 * KD_ATLAS_BLOCK) +
                      (direction & 1) * apart + within;
    float depths[3];
    unpack_rgb9e5(a->radiance[slice * SLICE + in_slice], out);
    unpack_rgb9e5(a->depths[of_depth * SLICE + in_slice], depths);
    out[3] = depths[direction >> 1];
}

/* Cell of cascade c (mip 0), or of mip level `mip` above the outermost, as a ray towards `direction` sees it.
 */
static void load(const atlas *a, uint32_t c, uint32_t mip, const uint32_t cell[3], uint32_t direction,
                 float out[4])
{
    uint32_t x = cell[0], y = cell[1], z = cell[2];
    if (mip) {
        y += KD_DENSE - (2u * KD_DENSE >> mip);
        z += a->cascades * 6 * KD_ATLAS_BLOCK + direction * (KD_DENSE / 2);
    } else {
        const uint32_t *corner = a->corner[c];
        x = (x + corner[0]) % KD_DENSE, y = (y + corner[1]) % KD_DENSE, z = (z + corner[2]) % KD_DENSE;
        z += (c * 6 + direction) * KD_ATLAS_BLOCK + 1;
    }
    load_texel(a, z, (size_t)y * KD_DENSE + x, out);
}

/* ---- a room that shines everywhere ---- */

/* Every texel with matter in it sends out what the walls do. A hundredth for 12 bits of relative emission and
 * sums of depths, and twice half of a 256th of the brightest channel: leaves and dense cells share exponents.
 * Returns how many there are. */
static uint32_t assert_uniform(voxel_world *v, kd_vec3 emission)
{
    atlas a = read_atlas(v);
    uint32_t seen = 0;
    for (size_t i = 0; i < (size_t)a.width * KD_DENSE * a.depth; i++) {
        float texel[4];
        load_texel(&a, i / SLICE, i % SLICE, texel);
        float depth = texel[3];
        if (!(depth > 0))
            continue;
        for (int k = 0; k < 3; k++) {
            float radiance = texel[k] / depth, expected = (&emission.x)[k];
            if (!(fabsf(radiance - expected) <= 0.01f * expected + 0.004f * emission.x))
                fail_msg("texel %zu: channel %d sends %g, expected %g; depth %g", i, k, (double)radiance,
                         (double)expected, (double)depth);
        }
        seen++;
    }
    free_atlas(&a);
    return seen;
}

static void shining_room(uint32_t resolution, uint32_t cascades, bool moving)
{
    voxel_world v = voxel_open((voxel_options){
        .resolution = resolution, .cascades = cascades, .span = 2.56f / (float)resolution, .lit = true});
    kd_material_desc m = voxel_matte(0, 0, 0);
    m.emissive = (kd_vec3){2.5f, 1.7f, 0.4f};
    m.double_sided = true;
    kd_entity room = voxel_shape(&v, KD_SHAPE_BOX, (kd_vec3){2.1f, 1.7f, 1.9f}, &m, voxel_at(0, 0, 0));
    for (int i = 0; i < (moving ? 3 : 1); i++) {
        voxel_frame(&v);
        assert_true(assert_uniform(&v, m.emissive) > 10000);
        kd_find_mut(v.world, room, kd_transform)->position.y += 0.0063f;
        kd_find_mut(v.world, room, kd_transform)->position.x += 0.0021f;
    }
    voxel_close(&v);
}

static void shining_room_is_equally_bright_everywhere(void **state)
{
    (void)state, shining_room(128, 1, false);
}
static void shining_room_of_two_sparse_levels_is_too(void **state)
{
    (void)state, shining_room(256, 1, false);
}
static void shining_room_across_cascades_is_too(void **state)
{
    (void)state, shining_room(128, 2, false);
}
static void shining_room_that_moves_is_too(void **state)
{
    (void)state, shining_room(128, 1, true);
}

/* ---- a wall ---- */

/* A plane through all cascades, seen from its front, its back and along it. */
static void assert_wall(const atlas *a, uint32_t c, uint32_t mip, const voxel_world *v, float height)
{
    const kd_voxel_scene *scene = kd_singleton(v->world, kd_voxel_scene);
    uint32_t n = KD_DENSE >> mip, cell[3];
    float edge = scene->span[c] * (float)(scene->resolution / n);
    cell[1] = (uint32_t)floorf((height - scene->origin_ws[c].y) / edge);
    for (cell[2] = n / 8; cell[2] < n - n / 8; cell[2]++)
        for (cell[0] = n / 8; cell[0] < n - n / 8; cell[0]++)
            for (uint32_t direction = 0; direction < 6; direction++) {
                float texel[4];
                load(a, c, mip, cell, direction, texel);
                assert_float_equal(texel[3], direction == 3 ? KD_FULL_DEPTH : 0, 0.05f);
            }
}

static void wall_keeps_its_depth(uint32_t resolution, float height)
{
    voxel_world v = voxel_open((voxel_options){
        .resolution = resolution, .cascades = 2, .span = 2.56f / (float)resolution, .lit = true});
    voxel_shape(&v, KD_SHAPE_PLANE, (kd_vec3){9, 0, 9}, NULL, voxel_at(0, height, 0));
    voxel_frame(&v);
    atlas a = read_atlas(&v);
    assert_wall(&a, 0, 0, &v, height);
    assert_wall(&a, 1, 0, &v, height);
    for (uint32_t mip = 1; mip <= KD_DENSE_MIPS; mip++)
        assert_wall(&a, 1, mip, &v, height);
    free_atlas(&a);
    voxel_close(&v);
}

static void wall_stops_rays_at_every_level(void **state)
{
    (void)state;
    wall_keeps_its_depth(128, 0.003f);
    wall_keeps_its_depth(128, 0.031f);
}

static void wall_of_two_sparse_levels_does_too(void **state)
{
    (void)state;
    wall_keeps_its_depth(256, 0.003f);
    wall_keeps_its_depth(256, 0.017f);
}

/* ---- what is gone is gone ---- */

static voxel_world open_hall(kd_entity *lamp)
{
    voxel_world v = voxel_open((voxel_options){.cascades = 2, .span = 0.02f, .lit = true});
    kd_material_desc bright = voxel_matte(0.2f, 0.2f, 0.2f);
    bright.emissive = (kd_vec3){3, 2, 1};
    voxel_shape(&v, KD_SHAPE_BOX, (kd_vec3){0.1f, 0.1f, 0.1f}, &bright,
                voxel_at(-2, -1, -1)); /* they span the bounds */
    voxel_shape(&v, KD_SHAPE_BOX, (kd_vec3){0.1f, 0.1f, 0.1f}, &bright, voxel_at(2, 1, 1));
    voxel_shape(&v, KD_SHAPE_PLANE, (kd_vec3){2, 0, 2}, &bright, voxel_at(0.013f, -0.3f, 0.003f));
    if (lamp)
        *lamp = voxel_shape(&v, KD_SHAPE_SPHERE, (kd_vec3){0.7f, 0.7f, 0.7f}, &bright,
                            voxel_at(0.1f, 0.1f, 0.1f));
    return v;
}

static void what_leaves_is_emptied(void **state)
{
    (void)state;
    kd_entity lamp;
    voxel_world visited = open_hall(&lamp), fresh = open_hall(NULL);
    for (int i = 0; i < 3;
         i++) { /* the lamp rests, moves, and leaves; the camera moves the cascades and comes back */
        voxel_frame(&visited);
        kd_find_mut(visited.world, lamp, kd_transform)->position.x += 0.231f;
        kd_find_mut(visited.world, visited.camera, kd_transform)->position.x = i == 1 ? 1.5f : 0.0f;
    }
    kd_destroy(visited.world, lamp);
    voxel_frame(&visited);
    voxel_frame(&fresh);
    atlas a = read_atlas(&visited), b = read_atlas(&fresh);
    size_t texels = (size_t)SLICE * a.depth, lit = 0;
    for (size_t i = 0; i < texels; i++) {
        float x[4], y[4];
        load_texel(&a, i / SLICE, i % SLICE, x);
        load_texel(&b, i / SLICE, i % SLICE, y);
        lit += y[3] > 0;
        if (memcmp(x, y, sizeof x) != 0)
            fail_msg("texel %zu holds depth %g, a fresh run's %g", i, (double)x[3], (double)y[3]);
    }
    assert_true(lit > 1000);
    free_atlas(&a);
    free_atlas(&b);
    voxel_close(&visited);
    voxel_close(&fresh);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(shining_room_is_equally_bright_everywhere),
        cmocka_unit_test(shining_room_of_two_sparse_levels_is_too),
        cmocka_unit_test(shining_room_across_cascades_is_too),
        cmocka_unit_test(shining_room_that_moves_is_too),
        cmocka_unit_test(wall_stops_rays_at_every_level),
        cmocka_unit_test(wall_of_two_sparse_levels_does_too),
        cmocka_unit_test(what_leaves_is_emptied),
    };
    return VOXEL_GROUP(tests);
}
