/* Paths of names: what is written is found again, whatever characters the names have. */

#include "runtime/ecs/path.h"
#include "tests/unit/ecs_fixture.h"

static kd_entity named(kd_world *w, kd_entity parent, const char *name)
{
    kd_entity e = parent.generation ? kd_spawn_child(w, parent, KD_TAG(frozen)) : kd_spawn(w, KD_TAG(frozen));
    assert_int_equal(kd_set_name(w, e, name), KD_OK);
    return e;
}

static void assert_path(const kd_world *w, kd_entity e, const char *expected)
{
    char text[64];
    assert_int_equal(kd_entity_path(w, e, text, sizeof text), strlen(expected));
    assert_string_equal(text, expected);
}

static void a_path_leads_where_it_came_from(void **state)
{
    (void)state;
    kd_world *w = kd_world_make();
    kd_entity ship = named(w, KD_NO_ENTITY, "ship"), gun = named(w, ship, "gun"),
              barrel = named(w, gun, "big barrel");
    assert_path(w, ship, "ship");
    assert_path(w, barrel, "ship/gun/big barrel");
    assert_entity(kd_find_path(w, KD_NO_ENTITY, "ship/gun/big barrel"), barrel);
    assert_entity(kd_find_path(w, KD_NO_ENTITY, "ship"), ship);
    assert_entity(kd_find_path(w, ship, "gun/big barrel"), barrel);
    assert_entity(kd_find_path(w, gun, "big barrel"), barrel);
    kd_set_parent(w, gun, KD_NO_ENTITY);
    assert_path(w, barrel, "gun/big barrel");
    assert_int_equal(kd_find_path(w, ship, "gun").generation, 0);
    kd_world_destroy(w);
}

static void what_is_not_there_is_not_found(void **state)
{
    (void)state;
    static const char *const wrong[] = {"",  "/",   "a/",    "/a",  "a//b", "a/b/", "b",  "a/a",
                                        "A", "a/c", "a\\/b", "a\\", "ab",   "a/bb", "\\", "a/b/c"};
    kd_world *w = kd_world_make();
    assert_int_equal(kd_find_path(w, KD_NO_ENTITY, "a").generation, 0); /* nobody has any name */
    kd_entity a = named(w, KD_NO_ENTITY, "a"), b = named(w, a, "b"), c = kd_spawn_child(w, b, KD_TAG(frozen));
    for (size_t i = 0; i < sizeof wrong / sizeof *wrong; i++)
        assert_int_equal(kd_find_path(w, KD_NO_ENTITY, wrong[i]).generation, 0);
    assert_int_equal(kd_find_path(w, KD_NO_ENTITY, NULL).generation, 0);
    assert_path(w, c, ""); /* no name */
    kd_set_name(w, c, "c");
    assert_path(w, c, "a/b/c");
    kd_set_name(w, b, NULL);
    assert_path(w, c, "");
    kd_destroy(w, a);
    assert_path(w, c, "");
    assert_int_equal(kd_find_path(w, a, "b").generation, 0);
    kd_world_destroy(w);
}

static void the_first_of_equal_siblings_is_meant(void **state)
{
    (void)state;
    kd_world *w = kd_world_make();
    kd_entity root = named(w, KD_NO_ENTITY, "root"), one = named(w, root, "x"), two = named(w, root, "x");
    assert_entity(kd_find_path(w, root, "x"), one);
    kd_set_parent(w, one, KD_NO_ENTITY);
    kd_set_parent(w, one, root); /* it comes last now */
    assert_entity(kd_find_path(w, root, "x"), two);
    assert_int_equal(kd_find_path(w, KD_NO_ENTITY, "x").generation, 0); /* both are children */
    kd_entity a = named(w, KD_NO_ENTITY, "y"), b = named(w, KD_NO_ENTITY, "x"),
              c = named(w, KD_NO_ENTITY, "x");
    kd_set_name(w, a, "x");
    assert_entity(kd_find_path(w, KD_NO_ENTITY, "x"), b);
    kd_destroy(w, b);
    assert_entity(kd_find_path(w, KD_NO_ENTITY, "x"), c); /* a was named later */
    kd_world_destroy(w);
}

static void a_text_that_is_too_short_is_cut(void **state)
{
    (void)state;
    kd_world *w = kd_world_make();
    kd_entity a = named(w, KD_NO_ENTITY, "a\\b"), b = named(w, a, "c/d");
    const char whole[] = "a\\\\b/c\\/d";
    for (size_t size = 0; size <= sizeof whole + 2; size++) {
        char *text = malloc(size + 1);
        assert_non_null(text);
        text[size] = 'x';
        assert_int_equal(kd_entity_path(w, b, size ? text : NULL, size), sizeof whole - 1);
        size_t shown = size < sizeof whole ? size : sizeof whole;
        assert_true(!size || (memcmp(text, whole, shown - 1) == 0 && !text[shown - 1]));
        assert_int_equal(text[size], 'x');
        free(text);
    }
    assert_entity(kd_find_path(w, KD_NO_ENTITY, whole), b);
    kd_world_destroy(w);
}

/* Names of the worst characters, in a chain. */
static void random_names_come_back(void **state)
{
    (void)state;
    static const char letters[] = "/\\ab";
    uint64_t random = 9;
    for (int round = 0; round < 300; round++) {
        kd_world *w = kd_world_make();
        kd_entity at = KD_NO_ENTITY;
        for (uint32_t depth = 0; depth < 5; depth++) {
            char name[8] = {0};
            for (uint32_t i = 0; i < 1 + random_below(&random, 5); i++)
                name[i] = letters[random_below(&random, 4)];
            if (!*name)
                name[0] = 'a';
            at = named(w, at, name);
            char text[128];
            assert_true(kd_entity_path(w, at, text, sizeof text) < sizeof text);
            assert_entity(kd_find_path(w, KD_NO_ENTITY, text), at);
        }
        kd_world_destroy(w);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_path_leads_where_it_came_from),
        cmocka_unit_test(what_is_not_there_is_not_found),
        cmocka_unit_test(the_first_of_equal_siblings_is_meant),
        cmocka_unit_test(a_text_that_is_too_short_is_cut),
        cmocka_unit_test(random_names_come_back),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
