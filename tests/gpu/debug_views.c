/* Views of voxels and of the tree, pixel by pixel against what is known of the scene. A box of 10 x 10 x 10
 * voxels stands on the lattice before an orthographic camera with 4 pixels a voxel: 1600 pixels. */
#include "runtime/core/half.h"
#include "shaders/shared/gather.h"
#include "tests/voxel_fixture.h"

enum { SIZE = 64, PIXELS = SIZE * SIZE };

/* Each side lies a quarter of a voxel inside the 10th, so nothing hangs on which cell a plane belongs to. */
static const kd_vec3 BOX = {0.19f, 0.19f, 0.19f};

static float picture[PIXELS * 4];

/* A world with a camera at (0, 0, 2) that looks along -Z and sees 0.32 m. */
static voxel_world open_world(uint32_t cascades)
{
    voxel_world v = voxel_open((voxel_options){.cascades = cascades, .pictures = true});
    v.frame->settings.view_tonemap = KD_TONEMAP_LINEAR;
    *kd_find_mut(v.world, v.camera, kd_camera) =
        (kd_camera){.orthographic = true, .y_mag = 0.16f, .z_near = 0.1f, .z_far = 40};
    *kd_find_mut(v.world, v.camera, kd_transform) = voxel_at(0, 0, 2);
    return v;
}

static kd_entity add_box(voxel_world *v, float x, float z)
{
    kd_material_desc m = voxel_matte(0.5f, 0.1f, 0.9f);
    return voxel_shape(v, KD_SHAPE_BOX, BOX, &m, voxel_at(x, 0, z));
}

/* Render a frame and read what it shows. */
static void show(voxel_world *v, kd_view_mode view, kd_view_channel channel, int level)
{
    static uint16_t half[PIXELS * 4];
    v->frame->view = view;
    v->frame->settings.view_channel = (int32_t)channel;
    v->frame->settings.view_level = level;
    voxel_frame(v);
    kd_gpu_read_texture(voxel_gpu, kd_singleton(v->world, kd_picture)->hdr, 0, half, sizeof half);
    for (size_t i = 0; i < PIXELS * 4; i++)
        picture[i] = kd_half_to_float(half[i]);
}

/* Pixels that something was drawn into. */
static uint32_t covered(void)
{
    uint32_t n = 0;
    for (size_t i = 0; i < PIXELS; i++)
        n += picture[i * 4 + 3] > 0;
    return n;
}

static void expect(uint32_t x, uint32_t y, float r, float g, float b, float tolerance)
{
    const float *p = picture + (y * SIZE + x) * 4, wanted[3] = {r, g, b};
    for (int k = 0; k < 3; k++)
        if (!(fabsf(p[k] - wanted[k]) <= tolerance))
            fail_msg("pixel %u %u channel %d is %g, expected %g", x, y, k, (double)p[k], (double)wanted[k]);
}

static const kd_view_mode views[] = {KD_VIEW_CACHES, KD_VIEW_PAGES, KD_VIEW_OCTREE, KD_VIEW_LOOKUP};

/* Albedo keeps 8 bits of its root in caches and 10 bits in cells; a covered cell lets nothing through. */
static void a_box_shows_its_voxels(void **state)
{
    (void)state;
    voxel_world v = open_world(1);
    add_box(&v, 0, 0);
    for (size_t i = 0; i < 4; i++) {
        show(&v, views[i], KD_CHANNEL_ALBEDO, -1);
        assert_int_equal(covered(), views[i] == KD_VIEW_LOOKUP ? 38 * 38 : 1600);
        expect(32, 32, 0.5f, 0.1f, 0.9f, 0.008f);
        float voxel = views[i] != KD_VIEW_LOOKUP; /* before the surface lies half a pixel of voxel */
        expect(12, 12, 0.5f * voxel, 0.1f * voxel, 0.9f * voxel, 0.008f);
        expect(8, 32, 0, 0, 0, 0);
        show(&v, views[i], KD_CHANNEL_NORMAL, 0);
        expect(32, 32, 0.5f, 0.5f, 1, 0.01f);
        show(&v, views[i], KD_CHANNEL_OPACITY, 0);
        expect(32, 32, 1, 1, 1, 0.001f);
        show(&v, views[i], KD_CHANNEL_CASCADE, 0);
        expect(32, 32, 1, 0, 0, 0.004f);
    }
    voxel_close(&v);
}

/* Cells 4 cm wide cover -12 to 12 cm of the box, cells 8 cm wide -16 to 16. The caches of the coarser cascade
 * are made to be shown, though the box does not stand in it. */
static void levels_double_the_cells(void **state)
{
    static const kd_view_channel channels[] = {KD_CHANNEL_ALBEDO, KD_CHANNEL_RADIANCE};
    (void)state;
    voxel_world v = open_world(3);
    add_box(&v, 0, 0);
    for (int level = 0; level < 3; level++) {
        uint32_t edge = level == 0 ? 40 : level == 1 ? 48 : 64;
        show(&v, KD_VIEW_CACHES, KD_CHANNEL_ALBEDO, level);
        assert_int_equal(covered(), edge * edge);
        for (int c = 0; c < 2; c++) {
            show(&v, KD_VIEW_OCTREE, channels[c], level);
            assert_int_equal(covered(), edge * edge);
        }
        show(&v, KD_VIEW_OCTREE, KD_CHANNEL_ALBEDO, level);
        expect(32, 32, 0.5f, 0.1f, 0.9f, 0.008f);
        show(&v, KD_VIEW_LOOKUP, KD_CHANNEL_ALBEDO, level);
        expect(32, 32, 0.5f, 0.1f, 0.9f, 0.008f);
    }
    show(&v, KD_VIEW_PAGES, KD_CHANNEL_ALBEDO, 1); /* nothing of it stands in a coarser cascade */
    assert_int_equal(covered(), 0);
    voxel_close(&v);
}

/* Moved by 10 pixels; turned by 45 degrees the square keeps its area, 1600 pixels less and more along its
 * border, which is 160 long. Pages hold upright voxels in turned rows, between which one sees through. */
static void caches_are_drawn_at_their_object(void **state)
{
    (void)state;
    voxel_world v = open_world(1);
    kd_entity box = add_box(&v, 0, 0);
    voxel_frame(&v);
    kd_find_mut(v.world, box, kd_transform)->position.x = 0.05f;
    show(&v, KD_VIEW_CACHES, KD_CHANNEL_ALBEDO, -1);
    assert_int_equal(covered(), 1600);
    expect(21, 32, 0, 0, 0, 0);
    expect(22, 32, 0.5f, 0.1f, 0.9f, 0.008f);
    expect(61, 32, 0.5f, 0.1f, 0.9f, 0.008f);
    *kd_find_mut(v.world, box, kd_transform) =
        (kd_transform){{0, 0, 0}, {0, 0, 0.38268343f, 0.92387953f}, {1, 1, 1}};
    for (size_t i = 0; i < 2; i++) {
        show(&v, views[i], KD_CHANNEL_ALBEDO, -1);
        assert_in_range(covered(), views[i] == KD_VIEW_CACHES ? 1560 : 1300, 1760);
        expect(32, 8, 0.5f, 0.1f, 0.9f, 0.008f);
        expect(16, 16, 0, 0, 0, 0);
    }
    voxel_close(&v);
}

/* The share of pixels that voxels and surfaces both cover, of those that one of them does. */
static double overlap(voxel_world *v, kd_view_mode view)
{
    static bool drawn[PIXELS];
    uint32_t both = 0, either = 0;
    show(v, view, KD_CHANNEL_ALBEDO, -1);
    for (size_t i = 0; i < PIXELS; i++)
        drawn[i] = picture[i * 4 + 3] > 0;
    show(v, KD_VIEW_DEPTH, KD_CHANNEL_AUTO, -1);
    for (size_t i = 0; i < PIXELS; i++) {
        bool surface = picture[i * 4 + 3] > 0;
        both += drawn[i] && surface;
        either += drawn[i] || surface;
    }
    return (double)both / either;
}

/* A walker of half a metre in stride: its voxels are where its skin is, and those of its rest pose are not.
 */
static void voxels_of_a_skin_follow_its_pose(void **state)
{
    (void)state;
    voxel_world v = open_world(1);
    kd_find_mut(v.world, v.camera, kd_camera)->y_mag = 0.5f;
    kd_find_mut(v.world, v.camera, kd_transform)->position = (kd_vec3){0, 0.4f, 3};
    kd_entity walker = voxel_load(&v, "samples/assets/walker.gltf",
                                  (kd_transform){{0, 0, 0}, {0, 0.7071068f, 0, 0.7071068f}, {1, 1, 1}});
    voxel_frame(&v);
    kd_find_mut(v.world, walker, kd_animation)->clip = 1;
    for (int frame = 0; frame < 3; frame++) {
        kd_find_mut(v.world, walker, kd_animation)->time_s = 0.2f * (float)frame;
        for (size_t i = 0; i < 2; i++) {
            double share = overlap(&v, views[i]);
            if (share < 0.8)
                fail_msg("view %zu of frame %d covers %g of the walker", i, frame, share);
        }
    }
    voxel_close(&v);
}

/* The second box stands 10 m away, where no cascade reaches: 0.04 m of it show beside the first. */
static void surfaces_that_the_tree_lacks_are_grey(void **state)
{
    (void)state;
    voxel_world v = open_world(2);
    add_box(&v, 0, 0);
    add_box(&v, 0.22f, -10);
    show(&v, KD_VIEW_LOOKUP, KD_CHANNEL_ALBEDO, -1);
    expect(32, 32, 0.5f, 0.1f, 0.9f, 0.008f);
    expect(60, 32, 0.2f, 0.2f, 0.2f, 0.001f);
    show(&v, KD_VIEW_LOOKUP, KD_CHANNEL_NORMAL, -1);
    expect(60, 32, 0.5f, 0.5f, 0.5f, 0.001f);
    show(&v, KD_VIEW_OCTREE, KD_CHANNEL_ALBEDO, -1);
    expect(60, 32, 0, 0, 0, 0);
    voxel_close(&v);
}

static const kd_view_mode all_views[] = {KD_VIEW_LIGHT,  KD_VIEW_CACHES, KD_VIEW_PAGES,
                                         KD_VIEW_OCTREE, KD_VIEW_LOOKUP, KD_VIEW_COST};
enum { VIEW_COUNT = sizeof all_views / sizeof *all_views };

static void nothing_is_shown_of_nothing(void **state)
{
    (void)state;
    voxel_world v = open_world(2);
    for (size_t i = 0; i < VIEW_COUNT; i++) {
        show(&v, all_views[i], KD_CHANNEL_AUTO, (int)i - 1);
        assert_int_equal(covered(), 0);
        expect(32, 32, 0, 0, 0, 0);
    }
    voxel_close(&v);
}

/* The picture after as many frames as there are views, each showing one of them or all the final picture. */
static void light_after(bool with_views, float *out)
{
    voxel_world v = open_world(2);
    v.frame->settings.light_bounces = KD_BOUNCES_INF;
    add_box(&v, 0, 0);
    kd_spawn(v.world, KD_VAL(kd_light, {.type = KD_POINT, .color = {1, 1, 1}, .intensity = 1}),
             KD_VAL(kd_transform, {{0.2f, 0.3f, 0.6f}, {0, 0, 0, 1}, {1, 1, 1}}), KD_TAG(kd_world_transform));
    for (size_t i = 0; i < VIEW_COUNT; i++)
        show(&v, with_views ? all_views[i] : KD_VIEW_FINAL, KD_CHANNEL_AUTO, 1);
    show(&v, KD_VIEW_FINAL, KD_CHANNEL_AUTO, -1);
    memcpy(out, picture, sizeof picture);
    voxel_close(&v);
}

static void views_leave_the_light_as_it_is(void **state)
{
    static float plain[PIXELS * 4], after[PIXELS * 4];
    (void)state;
    light_after(false, plain);
    light_after(true, after);
    assert_true(plain[(32 * SIZE + 32) * 4 + 1] > 0);
    assert_memory_equal(plain, after, sizeof plain);
}

static uint64_t runs_of(const voxel_world *v, const char *name)
{
    for (uint32_t i = 0; i < kd_schedule_count(v->schedule); i++)
        if (strcmp(kd_schedule_system(v->schedule, i)->name, name) == 0)
            return kd_schedule_statistics(v->schedule, i).runs;
    fail_msg("there is no system %s", name);
    return 0;
}

static void views_that_are_not_shown_cost_nothing(void **state)
{
    (void)state;
    voxel_world v = open_world(1);
    add_box(&v, 0, 0);
    show(&v, KD_VIEW_FINAL, KD_CHANNEL_AUTO, -1);
    size_t bytes = kd_gpu_bytes(voxel_gpu);
    show(&v, KD_VIEW_FINAL, KD_CHANNEL_AUTO, -1);
    assert_int_equal(kd_gpu_bytes(voxel_gpu), bytes);
    assert_int_equal(runs_of(&v, "view_voxels") + runs_of(&v, "view_tree") + runs_of(&v, "view_cost"), 0);
    assert_int_equal(kd_singleton(v.world, kd_gi_targets)->samples.id, 0);
    assert_int_equal(runs_of(&v, "gather_cones"), 2);
    for (size_t i = 0; i < 4; i++) /* and these want no cones */
        show(&v, views[i], KD_CHANNEL_AUTO, -1);
    assert_int_equal(runs_of(&v, "gather_cones"), 2);
    assert_int_equal(runs_of(&v, "view_voxels"), 2);
    assert_int_equal(runs_of(&v, "view_tree"), 2);
    voxel_close(&v);
}

static void samples_of_cones_and_of_pixels_add_up(void **state)
{
    uint32_t counts[KD_CONE_COUNTERS + PIXELS], most = 0;
    uint64_t of_cones = 0, of_pixels = 0;
    (void)state;
    voxel_world v = open_world(1);
    add_box(&v, 0, 0);
    v.frame->settings.cones_count = 5;
    v.frame->settings.cones_resolution = 1;
    v.frame->settings.cones_refine = 0;
    show(&v, KD_VIEW_COST, KD_CHANNEL_AUTO, -1);
    const kd_gi_targets *gi = kd_singleton(v.world, kd_gi_targets);
    assert_true(gi->counted);
    kd_gpu_read_buffer(voxel_gpu, gi->samples, 0, counts, sizeof counts);
    assert_int_equal(counts[0], 38 * 38); /* the surface's pixels */
    for (uint32_t i = 0; i <= KD_MAX_CONES; i++) {
        const uint32_t *cone = counts + KD_CONE_HEAD + i * KD_CONE_WORDS;
        assert_int_equal(cone[0], i < 5 ? 38 * 38 : 0); /* it is rough: no glossy cone */
        assert_true(cone[2] <= cone[1] && (i >= 5 || cone[2] > 0));
        of_cones += cone[1];
    }
    for (uint32_t i = 0; i < PIXELS; i++) {
        of_pixels += counts[KD_CONE_COUNTERS + i];
        most = counts[KD_CONE_COUNTERS + i] > most ? counts[KD_CONE_COUNTERS + i] : most;
        uint32_t x = i % SIZE, y = SIZE - 1 - i / SIZE; /* pictures begin at the top */
        assert_true(picture[(y * SIZE + x) * 4] == (float)counts[KD_CONE_COUNTERS + i]);
    }
    assert_int_equal(of_cones, of_pixels);
    assert_int_equal(counts[1], most);
    voxel_close(&v);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_box_shows_its_voxels),
        cmocka_unit_test(levels_double_the_cells),
        cmocka_unit_test(caches_are_drawn_at_their_object),
        cmocka_unit_test(voxels_of_a_skin_follow_its_pose),
        cmocka_unit_test(surfaces_that_the_tree_lacks_are_grey),
        cmocka_unit_test(nothing_is_shown_of_nothing),
        cmocka_unit_test(views_leave_the_light_as_it_is),
        cmocka_unit_test(views_that_are_not_shown_cost_nothing),
        cmocka_unit_test(samples_of_cones_and_of_pixels_add_up),
    };
    return VOXEL_GROUP(tests);
}
