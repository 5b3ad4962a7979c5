/* The voxelizer marks the cells that triangles touch, and no others. */

#include "tests/voxel_cells_fixture.h"

#include "systems/svo/reference.h"
#include "systems/voxel_cache/reference.h"

#define SPAN 0.02f

/* Corners in cells from the lattice's phase, moved as the voxelizer does. */
static void triangle_cells(const cells *c, uint32_t triangle, double out[3][3])
{
    const kd_primitive_desc *p = c->cache->desc;
    for (int v = 0; v < 3; v++) {
        const float *at = &p->positions[p->indices[3 * triangle + (uint32_t)v]].x,
                    *phase = &c->cache->phase.x;
        for (int k = 0; k < 3; k++)
            out[v][k] = ((double)at[k] - (double)phase[k]) / (double)c->cache->span + KD_VOXELIZE_NUDGE;
    }
}

/* Mark every cell that a triangle touches when cells are larger by `margin` on each side. What has no area
 * touches none. */
static void mark_exactly(const cells *c, double margin, uint8_t *out)
{
    for (uint32_t t = 0; t < c->cache->desc->index_count / 3; t++) {
        double p[3][3];
        int64_t from[3], to[3], cell[3];
        const uint32_t *corner = c->cache->desc->indices + 3 * t;
        if (corner[0] == corner[1] || corner[1] == corner[2] || corner[2] == corner[0])
            continue;
        triangle_cells(c, t, p);
        for (int k = 0; k < 3; k++) {
            from[k] = (int64_t)floor(fmin(p[0][k], fmin(p[1][k], p[2][k])) - 0.01);
            to[k] = (int64_t)floor(fmax(p[0][k], fmax(p[1][k], p[2][k])) + 0.01);
        }
        for (cell[2] = from[2]; cell[2] <= to[2]; cell[2]++)
            for (cell[1] = from[1]; cell[1] <= to[1]; cell[1]++)
                for (cell[0] = from[0]; cell[0] <= to[0]; cell[0]++) {
                    double low[3], high[3];
                    for (int k = 0; k < 3; k++) {
                        low[k] = (double)cell[k] - margin;
                        high[k] = (double)cell[k] + 1 + margin;
                    }
                    if (voxel_reference_touches((const double(*)[3])p, low, high))
                        out[cell_at(c, cell)] = 1;
                }
    }
}

/* Rounding in cells, for coordinates up to some thousands: a thousandth is well above it. Less than the
 * nudge, which is a 1024th, so that a plane on a border is still told apart from its other side. */
#define MARGIN 8e-4

static void assert_exact(const cells *c)
{
    size_t count = (size_t)c->size[0] * c->size[1] * c->size[2];
    uint8_t *must = calloc(count, 1), *may = calloc(count, 1);
    assert_true(must && may);
    mark_exactly(c, -MARGIN, must);
    mark_exactly(c, MARGIN, may);
    for (size_t i = 0; i < count; i++) {
        if (must[i] && !c->wall[i])
            fail_msg("cell %zu is touched and has no voxel", i);
        if (c->wall[i] && !may[i])
            fail_msg("cell %zu has a voxel and is not touched", i);
    }
    free(must);
    free(may);
}

/* Does the flood from outside stay out of the cell at a model-space point? */
static void assert_closed(const cells *c, kd_vec3 inside)
{
    uint8_t *outside = calloc((size_t)c->size[0] * c->size[1] * c->size[2], 1);
    int64_t cell[3];
    assert_non_null(outside);
    voxel_flood(c->wall, c->size, outside);
    for (int k = 0; k < 3; k++)
        cell[k] = (int64_t)floorf(((&inside.x)[k] - (&c->cache->phase.x)[k]) / c->cache->span);
    assert_int_equal(c->wall[cell_at(c, cell)], 0);
    assert_int_equal(outside[cell_at(c, cell)], 0);
    assert_int_equal(outside[0], 1);
    free(outside);
}

static void shapes_become_closed_shells_of_the_cells_they_touch(void **state)
{
    (void)state;
    static const struct {
        kd_shape shape;
        kd_vec3 size, inside;
    } cases[] = {{KD_SHAPE_BOX, {0.51f, 0.32f, 0.4f}, {0, 0, 0}},
                 {KD_SHAPE_SPHERE, {0.7f, 0.5f, 0}, {0, 0, 0}},
                 {KD_SHAPE_CYLINDER, {0.3f, 0.6f, 0}, {0, 0, 0}},
                 {KD_SHAPE_TORUS, {0.8f, 0.3f, 0}, {0.25f, 0, 0}}};
    voxel_world v = voxel_open((voxel_options){.span = SPAN});
    v.frame->settings.voxels_separating = 26;
    for (int i = 0; i < 4; i++) /* off the lattice, each in its own way */
        voxel_shape(&v, cases[i].shape, cases[i].size, NULL,
                    voxel_at(0.0037f * (float)i, 0.011f, -0.006f * (float)i));
    voxel_frame(&v);
    assert_int_equal(voxel_scene(&v)->object_count, 4);
    for (uint32_t i = 0; i < 4; i++) {
        cells c = read_cells(&v, i);
        assert_exact(&c);
        for (int k = 0; k < 4;
             k++) /* objects come in the order of the draw list: know them by their extent */
            if (fabsf(c.cache->desc->bounds_max.x - cases[k].size.x / 2) < 1e-4f)
                assert_closed(&c, cases[k].inside);
        free_cells(&c);
    }
    voxel_close(&v);
}

/* Slivers, needles and large ones, through each other. */
static void any_triangle_marks_the_cells_it_touches(void **state)
{
    (void)state;
    uint64_t random = 11;
    kd_model *model = fixture_model();
    kd_primitive_desc *p = FIXTURE_NEW(model, kd_primitive_desc, 1);
    *p = fixture_primitive(model, 60, 0, 0, &random);
    kd_vec3 *positions = FIXTURE_NEW(model, kd_vec3, 60);
    for (uint32_t i = 0; i < 60; i++) { /* every third a hair's breadth from its neighbour */
        positions[i] = kd_vec3_scale(p->positions[i], 0.3f);
        if (i % 3 == 2)
            positions[i] = kd_vec3_add(positions[i - 1], kd_vec3_scale(fixture_unit(&random), 0.002f));
    }
    p->positions = positions;
    p->bounds_min = (kd_vec3){-0.7f, -0.7f, -0.7f};
    p->bounds_max = (kd_vec3){0.7f, 0.7f, 0.7f};
    kd_mesh_desc *mesh = FIXTURE_NEW(model, kd_mesh_desc, 1);
    *mesh = (kd_mesh_desc){.name = "mesh", .primitive_count = 1, .primitives = p};
    fixture_nodes(model, 1)->mesh = 0;
    model->meshes = mesh;
    model->mesh_count = 1;
    voxel_world v = voxel_open((voxel_options){.span = SPAN});
    v.frame->settings.voxels_separating = 26;
    voxel_spawn(&v, model, voxel_at(0, 0, 0));
    voxel_frame(&v);
    cells c = read_cells(&v, 0);
    assert_true(c.total > 5000);
    assert_exact(&c);
    free_cells(&c);
    voxel_close(&v);
}

static void plane_on_a_border_is_one_layer(void **state)
{
    (void)state;
    for (int k = -3; k <= 3;
         k++) { /* 24 cells wide, on whole cells; the nudge puts the far edge into one more */
        voxel_world v = voxel_open((voxel_options){.span = SPAN});
        voxel_shape(&v, KD_SHAPE_PLANE, (kd_vec3){24 * SPAN, 0, 24 * SPAN}, NULL,
                    voxel_at(0, (float)k * SPAN, 5 * SPAN));
        voxel_frame(&v);
        cells c = read_cells(&v, 0);
        assert_int_equal(c.total, 25 * 25);
        assert_exact(&c);
        free_cells(&c);
        uint32_t words = voxel_svo(&v)->layer_words, *mask = voxel_read_mask(&v, KD_LAYER_STATIC);
        assert_int_equal(voxel_count_bits(mask, words), 25 * 25); /* and none is shared out over two */
        free(mask);
        voxel_close(&v);
    }
}

/* A bar far longer than the grid is cut into tiles: inside the grid it is as whole as anywhere, every slice
 * of cells across it like the one in the middle, and what lies outside is not voxelized. */
static void long_primitive_is_cut_into_tiles(void **state)
{
    (void)state;
    voxel_world v = voxel_open((voxel_options){.span = SPAN});
    voxel_shape(&v, KD_SHAPE_BOX, (kd_vec3){50, 0.09f, 0.13f}, NULL,
                (kd_transform){{0.3f, 0, 0}, {0, 0, 0, 1}, {1, 1, 1}});
    voxel_frame(&v);
    const kd_voxel_scene *scene = voxel_scene(&v);
    uint32_t edge = scene->resolution, *slices = calloc(edge, sizeof *slices);
    uint32_t *mask = voxel_read_mask(&v, KD_LAYER_STATIC);
    for (uint32_t code = 0; code < edge * edge * edge; code++) {
        uint32_t cell[3];
        svo_morton_cell(code, cell);
        for (int k = 0; k < 3; k++) /* back from their wrapped places */
            cell[k] = (cell[k] - (uint32_t)scene->origin_cells[0][k]) & (edge - 1);
        if (mask[code >> 5] >> (code & 31) & 1)
            slices[cell[0]] += 1 + cell[1] * 131 + cell[2] * 17389; /* which cells, not only how many */
    }
    assert_true(slices[edge / 2] > 0);
    for (uint32_t x = 0; x < edge; x++)
        assert_int_equal(slices[x], slices[edge / 2]);
    assert_true(scene->cached_voxels < 1000 * edge);
    free(slices);
    free(mask);
    voxel_close(&v);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(shapes_become_closed_shells_of_the_cells_they_touch),
        cmocka_unit_test(any_triangle_marks_the_cells_it_touches),
        cmocka_unit_test(plane_on_a_border_is_one_layer),
        cmocka_unit_test(long_primitive_is_cut_into_tiles),
    };
    return VOXEL_GROUP(tests);
}
