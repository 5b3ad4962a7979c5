/* Dense cells in which leaves came or went, against a naive comparison of two frames' occupancy, cell by
 * cell. */

#include "tests/voxel_fixture.h"

/* Occupancy of a frame. */
typedef struct cells {
    uint32_t *layer[KD_LAYER_COUNT];
} cells;

static cells read_cells(voxel_world *v)
{
    return (cells){{voxel_read_mask(v, KD_LAYER_STATIC), voxel_read_mask(v, KD_LAYER_DYNAMIC)}};
}

static void free_cells(cells *c)
{
    for (int l = 0; l < KD_LAYER_COUNT; l++)
        free(c->layer[l]);
}

/* What the shaders' question says of each cell of cascade 0. */
static uint32_t *ask(voxel_world *v)
{
    uint32_t edge = voxel_scene(v)->resolution, count = edge * edge * edge;
    kd_gpu_program program =
        kd_gpu_make_program(voxel_gpu, &(kd_gpu_program_desc){.compute = "tests/gpu/cells_changed.comp"});
    kd_gpu_buffer out =
        kd_gpu_make_buffer(voxel_gpu, &(kd_gpu_buffer_desc){.size = count * 4ul, .name = "answers"});
    kd_gpu_bind_uniform_buffer(voxel_gpu, KD_BIND_TREE, voxel_svo(v)->uniform, 0,
                               sizeof(struct kd_tree_params));
    kd_gpu_bind_storage(voxel_gpu, 0, out);
    kd_svo_bind_changes(voxel_gpu, voxel_svo(v), 1);
    kd_gpu_dispatch_linear(voxel_gpu, program, (count + 63) / 64);
    kd_gpu_barrier(voxel_gpu, 1023);
    uint32_t *answers = voxel_read(out, 0, count * 4ul);
    kd_gpu_destroy_buffer(voxel_gpu, out);
    kd_gpu_destroy_program(voxel_gpu, program);
    return answers;
}

/* Each bit answers for cells that follow each other in Morton order: those of a block four cells wide, or of
 * a dense cell that is wider. */
static uint32_t block_bits(voxel_world *v)
{
    uint32_t levels = voxel_svo(v)->leaf_level - KD_DENSE_LOG2;
    return 1u << (3 * (levels > 2 ? levels : 2));
}

static bool bits_differ(const uint32_t *a, const uint32_t *b, uint32_t first, uint32_t count)
{
    for (uint32_t bit = first; bit < first + count; bit += 32)
        if (a[bit >> 5] != b[bit >> 5])
            return true;
    return false;
}

static bool unions_differ(const cells *a, const cells *b, uint32_t first, uint32_t count)
{
    for (uint32_t bit = first; bit < first + count; bit += 32)
        if ((a->layer[0][bit >> 5] | a->layer[1][bit >> 5]) !=
            (b->layer[0][bit >> 5] | b->layer[1][bit >> 5]))
            return true;
    return false;
}

/* Where occupancy differs it must be told; it may be where that of a layer does. Returns the blocks told. */
static uint32_t assert_changes(voxel_world *v, const cells *before, const cells *now, bool one_layer)
{
    uint32_t edge = voxel_scene(v)->resolution, *answers = ask(v), told = 0, missed = 0, astray = 0;
    uint32_t size = block_bits(v);
    const int32_t *origin = voxel_scene(v)->origin_cells[0];
    for (uint32_t n = 0; n < edge * edge * edge; n++) {
        int32_t cell[3] = {(int32_t)(n % edge), (int32_t)(n / edge % edge), (int32_t)(n / edge / edge)};
        uint32_t bit = svo_wrapped_code(voxel_scene(v)->resolution_log2, origin, cell);
        uint32_t first = bit / size * size;
        bool differ = unions_differ(before, now, first, size), may = differ;
        for (int l = 0; l < KD_LAYER_COUNT && !one_layer; l++)
            may = may || bits_differ(before->layer[l], now->layer[l], first, size);
        missed += differ && !answers[n];
        astray += answers[n] && !may;
        told += answers[n] && bit == first;
    }
    free(answers);
    assert_int_equal(missed, 0);
    assert_int_equal(astray, 0);
    return told;
}

static void box_that_moves_is_all_that_changes(uint32_t resolution, bool one_layer)
{
    voxel_world v = voxel_open(
        (voxel_options){.resolution = resolution, .span = 2.56f / (float)resolution, .one_layer = one_layer});
    voxel_shape(&v, KD_SHAPE_BOX, (kd_vec3){1.5f, 0.1f, 1.5f}, NULL, voxel_at(0, -0.5f, 0));
    kd_entity box = voxel_shape(&v, KD_SHAPE_BOX, (kd_vec3){0.3f, 0.3f, 0.3f}, NULL, voxel_at(0.1f, 0.1f, 0));
    kd_singleton(v.world, kd_svo)->wants_changes = true;
    cells before = {{NULL, NULL}};
    for (int i = 0; i < 6; i++) { /* at rest twice, moving twice, at rest, gone */
        if (i == 5)
            kd_destroy(v.world, box);
        voxel_frame(&v);
        cells now = read_cells(&v);
        for (int l = 0; l < KD_LAYER_COUNT && i == 0; l++)
            before.layer[l] = calloc(voxel_svo(&v)->layer_words, 4);
        uint32_t changed = assert_changes(&v, &before, &now, one_layer);
        assert_true(i == 1 || i == 4 ? changed == 0 : changed > 20);
        free_cells(&before);
        before = now;
        if (i == 1 || i == 2)
            kd_find_mut(v.world, box, kd_transform)->position.x += 0.0317f;
    }
    free_cells(&before);
    voxel_close(&v);
}

static void changes_of_two_layers_are_told(void **state)
{
    (void)state, box_that_moves_is_all_that_changes(128, false);
}
static void changes_in_finer_cascades_are_told(void **state)
{
    (void)state, box_that_moves_is_all_that_changes(256, false);
}
static void changes_of_one_layer_are_told(void **state)
{
    (void)state, box_that_moves_is_all_that_changes(128, true);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(changes_of_two_layers_are_told),
        cmocka_unit_test(changes_in_finer_cascades_are_told),
        cmocka_unit_test(changes_of_one_layer_are_told),
    };
    return VOXEL_GROUP(tests);
}
