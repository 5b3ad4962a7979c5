/* The order-free build against its C reference: from the same voxels the same bytes. Numbers of nodes are
 * those of the reference when a tree is made at once. */

#include "tests/tree_fixture.h"

/* Dynamic cells lie eight a leaf parent, at the rank of its bit. */
static void assert_dynamic_cells(const kd_svo *svo, const svo_reference *r)
{
    uint32_t words = kd_svo_parent_words(svo), rank = 0, at = 0;
    const uint32_t *mask = r->masks[KD_LAYER_DYNAMIC];
    uint32_t *parents = voxel_read(svo->moving, 0, (size_t)words * 8);
    uint32_t(*cells)[8][4] = voxel_read(svo->dynamic_cells, 0, svo->dynamic_room * sizeof *cells);
    for (uint32_t parent = 0; parent < words * 32; parent++) {
        uint32_t bits = mask[parent >> 2] >> (8 * (parent & 3)) & 255u;
        if ((parent & 31) == 0)
            assert_int_equal(parents[words + (parent >> 5)], rank);
        assert_int_equal(parents[parent >> 5] >> (parent & 31) & 1u, bits != 0);
        for (uint32_t k = 0; k < 8; k++)
            if (bits >> k & 1u)
                assert_memory_equal(cells[rank][k], r->cells[KD_LAYER_DYNAMIC][at++], 16);
        rank += bits != 0;
    }
    assert_int_equal(at, r->cell_count[KD_LAYER_DYNAMIC]);
    free(parents);
    free(cells);
}

static void assert_layers(voxel_world *v, const svo_reference *r)
{
    const kd_svo *svo = voxel_svo(v);
    const uint32_t dynamic = KD_LAYER_DYNAMIC;
    uint32_t counts[KD_COUNT_WORDS];
    kd_gpu_read_buffer(voxel_gpu, svo->counters, 0, counts, sizeof counts);
    assert_int_equal(svo->layer_words, r->layer_words);
    for (uint32_t l = 0; l < KD_LAYER_COUNT; l++) {
        assert_int_equal(counts[l == KD_LAYER_STATIC ? KD_COUNT_STATIC : KD_COUNT_DYNAMIC], r->cell_count[l]);
        uint32_t *mask = voxel_read_mask(v, (int)l);
        assert_memory_equal(mask, r->masks[l], (size_t)r->layer_words * 4);
        free(mask);
    }
    if (!r->cell_count[dynamic])
        return;
    assert_dynamic_cells(svo, r);
}

/* Static cells lie beside their leaves. */
static void assert_static_cells(const tree_copy *t, const svo_reference *r)
{
    uint32_t top = r->levels - 1, at = 0;
    for (uint32_t i = 0; i < t->count[top]; i++)
        for (uint32_t k = 0; k < 8; k++) {
            uint32_t code = t->codes[top][i] * 8 + k, cell[4];
            if (!(r->masks[KD_LAYER_STATIC][code >> 5] >> (code & 31) & 1u))
                continue;
            tree_static_cell(t, i, k, cell);
            assert_memory_equal(cell, r->cells[KD_LAYER_STATIC][at++], sizeof cell);
        }
    assert_int_equal(at, r->cell_count[KD_LAYER_STATIC]);
}

/* `fresh`: the tree was made at once. */
static void assert_levels(const tree_copy *t, const svo_reference *r, bool fresh)
{
    assert_int_equal(t->levels, r->levels);
    for (uint32_t l = 0; l < r->levels; l++) {
        assert_int_equal(t->words[l], r->level_words[l]);
        assert_memory_equal(t->masks[l], r->level_masks[l], (size_t)r->level_words[l] * 4);
        assert_int_equal(t->count[l], r->node_count[l]);
        assert_memory_equal(t->codes[l], r->lists[l], (size_t)r->node_count[l] * 4);
        for (uint32_t i = 0; fresh && i < t->count[l]; i++)
            assert_int_equal(t->numbers[l][i], i);
        if (fresh && l + 1 < r->levels)
            assert_memory_equal(t->nodes + t->child_first[l], r->nodes[l], (size_t)r->node_count[l] * 32);
    }
    if (fresh)
        assert_memory_equal(t->index, r->index, (size_t)r->cascades * KD_DENSE * KD_DENSE * KD_DENSE * 4);
}

/* Compare this frame; returns how many cells there are. */
static uint32_t assert_same(voxel_world *v, bool fresh)
{
    voxel_capture capture = voxel_read_source(v);
    tree_copy copy = tree_read(v);
    svo_reference tree;
    assert_int_equal(svo_reference_build(&capture.source, &tree), KD_OK);
    assert_layers(v, &tree);
    assert_static_cells(&copy, &tree);
    assert_levels(&copy, &tree, fresh);
    tree_free(&copy);
    uint32_t cells = tree.cell_count[0] + tree.cell_count[1];
    svo_reference_free(&tree);
    voxel_capture_free(&capture);
    return cells;
}

static void room_is_the_same(uint32_t resolution, uint32_t cascades, float span)
{
    voxel_world v = voxel_open((voxel_options){.resolution = resolution, .cascades = cascades, .span = span});
    voxel_load(&v, "samples/assets/cornell.gltf", voxel_at(0, 0, 0));
    kd_find_mut(v.world, v.camera, kd_transform)->position = (kd_vec3){0, 1, 1};
    voxel_frame(&v);
    assert_true(assert_same(&v, true) > 10000);
    voxel_close(&v);
}

static void room_of_one_cascade_is_the_same(void **state)
{
    (void)state, room_is_the_same(128, 1, 0.02f);
}
static void room_of_two_fine_cascades_is_the_same(void **state)
{
    (void)state, room_is_the_same(256, 2, 0.0078f);
}
/* 1 MiB holds 65536 entries of chains: more are done in rounds, and nothing is lost. */
static void chains_in_rounds_are_the_same(void **state)
{
    (void)state;
    voxel_world v = voxel_open((voxel_options){.span = 0.026f});
    v.frame->settings.svo_memory = 1;
    for (int copy = 0; copy < 4; copy++) /* more voxels, no more cells */
        voxel_load(&v, "samples/assets/cornell.gltf", voxel_at(0, 0, 0));
    kd_find_mut(v.world, v.camera, kd_transform)->position = (kd_vec3){0, 1, 0};
    voxel_frame(&v);
    assert_in_range(voxel_svo(&v)->entry_room, 1, (1 << 20) / 16);
    assert_true(voxel_scene(&v)->pages[KD_LAYER_STATIC].voxel_count > 2 * voxel_svo(&v)->entry_room);
    assert_true(assert_same(&v, true) > 10000);
    voxel_close(&v);
}

static void room_of_three_cascades_is_the_same(void **state)
{
    (void)state, room_is_the_same(128, 3, 0.0071f);
}
static void room_of_four_cascades_is_the_same(void **state)
{
    (void)state, room_is_the_same(128, 4, 0.005f);
}

static void walker_is_the_same_at_any_time(void **state)
{
    (void)state;
    voxel_world v = voxel_open((voxel_options){.cascades = 2, .span = 0.014f});
    voxel_load(&v, "samples/assets/walker.gltf", voxel_at(0.1f, 0, 0));
    for (int i = 0; i < 4; i++) {
        v.frame->dt_s = 0.21f;
        voxel_frame(&v);
        assert_true(assert_same(&v, i == 0) > 1000);
    }
    voxel_close(&v);
}

/* Lamps of unlike strength and hue, one of them moving through a standing one. */
static void still_and_moving_mix_is_the_same(void **state)
{
    (void)state;
    voxel_world v = voxel_open((voxel_options){.cascades = 2, .span = 0.01f});
    kd_material_desc lamp = voxel_matte(0.7f, 0.2f, 0.1f), dim = voxel_matte(0.1f, 0.9f, 0.4f);
    lamp.emissive = (kd_vec3){8, 5, 1.5f};
    dim.emissive = (kd_vec3){0.02f, 0.3f, 0.011f};
    dim.double_sided = true;
    voxel_shape(&v, KD_SHAPE_TORUS, (kd_vec3){0.8f, 0.3f, 0}, &lamp, voxel_at(0.003f, 0.1f, 0));
    kd_entity ball =
        voxel_shape(&v, KD_SHAPE_SPHERE, (kd_vec3){0.5f, 0.5f, 0.5f}, &dim, voxel_at(0.1f, 0.1f, 0.2f));
    voxel_load(&v, "samples/assets/walker.gltf", voxel_at(0.2f, -0.5f, 0));
    for (int i = 0; i < 3; i++) {
        voxel_frame(&v);
        assert_true(assert_same(&v, i == 0) > 1000);
        assert_int_equal(voxel_scene(&v)->pages[KD_LAYER_STATIC].segment_count > 0, 1);
        kd_find_mut(v.world, ball, kd_transform)->position.x += 0.0137f;
    }
    voxel_close(&v);
}

static void empty_scene_is_the_same(void **state)
{
    (void)state;
    voxel_world v = voxel_open((voxel_options){.cascades = 2});
    voxel_frame(&v);
    const kd_svo *svo = voxel_svo(&v);
    uint32_t *mask = voxel_read_union(&v);
    assert_int_equal(voxel_count_bits(mask, svo->layer_words), 0);
    uint32_t *index = voxel_read(svo->index, 0, (size_t)svo->cascades * KD_DENSE * KD_DENSE * KD_DENSE * 4);
    for (size_t i = 0; i < (size_t)svo->cascades * KD_DENSE * KD_DENSE * KD_DENSE; i++)
        assert_int_equal(index[i], KD_EMPTY);
    free(mask);
    free(index);
    voxel_close(&v);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(room_of_one_cascade_is_the_same),
        cmocka_unit_test(room_of_two_fine_cascades_is_the_same),
        cmocka_unit_test(chains_in_rounds_are_the_same),
        cmocka_unit_test(room_of_three_cascades_is_the_same),
        cmocka_unit_test(room_of_four_cascades_is_the_same),
        cmocka_unit_test(walker_is_the_same_at_any_time),
        cmocka_unit_test(still_and_moving_mix_is_the_same),
        cmocka_unit_test(empty_scene_is_the_same),
    };
    return VOXEL_GROUP(tests);
}
