/* Command buffers: what they do, in which order, and that the layout of workers does not show. */

#include <pthread.h>

#include "tests/unit/ecs_fixture.h"

static int make(void **state)
{
    *state = kd_world_make();
    return *state ? 0 : -1;
}
static int drop(void **state)
{
    kd_world_destroy(*state);
    return 0;
}

#define RECORD_SPAWN(c, ...)                                                                                 \
    kd_commands_spawn((c), (kd_value[]){__VA_ARGS__},                                                        \
                      (uint32_t)(sizeof((kd_value[]){__VA_ARGS__}) / sizeof(kd_value)))

static void commands_are_applied_by_the_merge_only(void **state)
{
    kd_world *w = *state;
    kd_commands *c = kd_world_commands(w, 0);
    kd_entity e = kd_spawn(w, KD_VAL(position, {1, 2, 3})), doomed = kd_spawn(w, KD_TAG(position));
    kd_entity made = RECORD_SPAWN(c, KD_VAL(position, {4, 5, 6}), KD_TAG(health), KD_TAG(frozen));
    kd_commands_set(c, e, KD_VAL(position, {7, 8, 9}));
    kd_commands_set(c, e, KD_TAG(health));
    kd_commands_destroy(c, doomed);
    kd_commands_set_parent(c, made, e);
    kd_commands_set_name(c, made, "made");
    assert_true(kd_world_has_commands(w));
    assert_true(kd_alive(w, doomed) && !kd_alive(w, made) && !kd_has(w, e, health));
    assert_true(kd_find(w, e, position)->x == 1);
    assert_int_equal(kd_world_merge(w), KD_OK);
    assert_false(kd_world_has_commands(w));
    assert_false(kd_alive(w, doomed));
    assert_true(kd_find(w, e, position)->x == 7);
    assert_int_equal(kd_find(w, e, health)->now, 100);
    assert_entity(kd_first_child(w, e), kd_find_named(w, "made"));
    kd_commands_remove(c, e, &health_desc);
    kd_commands_remove(c, e, &bond_desc); /* never had */
    assert_int_equal(kd_world_merge(w), KD_OK);
    assert_false(kd_has(w, e, health));
    assert_int_equal(kd_world_merge(w), KD_OK); /* nothing recorded */
}

static void pending_handle_names_the_entity_after_the_merge(void **state)
{
    kd_world *w = *state;
    kd_commands *c = kd_world_commands(w, 5);
    kd_entity made = RECORD_SPAWN(c, KD_VAL(position, {1, 2, 3}));
    kd_entity holder = RECORD_SPAWN(c, KD_VAL(bond, {made, 9})); /* inside a recorded value */
    kd_commands_set(c, made, KD_VAL(bond, {holder, 8}));         /* and both ways round */
    assert_null(kd_find(w, made, position));
    kd_world_merge(w);
    assert_true(kd_alive(w, made));
    assert_true(kd_find(w, made, position)->y == 2);
    kd_entity lasting = kd_entity_resolve(w, made);
    assert_true(lasting.generation && !kd_entity_equal(lasting, made));
    assert_entity(kd_entity_resolve(w, lasting), lasting);
    assert_entity(kd_find(w, holder, bond)->target, lasting);
    assert_entity(kd_find(w, made, bond)->target, kd_entity_resolve(w, holder));
    kd_commands_set(c, made, KD_VAL(position, {5, 5, 5})); /* recorded before the next merge that spawns */
    RECORD_SPAWN(c, KD_VAL(bond, {made, 7}));
    kd_world_merge(w);
    assert_true(kd_find(w, lasting, position)->x == 5);
    assert_false(kd_alive(w, made)); /* the pending handle is over, the lasting one is not */
    assert_true(kd_alive(w, lasting));
    uint32_t found = 0;
    kd_query *q = kd_query_make(w, &(kd_query_desc){.terms = {KD_READ(bond)}});
    for (kd_iter it = kd_query_iter(q); kd_iter_next(&it);)
        for (uint32_t i = 0; i < it.count; i++)
            found += KD_COLUMN(&it, bond, 0)[i].weight == 7 &&
                     kd_entity_equal(KD_COLUMN(&it, bond, 0)[i].target, lasting);
    assert_int_equal(found, 1);
}

static void commands_to_the_dead_do_nothing(void **state)
{
    kd_world *w = *state;
    kd_commands *c = kd_world_commands(w, 0);
    kd_entity e = kd_spawn(w, KD_TAG(position)), child = kd_spawn(w, KD_TAG(position));
    kd_commands_destroy(c, e);
    kd_commands_destroy(c, e);
    kd_commands_set(c, e, KD_VAL(position, {1, 1, 1}));
    kd_commands_remove(c, e, &position_desc);
    kd_commands_set_parent(c, child, e);
    kd_commands_set_name(c, e, "ghost");
    assert_int_equal(kd_world_merge(w), KD_OK);
    assert_int_equal(kd_entity_count(w), 1);
    assert_entity(kd_find_named(w, "ghost"), KD_NO_ENTITY);
    assert_int_equal(kd_get_depth(w, child), 0);
}

static void merge_goes_by_sort_key_then_order(void **state)
{
    kd_world *w = *state;
    kd_entity e = kd_spawn(w, KD_TAG(health));
    kd_commands *a = kd_world_commands(w, 0), *b = kd_world_commands(w, 1);
    kd_commands_key(a, 9);
    kd_commands_set(a, e, KD_VAL(health, {9, 1}));
    kd_commands_key(b, 3);
    kd_commands_set(b, e, KD_VAL(health, {3, 1}));
    kd_commands_set(b, e, KD_VAL(health, {3, 2}));
    kd_world_merge(w);
    assert_int_equal(kd_find(w, e, health)->now, 9); /* the greatest key comes last */
    kd_commands_key(a, 1);
    kd_commands_set(a, e, KD_VAL(health, {1, 1}));
    kd_commands_set(a, e, KD_VAL(health, {1, 2}));
    kd_world_merge(w);
    assert_int_equal(kd_find(w, e, health)->most, 2); /* then the last recorded */
    kd_commands_set(a, e, KD_VAL(health, {0, 7}));
    kd_commands_key(a, 5);
    kd_commands_set(a, e, KD_VAL(health, {5, 5}));
    kd_commands_key(a, 4);
    kd_commands_set(a, e, KD_VAL(health, {4, 4}));
    kd_world_merge(w);
    assert_int_equal(kd_find(w, e, health)->now,
                     5); /* keys that fall are sorted too; a merge resets the key to 0 */
}

/* What job `key` records: the same whichever worker runs it. */
static void record_job(kd_commands *c, uint64_t key, const kd_entity *known, uint32_t known_count)
{
    uint64_t random = key * 7919 + 1;
    kd_commands_key(c, key);
    uint32_t n = random_below(&random, 6);
    for (uint32_t i = 0; i < n; i++) {
        kd_entity e = known[random_below(&random, known_count)];
        switch (random_below(&random, 7)) {
        case 0: kd_commands_destroy(c, e); break;
        case 1: kd_commands_set(c, e, KD_VAL(position, {(float)key, (float)i, 0})); break;
        case 2: kd_commands_remove(c, e, &position_desc); break;
        case 3: kd_commands_set(c, e, KD_TAG(frozen)); break;
        case 4: kd_commands_set_parent(c, e, known[random_below(&random, known_count)]); break;
        default: {
            kd_entity made = RECORD_SPAWN(c, KD_VAL(position, {(float)key, 0, 0}), KD_VAL(bond, {e, i}));
            kd_commands_set_parent(c, made, e);
            kd_commands_set(c, e, KD_VAL(bond, {made, i}));
        }
        }
    }
}

/* The jobs record circles, too. */
static kd_status merge_quietly(kd_world *w)
{
    kd_log_set_sink(silent, NULL);
    kd_status status = kd_world_merge(w);
    kd_log_set_sink(NULL, NULL);
    assert_true(status == KD_OK || status == KD_OUT_OF_RANGE);
    return status;
}

static uint32_t list_entities(kd_world *w, kd_entity *out, uint32_t capacity)
{
    uint32_t count = 0;
    kd_query *q = kd_query_make(w, &(kd_query_desc){0});
    for (kd_iter it = kd_query_iter(q); kd_iter_next(&it);)
        for (uint32_t i = 0; i < it.count && count < capacity; i++)
            out[count++] = it.entities[i];
    kd_query_destroy(q);
    return count;
}

static void worker_layout_does_not_show(void **state)
{
    kd_world *one = *state;
    static kd_entity known[4096];
    for (uint32_t workers = 2; workers <= KD_MAX_WORKERS; workers *= 2) {
        kd_world *many = kd_world_make(), *single = kd_world_make();
        uint64_t random = workers;
        for (int i = 0; i < 50; i++) {
            kd_spawn(single, KD_TAG(position));
            kd_spawn(many, KD_TAG(position));
        }
        for (uint64_t frame = 0; frame < 12; frame++) {
            uint32_t count = list_entities(single, known, 4096);
            for (uint64_t job = 0; job < 40 && count; job++)
                record_job(kd_world_commands(single, 0), frame * 40 + job, known, count);
            for (uint64_t job = 40; job-- > 0 && count;) /* another order, other workers */
                record_job(kd_world_commands(many, random_below(&random, workers)), frame * 40 + job, known,
                           count);
            assert_int_equal(merge_quietly(single), merge_quietly(many));
            assert_true(kd_world_checksum(single) == kd_world_checksum(many));
        }
        assert_true(kd_entity_count(single) > 10);
        kd_world_destroy(single);
        kd_world_destroy(many);
    }
    (void)one;
}

/* ---- recorded on real threads ---- */
typedef struct recorder {
    kd_world *w;
    const kd_entity *known;
    uint32_t count, worker, workers;
    uint64_t frame;
} recorder;

static void *record_share(void *user)
{
    const recorder *r = user;
    for (uint64_t job = r->worker; job < 200; job += r->workers)
        record_job(kd_world_commands(r->w, r->worker), r->frame * 200 + job, r->known, r->count);
    return NULL;
}

static void threads_record_side_by_side(void **state)
{
    kd_world *w = *state, *single = kd_world_make();
    enum { WORKERS = 4 };
    static kd_entity known[4096];
    for (int i = 0; i < 200; i++) {
        kd_spawn(w, KD_TAG(health));
        kd_spawn(single, KD_TAG(health));
    }
    for (uint64_t frame = 0; frame < 5; frame++) {
        pthread_t threads[WORKERS];
        recorder r[WORKERS];
        uint32_t count = list_entities(single, known, 4096);
        for (uint32_t i = 0; i < WORKERS; i++) {
            r[i] = (recorder){w, known, count, i, WORKERS, frame};
            assert_int_equal(pthread_create(&threads[i], NULL, record_share, &r[i]), 0);
        }
        for (uint32_t i = 0; i < WORKERS; i++)
            pthread_join(threads[i], NULL);
        record_share(&(recorder){single, known, count, 0, 1, frame});
        assert_int_equal(merge_quietly(single), merge_quietly(w));
        assert_true(kd_world_checksum(w) == kd_world_checksum(single));
    }
    kd_world_destroy(single);
}

static void commands_may_be_recorded_while_iterating(void **state)
{
    kd_world *w = *state;
    kd_query *q = kd_query_make(w, &(kd_query_desc){.terms = {KD_WRITE(health)}});
    for (int i = 0; i < 1000; i++)
        kd_spawn(w, KD_VAL(health, {i, 0}));
    kd_commands *c = kd_world_commands(w, 0);
    uint32_t rows = 0;
    for (kd_iter it = kd_query_iter(q); kd_iter_next(&it);) {
        health *h = KD_COLUMN_MUT(&it, health, 0);
        for (uint32_t i = 0; i < it.count; i++, rows++) {
            if (h[i].now % 3 == 0)
                kd_commands_destroy(c, it.entities[i]);
            else if (h[i].now % 3 == 1)
                kd_commands_set(c, it.entities[i], KD_TAG(frozen));
            else
                RECORD_SPAWN(c, KD_VAL(health, {-1, 0}));
        }
    }
    assert_int_equal(rows, 1000);
    assert_int_equal(kd_world_merge(w), KD_OK);
    assert_int_equal(kd_entity_count(w), 1000 - 334 + 333); /* multiples of 3 below 1000: 334; 3k+2: 333 */
    kd_query *stiff = kd_query_make(w, &(kd_query_desc){.terms = {KD_WITH(frozen)}});
    assert_int_equal(kd_query_count(stiff), 333);
}

/* Some rows of 20 get a component: each under a key of its own or all under one. */
static uint64_t added_to_rows(uint32_t first, uint32_t count, bool own_keys)
{
    kd_world *w = kd_world_make();
    kd_entity e[20];
    for (int i = 0; i < 20; i++)
        e[i] = kd_spawn(w, KD_VAL(health, {i, 20}));
    kd_commands *c = kd_world_commands(w, 0);
    for (uint32_t i = 0; i < count; i++) {
        kd_commands_key(c, own_keys ? i + 1 : 1);
        kd_commands_set(c, e[first + i], KD_VAL(position, {(float)i, 0, 0}));
    }
    assert_int_equal(kd_world_merge(w), KD_OK);
    uint64_t checksum = kd_world_checksum(w);
    kd_world_destroy(w);
    return checksum;
}

/* Keys depend on how a loop was shared among workers: nothing may depend on which rows move together. */
static void rows_lie_the_same_whether_they_moved_together_or_not(void **state)
{
    (void)state;
    for (uint32_t first = 0; first < 20; first++)
        for (uint32_t count = 1; count <= 20 - first; count++)
            assert_true(added_to_rows(first, count, false) == added_to_rows(first, count, true));
}

static void neighbouring_rows_are_changed_together(void **state)
{
    kd_world *w = *state;
    enum { N = 1000, FIRST = 300, END = 700 };
    static kd_entity e[N];
    kd_entity root = kd_spawn(w, KD_TAG(frozen));
    kd_query *q = kd_query_make(w, &(kd_query_desc){.terms = {KD_READ(position)}});
    kd_commands *c = kd_world_commands(w, 0);
    for (int i = 0; i < N; i++)
        e[i] =
            kd_spawn_child(w, root, KD_VAL(position, {(float)i, 0, 0}), KD_VAL(velocity, {0, (float)i, 0}));
    for (kd_iter it = kd_query_iter(q); kd_iter_next(&it);)
        for (uint32_t i = FIRST; i < END; i++)
            kd_commands_set(c, it.entities[i], KD_VAL(health, {(int32_t)i, 1}));
    uint64_t since = kd_world_version(w);
    assert_int_equal(kd_world_merge(w), KD_OK);
    for (int i = 0; i < N; i++) {
        assert_true(kd_find(w, e[i], position)->x == (float)i && kd_find(w, e[i], velocity)->y == (float)i);
        assert_int_equal(kd_has(w, e[i], health), i >= FIRST && i < END);
        assert_true(!kd_has(w, e[i], health) || kd_find(w, e[i], health)->now == i);
        assert_entity(kd_get_parent(w, e[i]), root);
        kd_find_mut(w, e[i], position)->z = 1; /* every record leads to its own row */
    }
    uint32_t rows = 0;
    for (kd_iter it = kd_query_iter(q); kd_iter_next(&it); rows += it.count)
        for (uint32_t i = 0; i < it.count; i++)
            assert_true(KD_COLUMN(&it, position, 0)[i].z == 1);
    assert_int_equal(rows, N);
    kd_query *with = kd_query_make(w, &(kd_query_desc){.terms = {KD_READ(health)}});
    kd_iter it = kd_query_iter(with);
    it.changed_since = since;
    assert_true(kd_iter_next(&it));
    assert_int_equal(it.count, END - FIRST);
}

static void recording_out_of_memory_is_told_by_the_merge(void **state)
{
    kd_world *w = *state;
    kd_commands *c = kd_world_commands(w, 0);
    kd_entity e = kd_spawn(w, KD_TAG(health));
    kd_world_limit_bytes(w, kd_world_bytes(w) + 4096);
    uint32_t recorded = 0;
    while (RECORD_SPAWN(c, KD_VAL(position, {1, 2, 3})).generation)
        recorded++;
    assert_in_range(recorded, 1, 4096 / 16);
    kd_world_limit_bytes(w, 0);
    assert_int_equal(kd_world_merge(w), KD_NO_MEMORY);
    assert_int_equal(kd_entity_count(w), recorded + 1); /* what was recorded is there */
    kd_commands_set(c, e, KD_VAL(health, {1, 1}));
    assert_int_equal(kd_world_merge(w), KD_OK);
}

static void what_a_recorded_value_owns_is_released_once(void **state)
{
    kd_world *w = *state, *other = kd_world_make();
    kd_commands *c = kd_world_commands(w, 0), *unmerged = kd_world_commands(other, 3);
    kd_entity dead = kd_spawn(w, KD_TAG(position)), living = kd_spawn(w, KD_TAG(position));
    owner_releases = 0;
    kd_destroy(w, dead);
    assert_int_equal(kd_commands_set(c, dead, KD_VAL(owner, {owned(1)})), KD_OK);
    kd_commands_set(c, living, KD_VAL(owner, {owned(2)}));
    kd_commands_set(c, living, KD_VAL(owner, {owned(3)})); /* takes the place of the first */
    kd_entity e = RECORD_SPAWN(c, KD_VAL(owner, {owned(4)}));
    assert_int_equal(kd_world_merge(w), KD_OK);
    assert_int_equal(owner_releases, 2);
    assert_int_equal(*kd_find(w, living, owner)->memory, 3);
    assert_int_equal(*kd_find(w, e, owner)->memory, 4);
    kd_commands_set(unmerged, kd_spawn(other, KD_TAG(position)), KD_VAL(owner, {owned(5)}));
    RECORD_SPAWN(unmerged, KD_VAL(position, {1, 2, 3}), KD_VAL(owner, {owned(6)}));
    kd_world_destroy(other); /* nobody merged these */
    assert_int_equal(owner_releases, 4);
}

typedef struct wide {
    _Alignas(64) int *memory;
} wide;
typedef struct huge { /* more than a stack should hold */
    _Alignas(64) int *memory;
    uint8_t rest[4096];
} huge;
static int misaligned;
static void wide_release(void *value, void *user)
{
    (void)user;
    misaligned += (uintptr_t)value % 64 != 0;
    free(*(int **)value);
    owner_releases++;
}
static const kd_component_desc wide_desc = {
    .name = "wide", .size = sizeof(wide), .align = _Alignof(wide), .on_remove = wide_release};
static const kd_component_desc huge_desc = {
    .name = "huge", .size = sizeof(huge), .align = _Alignof(huge), .on_remove = wide_release};

static void hooks_of_recorded_values_see_them_aligned(void **state)
{
    kd_world *w = *state, *other = kd_world_make();
    kd_commands *c = kd_world_commands(w, 0), *unmerged = kd_world_commands(other, 0);
    kd_entity dead = kd_spawn(w, KD_TAG(position));
    kd_destroy(w, dead);
    owner_releases = misaligned = 0;
    for (int i = 0; i < 8; i++) { /* a tag more before each: other addresses */
        kd_value values[10] = {KD_VAL(wide, {owned(1)}), KD_VAL(huge, {owned(2), {0}})};
        kd_commands_set(c, dead, KD_VAL(wide, {owned(3)}));
        kd_commands_set(c, dead, KD_VAL(huge, {owned(4), {0}}));
        for (int k = 0; k < i; k++)
            kd_commands_destroy(unmerged, dead);
        kd_commands_spawn(unmerged, values, 2);
    }
    assert_int_equal(kd_world_merge(w), KD_OK);
    assert_int_equal(owner_releases, 16);
    kd_world_destroy(other);
    assert_int_equal(owner_releases, 32);
    assert_int_equal(misaligned, 0);
}

static int messages;
static char last_message[512];
static void keep_message(void *user, kd_log_level level, const char *text)
{
    (void)user, (void)level;
    messages++;
    snprintf(last_message, sizeof last_message, "%s", text);
}

static void a_circle_is_told_by_the_merge(void **state)
{
    kd_world *w = *state;
    kd_commands *c = kd_world_commands(w, 0);
    kd_entity a = kd_spawn(w, KD_TAG(position)), b = kd_spawn_child(w, a, KD_TAG(position));
    kd_commands_set_parent(c, a, b);
    kd_commands_set_parent(c, a, a);
    kd_commands_set(c, b, KD_VAL(health, {4, 5}));
    kd_commands_destroy(c, KD_NO_ENTITY); /* does nothing, as ever */
    messages = 0;
    kd_log_set_sink(keep_message, NULL);
    assert_int_equal(kd_world_merge(w), kd_set_parent(w, a, b));
    kd_log_set_sink(NULL, NULL);
    assert_int_equal(messages, 1);
    assert_non_null(strstr(last_message, "entity 0 cannot hang below entity 1"));
    assert_int_equal(kd_set_parent(w, a, b), KD_OUT_OF_RANGE);
    assert_entity(kd_get_parent(w, b), a);
    assert_int_equal(kd_find(w, b, health)->now, 4); /* the rest is applied */
    assert_int_equal(kd_world_merge(w), KD_OK);
}

static void a_description_that_clashes_is_told_by_the_merge(void **state)
{
    kd_world *w = *state;
    static const kd_component_desc clash = {.name = "health", .size = 3, .align = 1};
    kd_commands *c = kd_world_commands(w, 0);
    kd_entity e = kd_spawn(w, KD_TAG(health));
    kd_log_set_sink(keep_message, NULL);
    const kd_status direct = kd_set_value(w, e, (kd_value){&clash, "ab"});
    assert_int_equal(direct, KD_BAD_FORMAT);
    assert_int_equal(kd_spawn_n(w, 1, (const kd_component_desc *const[]){&clash}, NULL, 1, NULL), direct);
    for (int way = 0; way < 4; way++) {
        if (way == 0)
            assert_int_equal(kd_commands_set(c, e, (kd_value){&clash, "ab"}), direct);
        else if (way == 1)
            assert_int_equal(kd_commands_spawn(c, (kd_value[]){{&clash, "ab"}}, 1).generation, 0);
        else if (way == 2)
            kd_commands_remove(c, e, &clash);
        else
            kd_commands_enable(c, e, &clash, true);
        assert_int_equal(kd_world_merge(w), direct);
        assert_non_null(strstr(last_message, "described twice"));
        assert_int_equal(kd_world_merge(w), KD_OK);
    }
    kd_log_set_sink(NULL, NULL);
    assert_int_equal(kd_entity_count(w), 1);
}

int main(void)
{
#define CASE(test) cmocka_unit_test_setup_teardown(test, make, drop)
    const struct CMUnitTest tests[] = {
        CASE(commands_are_applied_by_the_merge_only),
        CASE(pending_handle_names_the_entity_after_the_merge),
        CASE(commands_to_the_dead_do_nothing),
        CASE(merge_goes_by_sort_key_then_order),
        CASE(worker_layout_does_not_show),
        CASE(threads_record_side_by_side),
        CASE(commands_may_be_recorded_while_iterating),
        CASE(neighbouring_rows_are_changed_together),
        CASE(rows_lie_the_same_whether_they_moved_together_or_not),
        CASE(recording_out_of_memory_is_told_by_the_merge),
        CASE(what_a_recorded_value_owns_is_released_once),
        CASE(hooks_of_recorded_values_see_them_aligned),
        CASE(a_circle_is_told_by_the_merge),
        CASE(a_description_that_clashes_is_told_by_the_merge),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
