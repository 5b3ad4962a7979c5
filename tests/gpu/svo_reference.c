/* The order-free build against its C reference: from the same page voxels the same bytes in every buffer. */

#include "tests/voxel_fixture.h"

static void assert_words(const char *what, kd_gpu_buffer buffer, size_t first, const void *expected,
                         size_t words) {
    uint32_t *got = voxel_read(buffer, first * 4, words * 4);
    const uint32_t *want = expected;
    for (size_t i = 0; i < words; i++)
        if (got[i] != want[i])
            fail_msg("%s: word %zu of %zu is %08x, the reference has %08x", what, i, words, got[i], want[i]);
    free(got);
}

static void assert_layers(voxel_world *v, const svo_reference *r) {
    const kd_svo *svo = voxel_svo(v);
    uint32_t counts[KD_COUNT_WORDS];
    kd_gpu_read_buffer(voxel_gpu, svo->counters, 0, counts, sizeof counts);
    assert_int_equal(svo->layer_words, r->layer_words);
    for (uint32_t l = 0; l < KD_LAYER_COUNT; l++) {
        assert_int_equal(counts[l == KD_LAYER_STATIC ? KD_COUNT_STATIC : KD_COUNT_DYNAMIC], r->cell_count[l]);
        assert_words("mask", svo->masks, l * r->layer_words, r->masks[l], r->layer_words);
        assert_words("ranks", svo->ranks, l * r->layer_words, r->ranks[l], r->layer_words);
        assert_words("cells", l == KD_LAYER_STATIC ? svo->static_cells : svo->dynamic_cells, 0, r->cells[l],
                     (size_t)r->cell_count[l] * 4);
    }
    for (uint32_t l = 0; l < r->levels; l++)
        assert_int_equal(counts[KD_COUNT_LEVEL + l], r->node_count[l]);
}

static void assert_levels(voxel_world *v, const svo_reference *r) {
    const kd_svo *svo = voxel_svo(v);
    size_t cap = svo->node_capacity;
    for (uint32_t l = 0; l < r->levels; l++) {
        assert_int_equal(svo->mask_words[l], r->level_words[l]);
        assert_words("level mask", svo->level_masks, svo->mask_first[l], r->level_masks[l],
                     r->level_words[l]);
        assert_words("level ranks", svo->level_ranks, svo->mask_first[l], r->level_ranks[l],
                     r->level_words[l]);
        assert_words("list", svo->lists[svo->current], l * cap, r->lists[l], r->node_count[l]);
        if (l + 1 < r->levels)
            assert_words("nodes", svo->nodes, l * 8 * cap, r->nodes[l], (size_t)r->node_count[l] * 8);
    }
    assert_words("index", svo->index, 0, r->index, (size_t)r->cascades * KD_DENSE * KD_DENSE * KD_DENSE);
}

/* Compare this frame; returns how many cells there are. */
static uint32_t assert_same(voxel_world *v) {
    voxel_capture capture = voxel_read_source(v);
    svo_reference tree;
    assert_int_equal(svo_reference_build(&capture.source, &tree), KD_OK);
    assert_layers(v, &tree);
    assert_levels(v, &tree);
    uint32_t cells = tree.cell_count[0] + tree.cell_count[1];
    svo_reference_free(&tree);
    voxel_capture_free(&capture);
    return cells;
}

static void room_is_the_same(uint32_t resolution, uint32_t cascades, float span) {
    voxel_world v = voxel_open((voxel_options){.resolution = resolution, .cascades = cascades, .span = span});
    voxel_load(&v, "samples/assets/cornell.gltf", voxel_at(0, 0, 0));
    kd_find_mut(v.world, v.camera, kd_transform)->position = (kd_vec3){0, 1, 1};
    voxel_frame(&v);
    assert_true(assert_same(&v) > 10000);
    voxel_close(&v);
}

static void room_of_one_cascade_is_the_same(void **state) {
    (void)state, room_is_the_same(128, 1, 0.02f);
}
static void room_of_two_fine_cascades_is_the_same(void **state) {
    (void)state, room_is_the_same(256, 2, 0.0078f);
}
static void room_of_three_cascades_is_the_same(void **state) {
    (void)state, room_is_the_same(128, 3, 0.0071f);
}
static void room_of_four_cascades_is_the_same(void **state) {
    (void)state, room_is_the_same(128, 4, 0.005f);
}

static void walker_is_the_same_at_any_time(void **state) {
    (void)state;
    voxel_world v = voxel_open((voxel_options){.cascades = 2, .span = 0.014f});
    voxel_load(&v, "samples/assets/walker.gltf", voxel_at(0.1f, 0, 0));
    for (int i = 0; i < 4; i++) {
        v.frame->dt_s = 0.21f;
        voxel_frame(&v);
        assert_true(assert_same(&v) > 1000);
    }
    voxel_close(&v);
}

/* Lamps of unlike strength and hue, one of them moving through a standing one. */
static void still_and_moving_mix_is_the_same(void **state) {
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
        assert_true(assert_same(&v) > 1000);
        assert_int_equal(voxel_scene(&v)->pages[KD_LAYER_STATIC].segment_count > 0, 1);
        kd_find_mut(v.world, ball, kd_transform)->position.x += 0.0137f;
    }
    voxel_close(&v);
}

static void empty_scene_is_the_same(void **state) {
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

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(room_of_one_cascade_is_the_same),
        cmocka_unit_test(room_of_two_fine_cascades_is_the_same),
        cmocka_unit_test(room_of_three_cascades_is_the_same),
        cmocka_unit_test(room_of_four_cascades_is_the_same),
        cmocka_unit_test(walker_is_the_same_at_any_time),
        cmocka_unit_test(still_and_moving_mix_is_the_same),
        cmocka_unit_test(empty_scene_is_the_same),
    };
    return VOXEL_GROUP(tests);
}
