/* `kandil bench svo --dump`: the tables read back hold what the scene has, agree with each other and with
 * --stats; failures are said and leave no index. */
#include <setjmp.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cmocka.h>

#include "tests/folder_fixture.h"

/* Rows as docs/voxel_dumps.md gives them. */
typedef struct leaf {
    uint32_t cascade;
    int32_t cell[3];
    uint32_t layers;
    float weight, albedo[3], emission[3], normal[3], depth, radiance[3], other;
} leaf;
typedef struct node {
    uint32_t level, cascade;
    int32_t cell[3];
    uint32_t number, children[8];
    float depth[6], radiance[3];
} node;
typedef struct page {
    uint32_t object, cascade;
    int32_t cell[3];
    uint32_t fraction[3];
    float centre_m[3], normal[3];
} page;

/* A box of 8 cells on the lattice, and a ball that moves between its frames; one cascade of 128^3. */
static const char scenario[] =
    "kandil.scene { size = {16, 16}, fps = 10 }\n"
    "for key, value in pairs { span = 0.05, resolution = kandil.param('resolution', 128), cascades = 2 } do\n"
    "  kandil.set('voxels.' .. key, value)\n"
    "end\n"
    "kandil.spawn { mesh = { shape = 'box', size = {0.4, 0.4, 0.4} }, material = { base_color = {0.25, 0.5, "
    "1} },\n"
    "  transform = { position = {0.2, 0.2, 0.2} } }\n"
    "kandil.spawn { light = { type = 'directional', intensity = 1 }, transform = { look_at = {0, -1, 0.1} } "
    "}\n"
    "kandil.spawn { camera = {}, transform = { position = {0, 1, 3}, look_at = {0, 0, 0} } }\n"
    "if kandil.param('ball', 1) == 1 then\n"
    "  local ball = kandil.spawn { mesh = { shape = 'sphere', size = {0.5, 0.5, 0.5} } }\n"
    "  function kandil.update(t) ball:set('transform.position', {-0.6 + 0.313 * t, 0.37, 0.2}) end\n"
    "end\n";

static int run(const char *command)
{
    int state = system(command);
    return WIFEXITED(state) ? WEXITSTATUS(state) : -1;
}

static int kandil(const char *arguments)
{
    char command[1024];
    snprintf(command, sizeof command, "'%s/kandil' %s >out 2>said", KD_BINARY_DIR, arguments);
    return run(command);
}

static char text[65536];

static const char *read_text(const char *name)
{
    FILE *file = fopen(name, "rb");
    size_t size = file ? fread(text, 1, sizeof text - 1, file) : 0;
    if (file)
        fclose(file);
    text[size] = '\0';
    return text;
}

/* All rows of a table; free() them. */
static void *read_rows(const char *name, size_t row_size, uint32_t *count)
{
    FILE *file = fopen(name, "rb");
    assert_non_null(file);
    assert_int_equal(fseek(file, 0, SEEK_END), 0);
    size_t size = (size_t)ftell(file);
    rewind(file);
    assert_int_equal(size % row_size, 0);
    void *rows = malloc(size + 1);
    assert_non_null(rows);
    assert_int_equal(fread(rows, 1, size, file), size);
    fclose(file);
    *count = (uint32_t)(size / row_size);
    return rows;
}

static uint64_t number_behind(const char *where, const char *key)
{
    const char *at = where ? strstr(where, key) : NULL;
    if (!at)
        fail_msg("%s is missing", key);
    return strtoull(at + strlen(key), NULL, 10);
}

static void write_scenario(void)
{
    FILE *file = fopen("scene.lua", "wb");
    assert_non_null(file);
    assert_int_equal(fwrite(scenario, 1, sizeof scenario - 1, file), sizeof scenario - 1);
    fclose(file);
}

/* ---- sets of cells ---- */

typedef struct cell_key {
    int32_t cascade, x, y, z;
} cell_key;

static int compare_keys(const void *a, const void *b)
{
    return memcmp(a, b, sizeof(cell_key));
}

/* Sort, and drop what is there twice. Returns how many are left. */
static uint32_t make_set(cell_key *keys, uint32_t count)
{
    uint32_t left = 0;
    qsort(keys, count, sizeof *keys, compare_keys);
    for (uint32_t i = 0; i < count; i++)
        if (!left || compare_keys(&keys[left - 1], &keys[i]) != 0)
            keys[left++] = keys[i];
    return left;
}

static void assert_same_set(const char *what, const cell_key *a, uint32_t a_count, const cell_key *b,
                            uint32_t b_count)
{
    if (a_count != b_count)
        fail_msg("%s: %u cells, expected %u", what, a_count, b_count);
    assert_memory_equal(a, b, a_count * sizeof *a);
}

static cell_key *leaf_set(const leaf *leaves, uint32_t count, uint32_t layer, uint32_t shift, uint32_t *out)
{
    cell_key *keys = malloc((count + 1) * sizeof *keys);
    uint32_t n = 0;
    assert_non_null(keys);
    for (uint32_t i = 0; i < count; i++)
        if (leaves[i].layers & layer)
            keys[n++] = (cell_key){(int32_t)leaves[i].cascade, leaves[i].cell[0] >> shift,
                                   leaves[i].cell[1] >> shift, leaves[i].cell[2] >> shift};
    *out = make_set(keys, n);
    return keys;
}

/* ---- the tests ---- */

/* Planes on a border of cells belong to the far one, so the box's shell reaches from cell 0 to cell 8: the
 * surface of 9^3 cells. */
static void leaves_are_the_cells_of_a_box(void **state)
{
    (void)state;
    uint32_t count, expected = 0;
    write_scenario();
    assert_int_equal(kandil("bench svo scene.lua --dump box --set param.ball=0"), 0);
    leaf *leaves = read_rows("box/leaves.bin", sizeof *leaves, &count);
    assert_int_equal(count, 9 * 9 * 9 - 7 * 7 * 7);
    for (uint32_t i = 0; i < count; i++) {
        const leaf *l = &leaves[i];
        bool rim = false;
        for (int k = 0; k < 3; k++) {
            assert_in_range(l->cell[k], 0, 8);
            rim |= l->cell[k] == 0 || l->cell[k] == 8;
        }
        expected += rim;
        assert_int_equal(l->layers, 1);
        assert_true(l->albedo[0] > 0.24f && l->albedo[0] < 0.26f && l->albedo[2] > 0.99f);
        assert_true(l->depth > 1.95f);
        if (l->cell[1] == 8 && l->cell[0] > 0 && l->cell[0] < 8 && l->cell[2] > 0 && l->cell[2] < 8)
            assert_true(l->normal[1] > 0.99f && l->radiance[2] > 0); /* the sun is above */
        if (l->cell[1] == 0 && l->cell[0] > 0 && l->cell[0] < 8 && l->cell[2] > 0 && l->cell[2] < 8)
            assert_true(l->normal[1] < -0.99f && l->radiance[2] == 0);
    }
    assert_int_equal(expected, count);
    assert_non_null(strstr(read_text("box/index.json"), "\"origin_cells\""));
    assert_int_equal(number_behind(text, "\"levels\": "), 1);
    free(leaves);
}

/* By hand: every corner of a voxel's block that gets 8 of 256 or more and belongs to the voxel's cascade. */
static void pages_cover_the_dynamic_leaves(void **state)
{
    (void)state;
    uint32_t leaf_count, page_count, want_count, n = 0;
    write_scenario();
    assert_int_equal(kandil("bench svo scene.lua --dump moving --frames 3 --set svo.layers=two"), 0);
    leaf *leaves = read_rows("moving/leaves.bin", sizeof *leaves, &leaf_count);
    page *pages = read_rows("moving/pages.bin", sizeof *pages, &page_count);
    cell_key *want = malloc(((size_t)page_count * 8 + 1) * sizeof *want);
    assert_non_null(want);
    assert_true(page_count > 200);
    for (uint32_t i = 0; i < page_count; i++)
        for (uint32_t k = 0; k < 8; k++) {
            uint32_t share = 1;
            int32_t cell[3];
            for (int a = 0; a < 3; a++) {
                uint32_t far = k >> a & 1u, f = pages[i].fraction[a];
                share *= far ? f : 256 - f;
                cell[a] = pages[i].cell[a] + (int32_t)far;
            }
            /* the ball is well inside the finest cascade: no border to heed */
            assert_int_equal(pages[i].cascade, 0);
            if (share >> 16 >= 8)
                want[n++] = (cell_key){0, cell[0], cell[1], cell[2]};
        }
    want_count = make_set(want, n);
    uint32_t got_count;
    cell_key *got = leaf_set(leaves, leaf_count, 2, 0, &got_count);
    assert_same_set("dynamic leaves", got, got_count, want, want_count);
    free(got);
    free(want);
    free(pages);
    free(leaves);
}

/* Every level's nodes are the cells, halved; children are the numbers of the nodes below. */
static void check_levels(const char *folder_name, uint32_t levels)
{
    char path[64];
    uint32_t leaf_count, node_count, children = 0, present[4] = {0};
    snprintf(path, sizeof path, "%s/leaves.bin", folder_name);
    leaf *leaves = read_rows(path, sizeof *leaves, &leaf_count);
    snprintf(path, sizeof path, "%s/nodes.bin", folder_name);
    node *nodes = read_rows(path, sizeof *nodes, &node_count);
    for (uint32_t l = 0; l < levels; l++) {
        cell_key *got = malloc((node_count + 1) * sizeof *got);
        uint32_t n = 0, want_count;
        assert_non_null(got);
        for (uint32_t i = 0; i < node_count; i++)
            if (nodes[i].level == l)
                got[n++] = (cell_key){(int32_t)nodes[i].cascade, nodes[i].cell[0], nodes[i].cell[1],
                                      nodes[i].cell[2]};
        cell_key *want = leaf_set(leaves, leaf_count, 3, levels - l, &want_count);
        assert_int_equal(make_set(got, n), n); /* each once */
        assert_same_set("nodes", got, n, want, want_count);
        present[l] = n;
        free(got);
        free(want);
    }
    for (uint32_t i = 0; i < node_count; i++) {
        float depths = 0;
        for (int k = 0; k < 8; k++)
            children += nodes[i].children[k] != UINT32_MAX;
        for (int k = 0; k < 6; k++)
            depths += nodes[i].depth[k];
        assert_true(depths > 0); /* something is there, seen from some side */
    }
    uint32_t below_dense = leaf_count;
    for (uint32_t l = 1; l < levels; l++)
        below_dense += present[l];
    assert_int_equal(children, below_dense);
    free(nodes);
    free(leaves);
}

static void levels_follow_from_the_leaves(void **state)
{
    (void)state;
    write_scenario();
    assert_int_equal(kandil("bench svo scene.lua --dump one_level --frames 2"), 0);
    check_levels("one_level", 1);
    assert_int_equal(kandil("bench svo scene.lua --dump two_levels --frames 2 --set param.resolution=256"),
                     0);
    check_levels("two_levels", 2);
}

/* Counts of --stats come some frames late: of a scene at rest they are the same. */
static void counts_are_those_of_stats(void **state)
{
    (void)state;
    uint32_t nodes, caches;
    write_scenario();
    assert_int_equal(kandil("bench svo scene.lua --dump still --frames 8 --set param.ball=0"), 0);
    assert_int_equal(kandil("run scene.lua --frames 8 --stats stats.json --quiet --set param.ball=0"), 0);
    free(read_rows("still/nodes.bin", sizeof(node), &nodes));
    free(read_rows("still/caches.bin", 12 * 4, &caches));
    const char *voxels = strstr(read_text("stats.json"), "\"voxels\"");
    assert_int_equal(number_behind(voxels, "\"cached\": "), caches);
    const char *cascades = strstr(voxels, "\"cascades\"");
    assert_int_equal(number_behind(cascades, "\"nodes\": "), nodes);
}

static void failures_are_said(void **state)
{
    (void)state;
    write_scenario();
    assert_int_equal(run("echo taken >taken; mkdir -p half && echo old >half/pages.bin"), 0);
    assert_int_equal(kandil("bench svo scene.lua --dump taken"), 1);
    assert_non_null(strstr(read_text("said"), "taken: is a file"));
    assert_int_equal(kandil("bench svo scene.lua --dump half"), 1);
    assert_non_null(strstr(read_text("said"), "half/pages.bin: there is a file already"));
    assert_int_not_equal(access("half/index.json", F_OK), 0);
    assert_string_equal(read_text("half/pages.bin"), "old\n");
    assert_int_equal(kandil("bench svo missing.lua --dump none"), 1);
    assert_int_not_equal(access("none", F_OK), 0);
    /* no room: files may have 8 KiB, leaves need more */
    assert_int_equal(run("trap '' XFSZ; ulimit -f 16; '" KD_BINARY_DIR
                         "/kandil' bench svo scene.lua --dump full >/dev/null 2>said"),
                     1);
    assert_non_null(strstr(read_text("said"), "full/leaves.bin"));
    assert_int_not_equal(access("full/leaves.bin", F_OK), 0);
    assert_int_not_equal(access("full/index.json", F_OK), 0);
}

static void a_second_dump_is_refused(void **state)
{
    (void)state;
    write_scenario();
    assert_int_equal(kandil("bench svo scene.lua --dump twice"), 0);
    assert_int_equal(kandil("bench svo scene.lua --dump twice"), 1);
    assert_non_null(strstr(read_text("said"), "twice/index.json: a dump is here already"));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(leaves_are_the_cells_of_a_box),
        cmocka_unit_test(pages_cover_the_dynamic_leaves),
        cmocka_unit_test(levels_follow_from_the_leaves),
        cmocka_unit_test(counts_are_those_of_stats),
        cmocka_unit_test(failures_are_said),
        cmocka_unit_test(a_second_dump_is_refused),
    };
    if (access(KD_BINARY_DIR "/kandil", X_OK) != 0)
        return 77; /* the program was not built */
    return cmocka_run_group_tests(tests, open_folder, close_folder);
}
