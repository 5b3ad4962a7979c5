/* Voxels brought to a pose against voxelizing the posed mesh: at least 99 % of what the mesh touches is
 * there, and at least 97 % of what is there lies within one voxel of it. */

#include "tests/posed_fixture.h"

enum { POSES = 8 };

/* Is a cell of the direct voxelization among the 27 round a cell? The box is wider than the mesh by two. */
static bool near_direct(const posed *p, size_t cell)
{
    size_t row = p->size[0], slice = row * p->size[1];
    int64_t x = (int64_t)(cell % row), y = (int64_t)(cell / row % p->size[1]), z = (int64_t)(cell / slice);
    for (int n = 0; n < 27; n++) {
        int64_t i = x + n % 3 - 1, j = y + n / 3 % 3 - 1, k = z + n / 9 - 1;
        bool in = i >= 0 && j >= 0 && k >= 0 && i < p->size[0] && j < p->size[1] && k < p->size[2];
        if (in && p->direct[(size_t)k * slice + (size_t)j * row + (size_t)i])
            return true;
    }
    return false;
}

static void compare(voxel_world *v, const char *name, int pose)
{
    posed p = posed_read(v);
    uint32_t layers = voxel_svo(v)->layer_words, *mask = voxel_read_union(v);
    size_t direct = 0, present = 0, ours = 0, close = 0;
    for (size_t i = 0; i < p.cells; i++) {
        direct += p.direct[i];
        present += p.direct[i] && p.ours[i];
        ours += p.ours[i];
        close += p.ours[i] && near_direct(&p, i);
    }
    assert_int_equal(ours, voxel_count_bits(mask, layers)); /* and none elsewhere */
    double there = (double)present / (double)direct, near_by = (double)close / (double)ours;
    if (getenv("KD_KEEP_PICTURES") || there < 0.99 || near_by < 0.97)
        print_message(
            "%s, pose %d: %zu cells touched, %.2f %% of them there; %zu leaves, %.2f %% of them within "
            "one voxel\n",
            name, pose, direct, 100 * there, ours, 100 * near_by);
    assert_true(direct > 1000);
    assert_true(there >= 0.99);
    assert_true(near_by >= 0.97);
    free(mask);
    posed_free(&p);
}

static void pose_character(const char *path, const char *name)
{
    kd_model *model;
    uint64_t random = 3;
    assert_int_equal(kd_model_load(path, &model), KD_OK);
    voxel_world v = voxel_open((voxel_options){.span = (model->bounds_max.y - model->bounds_min.y) / 60});
    kd_entity root = voxel_spawn(&v, model, voxel_at(0, 0, 0));
    const kd_scene_store *store = kd_singleton(v.world, kd_scene_store);
    for (int pose = 0; pose < POSES; pose++) {
        kd_animation *a = kd_find_mut(v.world, root, kd_animation);
        uint32_t clip = (uint32_t)pose % store->clip_count;
        a->clip = clip + 1;
        a->time_s = store->clips[clip].desc->duration * fixture_float(&random, 0, 1);
        kd_find_mut(v.world, root, kd_transform)->rotation = fixture_quat(&random);
        voxel_frame(&v);
        compare(&v, name, pose);
    }
    voxel_close(&v);
}

static void posed_walker_is_as_if_voxelized_there(void **state)
{
    (void)state;
    pose_character(KD_SOURCE_DIR "/samples/assets/walker.gltf", "walker");
}

static void posed_robot_is_as_if_voxelized_there(void **state)
{
    const char *path = KD_SOURCE_DIR "/../shared/assets/robot/robot.glb";
    (void)state;
    if (!kd_file_exists(path))
        skip();
    pose_character(path, "robot");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(posed_walker_is_as_if_voxelized_there),
        cmocka_unit_test(posed_robot_is_as_if_voxelized_there),
    };
    return VOXEL_GROUP(tests);
}
