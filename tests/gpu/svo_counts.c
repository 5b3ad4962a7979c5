/* What the statistics say of each cascade, against the masks and segments themselves. */

#include "tests/voxel_fixture.h"

enum { CASCADES = 3 };

static void load_scene(voxel_world *v)
{
    *v = voxel_open((voxel_options){.cascades = CASCADES, .span = 0.008f});
    voxel_load(v, "samples/assets/cornell.gltf", voxel_at(0, 0, 0));
    voxel_shape(v, KD_SHAPE_SPHERE, (kd_vec3){0.3f, 0.3f, 0.3f}, NULL, voxel_at(0.05f, 1, 0.1f));
    kd_find_mut(v->world, v->camera, kd_transform)->position = (kd_vec3){0, 1, 0.2f};
}

/* Counts come back some frames late: four frames of a still scene bring them all. */
static const kd_tree *settle(voxel_world *v)
{
    for (int i = 0; i < 4; i++) {
        voxel_frame(v);
        kd_gpu_finish(voxel_gpu);
    }
    return kd_singleton(v->world, kd_tree);
}

static void nodes_of_a_cascade_are_the_bits_of_its_masks(void **state)
{
    voxel_world v;
    (void)state;
    load_scene(&v);
    const kd_tree *tree = settle(&v);
    const kd_svo *svo = voxel_svo(&v);
    uint64_t sum = 0;
    for (uint32_t c = 0; c < CASCADES; c++) {
        uint64_t nodes = 0;
        for (uint32_t l = 0; l < svo->leaf_level - KD_DENSE_LOG2; l++) {
            uint32_t words = svo->mask_words[l] / CASCADES;
            uint32_t *mask =
                voxel_read(svo->level_masks, ((size_t)svo->mask_first[l] + c * words) * 4, (size_t)words * 4);
            nodes += voxel_count_bits(mask, words);
            free(mask);
        }
        assert_true(nodes > 100);
        assert_int_equal(tree->cascade_nodes[c], nodes);
        sum += nodes;
    }
    assert_int_equal(sum, tree->node_count);
    voxel_close(&v);
}

/* 128^3: all nodes are dense cells with eight leaves each: code, place in the stack of numbers, word of the
 * block; 12 bytes a leaf with its static cell; nothing glows. */
static void bytes_of_a_cascade_grow_with_its_nodes(void **state)
{
    voxel_world v;
    (void)state;
    load_scene(&v);
    const kd_tree *tree = settle(&v);
    /* atlas, index and words that lead to leaves of 64^3 cells; twice 64^3 bits (nothing moves): nodes and
     * static parents; four more of dense cells, a list of those that finer cascades fill, lists of free
     * blocks */
    uint64_t empty = 262144 * 40 + 2 * 32768 + 4 * 32768 + 32768 * 4 + 8 * KD_FREE_BLOCKS * 4;
    for (uint32_t c = 0; c < CASCADES; c++)
        assert_int_equal(tree->cascade_bytes[c], empty + tree->cascade_nodes[c] * (12 + 8 * 12));
    voxel_close(&v);
}

static void voxels_of_the_cascades_are_the_resident_ones(void **state)
{
    voxel_world v;
    (void)state;
    load_scene(&v);
    const kd_tree *tree = settle(&v);
    uint64_t sum = 0;
    for (uint32_t c = 0; c < CASCADES; c++) {
        assert_true(tree->cascade_voxels[c] > 0);
        sum += tree->cascade_voxels[c];
    }
    assert_int_equal(sum, tree->resident_voxels);
    voxel_close(&v);
}

/* What moves may take another pose, but no level has as many nodes as the one below: with room for a node a
 * voxel on each the table of three levels is larger than what drivers bind. */
static void room_for_what_moves_is_less_above(void **state)
{
    (void)state;
    voxel_world v =
        voxel_open((voxel_options){.resolution = 256, .cascades = 2, .span = 0.01f, .one_layer = true});
    voxel_load(&v, "samples/assets/cornell.gltf", voxel_at(0, 0, 0));
    voxel_frame(&v);
    const kd_svo *svo = voxel_svo(&v);
    assert_true(voxel_scene(&v)->pages[KD_LAYER_DYNAMIC].voxel_count > 100000);
    assert_in_range(svo->node_room[0], 1000, svo->node_room[1] * 6 / 10);
    voxel_close(&v);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(nodes_of_a_cascade_are_the_bits_of_its_masks),
        cmocka_unit_test(bytes_of_a_cascade_grow_with_its_nodes),
        cmocka_unit_test(voxels_of_the_cascades_are_the_resident_ones),
        cmocka_unit_test(room_for_what_moves_is_less_above),
    };
    return cmocka_run_group_tests(tests, voxel_group_setup, voxel_group_teardown);
}
