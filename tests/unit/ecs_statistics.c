/* What a world says about its memory. */

#include "runtime/ecs/statistics.h"
#include "tests/unit/ecs_fixture.h"

typedef struct spark {
    uint32_t heat;
} spark;
KD_COMPONENT_DEFINE_FLAGS(spark, "spark", KD_COMPONENT_SPARSE, KD_FIELD(spark, heat, KD_U32, "K", "how hot"));

static void bytes_are_counted_by_component_archetype_and_query(void **state)
{
    (void)state;
    kd_world *w = kd_world_make();
    kd_component_statistics c;
    kd_archetype_statistics a;
    kd_query_statistics q;
    for (int i = 0; i < 100; i++) {
        kd_entity e = kd_spawn(w, KD_TAG(position));
        if (i < 10)
            kd_set(w, e, spark, {1});
        else if (i < 30)
            kd_add(w, e, velocity);
    }
    assert_int_equal(kd_component_count_memory(w, KD_ID(w, position), &c), KD_OK);
    assert_int_equal(c.entities, 100);
    assert_int_equal(c.used_bytes, 1200);
    assert_in_range(c.held_bytes, 1200, 4 * 1200);
    assert_int_equal(kd_component_count_memory(w, KD_ID(w, spark), &c), KD_OK);
    assert_int_equal(c.entities, 10);
    assert_int_equal(c.used_bytes, 40);
    assert_true(c.held_bytes >=
                40 + 10 * sizeof(kd_entity) + 4096); /* values, handles, one page of the index */
    assert_int_equal(kd_component_count_memory(w, 0, &c), KD_OUT_OF_RANGE);
    assert_int_equal(kd_component_count_memory(w, 99, &c), KD_OUT_OF_RANGE);

    assert_int_equal(kd_archetype_count(w), 3); /* nothing; position; position and velocity */
    assert_int_equal(kd_archetype_count_memory(w, 2, &a), KD_OK);
    assert_int_equal(a.components, 2);
    assert_int_equal(a.tables, 1);
    assert_int_equal(a.entities, 20);
    assert_int_equal(a.used_bytes, 20 * (8 + 12 + 12));
    assert_true(a.held_bytes > a.used_bytes && a.held_bytes < kd_world_bytes(w));
    assert_int_equal(kd_archetype_count_memory(w, 3, &a), KD_OUT_OF_RANGE);

    kd_query_desc desc = {.terms = {KD_READ(position)}, .name = "movers"};
    kd_query_make(w, &desc);
    kd_query_make(w, &desc);
    assert_int_equal(kd_world_query_count(w), 1);
    assert_int_equal(kd_query_count_memory(w, 0, &q), KD_OK);
    assert_string_equal(q.name, "movers");
    assert_int_equal(q.references, 2);
    assert_int_equal(q.tables, 2);
    assert_int_equal(kd_query_count_memory(w, 1, &q), KD_OUT_OF_RANGE);

    kd_json j = {0};
    kd_world_write_statistics(w, &j);
    assert_non_null(kd_json_text(&j));
    assert_non_null(strstr(kd_json_text(&j), "{\"name\":\"position\",\"entities\":100,\"used_bytes\":1200,"));
    assert_non_null(strstr(kd_json_text(&j), "{\"name\":\"movers\",\"references\":2,\"tables\":2,"));
    assert_non_null(strstr(kd_json_text(&j),
                           "{\"components\":[\"position\",\"velocity\"],\"tables\":1,\"entities\":20,"));
    kd_json_fini(&j);
    kd_world_destroy(w);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(bytes_are_counted_by_component_archetype_and_query),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
