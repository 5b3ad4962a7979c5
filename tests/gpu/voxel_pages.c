/* Segments come and go; no slot is lost, none is given twice. */

#include "runtime/gpu/internal.h"
#include "tests/voxel_fixture.h"

/* Slots of a page are each on its stack or in use, once; what is in use is what the objects have. */
static void assert_books_balance(voxel_world *v)
{
    const kd_voxel_scene *scene = voxel_scene(v);
    for (int l = 0; l < KD_LAYER_COUNT; l++) {
        const kd_voxel_pages *pages = &scene->pages[l];
        uint32_t used = 0, slots = pages->page_count * KD_PAGE_SEGMENTS;
        uint64_t voxels = 0;
        struct kd_voxel_segment *segments = voxel_read(pages->segments, 0, slots * sizeof *segments);
        uint32_t *stacks =
            voxel_read(pages->stacks, 0, (size_t)pages->page_count * (KD_PAGE_SEGMENTS + 1) * 4);
        uint8_t *free_slot = calloc(slots + 1, 1);
        assert_non_null(free_slot);
        for (uint32_t p = 0; p < pages->page_count; p++) {
            const uint32_t *stack = stacks + p * (KD_PAGE_SEGMENTS + 1);
            assert_in_range(stack[0], 0, KD_PAGE_SEGMENTS);
            for (uint32_t i = 0; i < stack[0]; i++) {
                assert_in_range(stack[1 + i], 0, KD_PAGE_SEGMENTS - 1);
                uint8_t *mark = &free_slot[p * KD_PAGE_SEGMENTS + stack[1 + i]];
                assert_int_equal(*mark, 0);
                *mark = 1;
            }
        }
        for (uint32_t s = 0; s < slots; s++) {
            assert_int_equal(segments[s].count == 0, free_slot[s]);
            used += segments[s].count != 0;
            voxels += segments[s].count;
            if (segments[s].count)
                assert_true(scene->objects[segments[s].object].alive);
        }
        assert_int_equal(used, pages->segment_count);
        assert_int_equal(voxels, pages->voxel_count);
        free(segments);
        free(stacks);
        free(free_slot);
    }
}

/* Every object's segments cover its cached voxels once in each cascade that it is in. */
static void assert_segments_are_whole(voxel_world *v)
{
    const kd_voxel_scene *scene = voxel_scene(v);
    uint64_t *covered = calloc(scene->object_count + 1, KD_MAX_CASCADES * sizeof *covered);
    assert_non_null(covered);
    for (int l = 0; l < KD_LAYER_COUNT; l++) {
        uint32_t slots = scene->pages[l].page_count * KD_PAGE_SEGMENTS;
        struct kd_voxel_segment *segments = voxel_read(scene->pages[l].segments, 0, slots * sizeof *segments);
        for (uint32_t s = 0; s < slots; s++) {
            uint32_t chunk = segments[s].chunk_cascade & 0xFFFFFFFu, c = segments[s].chunk_cascade >> 28;
            if (!segments[s].count)
                continue;
            assert_true(segments[s].first >= scene->chunks[chunk].first);
            assert_true(segments[s].first + segments[s].count <=
                        scene->chunks[chunk].first + scene->chunks[chunk].count);
            covered[segments[s].object * KD_MAX_CASCADES + c] += segments[s].count;
        }
        free(segments);
    }
    for (uint32_t i = 0; i < scene->object_count; i++)
        for (uint32_t c = 0; c < scene->cascade_count; c++) {
            const kd_voxel_object *o = &scene->objects[i];
            bool in = o->alive && o->segment_count[c];
            assert_int_equal(covered[i * KD_MAX_CASCADES + c],
                             in ? scene->caches[o->caches[c] - 1].voxel_count : 0);
        }
    free(covered);
}

static void camera_flies_through_a_field(void **state)
{
    (void)state;
    voxel_world v = voxel_open((voxel_options){.cascades = 3, .span = 0.02f});
    kd_model *ball;
    kd_material_desc grey = voxel_matte(0.5f, 0.5f, 0.5f);
    uint32_t number, most = 0, least = UINT32_MAX;
    assert_int_equal(kd_model_make_shape(KD_SHAPE_SPHERE, (kd_vec3){0.6f, 0.6f, 0.6f}, 12, &grey, &ball),
                     KD_OK);
    assert_int_equal(kd_scene_add_model(v.world, ball, &number), KD_OK);
    for (int i = 0; i < 100; i++) {
        kd_entity root;
        assert_int_equal(kd_scene_instantiate(v.world, number, KD_NO_ENTITY, "ball", &root), KD_OK);
        kd_find_mut(v.world, root, kd_transform)->position =
            (kd_vec3){(float)(i % 10) * 2, 0, (float)(i / 10) * 2};
    }
    for (int i = 0; i < 24; i++) {
        float angle = 0.55f * (float)i;
        kd_find_mut(v.world, v.camera, kd_transform)->position =
            (kd_vec3){9 + 9 * cosf(angle), 0.5f, 9 + 9 * sinf(1.7f * angle)};
        voxel_frame(&v);
        assert_books_balance(&v);
        assert_segments_are_whole(&v);
        uint32_t resident = voxel_scene(&v)->pages[KD_LAYER_STATIC].segment_count;
        most = resident > most ? resident : most;
        least = resident < least ? resident : least;
    }
    assert_true(least > 0 && most > least); /* some came, some went */
    voxel_close(&v);
}

/* Random births, deaths, first moves and changes of scale; caches are few, so each frame is short. */
static void thousands_come_and_go(void **state)
{
    (void)state;
    enum { LIVE = 60, FRAMES = 60, CHANGES = 40 };
    uint64_t random = 3;
    uint32_t number, steps = 0;
    kd_entity roots[LIVE] = {{0}};
    kd_model *box;
    kd_material_desc grey = voxel_matte(0.5f, 0.5f, 0.5f);
    voxel_world v = voxel_open((voxel_options){.cascades = 2, .span = 0.04f});
    assert_int_equal(kd_model_make_shape(KD_SHAPE_BOX, (kd_vec3){1.2f, 0.8f, 1}, 0, &grey, &box), KD_OK);
    assert_int_equal(kd_scene_add_model(v.world, box, &number), KD_OK);
    for (int frame = 0; frame < FRAMES; frame++) {
        for (int i = 0; i < CHANGES; i++, steps++) {
            uint32_t k = fixture_random(&random) % LIVE;
            kd_vec3 at = kd_vec3_scale(
                (kd_vec3){(float)(fixture_random(&random) % 150), 0, (float)(fixture_random(&random) % 150)},
                0.08f);
            if (!roots[k].generation) {
                assert_int_equal(kd_scene_instantiate(v.world, number, KD_NO_ENTITY, "box", &roots[k]),
                                 KD_OK);
                kd_find_mut(v.world, roots[k], kd_transform)->position = at;
            } else if (fixture_random(&random) % 3) {
                kd_destroy(v.world, roots[k]);
                roots[k] = KD_NO_ENTITY;
            } else {
                kd_transform *t = kd_find_mut(v.world, roots[k], kd_transform);
                t->position = at;
                t->scale = fixture_random(&random) % 2 ? (kd_vec3){1, 1, 1} : (kd_vec3){0.5f, 0.5f, 0.5f};
            }
        }
        voxel_frame(&v);
        assert_books_balance(&v);
        if (frame % 10 == 9)
            assert_segments_are_whole(&v);
    }
    assert_true(steps >= 2000);
    for (int i = 0; i < LIVE; i++)
        if (roots[i].generation)
            kd_destroy(v.world, roots[i]);
    voxel_frame(&v);
    assert_books_balance(&v);
    assert_int_equal(voxel_scene(&v)->pages[0].segment_count + voxel_scene(&v)->pages[1].segment_count, 0);
    uint32_t *mask = voxel_read_union(&v);
    assert_int_equal(voxel_count_bits(mask, voxel_svo(&v)->layer_words), 0);
    free(mask);
    voxel_close(&v);
}

/* With blocks of 2 MiB the driver takes two pages of what moves, 131 072 voxels; three boxes have 180 000. */
static void moving_voxels_beyond_one_block_are_left_out_and_told(void **state)
{
    (void)state;
    int64_t driver = voxel_gpu->info.max_ssbo_bytes;
    voxel_gpu->info.max_ssbo_bytes = 2 << 20;
    voxel_world v = voxel_open((voxel_options){.resolution = 128, .span = 0.01f});
    kd_entity boxes[3];
    for (int i = 0; i < 3; i++) {
        float edge = 1.195f - 0.2f * (float)i;
        boxes[i] = voxel_shape(&v, KD_SHAPE_BOX, (kd_vec3){edge, edge, edge}, NULL, voxel_at(0, 0, 0));
    }
    voxel_frame(&v);
    for (int frame = 0; frame < 2; frame++) {
        for (int i = 0; i < 3; i++)
            kd_find_mut(v.world, boxes[i], kd_transform)->position.x += 0.004f;
        voxel_frame(&v);
        const kd_voxel_pages *pages = &voxel_scene(&v)->pages[KD_LAYER_DYNAMIC];
        uint32_t *mask = voxel_read_mask(&v, KD_LAYER_DYNAMIC);
        assert_true(pages->voxel_count > 2 * KD_PAGE_VOXELS);
        assert_int_equal(pages->page_count, 2);
        /* the tree has no room for all of these either, but for a good part */
        assert_true(voxel_count_bits(mask, voxel_svo(&v)->layer_words) > 20000);
        free(mask);
    }
    const char *said = strstr(voxel_warnings, "the driver binds 131072 voxels that move");
    assert_non_null(said);
    assert_null(strstr(said + 1, "the driver binds"));
    for (int i = 0; i < 3; i++)
        kd_destroy(v.world, boxes[i]);
    voxel_frame(&v);
    assert_int_equal(voxel_scene(&v)->pages[KD_LAYER_DYNAMIC].segment_count, 0);
    voxel_gpu->info.max_ssbo_bytes = driver;
    if (kd_gpu_failed(voxel_gpu))
        fail_msg("logged: %s", voxel_warnings);
    voxel_warnings[0] = '\0';
    voxel_close(&v);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(moving_voxels_beyond_one_block_are_left_out_and_told),
        cmocka_unit_test(camera_flies_through_a_field),
        cmocka_unit_test(thousands_come_and_go),
    };
    return VOXEL_GROUP(tests);
}
