/* The three builds on random voxels: each makes the nodes and cells of the C reference, whole or, where there
 * is no room for all, a part of them that hangs together. Room that is not wanted any more goes back. */

#include <stdio.h>
#include <unistd.h>

#include "tests/tree_fixture.h"

enum { CASCADES = 2, GIVEN_BACK_AFTER = 64 };

/* Page voxels made up at random, and all that the reference and the systems need of them. */
typedef struct cloud {
    uint32_t count, slots;
    struct kd_voxel_segment *segments;
    uint32_t (*voxels)[KD_PAGE_WORDS], (*shape)[2], *color;
    struct kd_voxel_object_params *objects;
    svo_reference_source source;
} cloud;

/* `spread`: cells along an axis over which they lie, in the middle; `fill`: voxels in each segment. */
static cloud make_cloud_in(uint32_t leaf_level, uint32_t count, uint32_t spread, uint64_t seed, uint32_t fill)
{
    cloud c = {.count = count,
               .slots = (count + fill * KD_PAGE_SEGMENTS - 1) / (fill * KD_PAGE_SEGMENTS) * KD_PAGE_SEGMENTS};
    uint32_t low = ((1u << leaf_level) - spread) / 2;
    c.segments = calloc(c.slots + 1, sizeof *c.segments);
    c.voxels = calloc((size_t)c.slots * KD_SEGMENT_VOXELS + 1, sizeof *c.voxels);
    c.shape = calloc((size_t)count + 1, sizeof *c.shape);
    c.color = calloc((size_t)count + 1, sizeof *c.color);
    c.objects = calloc(CASCADES, sizeof *c.objects);
    assert_true(c.objects && c.segments && c.voxels && c.shape && c.color);
    for (uint32_t i = 0; i < CASCADES; i++)
        c.objects[i].emission = (kd_gl_vec4){i ? 0.7f : 0, i ? 0.2f : 0, 0, 0};
    for (uint32_t i = 0; i < count; i++) {
        uint32_t *voxel = c.voxels[(size_t)(i / fill) * KD_SEGMENT_VOXELS + i % fill];
        for (int k = 0; k < 3; k++)
            voxel[0] |= (low + (uint32_t)(fixture_random(&seed) >> 8) % (spread + 1)) << (10 * k);
        voxel[0] = i % 97 ? voxel[0] : KD_NO_VOXEL;
        voxel[1] =
            i % 3 ? (uint32_t)fixture_random(&seed) & 0xFFFFFFu : 0; /* every third falls on one cell */
        voxel[2] = (uint32_t)fixture_random(&seed);
        c.shape[i][1] = voxel[2] & 0xFF000000u;
        voxel[3] = c.color[i] = (uint32_t)fixture_random(&seed);
    }
    for (uint32_t s = 0; s * fill < count; s++) {
        uint32_t left = count - s * fill;
        c.segments[s] = (struct kd_voxel_segment){s % CASCADES, s * fill, left < fill ? left : fill,
                                                  (s / 2) % CASCADES << 28};
    }
    c.source = (svo_reference_source){
        .cascades = CASCADES, .leaf_level = leaf_level, .objects = c.objects, .shape = (void *)c.shape};
    c.source.color = c.color;
    for (int k = 0; k < 3; k++) /* low corners lie on dense cells */
        for (int32_t i = 0; i < CASCADES; i++)
            c.source.origin[i][k] = (k * 13 - i * 7 - 20) * (1 << (leaf_level - KD_DENSE_LOG2));
    c.source.layers[KD_LAYER_DYNAMIC] =
        (svo_reference_layer){.segments = c.segments, .voxels = (void *)c.voxels, .slots = c.slots};
    return c;
}

static cloud make_cloud(uint32_t leaf_level, uint32_t count, uint32_t spread, uint64_t seed)
{
    return make_cloud_in(leaf_level, count, spread, seed, KD_SEGMENT_VOXELS);
}

static void free_cloud(cloud *c)
{
    free(c->objects);
    free(c->segments);
    free(c->voxels);
    free(c->shape);
    free(c->color);
}

/* ---- a world with the octree's systems alone ---- */

static voxel_world open_tree(uint32_t build, uint32_t memory)
{
    voxel_world v = {.world = kd_world_make()};
    voxel_warnings[0] = '\0';
    assert_non_null(v.world);
    v.frame = kd_singleton(v.world, kd_frame);
    *v.frame = (kd_frame){.width = 64, .height = 64, .gi = KD_GI_CONES, .settings = kd_settings_defaults()};
    v.frame->settings.svo_build = (int32_t)build;
    v.frame->settings.svo_memory = (int32_t)memory;
    v.frame->settings.svo_layers = KD_SVO_LAYERS_ONE;
    v.schedule = kd_schedule_make(v.world, NULL, voxel_gpu);
    assert_non_null(v.schedule);
    kd_schedule_set_hooks(v.schedule, &(kd_schedule_hooks){.barrier = voxel_barrier});
    assert_int_equal(kd_svo_import(v.schedule), KD_OK);
    if (kd_schedule_init(v.schedule) != KD_OK)
        fail_msg("init: %s", voxel_warnings);
    return v;
}

static void upload(kd_gpu_buffer *buffer, const void *data, size_t bytes, const char *name)
{
    kd_gpu_destroy_buffer(voxel_gpu, *buffer);
    *buffer = kd_gpu_make_buffer(voxel_gpu, &(kd_gpu_buffer_desc){.size = bytes + 16, .name = name});
    if (bytes)
        kd_gpu_write_buffer(voxel_gpu, *buffer, 0, data, bytes);
}

static void place(kd_voxel_scene *scene, const cloud *c, uint32_t build, bool one_layer)
{
    scene->cascade_count = CASCADES;
    scene->resolution_log2 = c->source.leaf_level;
    scene->resolution = 1u << c->source.leaf_level;
    scene->build = build;
    scene->one_layer = one_layer;
    scene->brightest_emission = 1;
    memcpy(scene->origin_cells, c->source.origin, sizeof c->source.origin);
    for (uint32_t i = 0; i < CASCADES; i++)
        scene->span[i] = (float)(i + 1);
}

/* Put a cloud where the systems expect the dynamic layer, marks and all; the builds that take numbers need
 * none of these. */
static void put_cloud(voxel_world *v, const cloud *c, const svo_reference *r)
{
    kd_voxel_scene *scene = kd_singleton(v->world, kd_voxel_scene);
    kd_voxel_pages *pages = &scene->pages[KD_LAYER_DYNAMIC];
    const kd_svo *svo = voxel_svo(v);
    upload(&pages->segments, c->segments, c->slots * sizeof *c->segments, "segments");
    upload(&pages->voxels, c->voxels, (size_t)c->slots * KD_SEGMENT_VOXELS * KD_PAGE_WORDS * 4, "voxels");
    upload(&scene->cache_shape, c->shape, (size_t)c->count * 8, "shape");
    upload(&scene->cache_color, c->color, (size_t)c->count * 4, "color");
    upload(&scene->object_params, c->objects, CASCADES * sizeof *c->objects, "objects");
    pages->page_count = c->slots / KD_PAGE_SEGMENTS;
    pages->segment_count = c->slots;
    pages->voxel_count = c->count;
    pages->changed = true;
    if (scene->build == KD_SVO_BUILD_ORDERFREE) {
        voxel_frame(v); /* makes room for the bits; what moves is all there is */
        kd_gpu_write_buffer(voxel_gpu, svo->moving, 0, r->level_masks[r->levels - 1],
                            kd_svo_parent_words(svo) * 4);
    }
    voxel_frame(v);
    pages->changed = false;
}

static void close_tree(voxel_world *v)
{
    kd_voxel_scene *scene = kd_singleton(v->world, kd_voxel_scene);
    kd_gpu_buffer held[] = {scene->pages[KD_LAYER_DYNAMIC].segments, scene->pages[KD_LAYER_DYNAMIC].voxels,
                            scene->cache_shape, scene->cache_color, scene->object_params};
    for (size_t i = 0; i < sizeof held / sizeof *held; i++)
        kd_gpu_destroy_buffer(voxel_gpu, held[i]);
    voxel_close(v);
}

typedef struct tree_case {
    voxel_world v;
    cloud c;
    svo_reference r;
} tree_case;

static tree_case open_case(uint32_t build, uint32_t memory, cloud c)
{
    tree_case t = {.v = open_tree(build, memory), .c = c};
    place(kd_singleton(t.v.world, kd_voxel_scene), &c, build, true);
    assert_int_equal(svo_reference_build(&c.source, &t.r), KD_OK);
    voxel_frame(&t.v); /* without voxels; makes the buffers */
    put_cloud(&t.v, &c, &t.r);
    return t;
}

static void close_case(tree_case *t)
{
    close_tree(&t->v);
    free_cloud(&t->c);
    svo_reference_free(&t->r);
}

/* ---- what is compared ---- */

static bool has_bit(const uint32_t *mask, uint32_t bit)
{
    return (mask[bit >> 5] >> (bit & 31) & 1u) != 0;
}

/* Number of a cell's leaf parent in the order of the codes; `from`: one that does not lie behind it. */
static uint32_t find_parent(const svo_reference *r, uint32_t code, uint32_t from)
{
    while (r->lists[r->levels - 1][from] < code >> 3)
        from++;
    return from;
}

/* Cells that there are, which must be those of the reference with its attributes; returns how many. Those of
 * `orderfree` lie eight a parent in the order of the parents' bits, the others' beside their leaves. */
static uint32_t assert_cells(tree_case *t, const tree_copy *copy)
{
    const svo_reference *r = &t->r;
    uint32_t top = copy->levels - 1, rank = 0, seen = 0, astray = 0;
    bool by_rank = voxel_scene(&t->v)->build == KD_SVO_BUILD_ORDERFREE;
    const uint32_t *mask = r->masks[KD_LAYER_DYNAMIC];
    uint32_t room = voxel_svo(&t->v)->dynamic_room, parent = 0;
    uint32_t(*cells)[8][4] =
        voxel_read(voxel_svo(&t->v)->dynamic_cells, 0, by_rank ? room * sizeof *cells : 0);
    for (uint32_t code = 0, i = 0; code < r->layer_words * 32; code++) {
        if (!mask[code >> 5])
            code |= 31;
        if (!has_bit(mask, code))
            continue;
        const uint32_t *want = r->cells[KD_LAYER_DYNAMIC][rank++];
        uint32_t beside[4];
        while (i < copy->count[top] && copy->codes[top][i] < code >> 3)
            i++;
        parent = find_parent(r, code, parent);
        bool there = i < copy->count[top] && copy->codes[top][i] == code >> 3;
        if (!there || (by_rank ? parent >= room : !has_bit(copy->still, code)))
            continue;
        tree_static_cell(copy, i, code & 7, beside);
        assert_memory_equal(by_rank ? cells[parent][code & 7] : beside, want, 16);
        seen++;
    }
    for (uint32_t w = 0; w < r->layer_words; w++)
        astray |= copy->still[w] & ~mask[w];
    assert_int_equal(astray, 0);
    free(cells);
    return seen;
}

/* The whole tree of the reference. */
static void assert_whole(tree_case *t)
{
    tree_copy copy = tree_read(&t->v);
    for (uint32_t l = 0; l < copy.levels; l++)
        assert_memory_equal(copy.masks[l], t->r.level_masks[l], (size_t)copy.words[l] * 4);
    assert_int_equal(assert_cells(t, &copy), t->r.cell_count[KD_LAYER_DYNAMIC]);
    tree_free(&copy);
}

static void makes_the_reference(uint32_t build)
{
    const uint32_t clouds[][3] = {/* level of the leaves, voxels, cells over which they spread */
                                  {7, 3000, 128},
                                  {8, 5000, 256},
                                  {8, 40000, 20},
                                  {9, 20000, 512}};
    for (size_t i = 0; i < sizeof clouds / sizeof *clouds; i++) {
        tree_case t =
            open_case(build, 0, make_cloud(clouds[i][0], clouds[i][1], clouds[i][2], 17 + (uint64_t)i));
        assert_true(t.r.cell_count[KD_LAYER_DYNAMIC] > 4000);
        assert_whole(&t);
        if (i == 0) { /* and again, from what was there */
            voxel_frame(&t.v);
            assert_whole(&t);
        }
        close_case(&t);
    }
}

static void orderfree_makes_the_reference(void **state)
{
    (void)state, makes_the_reference(KD_SVO_BUILD_ORDERFREE);
}
static void atomic_makes_the_reference(void **state)
{
    (void)state, makes_the_reference(KD_SVO_BUILD_ATOMIC);
}
static void levels_make_the_reference(void **state)
{
    (void)state, makes_the_reference(KD_SVO_BUILD_LEVELS);
}

/* ---- contention ---- */

static char *read_text(const char *path)
{
    FILE *file = fopen(path, "rb");
    assert_non_null(file);
    char *text = calloc(1, 1 << 16);
    assert_non_null(text);
    assert_in_range(fread(text, 1, (1 << 16) - 1, file), 1, (1 << 16) - 2);
    fclose(file);
    return text;
}

static void put_replaced(FILE *file, const char *text, const char *what, const char *with)
{
    const char *at = strstr(text, what);
    assert_non_null(at);
    fprintf(file, "%.*s%s", (int)(at - text), text, with);
    fputs(at + strlen(what), file);
}

enum { LOST_WORD = 63 }; /* of the counters: nobody else's */

/* A copy of the shaders in which a voxel that finds a word locked looks no second time, and is counted. */
static void copy_impatient_shaders(char folder[32])
{
    char command[512], path[256];
    strcpy(folder, "/tmp/kandil_takes_XXXXXX");
    assert_non_null(mkdtemp(folder));
    snprintf(command, sizeof command, "cp -r '%s/shaders' '%s'", KD_SOURCE_DIR, folder);
    assert_int_equal(system(command), 0);
    snprintf(path, sizeof path, "%s/shaders/svo/taken_add.comp", folder);
    char *text = read_text(path), *half = calloc(1, 1 << 17);
    assert_non_null(half);
    FILE *memory = fmemopen(half, 1 << 17, "w"), *file;
    assert_non_null(memory);
    put_replaced(memory, text, "KD_TAKE_TRIES 64u", "KD_TAKE_TRIES 1u");
    fclose(memory);
    file = fopen(path, "wb");
    assert_non_null(file);
    put_replaced(file, half, "counters[KD_COUNT_LEFT] = 1u;",
                 "{ counters[KD_COUNT_LEFT] = 1u; atomicAdd(counters[63], 1u); }");
    fclose(file);
    free(text);
    free(half);
}

/* Sixteen voxels in a row want the same new nodes at once: without patience thousands lose, and further
 * passes bring every one of them in. */
static void voxels_that_lose_a_lock_come_in_later(void **state)
{
    static const uint32_t leaf_levels[] = {8, 9};
    char folder[32], command[64];
    (void)state;
    copy_impatient_shaders(folder);
    assert_int_equal(setenv("KANDIL_SHADER_DIR", folder, 1), 0);
    for (int i = 0; i < 2; i++) {
        uint32_t lost = 0;
        cloud crowd = make_cloud(leaf_levels[i], 20000, 200, 29);
        for (uint32_t n = 0; n < crowd.count; n++)
            crowd.voxels[n][0] = crowd.voxels[n / 16 * 16][0];
        tree_case t = open_case(KD_SVO_BUILD_ATOMIC, 0, crowd);
        kd_gpu_read_buffer(voxel_gpu, voxel_svo(&t.v)->counters, LOST_WORD * 4, &lost, sizeof lost);
        assert_true(lost > 100);
        assert_whole(&t);
        close_case(&t);
    }
    assert_int_equal(unsetenv("KANDIL_SHADER_DIR"), 0);
    snprintf(command, sizeof command, "rm -r '%s'", folder);
    assert_int_equal(system(command), 0);
}

/* Segments of few voxels: their chains are longer than what a software driver binds. */
static void chains_in_rounds_are_the_same(void **state)
{
    (void)state;
    tree_case t = open_case(KD_SVO_BUILD_ORDERFREE, 0, make_cloud_in(8, 13000, 120, 9, 3));
    assert_true((uint64_t)t.c.slots * KD_SEGMENT_VOXELS * 32 > 128ull << 20);
    assert_whole(&t);
    close_case(&t);
}

/* ---- too little room ---- */

static uint32_t count_text(const char *text, const char *what)
{
    uint32_t n = 0;
    for (const char *at = text; (at = strstr(at, what)) != NULL; at++)
        n++;
    return n;
}

/* With arrays of 1 MiB there are some 16000 nodes a level, of which the cloud wants three times as many. tree_read
 * checks that index, nodes, codes and free numbers belong together. */
static void keeps_what_has_room(uint32_t build)
{
    tree_case t = open_case(build, 1, make_cloud(8, 24000, 256, 5));
    for (int i = 0; i < 2; i++) {
        tree_copy copy = tree_read(&t.v);
        uint32_t top = copy.levels - 1, left_out = 0;
        assert_in_range(copy.capacity, 16000, 16384);
        assert_true(t.r.node_count[top] > 2 * copy.capacity);
        assert_int_equal(copy.count[top], copy.capacity);
        for (uint32_t l = 0; l < copy.levels; l++)
            for (uint32_t w = 0; w < copy.words[l]; w++)
                left_out |= copy.masks[l][w] & ~t.r.level_masks[l][w];
        assert_int_equal(left_out, 0); /* nothing that is not the reference's */
        assert_true(assert_cells(&t, &copy) > copy.capacity / 2);
        tree_free(&copy);
        voxel_frame(&t.v);
    }
    assert_int_equal(count_text(voxel_warnings, "octree: "), count_text(voxel_warnings, "\n"));
    assert_int_equal(count_text(voxel_warnings, "nodes"), 1);
    voxel_warnings[0] = '\0';
    close_case(&t);
}

static void atomic_without_room_keeps_a_part(void **state)
{
    (void)state, keeps_what_has_room(KD_SVO_BUILD_ATOMIC);
}
static void levels_without_room_keep_a_part(void **state)
{
    (void)state, keeps_what_has_room(KD_SVO_BUILD_LEVELS);
}

/* ---- room that goes back ---- */

static void gives_room_back(uint32_t build)
{
    tree_case t = open_case(build, 0, make_cloud(8, 40000, 200, 3));
    const kd_svo *svo = voxel_svo(&t.v);
    const uint32_t *cells = build == KD_SVO_BUILD_ORDERFREE ? &svo->dynamic_capacity : &svo->sum_capacity;
    uint32_t nodes = svo->node_capacity, had = *cells;
    assert_whole(&t);
    free_cloud(&t.c);
    svo_reference_free(&t.r);
    t.c = make_cloud(8, 3000, 60, 4);
    assert_int_equal(svo_reference_build(&t.c.source, &t.r), KD_OK);
    put_cloud(&t.v, &t.c, &t.r);
    assert_int_equal(svo->node_capacity, nodes);
    for (int i = 0; i < GIVEN_BACK_AFTER + 2; i++)
        voxel_frame(&t.v);
    assert_true(svo->node_capacity < nodes / 2 && *cells < had / 2);
    assert_whole(&t);
    voxel_frame(&t.v);
    assert_whole(&t);
    close_case(&t);
}

static void orderfree_gives_room_back(void **state)
{
    (void)state, gives_room_back(KD_SVO_BUILD_ORDERFREE);
}
static void levels_give_room_back(void **state)
{
    (void)state, gives_room_back(KD_SVO_BUILD_LEVELS);
}

/* ---- threads ---- */

static uint64_t hash(uint64_t h, const void *data, size_t bytes)
{
    for (size_t i = 0; i < bytes; i++)
        h = (h ^ ((const uint8_t *)data)[i]) * 0x100000001B3ull; /* FNV-1a */
    return h;
}

/* One number for all bytes of a tree. */
static uint64_t hash_tree(void)
{
    tree_case t = open_case(KD_SVO_BUILD_ORDERFREE, 0, make_cloud(8, 30000, 120, 6));
    tree_copy copy = tree_read(&t.v);
    uint64_t h = 0xCBF29CE484222325ull;
    uint32_t(*cells)[8][4] =
        voxel_read(voxel_svo(&t.v)->dynamic_cells, 0, voxel_svo(&t.v)->dynamic_room * sizeof *cells);
    for (uint32_t code = 0, parent = 0; code < t.r.layer_words * 32; code++)
        if (has_bit(t.r.masks[KD_LAYER_DYNAMIC], code)) {
            parent = find_parent(&t.r, code, parent);
            h = hash(h, cells[parent][code & 7], 16);
        }
    h = hash(h, copy.index, (size_t)CASCADES * KD_DENSE * KD_DENSE * KD_DENSE * 4);
    for (uint32_t l = 0; l < copy.levels; l++) {
        h = hash(h, copy.numbers[l], (size_t)copy.count[l] * 4);
        h = hash(h, copy.masks[l], (size_t)copy.words[l] * 4);
    }
    h = hash(h, copy.nodes, (size_t)copy.count[0] * 32);
    free(cells);
    tree_free(&copy);
    close_case(&t);
    return h;
}

/* The driver takes its number of threads from the environment when a process starts to use it. */
static uint64_t hash_with_threads(const char *threads)
{
    char path[512], command[640];
    ssize_t length = readlink("/proc/self/exe", path, sizeof path - 1);
    assert_true(length > 0);
    path[length] = '\0';
    snprintf(command, sizeof command, "LP_NUM_THREADS=%s '%s' --hash", threads, path);
    FILE *pipe = popen(command, "r");
    unsigned long long h = 0;
    assert_non_null(pipe);
    assert_int_equal(fscanf(pipe, "tree %llx", &h), 1);
    assert_int_equal(pclose(pipe), 0);
    return h;
}

static void orderfree_is_the_same_on_any_number_of_threads(void **state)
{
    (void)state;
    uint64_t one = hash_with_threads("1");
    assert_true(one == hash_with_threads("2"));
    assert_true(one == hash_with_threads("4"));
}

int main(int argc, char **argv)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(orderfree_makes_the_reference),
        cmocka_unit_test(atomic_makes_the_reference),
        cmocka_unit_test(voxels_that_lose_a_lock_come_in_later),
        cmocka_unit_test(levels_make_the_reference),
        cmocka_unit_test(chains_in_rounds_are_the_same),
        cmocka_unit_test(atomic_without_room_keeps_a_part),
        cmocka_unit_test(levels_without_room_keep_a_part),
        cmocka_unit_test(orderfree_gives_room_back),
        cmocka_unit_test(levels_give_room_back),
        cmocka_unit_test(orderfree_is_the_same_on_any_number_of_threads),
    };
    if (argc == 2 && strcmp(argv[1], "--hash") == 0) {
        voxel_group_setup(NULL);
        printf("tree %llx\n", (unsigned long long)hash_tree());
        return voxel_group_teardown(NULL);
    }
    return VOXEL_GROUP(tests);
}
