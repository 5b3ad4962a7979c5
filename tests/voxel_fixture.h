#ifndef KD_TESTS_VOXEL_FIXTURE_H
#define KD_TESTS_VOXEL_FIXTURE_H

/* For tests of the voxel scene: worlds with the systems from animation to octree on one device that all tests
 * of a file share, shapes and models in one call each, and what the GPU holds read back. */

#include "tests/systems_fixture.h"

#include "components/camera.h"
#include "components/light.h"
#include "components/pose_access.h"
#include "components/render_targets.h"
#include "components/svo.h"
#include "components/voxel_scene.h"
#include "runtime/gpu/gpu.h"
#include "shaders/shared/bindings.h"
#include "systems/animation/animation.h"
#include "systems/cone_trace/cone_trace.h"
#include "systems/debug_view/debug_view.h"
#include "systems/deferred/deferred.h"
#include "systems/deform/deform.h"
#include "systems/hierarchy/hierarchy.h"
#include "systems/bounce/bounce.h"
#include "systems/lighting/lighting.h"
#include "systems/resolve/resolve.h"
#include "systems/scene/scene.h"
#include "systems/shadow/shadow.h"
#include "systems/sky/sky.h"
#include "systems/svo/reference.h"
#include "systems/svo/svo.h"
#include "systems/voxel_cache/voxel_cache.h"
#include "systems/voxel_pages/voxel_pages.h"
#include "systems/voxel_transform/voxel_transform.h"

static kd_gpu *voxel_gpu;
static char voxel_warnings[4096];

static inline void voxel_log(void *user, kd_log_level level, const char *text)
{
    size_t used = strlen(voxel_warnings);
    (void)user;
    if (level >= KD_LOG_WARNING)
        snprintf(voxel_warnings + used, sizeof voxel_warnings - used, "%s\n", text);
}

static inline int voxel_group_setup(void **state)
{
    (void)state;
    setenv("KANDIL_SHADER_DIR", KD_SOURCE_DIR, 1); /* tests have shaders of their own */
    kd_log_set_sink(voxel_log, NULL);
    if (kd_gpu_open(&(kd_gpu_desc){.debug = true}, &voxel_gpu) != KD_OK) {
        fprintf(stderr, "skipped: %s", voxel_warnings);
        exit(77);
    }
    return 0;
}

static inline int voxel_group_teardown(void **state)
{
    (void)state;
    kd_gpu_close(voxel_gpu);
    kd_log_set_sink(NULL, NULL);
    return 0;
}

/* ---- a world ---- */

typedef struct voxel_world {
    kd_world *world;
    kd_schedule *schedule;
    kd_frame *frame;
    kd_entity camera;
} voxel_world;

typedef struct voxel_options {
    uint32_t resolution, cascades; /* 0: 128, 1 */
    float span;                    /* m; 0: 0.02 */
    bool one_layer;
    bool lit;      /* with lights and injection, so that leaves hold radiance */
    bool pictures; /* and with all that makes a picture */
} voxel_options;

static inline void voxel_barrier(void *user, kd_gpu *gpu, uint32_t uses)
{
    (void)user;
    if (uses != 0)
        kd_gpu_barrier(gpu, 1023);
}

static inline void voxel_import(kd_schedule *s, bool lit, bool pictures)
{
    kd_status (*const imports[])(kd_schedule *) = {
        kd_scene_import,       kd_animation_import,     kd_hierarchy_import,
        kd_deform_import,      kd_voxel_objects_import, kd_voxel_cache_import,
        kd_voxel_pages_import, kd_svo_import,           kd_voxel_transform_import};
    for (size_t i = 0; i < sizeof imports / sizeof *imports; i++)
        assert_int_equal(imports[i](s), KD_OK);
    if (lit) {
        assert_int_equal(kd_shadow_import(s), KD_OK);
        assert_int_equal(kd_sky_import(s), KD_OK);
        assert_int_equal(kd_lighting_import(s), KD_OK);
        assert_int_equal(kd_bounce_import(s), KD_OK);
    }
    if (pictures) {
        assert_int_equal(kd_deferred_import(s), KD_OK);
        assert_int_equal(kd_cone_trace_import(s), KD_OK);
        assert_int_equal(kd_debug_view_import(s), KD_OK);
        assert_int_equal(kd_resolve_import(s), KD_OK);
    }
}

static inline voxel_world voxel_open(voxel_options options)
{
    voxel_world v = {.world = kd_world_make()};
    voxel_warnings[0] = '\0';
    assert_non_null(v.world);
    v.frame = kd_singleton(v.world, kd_frame);
    *v.frame = (kd_frame){
        .width = 64, .height = 64, .dt_s = 1.0f / 30, .gi = KD_GI_CONES, .settings = kd_settings_defaults()};
    v.frame->settings.light_bounces = KD_BOUNCES_ONE;
    v.frame->settings.voxels_resolution = options.resolution ? (int32_t)options.resolution : 128;
    v.frame->settings.voxels_cascades = options.cascades ? (int32_t)options.cascades : 1;
    v.frame->settings.voxels_span = options.span > 0 ? options.span : 0.02f;
    v.frame->settings.voxels_cache = false; /* what is tested is made here and now */
    v.frame->settings.svo_layers = options.one_layer ? KD_SVO_LAYERS_ONE : KD_SVO_LAYERS_TWO;
    v.schedule = kd_schedule_make(v.world, NULL, voxel_gpu);
    assert_non_null(v.schedule);
    kd_schedule_set_hooks(v.schedule, &(kd_schedule_hooks){.barrier = voxel_barrier});
    voxel_import(v.schedule, options.lit || options.pictures, options.pictures);
    if (kd_schedule_init(v.schedule) != KD_OK)
        fail_msg("init: %s", voxel_warnings);
    v.camera = kd_spawn(v.world, KD_VAL(kd_camera, {.fov_y = 0.8f, .z_near = 0.05f, .z_far = 200}),
                        KD_VAL(kd_transform, KD_TRANSFORM_IDENTITY), KD_TAG(kd_world_transform));
    return v;
}

static inline void voxel_close(voxel_world *v)
{
    kd_schedule_destroy(v->schedule);
    kd_world_destroy(v->world);
    if (kd_gpu_failed(voxel_gpu) || voxel_warnings[0])
        fail_msg("logged: %s", voxel_warnings);
}

static inline void voxel_frame(voxel_world *v)
{
    assert_int_equal(kd_schedule_run(v->schedule), KD_OK);
    kd_gpu_barrier(voxel_gpu, 1023);
    kd_gpu_end_frame(voxel_gpu);
    v->frame->index++;
    v->frame->time_s += (double)v->frame->dt_s;
}

static inline const kd_voxel_scene *voxel_scene(voxel_world *v)
{
    return kd_singleton(v->world, kd_voxel_scene);
}
static inline const kd_svo *voxel_svo(voxel_world *v)
{
    return kd_singleton(v->world, kd_svo);
}

/* ---- what is in it ---- */

static inline kd_entity voxel_spawn(voxel_world *v, kd_model *model, kd_transform at)
{
    uint32_t number;
    kd_entity root;
    assert_int_equal(kd_scene_add_model(v->world, model, &number), KD_OK);
    assert_int_equal(kd_scene_instantiate(v->world, number, KD_NO_ENTITY, "thing", &root), KD_OK);
    *kd_find_mut(v->world, root, kd_transform) = at;
    return root;
}

static inline kd_entity voxel_load(voxel_world *v, const char *path, kd_transform at)
{
    kd_model *model = NULL;
    char full[512];
    snprintf(full, sizeof full, "%s/%s", KD_SOURCE_DIR, path);
    if (kd_model_load(full, &model) != KD_OK)
        fail_msg("%s", voxel_warnings);
    return voxel_spawn(v, model, at);
}

static inline kd_material_desc voxel_matte(float r, float g, float b)
{
    kd_material_desc m = kd_material_default();
    m.base_color = (kd_vec4){r, g, b, 1};
    m.metallic = 0;
    return m;
}

static inline kd_entity voxel_shape(voxel_world *v, kd_shape shape, kd_vec3 size,
                                    const kd_material_desc *material, kd_transform at)
{
    kd_model *model;
    kd_material_desc grey = voxel_matte(0.5f, 0.5f, 0.5f);
    assert_int_equal(kd_model_make_shape(shape, size, 0, material ? material : &grey, &model), KD_OK);
    return voxel_spawn(v, model, at);
}

static inline kd_transform voxel_at(float x, float y, float z)
{
    return (kd_transform){{x, y, z}, {0, 0, 0, 1}, {1, 1, 1}};
}

/* ---- what the GPU holds ---- */

static inline void *voxel_read(kd_gpu_buffer buffer, size_t offset, size_t bytes)
{
    void *out = malloc(bytes + 16);
    assert_non_null(out);
    if (bytes)
        kd_gpu_read_buffer(voxel_gpu, buffer, offset, out, bytes);
    return out;
}

/* Cells of the static layer, from the words of its blocks. */
static inline void voxel_put_static(voxel_world *v, uint32_t *mask)
{
    const kd_svo *svo = voxel_svo(v);
    uint32_t top = kd_svo_leaf_parent_level(svo) - KD_DENSE_LOG2;
    size_t bytes = (size_t)svo->node_capacity * 4;
    uint32_t *codes = voxel_read(svo->book, (size_t)(&svo->places.codes.x)[top] * 4, bytes);
    uint32_t *blocks = voxel_read(svo->book, (size_t)svo->places.blocks.x * 4, bytes);
    for (uint32_t n = 0; n < svo->node_capacity; n++)
        if (codes[n] != KD_EMPTY)
            mask[codes[n] >> 2] |= blocks[n] >> KD_BLOCK_BITS << (8 * (codes[n] & 3));
    free(codes);
    free(blocks);
}

/* Cells of the dynamic layer: a word for each of its parents tells which of the eight there are. */
static inline void voxel_put_moving(voxel_world *v, uint32_t *mask)
{
    const kd_svo *svo = voxel_svo(v);
    uint32_t words = kd_svo_parent_words(svo), room = kd_svo_moving_room(svo), rank = 0;
    if (!room)
        return;
    uint32_t *parents = voxel_read(svo->moving, 0, (size_t)words * 4);
    uint32_t *cells = voxel_read(svo->dynamic_cells, kd_svo_moving_words(svo), (size_t)room * 4);
    for (uint32_t w = 0; w < words; w++)
        for (uint32_t bits = parents[w]; bits && rank < room; bits &= bits - 1, rank++) {
            uint32_t parent = w * 32 + (uint32_t)__builtin_ctz(bits);
            mask[parent >> 2] |= cells[rank] << (8 * (parent & 3));
        }
    free(parents);
    free(cells);
}

/* Cells of a layer. */
static inline uint32_t *voxel_read_mask(voxel_world *v, int layer)
{
    const kd_svo *svo = voxel_svo(v);
    uint32_t *mask = calloc(svo->layer_words, 4);
    assert_non_null(mask);
    if (layer == KD_LAYER_STATIC)
        voxel_put_static(v, mask);
    else
        voxel_put_moving(v, mask);
    return mask;
}

static inline uint32_t *voxel_read_union(voxel_world *v)
{
    uint32_t words = voxel_svo(v)->layer_words, *a = voxel_read_mask(v, 0), *b = voxel_read_mask(v, 1);
    for (uint32_t i = 0; i < words; i++)
        a[i] |= b[i];
    free(b);
    return a;
}

static inline uint32_t voxel_count_bits(const uint32_t *mask, uint32_t words)
{
    uint32_t n = 0;
    for (uint32_t i = 0; i < words; i++)
        for (uint32_t w = mask[i]; w; w &= w - 1)
            n++;
    return n;
}

/* Everything that the reference build reads. */
typedef struct voxel_capture {
    svo_reference_source source;
    void *held[8];
} voxel_capture;

/* Page voxels of the static layer: they are nowhere kept, so a pass of the tests makes them. */
static inline void *voxel_read_static(voxel_world *v)
{
    const kd_voxel_scene *scene = voxel_scene(v);
    const kd_voxel_pages *pages = &scene->pages[KD_LAYER_STATIC];
    uint32_t slots = pages->page_count * KD_PAGE_SEGMENTS, pass[4] = {slots, 0, 0, 0};
    size_t bytes = (size_t)slots * KD_SEGMENT_VOXELS * KD_PAGE_WORDS * 4;
    if (!bytes)
        return malloc(16);
    kd_gpu_program program =
        kd_gpu_make_program(voxel_gpu, &(kd_gpu_program_desc){.compute = "tests/gpu/static_pages.comp"});
    kd_gpu_buffer out = kd_gpu_make_buffer(voxel_gpu, &(kd_gpu_buffer_desc){.size = bytes, .name = "pages"});
    kd_gpu_bind_uniform(voxel_gpu, 0, pass, sizeof pass);
    kd_gpu_bind_uniform_buffer(voxel_gpu, KD_BIND_TREE, voxel_svo(v)->uniform, 0,
                               sizeof(struct kd_tree_params));
    kd_gpu_bind_storage(voxel_gpu, 1, pages->segments);
    kd_gpu_bind_storage(voxel_gpu, 2, scene->object_params);
    kd_gpu_bind_storage(voxel_gpu, 3, scene->chunk_params);
    kd_texel_view shape = {0};
    kd_texel_view_bind(voxel_gpu, &shape, 4, scene->cache_shape, KD_RG32UI);
    kd_gpu_bind_storage(voxel_gpu, 5, out);
    kd_gpu_dispatch_linear(voxel_gpu, program, slots * (KD_SEGMENT_VOXELS / 64));
    kd_gpu_barrier(voxel_gpu, 1023);
    void *voxels = voxel_read(out, 0, bytes);
    kd_texel_view_fini(voxel_gpu, &shape);
    kd_gpu_destroy_buffer(voxel_gpu, out);
    kd_gpu_destroy_program(voxel_gpu, program);
    return voxels;
}

static inline voxel_capture voxel_read_source(voxel_world *v)
{
    const kd_voxel_scene *scene = voxel_scene(v);
    voxel_capture c = {.source = {.cascades = scene->cascade_count, .leaf_level = scene->resolution_log2}};
    int at = 0;
    memcpy(c.source.origin, scene->origin_cells, sizeof c.source.origin);
    for (int l = 0; l < KD_LAYER_COUNT; l++) {
        const kd_voxel_pages *pages = &scene->pages[l];
        uint32_t slots = pages->page_count * KD_PAGE_SEGMENTS;
        c.source.layers[l].slots = slots;
        c.source.layers[l].segments = c.held[at++] =
            voxel_read(pages->segments, 0, slots * sizeof(struct kd_voxel_segment));
        c.source.layers[l].voxels = c.held[at++] =
            l == KD_LAYER_STATIC
                ? voxel_read_static(v)
                : voxel_read(pages->voxels, 0, (size_t)slots * KD_SEGMENT_VOXELS * KD_PAGE_WORDS * 4);
    }
    c.source.objects = c.held[at++] =
        voxel_read(scene->object_params, 0, scene->object_count * sizeof(struct kd_voxel_object_params));
    c.source.shape = c.held[at++] = voxel_read(scene->cache_shape, 0, (size_t)scene->voxel_places.end * 8);
    c.source.color = c.held[at++] = voxel_read(scene->cache_color, 0, (size_t)scene->voxel_places.end * 4);
    return c;
}

static inline void voxel_capture_free(voxel_capture *c)
{
    for (size_t i = 0; i < sizeof c->held / sizeof *c->held; i++)
        free(c->held[i]);
}

/* ---- floods ---- */

/* Fill a grid of cells from its border through those that are not wall, six-connected; outside[] is 1 where
 * it came. */
static inline void voxel_flood(const uint8_t *wall, const uint32_t size[3], uint8_t *outside)
{
    size_t step[4] = {1, size[0], (size_t)size[0] * size[1], (size_t)size[0] * size[1] * size[2]}, top = 0;
    size_t *stack = malloc(step[3] * sizeof *stack);
    assert_non_null(stack);
    memset(outside, 0, step[3]);
    for (size_t i = 0; i < step[3]; i++) {
        bool border = false;
        for (int k = 0; k < 3; k++)
            border = border || i / step[k] % size[k] == 0 || i / step[k] % size[k] == size[k] - 1;
        if (border && !wall[i])
            outside[stack[top++] = i] = 1;
    }
    while (top) {
        size_t i = stack[--top];
        for (int k = 0; k < 3; k++) {
            size_t at = i / step[k] % size[k], low = at > 0 ? i - step[k] : i,
                   high = at < size[k] - 1 ? i + step[k] : i;
            if (!wall[low] && !outside[low])
                outside[stack[top++] = low] = 1;
            if (!wall[high] && !outside[high])
                outside[stack[top++] = high] = 1;
        }
    }
    free(stack);
}

#define VOXEL_GROUP(tests) cmocka_run_group_tests(tests, voxel_group_setup, voxel_group_teardown)

#endif
