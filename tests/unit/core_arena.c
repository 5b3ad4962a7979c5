#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

#include "runtime/core/arena.h"

static void alloc_gives_aligned_zeroed_bytes(void **state)
{
    (void)state;
    kd_arena arena = {0};
    for (size_t size = 0; size < 300; size += 7) {
        unsigned char *p = kd_arena_alloc(&arena, size);
        assert_non_null(p);
        assert_int_equal((uintptr_t)p % 64, 0);
        for (size_t i = 0; i < size; i++)
            assert_int_equal(p[i], 0);
        memset(p, 0xAB, size);
    }
    kd_arena_fini(&arena);
}

static void alloc_after_reset_is_zeroed_again(void **state)
{
    (void)state;
    kd_arena arena = {0};
    memset(kd_arena_alloc(&arena, 1000), 0xFF, 1000);
    kd_arena_reset(&arena);
    assert_int_equal(arena.used_bytes, 0);
    const unsigned char *p = kd_arena_alloc(&arena, 1000);
    for (size_t i = 0; i < 1000; i++)
        assert_int_equal(p[i], 0);
    kd_arena_fini(&arena);
}

/* Equal frames get equal addresses: no block was added, for a new one would have moved an address. */
static void reset_reuses_all_blocks_without_growth(void **state)
{
    (void)state;
    kd_arena arena = {.block_bytes = 256};
    const size_t sizes[] = {100, 200, 5000, 30, 256, 1, 700};
    void *first[7];
    for (int i = 0; i < 7; i++)
        first[i] = kd_arena_alloc(&arena, sizes[i]);
    size_t used = arena.used_bytes;
    for (int frame = 0; frame < 100; frame++) {
        kd_arena_reset(&arena);
        for (int i = 0; i < 7; i++)
            assert_ptr_equal(kd_arena_alloc(&arena, sizes[i]), first[i]);
        assert_int_equal(arena.used_bytes, used);
    }
    kd_arena_fini(&arena);
}

static void alloc_never_overlaps_across_blocks(void **state)
{
    (void)state;
    kd_arena arena = {.block_bytes = 128};
    unsigned char *parts[64];
    for (int i = 0; i < 64; i++) {
        parts[i] = kd_arena_alloc(&arena, 48);
        memset(parts[i], i, 48);
    }
    for (int i = 0; i < 64; i++)
        for (int k = 0; k < 48; k++)
            assert_int_equal(parts[i][k], i);
    kd_arena_fini(&arena);
}

static void alloc_refuses_absurd_sizes(void **state)
{
    (void)state;
    kd_arena arena = {0};
    assert_null(kd_arena_alloc(&arena, SIZE_MAX));
    assert_null(kd_arena_alloc(&arena, SIZE_MAX - 63));
    assert_non_null(kd_arena_alloc(&arena, 16));
    kd_arena_fini(&arena);
}

static void printf_keeps_text_longer_than_a_block(void **state)
{
    (void)state;
    kd_arena arena = {.block_bytes = 64};
    char *text = kd_arena_printf(&arena, "%0200d-%s", 7, "end");
    assert_int_equal(strlen(text), 204);
    assert_string_equal(text + 199, "7-end");
    kd_arena_fini(&arena);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(alloc_gives_aligned_zeroed_bytes),
        cmocka_unit_test(alloc_after_reset_is_zeroed_again),
        cmocka_unit_test(reset_reuses_all_blocks_without_growth),
        cmocka_unit_test(alloc_never_overlaps_across_blocks),
        cmocka_unit_test(alloc_refuses_absurd_sizes),
        cmocka_unit_test(printf_keeps_text_longer_than_a_block),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
