/* Memory of scenarios: blocks keep what they hold while they grow and shrink, are aligned, and are used
 * again. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

#include "runtime/script/pool.h"
#include "tests/script_fixture.h"

enum { BLOCKS = 300 };

static uint8_t pattern(size_t block, size_t at)
{
    return (uint8_t)(block * 31 + at * 7);
}

static void blocks_keep_what_they_hold(void **state)
{
    (void)state;
    static const size_t sizes[] = {1, 8, 16, 17, 40, 255, 256, 257, 1000, 70000, 300, 64, 3};
    script_pool pool = {0};
    uint8_t *blocks[BLOCKS] = {NULL};
    size_t size[BLOCKS] = {0};
    for (size_t turn = 0; turn < 13; turn++)
        for (size_t i = 0; i < BLOCKS; i++) {
            size_t next = sizes[(turn + i) % 13], kept = size[i] < next ? size[i] : next;
            blocks[i] = script_pool_resize(&pool, blocks[i], size[i], next);
            assert_non_null(blocks[i]);
            assert_int_equal((uintptr_t)blocks[i] % SCRIPT_POOL_STEP, 0);
            for (size_t k = 0; k < kept; k++)
                assert_int_equal(blocks[i][k], pattern(i, k));
            for (size_t k = kept; k < next; k++)
                blocks[i][k] = pattern(i, k);
            size[i] = next;
        }
    for (size_t i = 0; i < BLOCKS; i++)
        script_pool_free(&pool, blocks[i], size[i]);
    script_pool_fini(&pool);
}

static void freed_blocks_are_used_again(void **state)
{
    (void)state;
    script_pool pool = {0};
    void *a = script_pool_resize(&pool, NULL, 0, 40);
    script_pool_free(&pool, a, 40);
    assert_ptr_equal(script_pool_resize(&pool, NULL, 0, 33), a); /* the same class: 33 to 48 bytes */
    assert_ptr_not_equal(script_pool_resize(&pool, NULL, 0, 40), a);
    script_pool_free(&pool, NULL, 0);
    script_pool_fini(&pool);
}

/* What names mean is noted by their addresses: other names, other components and other spellings of a name
 * must not be taken for it. */
static void names_are_not_mixed_up(void **state)
{
    (void)state;
    kd_world *w = fixture_world();
    kd_script *script;
    assert_int_equal(
        fixture_load(w,
                     "local e = kandil.spawn{name = 'e', transform = {position = {1, 2, 3}}, light = "
                     "{intensity = 4}}\n"
                     "local f = kandil.spawn{name = 'f', transform = {position = {5, 6, 7}}}\n"
                     "for i = 1, 3 do\n"
                     "  assert(e.transform.position[1] == 1 and f.transform.position[1] == 5)\n"
                     "  assert(e.light.intensity == 4 and e.transform.scale[1] == 1)\n"
                     "  assert(e:get('transform.position.' .. 'y') == 2 and e:get('light.intensity') == 4)\n"
                     "  assert(not pcall(function() return f.light end))\n"
                     "  assert(not pcall(function() return f:get('light.intensity') end))\n"
                     "  assert(not pcall(function() return e.transform.intensity end))\n"
                     "  assert(not pcall(function() return e[('x'):rep(60)] end))\n"
                     "  for k = 1, 500 do local s = 'transform' .. k; assert(not pcall(function() return "
                     "e[s] end)) end\n"
                     "end\n",
                     &script),
        KD_OK);
    kd_script_destroy(script);
    kd_world_destroy(w);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(blocks_keep_what_they_hold),
        cmocka_unit_test(freed_blocks_are_used_again),
        cmocka_unit_test(names_are_not_mixed_up),
    };
    return cmocka_run_group_tests(tests, fixture_open, fixture_close);
}
