/* Snapshots of related entities with bytes that are wrong under a checksum that is right: refused, or
 * restored to a world in which everything agrees. KANDIL_SLOW=1 tries more. */

#define XXH_INLINE_ALL
#include <xxhash.h>

#include "runtime/ecs/snapshot.h"
#include "runtime/ecs/snapshot_format.h"
#include "tests/relation_fixture.h"

static bool slow(void)
{
    return getenv("KANDIL_SLOW") && *getenv("KANDIL_SLOW") == '1';
}

/* Bytes that are wrong but bear a right checksum: refused, or a world in which everything agrees. */
static void hostile_pairs_never_break_a_world(void **state)
{
    (void)state;
    kd_entity e[24];
    kd_world *w = related_world(e, 24), *victim = kd_world_make();
    kd_snapshot s = {0};
    uint64_t random = 5;
    uint32_t restored = 0, refused = 0;
    register_relations(victim);
    kd_spawn(victim, KD_TAG(position));
    assert_int_equal(kd_snapshot_write(w, &s), KD_OK);
    kd_log_set_sink(silent, NULL);
    uint8_t *bytes = malloc(s.size);
    assert_non_null(bytes);
    const uint8_t values[] = {0, 1, 2, 23, 24, 0x7f, 0x80, 0xff};
    for (uint32_t round = 0; round < (slow() ? 100000u : 5000u); round++) {
        memcpy(bytes, s.data, s.size);
        /* relations lie at the end: the last third is hit most */
        size_t from = round % 4 ? s.size - s.size / 3 : sizeof(snapshot_header);
        for (uint32_t k = 0; k < 1 + round % 3; k++)
            bytes[from + random_u32(&random) % (s.size - from)] = values[random_below(&random, 8)];
        uint64_t checksum = XXH3_64bits(bytes + SNAPSHOT_HASHED, s.size - SNAPSHOT_HASHED);
        memcpy(bytes + offsetof(snapshot_header, checksum), &checksum, sizeof checksum);
        kd_status status = kd_snapshot_restore(victim, bytes, s.size);
        *(status ? &refused : &restored) += 1;
        if (!status)
            assert_int_equal(kd_world_validate(victim), KD_OK);
    }
    assert_true(refused > 500 && restored > 500);
    assert_int_equal(kd_world_validate(victim), KD_OK);
    kd_log_set_sink(NULL, NULL);
    free(bytes);
    kd_snapshot_fini(&s);
    kd_world_destroy(w);
    kd_world_destroy(victim);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(hostile_pairs_never_break_a_world),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
