/* The change mask against a naive one: occupancy of two frames, cell by cell. */

#include "tests/voxel_fixture.h"

/* What the shaders' question says of each cell of cascade 0. */
static uint32_t *ask(voxel_world *v)
{
    uint32_t edge = voxel_scene(v)->resolution, cells = edge * edge * edge;
    kd_gpu_program program =
        kd_gpu_make_program(voxel_gpu, &(kd_gpu_program_desc){.compute = "tests/gpu/cell_changed.comp"});
    kd_gpu_buffer out =
        kd_gpu_make_buffer(voxel_gpu, &(kd_gpu_buffer_desc){.size = cells * 4ul, .name = "answers"});
    kd_gpu_bind_uniform_buffer(voxel_gpu, KD_BIND_TREE, voxel_svo(v)->uniform, 0,
                               sizeof(struct kd_tree_params));
    kd_gpu_bind_storage(voxel_gpu, 0, out);
    kd_gpu_bind_storage(voxel_gpu, 1, voxel_svo(v)->changes);
    kd_gpu_dispatch_linear(voxel_gpu, program, (cells + 63) / 64);
    kd_gpu_barrier(voxel_gpu, 1023);
    uint32_t *answers = voxel_read(out, 0, cells * 4ul);
    kd_gpu_destroy_buffer(voxel_gpu, out);
    kd_gpu_destroy_program(voxel_gpu, program);
    return answers;
}

/* Returns how many cells changed. */
static uint32_t assert_changes(voxel_world *v, const uint32_t *before, const uint32_t *now)
{
    uint32_t edge = voxel_scene(v)->resolution, *answers = ask(v), changed = 0, wrong = 0;
    const int32_t *origin = voxel_scene(v)->origin_cells[0];
    for (uint32_t n = 0; n < edge * edge * edge; n++) {
        int32_t cell[3] = {(int32_t)(n % edge), (int32_t)(n / edge % edge), (int32_t)(n / edge / edge)};
        uint32_t bit = svo_wrapped_code(voxel_scene(v)->resolution_log2, origin, cell);
        uint32_t differs = (before[bit >> 5] ^ now[bit >> 5]) >> (bit & 31) & 1u;
        wrong += answers[n] != differs;
        changed += differs;
    }
    free(answers);
    assert_int_equal(wrong, 0);
    return changed;
}

static void box_that_moves_is_all_that_changes(bool one_layer)
{
    voxel_world v = voxel_open((voxel_options){.span = 0.02f, .one_layer = one_layer});
    voxel_shape(&v, KD_SHAPE_BOX, (kd_vec3){1.5f, 0.1f, 1.5f}, NULL, voxel_at(0, -0.5f, 0));
    kd_entity box = voxel_shape(&v, KD_SHAPE_BOX, (kd_vec3){0.3f, 0.3f, 0.3f}, NULL, voxel_at(0.1f, 0.1f, 0));
    kd_singleton(v.world, kd_svo)->wants_changes = true;
    uint32_t words, *before = NULL;
    for (int i = 0; i < 5; i++) { /* at rest twice, moving twice, at rest */
        voxel_frame(&v);
        words = voxel_svo(&v)->layer_words;
        uint32_t *now = voxel_read_union(&v);
        if (!before)
            before = calloc(words, 4);
        uint32_t changed = assert_changes(&v, before, now);
        assert_true(i == 1 || i == 4 ? changed == 0 : changed > 100);
        free(before);
        before = now;
        if (i == 1 || i == 2)
            kd_find_mut(v.world, box, kd_transform)->position.x += 0.0317f;
    }
    free(before);
    voxel_close(&v);
}

static void changes_of_two_layers_are_told(void **state)
{
    (void)state, box_that_moves_is_all_that_changes(false);
}
static void changes_of_one_layer_are_told(void **state)
{
    (void)state, box_that_moves_is_all_that_changes(true);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(changes_of_two_layers_are_told),
        cmocka_unit_test(changes_of_one_layer_are_told),
    };
    return VOXEL_GROUP(tests);
}
