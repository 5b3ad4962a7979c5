/* A voxel file cut at every length and with every byte spoilt is refused for a reason, and what can be read
 * of it is sound. Each try stands in a fresh allocation of its exact size, so that a sanitizer sees any read
 * beyond it. */

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>
#include <xxhash.h>

#include "runtime/asset/voxel_layout.h"

enum { COUNT = 200 };

typedef struct voxels {
    uint32_t shape[COUNT][2], color[COUNT], binding[COUNT][3];
} voxels;

static kd_voxel_words words_of(voxels *v, bool binds)
{
    return (kd_voxel_words){v->shape[0], v->color, binds ? v->binding[0] : NULL};
}

static voxels make_voxels(void)
{
    voxels v;
    uint64_t place = 0;
    const uint32_t size[3] = {8, 9, 10};
    for (uint32_t i = 0; i < COUNT;
         i++, place += 1 + i % 3) { /* of 720 cells, in four blocks of 512 places */
        while (!voxel_place_cell(size, place, &v.shape[i][0]))
            place++;
        assert_int_equal(voxel_cell_place(size, v.shape[i][0]), place);
        v.shape[i][1] = i * 0x9E3779B9u;
        v.color[i] = 0x1000000u | i * 77u;
        for (uint32_t k = 0; k < 3; k++)
            v.binding[i][k] = i * (k + 1) * 0x85EBCA6Bu;
    }
    return v;
}

/* Two levels, one with bindings. */
static void *make_file(voxels *v, size_t *size)
{
    kd_voxel_writer w = {0};
    kd_voxel_words rigid = words_of(v, false), bound = words_of(v, true);
    kd_voxel_block block = {.size = {8, 9, 10}, .count = COUNT};
    assert_int_equal(kd_voxel_writer_level(&w, &(kd_voxel_level){.key = {1, 2}, .span = 0.5f}), KD_OK);
    assert_int_equal(kd_voxel_writer_block(&w, &block, &rigid), KD_OK);
    block.count = COUNT / 2;
    assert_int_equal(kd_voxel_writer_block(&w, &block, &rigid), KD_OK);
    block.count = COUNT;
    assert_int_equal(kd_voxel_writer_level(&w, &(kd_voxel_level){.key = {3, 4}, .kind = 1, .span = 0.25f}),
                     KD_OK);
    assert_int_equal(kd_voxel_writer_block(&w, &block, &bound), KD_OK);
    const void *bytes = kd_voxel_writer_finish(&w, size);
    assert_non_null(bytes);
    void *copy = malloc(*size);
    memcpy(copy, bytes, *size);
    kd_voxel_writer_fini(&w);
    return copy;
}

/* Open bytes and read every block. Returns the first failure. */
static kd_status read_all(const void *bytes, size_t size, char why[KD_VOXEL_WHY], voxels *out)
{
    kd_voxel_file file;
    kd_status status = kd_voxel_file_parse(&file, bytes, size, why);
    for (uint32_t i = 0; i < file.block_count && !status; i++) {
        uint32_t count = file.blocks[i].count;
        bool binds = kd_voxel_level_binds(&file.levels[file.blocks[i].level]);
        kd_voxel_words words = {malloc(count * 8ull), malloc(count * 4ull),
                                binds ? malloc(count * 12ull) : NULL};
        assert_true(words.shape && words.color);
        status = kd_voxel_file_read(&file, i, &words);
        if (!status && out && count == COUNT) {
            memcpy(out->shape, words.shape, sizeof out->shape);
            memcpy(out->color, words.color, sizeof out->color);
            if (binds)
                memcpy(out->binding, words.binding, sizeof out->binding);
        }
        free(words.shape);
        free(words.color);
        free(words.binding);
    }
    return status;
}

static void what_was_written_is_read(void **state)
{
    (void)state;
    voxels v = make_voxels(), out;
    size_t size;
    char why[KD_VOXEL_WHY];
    void *bytes = make_file(&v, &size);
    memset(&out, 0, sizeof out);
    assert_int_equal(read_all(bytes, size, why, &out), KD_OK);
    assert_memory_equal(&out, &v, sizeof v);
    kd_voxel_file file;
    assert_int_equal(kd_voxel_file_parse(&file, bytes, size, why), KD_OK);
    assert_ptr_equal(kd_voxel_file_find(&file, (kd_voxel_key){3, 4}), &file.levels[1]);
    assert_null(kd_voxel_file_find(&file, (kd_voxel_key){3, 5}));
    assert_int_equal(file.levels[0].voxel_count, COUNT + COUNT / 2);
    free(bytes);
}

static void every_cut_is_refused(void **state)
{
    (void)state;
    voxels v = make_voxels();
    size_t size;
    char *whole = make_file(&v, &size), why[KD_VOXEL_WHY];
    for (size_t n = 0; n < size; n++) {
        char *part = malloc(n ? n : 1);
        memcpy(part, whole, n);
        assert_int_equal(read_all(part, n, why, NULL), KD_BAD_FORMAT);
        if (!strstr(why, n ? "cut short" : "empty"))
            fail_msg("%zu bytes: %s", n, why);
        free(part);
    }
    free(whole);
}

static void every_spoilt_byte_is_noticed(void **state)
{
    (void)state;
    voxels v = make_voxels();
    size_t size;
    char *whole = make_file(&v, &size), why[KD_VOXEL_WHY];
    const voxel_header *h = (const voxel_header *)(void *)whole;
    for (size_t n = 0; n < size; n++)
        for (int bit = 0; bit < 8; bit += 7) {
            char *part = malloc(size);
            memcpy(part, whole, size);
            part[n] = (char)(part[n] ^ 1 << bit);
            kd_status status = read_all(part, size, why, NULL);
            bool padding = n < h->table_offset && n + 8 > h->table_offset;
            if (n < sizeof h->magic)
                assert_int_equal(status, KD_UNSUPPORTED);
            else if (!padding || status != KD_OK) /* bytes between the blocks and the table mean nothing */
                assert_int_equal(status, KD_BAD_FORMAT);
            free(part);
        }
    free(whole);
}

/* Checksums keep accidents out, not intentions: with checksums made right again, tables are checked for
 * sense. */
static void spoilt_tables_with_right_checksums_read_no_further_than_they_may(void **state)
{
    (void)state;
    voxels v = make_voxels();
    size_t size, refused = 0, tries = 0;
    char *whole = make_file(&v, &size), why[KD_VOXEL_WHY];
    const voxel_header *h = (const voxel_header *)(void *)whole;
    for (size_t n = 8; n < size;
         n = n == offsetof(voxel_header, table_checksum) - 1 ? h->table_offset : n + 1)
        for (int value = 0; value < 256; value += 51) {
            char *part = malloc(size);
            memcpy(part, whole, size);
            part[n] = (char)value;
            voxel_header *changed = (voxel_header *)(void *)part;
            if (n >= h->table_offset)
                changed->table_checksum = XXH64(part + h->table_offset, size - h->table_offset, 0);
            changed->header_checksum = XXH64(changed, offsetof(voxel_header, header_checksum), 0);
            refused += read_all(part, size, why, NULL) != KD_OK;
            tries++;
            free(part);
        }
    assert_true(refused > tries / 4); /* origins, keys and phases may be anything */
    free(whole);
}

static void others_are_told_apart(void **state)
{
    (void)state;
    voxels v = make_voxels();
    size_t size;
    char *bytes = make_file(&v, &size), why[KD_VOXEL_WHY];
    voxel_header *h = (voxel_header *)(void *)bytes;
    kd_voxel_file file;
    assert_int_equal(kd_voxel_file_parse(&file, "glTF....................", 24, why), KD_UNSUPPORTED);
    assert_non_null(strstr(why, "no .kvox"));
    h->version = 77;
    h->header_checksum = XXH64(h, offsetof(voxel_header, header_checksum), 0);
    assert_int_equal(kd_voxel_file_parse(&file, bytes, size, why), KD_UNSUPPORTED);
    assert_non_null(strstr(why, "version 77"));
    h->order = 0x04030201u;
    assert_int_equal(kd_voxel_file_parse(&file, bytes, size, why), KD_UNSUPPORTED);
    assert_non_null(strstr(why, "byte order"));
    free(bytes);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(what_was_written_is_read),
        cmocka_unit_test(every_cut_is_refused),
        cmocka_unit_test(every_spoilt_byte_is_noticed),
        cmocka_unit_test(spoilt_tables_with_right_checksums_read_no_further_than_they_may),
        cmocka_unit_test(others_are_told_apart),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
