/* Snapshots: what comes back is what was written, in bytes, order and handles; anything else is refused with
 * one message and changes nothing. Differences name what differs. */

#define XXH_INLINE_ALL
#include <xxhash.h>

#include "runtime/ecs/snapshot.h"
#include "runtime/ecs/snapshot_format.h"
#include "runtime/ecs/system.h"
#include "tests/unit/ecs_fixture.h"

typedef enum mood { CALM, ANGRY } mood;
typedef struct creature {
    uint32_t mood;
    uint8_t asleep;
    char title[8];
    float weights[2];
} creature;
static const char *const mood_words[] = {"calm", "angry", NULL};
KD_COMPONENT_DEFINE(creature, "creature", KD_FIELD_ENUM(creature, mood, mood_words, "how it feels"),
                    KD_FIELD(creature, asleep, KD_BOOL, NULL, "does it sleep"),
                    KD_FIELD(creature, title, KD_STRING, NULL, "how it is called"),
                    KD_FIELD_ARRAY(creature, weights, KD_F32, 2, "kg", "in summer and winter"));
typedef struct spark {
    uint32_t heat;
} spark;
KD_COMPONENT_DEFINE_FLAGS(spark, "spark", KD_COMPONENT_SPARSE | KD_COMPONENT_TOGGLE,
                          KD_FIELD(spark, heat, KD_U32, "K", "how hot"));
static const kd_component_desc cache_desc = {.name = "cache",
                                             .size = sizeof(owner),
                                             .align = _Alignof(owner),
                                             .on_remove = owner_release,
                                             .flags = KD_COMPONENT_TRANSIENT};

static void register_all(kd_world *w)
{
    /* in another order than `populated` first uses them */
    const kd_component_desc *const all[] = {&creature_desc, &spark_desc,    &frozen_desc,
                                            &bond_desc,     &padded_desc,   &health_desc,
                                            &cache_desc,    &velocity_desc, &position_desc};
    for (size_t i = 0; i < sizeof all / sizeof *all; i++)
        assert_true(kd_component_ensure(w, all[i]) != 0);
}

/* A world with children, names, free handles, an emptied table and a singleton. */
static kd_world *populated(uint32_t n)
{
    kd_world *w = kd_world_make();
    kd_entity e[256], last = KD_NO_ENTITY;
    assert_true(w && n <= 256);
    register_all(w);
    kd_destroy(w, kd_spawn(w, KD_TAG(frozen), KD_VAL(padded, {1, 2})));
    for (uint32_t i = 0; i < n; i++) {
        e[i] = i % 3 || !i ? kd_spawn(w, KD_VAL(position, {(float)i, 0.1f, -1}))
                           : kd_spawn_child(w, e[i / 3], KD_VAL(position, {0, (float)i, 1}), KD_TAG(frozen));
        if (i % 4 == 1)
            kd_set(w, e[i], bond, {last, i});
        if (i % 5 == 2)
            kd_set(w, e[i], creature, {i % 2, 1, "beast", {0.1f, 2}});
        if (i % 6 == 1)
            kd_set(w, e[i], spark, {i});
        if (i % 12 == 1)
            kd_disable(w, e[i], spark);
        if (i % 7 == 3)
            kd_set_name(w, e[i], i % 2 ? "odd" : "even");
        last = e[i];
    }
    for (uint32_t i = 5; i < n; i += 11)
        kd_destroy(w, e[i]);
    kd_singleton(w, health)->now = 77;
    return w;
}

static kd_snapshot snapshot_of(const kd_world *w)
{
    kd_snapshot s = {0};
    assert_int_equal(kd_snapshot_write(w, &s), KD_OK);
    assert_true(s.size >= sizeof(snapshot_header));
    return s;
}

static void assert_same(const kd_world *a, const kd_world *b)
{
    kd_difference d = {0};
    char text[256];
    if (kd_world_diff(a, b, &d, 1))
        fail_msg("%s", kd_difference_text(a, b, &d, text, sizeof text));
    assert_true(kd_world_checksum(a) == kd_world_checksum(b));
}

/* ---- coming back ---- */
static void a_restored_world_equals_the_written_one(void **state)
{
    (void)state;
    kd_world *a = populated(200), *b = kd_world_make();
    kd_snapshot s = snapshot_of(a);
    register_all(b);
    kd_query *q =
        kd_query_make(b, &(kd_query_desc){.terms = {KD_READ(position), KD_WITH(frozen)}, .by_depth = true});
    assert_int_equal(kd_snapshot_restore(b, s.data, s.size), KD_OK);
    assert_same(a, b);
    assert_int_equal(kd_entity_count(b), kd_entity_count(a));
    assert_int_equal(kd_singleton(b, health)->now, 77);
    kd_query *sparks = kd_query_make(b, &(kd_query_desc){.terms = {KD_READ(spark)}});
    assert_in_range(kd_query_count(sparks), 5, 20); /* 33 of 200 less the disabled half and every eleventh */
    assert_entity(kd_find_named(b, "odd"), kd_find_named(a, "odd"));
    kd_query *other =
        kd_query_make(a, &(kd_query_desc){.terms = {KD_READ(position), KD_WITH(frozen)}, .by_depth = true});
    assert_true(kd_query_count(q) > 0);
    assert_int_equal(kd_query_count(q), kd_query_count(other));
    kd_snapshot again = snapshot_of(b);
    assert_int_equal(again.size, s.size);
    assert_memory_equal(again.data, s.data, s.size);
    kd_snapshot_fini(&again);
    kd_snapshot_fini(&s);
    kd_world_destroy(a);
    kd_world_destroy(b);
}

/* The same calls after a restore and without it: handles, order and checksum must not part. */
static void go_on(kd_world *w, uint64_t seed)
{
    for (int i = 0; i < 300; i++) {
        kd_entity made = kd_spawn(w, KD_VAL(velocity, {1, 2, (float)i}));
        kd_entity picked = {random_below(&seed, 220), 1 + random_below(&seed, 3)};
        switch (random_below(&seed, 6)) {
        case 0: kd_destroy(w, picked); break;
        case 1: kd_set(w, picked, padded, {1, (uint32_t)i}); break;
        case 2: kd_set_parent(w, made, picked); break;
        case 3: kd_remove(w, picked, position); break;
        case 4: kd_set_name(w, picked, "odd"); break;
        default: kd_destroy(w, kd_find_named(w, "odd"));
        }
    }
}

static void a_restored_world_goes_on_as_the_written_one(void **state)
{
    (void)state;
    for (uint64_t seed = 1; seed <= 30; seed++) {
        kd_world *a = populated(200), *b = kd_world_make(), *c = populated(20);
        kd_snapshot s = snapshot_of(a);
        register_all(b);
        go_on(c, seed + 100); /* an abandoned future with tables of its own */
        assert_int_equal(kd_snapshot_restore(b, s.data, s.size), KD_OK);
        assert_int_equal(kd_snapshot_restore(c, s.data, s.size), KD_OK);
        go_on(a, seed);
        go_on(b, seed);
        go_on(c, seed);
        assert_same(a, b);
        assert_same(a, c);
        kd_snapshot_fini(&s);
        kd_world_destroy(a);
        kd_world_destroy(b);
        kd_world_destroy(c);
    }
}

static void a_restore_into_its_own_world_undoes(void **state)
{
    (void)state;
    kd_world *a = populated(100), *b = populated(100);
    kd_query *q = kd_query_make(b, &(kd_query_desc){.terms = {KD_WRITE(position)}, .name = "positions"});
    uint32_t before = kd_query_count(q);
    uint64_t version = kd_world_version(b);
    kd_snapshot s = snapshot_of(b);
    go_on(b, 9);
    assert_true(kd_world_diff(a, b, NULL, 0) > 0);
    assert_int_equal(kd_snapshot_restore(b, s.data, s.size), KD_OK);
    assert_same(a, b);
    assert_int_equal(kd_query_count(q), before);
    uint32_t changed = 0;
    kd_iter it = kd_query_iter(q);
    it.changed_since = version;
    while (kd_iter_next(&it))
        changed += it.count;
    assert_int_equal(changed, before); /* everything counts as changed */
    kd_snapshot_fini(&s);
    kd_world_destroy(a);
    kd_world_destroy(b);
}

static void an_empty_world_comes_back_empty(void **state)
{
    (void)state;
    kd_world *a = kd_world_make(), *b = populated(50);
    kd_snapshot s = snapshot_of(a);
    assert_int_equal(s.size, sizeof(snapshot_header));
    assert_int_equal(kd_snapshot_restore(b, s.data, s.size), KD_OK);
    assert_int_equal(kd_entity_count(b), 0);
    assert_entity(kd_spawn(b, KD_TAG(position)), ((kd_entity){0, 1}));
    kd_snapshot_fini(&s);
    kd_world_destroy(a);
    kd_world_destroy(b);
}

static void a_restore_releases_what_the_old_world_owned(void **state)
{
    (void)state;
    kd_world *a = kd_world_make(), *b = kd_world_make();
    kd_spawn(a, KD_VAL(position, {1, 2, 3}));
    register_all(b);
    owner o = {owned(1)};
    kd_spawn(b, KD_TAG(position), ((kd_value){&owner_desc, &o}));
    kd_snapshot s = snapshot_of(a);
    owner_releases = 0;
    assert_int_equal(kd_snapshot_restore(b, s.data, s.size), KD_OK);
    assert_int_equal(owner_releases, 1);
    assert_same(a, b);
    kd_snapshot_fini(&s);
    kd_world_destroy(a);
    kd_world_destroy(b);
}

/* A world that was let in can be walked, written and destroyed. */
static void assert_sound(kd_world *w)
{
    uint32_t rows = 0, children = 0, below = 0;
    kd_query *q = kd_query_make(w, &(kd_query_desc){.by_depth = true});
    for (kd_iter it = kd_query_iter(q); kd_iter_next(&it); rows += it.count)
        for (uint32_t i = 0; i < it.count; i++) {
            below += it.parents != NULL;
            for (kd_entity c = kd_first_child(w, it.entities[i]); c.generation; c = kd_next_sibling(w, c)) {
                assert_entity(kd_get_parent(w, c), it.entities[i]);
                children++;
            }
        }
    assert_int_equal(rows, kd_entity_count(w));
    assert_int_equal(children, below);
    kd_query_destroy(q);
}

static void transient_components_stay_behind(void **state)
{
    (void)state;
    kd_world *a = kd_world_make(), *b = kd_world_make();
    register_all(b);
    owner o = {owned(5)};
    kd_entity with = kd_spawn(a, KD_VAL(position, {1, 0, 0}), ((kd_value){&cache_desc, &o}));
    kd_entity without = kd_spawn(a, KD_VAL(position, {2, 0, 0}));
    kd_entity last = KD_NO_ENTITY;
    for (int i = 0; i < 5; i++) {
        o = (owner){owned(5)};
        kd_spawn(a, KD_TAG(position), ((kd_value){&cache_desc, &o}));
        last = kd_spawn(a, KD_VAL(position, {3, (float)i, 0}));
    }
    kd_snapshot s = snapshot_of(a);
    for (int i = 0; i < 2; i++) { /* the second time the table is there, and two become one in it again */
        assert_int_equal(kd_snapshot_restore(b, s.data, s.size), KD_OK);
        assert_int_equal(kd_entity_count(b), 12);
        assert_true(kd_find(b, with, position)->x == 1 && kd_find(b, without, position)->x == 2);
        assert_true(kd_find(b, last, position)->x == 3 && kd_find(b, last, position)->y == 4);
        assert_null(kd_find_id(b, with, kd_component_ensure(b, &cache_desc)));
        assert_sound(b);
    }
    kd_difference d;
    assert_true(kd_world_diff(a, b, &d, 1) >= 1);
    assert_int_equal(d.kind, KD_DIFFERENCE_COMPONENT);
    assert_ptr_equal(d.component, &cache_desc);
    kd_snapshot_fini(&s);
    kd_world_destroy(a);
    kd_world_destroy(b);
}

/* What a snapshot lacks was at its default when it was taken; caches and what owns memory are none of its
 * business. */
static void a_singleton_made_since_goes_back_to_its_default(void **state)
{
    (void)state;
    static const kd_component_desc counter_desc = {
        .name = "counter", .size = sizeof(int), .align = _Alignof(int), .flags = KD_COMPONENT_TRANSIENT};
    kd_world *w = populated(10);
    kd_singleton(w, health)->now = 77;
    kd_snapshot s = snapshot_of(w);
    position *p = kd_singleton(w, position);
    creature *c = kd_singleton(w, creature);
    int *count = kd_singleton_ensure(w, &counter_desc);
    owner *o = kd_singleton(w, owner);
    p->x = 5;
    c->weights[1] = 5;
    *count = 5;
    o->memory = owned(5);
    kd_schedule_clock *clock = kd_singleton(w, kd_schedule_clock);
    const kd_schedule_clock begin = *clock;
    *clock = (kd_schedule_clock){.time_s = 9, .step_s = 8, .frame = 7};
    kd_singleton(w, health)->now = 1;
    assert_int_equal(kd_snapshot_restore(w, s.data, s.size), KD_OK);
    assert_true(p == kd_singleton(w, position) && p->x == 0);
    assert_true(c->weights[1] == 0);
    assert_int_equal(*count, 5);
    assert_int_equal(*o->memory, 5);
    assert_true(clock == kd_singleton(w, kd_schedule_clock) && clock->frame == 0);
    assert_true(clock->time_s == begin.time_s && clock->step_s == begin.step_s);
    assert_int_equal(kd_singleton(w, health)->now, 77);
    kd_snapshot_fini(&s);
    kd_world_destroy(w);
}

/* ---- refusals ---- */
static int messages;
static char message[512];
static void keep_message(void *user, kd_log_level level, const char *text)
{
    (void)user, (void)level;
    messages++;
    snprintf(message, sizeof message, "%s", text);
}

static void assert_refused(kd_status status, kd_status expected, const char *words)
{
    assert_int_equal(status, expected);
    assert_int_equal(messages, 1);
    if (!strstr(message, words))
        fail_msg("\"%s\" does not say \"%s\"", message, words);
    messages = 0;
}

static void what_owns_memory_is_not_written(void **state)
{
    (void)state;
    kd_world *w = kd_world_make();
    kd_snapshot s = {0};
    owner o = {owned(1)};
    kd_log_set_sink(keep_message, NULL);
    kd_entity e = kd_spawn(w, ((kd_value){&owner_desc, &o}));
    assert_refused(kd_snapshot_write(w, &s), KD_UNSUPPORTED, "component owner");
    assert_int_equal(s.size, 0);
    kd_destroy(w, e);
    assert_int_equal(kd_snapshot_write(w, &s), KD_OK); /* an empty table of it is no hindrance */
    kd_commands_destroy(kd_world_commands(w, 0), e);
    assert_refused(kd_snapshot_write(w, &s), KD_UNSUPPORTED, "kd_world_merge");
    assert_int_equal(s.size, 0);
    kd_log_set_sink(NULL, NULL);
    kd_snapshot_fini(&s);
    kd_world_destroy(w);
}

typedef struct long_position {
    double x, y, z;
} long_position;
KD_COMPONENT_DEFINE(long_position, "position", KD_FIELD(long_position, x, KD_F32, "m", "x"));
typedef struct turned_position {
    float z, y, x;
} turned_position;
KD_COMPONENT_DEFINE(turned_position, "position", KD_FIELD(turned_position, x, KD_F32, "m", "x"),
                    KD_FIELD(turned_position, y, KD_F32, "m", "y"),
                    KD_FIELD(turned_position, z, KD_F32, "m", "z"));

static void other_components_are_refused(void **state)
{
    (void)state;
    kd_world *a = kd_world_make(), *b = kd_world_make(), *c = kd_world_make(), *d = kd_world_make();
    kd_spawn(a, KD_VAL(position, {1, 2, 3}));
    kd_snapshot s = snapshot_of(a);
    kd_log_set_sink(keep_message, NULL);
    assert_refused(kd_snapshot_restore(b, s.data, s.size), KD_NOT_FOUND, "component position is not known");
    KD_ID(c, long_position);
    assert_refused(kd_snapshot_restore(c, s.data, s.size), KD_BAD_FORMAT, "other fields");
    KD_ID(d, turned_position);
    assert_refused(kd_snapshot_restore(d, s.data, s.size), KD_BAD_FORMAT, "other fields");
    kd_log_set_sink(NULL, NULL);
    kd_snapshot_fini(&s);
    kd_world_destroy(a);
    kd_world_destroy(b);
    kd_world_destroy(c);
    kd_world_destroy(d);
}

static void header_at_fault_is_named(void **state)
{
    (void)state;
    kd_world *w = populated(10);
    kd_snapshot s = snapshot_of(w);
    snapshot_header *h = s.data, good = *h;
    kd_log_set_sink(keep_message, NULL);
    assert_refused(kd_snapshot_restore(w, "no snapshot at all", 18), KD_BAD_FORMAT, "no snapshot of a world");
    h->version = 7;
    assert_refused(kd_snapshot_restore(w, s.data, s.size), KD_UNSUPPORTED, "version 7");
    *h = good;
    h->byte_order = 0x04030201u;
    assert_refused(kd_snapshot_restore(w, s.data, s.size), KD_UNSUPPORTED, "byte order");
    *h = good;
    ((uint8_t *)s.data)[s.size - 3] ^= 1;
    assert_refused(kd_snapshot_restore(w, s.data, s.size), KD_BAD_FORMAT, "checksum");
    kd_log_set_sink(NULL, NULL);
    kd_snapshot_fini(&s);
    kd_world_destroy(w);
}

static kd_status restore_copy(kd_world *w, const uint8_t *data, size_t size)
{
    uint8_t *copy = malloc(size ? size : 1); /* of exactly this size: a sanitizer sees a read beyond it */
    assert_non_null(copy);
    memcpy(copy, data, size);
    messages = 0;
    kd_status status = kd_snapshot_restore(w, copy, size);
    assert_int_equal(messages, status != KD_OK);
    free(copy);
    return status;
}

static void every_truncation_is_refused_and_changes_nothing(void **state)
{
    (void)state;
    kd_world *a = populated(40), *b = populated(12);
    kd_snapshot s = snapshot_of(a);
    uint64_t before = kd_world_checksum(b);
    kd_log_set_sink(keep_message, NULL);
    for (size_t size = 0; size < s.size; size++)
        assert_int_equal(restore_copy(b, s.data, size), KD_BAD_FORMAT);
    for (size_t size = sizeof(snapshot_header); size < s.size; size += 8) { /* with a header that agrees */
        snapshot_header h;
        uint8_t *copy = malloc(size);
        assert_non_null(copy);
        memcpy(copy, s.data, size);
        memcpy(&h, copy, sizeof h);
        h.size = size;
        h.checksum = XXH3_64bits(copy + SNAPSHOT_HASHED, size - SNAPSHOT_HASHED);
        memcpy(copy, &h, sizeof h);
        assert_int_equal(restore_copy(b, copy, size), KD_BAD_FORMAT);
        free(copy);
    }
    assert_true(kd_world_checksum(b) == before);
    kd_log_set_sink(NULL, NULL);
    kd_snapshot_fini(&s);
    kd_world_destroy(a);
    kd_world_destroy(b);
}

/* Flips under a checksum that was made to agree reach the checks behind it. */
static void flipped_bytes_never_break_a_world(void **state)
{
    (void)state;
    kd_world *a = populated(30);
    kd_snapshot s = snapshot_of(a), good_copy = snapshot_of(a);
    uint64_t before = kd_world_checksum(a);
    snapshot_header *h = s.data;
    uint64_t random = 5;
    int let_in = 0, refused = 0;
    kd_log_set_sink(keep_message, NULL);
    for (size_t at = SNAPSHOT_HASHED; at < s.size; at++)
        for (int turn = 0; turn < 2; turn++) {
            uint8_t *byte = (uint8_t *)s.data + at, good = *byte;
            *byte ^= (uint8_t)(turn ? 1 + random_below(&random, 255) : 1u << random_below(&random, 8));
            assert_int_equal(kd_snapshot_restore(a, s.data, s.size), KD_BAD_FORMAT);
            h->checksum = XXH3_64bits((uint8_t *)s.data + SNAPSHOT_HASHED, s.size - SNAPSHOT_HASHED);
            kd_world *w = kd_world_make();
            register_all(w);
            if (restore_copy(w, s.data, s.size) == KD_OK) {
                let_in++;
                assert_sound(w);
                go_on(w, at);
                assert_sound(w);
            } else {
                refused++;
                assert_int_equal(kd_entity_count(w), 0);
            }
            kd_world_destroy(w);
            /* The same into a world whose tables are there already: refused, it stays as it was. */
            if (restore_copy(a, s.data, s.size) == KD_OK) {
                assert_sound(a);
                assert_int_equal(kd_snapshot_restore(a, good_copy.data, good_copy.size), KD_OK);
            }
            assert_true(kd_world_checksum(a) == before);
            *byte = good;
            h->checksum = XXH3_64bits((uint8_t *)s.data + SNAPSHOT_HASHED, s.size - SNAPSHOT_HASHED);
        }
    assert_true(let_in > 100 && refused > 100); /* both sides were tried */
    assert_sound(a);
    kd_log_set_sink(NULL, NULL);
    kd_snapshot_fini(&s);
    kd_snapshot_fini(&good_copy);
    kd_world_destroy(a);
}

static void a_restore_without_memory_changes_nothing(void **state)
{
    (void)state;
    kd_world *a = populated(100), *b = populated(10);
    kd_snapshot s = snapshot_of(a);
    uint64_t before = kd_world_checksum(b);
    kd_status status = KD_NO_MEMORY;
    kd_log_set_sink(keep_message, NULL);
    kd_query *q = kd_query_make(b, &(kd_query_desc){.terms = {KD_READ(position)}});
    uint32_t count = kd_query_count(q), rounds = 0;
    for (; status; rounds++) {
        assert_true(kd_world_checksum(b) == before);
        assert_int_equal(kd_query_count(q), count);
        kd_world_limit_bytes(b, kd_world_bytes(b) + rounds * 256);
        status = kd_snapshot_restore(b, s.data, s.size);
        assert_true(status == KD_OK || status == KD_NO_MEMORY);
    }
    assert_true(rounds > 10);
    assert_same(a, b);
    kd_log_set_sink(NULL, NULL);
    kd_snapshot_fini(&s);
    kd_world_destroy(a);
    kd_world_destroy(b);
}

static void files_carry_a_world(void **state)
{
    (void)state;
    kd_world *a = populated(60), *b = kd_world_make();
    char path[64];
    snprintf(path, sizeof path, "ecs_snapshot_%d.kdworld", rand());
    register_all(b);
    assert_int_equal(kd_snapshot_save(a, path), KD_OK);
    assert_int_equal(kd_snapshot_load(b, path), KD_OK);
    assert_same(a, b);
    assert_int_equal(remove(path), 0);
    kd_log_set_sink(keep_message, NULL);
    messages = 0;
    assert_refused(kd_snapshot_load(b, path), KD_NOT_FOUND, path);
    kd_log_set_sink(NULL, NULL);
    kd_world_destroy(a);
    kd_world_destroy(b);
}

/* ---- differences ---- */
static void each_difference_is_named(void **state)
{
    (void)state;
    char text[128];
    kd_difference d[8];
    static const struct {
        int change;
        kd_difference_kind kind;
        const char *text;
    } cases[] = {
        {6, KD_DIFFERENCE_ENABLED, "entity 3.1 even: spark disabled only in the second world"},
        {0, KD_DIFFERENCE_VALUE, "entity 3.1 even: position.y differs"},
        {1, KD_DIFFERENCE_COMPONENT, "entity 3.1 even: health only in the second world"},
        {2, KD_DIFFERENCE_COMPONENT, "entity 3.1 even: position only in the first world"},
        {3, KD_DIFFERENCE_NAME, "entity 3.1 even: named \"even\" and \"other\""},
        {4, KD_DIFFERENCE_PARENT, "entity 3.1 even: another parent"},
        {5, KD_DIFFERENCE_ENTITY, "entity 3.1 even: only in the first world"},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        kd_world *w[2];
        kd_entity e = {3, 1};
        for (int k = 0; k < 2; k++) {
            w[k] = kd_world_make();
            for (int n = 0; n < 4; n++)
                kd_spawn(w[k], KD_VAL(position, {(float)n, 2, 3}), KD_VAL(spark, {1}));
            kd_set_name(w[k], e, "even");
        }
        assert_int_equal(kd_world_diff(w[0], w[1], NULL, 0), 0);
        switch (cases[i].change) {
        case 0: kd_find_mut(w[1], e, position)->y = 9; break;
        case 1: kd_add(w[1], e, health); break;
        case 2: kd_remove(w[1], e, position); break;
        case 3: kd_set_name(w[1], e, "other"); break;
        case 6: kd_disable(w[1], e, spark); break;
        case 4: kd_set_parent(w[1], e, (kd_entity){0, 1}); break;
        default: kd_destroy(w[1], e);
        }
        assert_true(kd_world_diff(w[0], w[1], d, 8) >= 1);
        assert_int_equal(d[0].kind, cases[i].kind);
        assert_string_equal(kd_difference_text(w[0], w[1], &d[0], text, sizeof text), cases[i].text);
        kd_world_destroy(w[0]);
        kd_world_destroy(w[1]);
    }
}

static void order_and_siblings_count(void **state)
{
    (void)state;
    kd_world *w[2];
    kd_difference d[4];
    for (int k = 0; k < 2; k++) {
        w[k] = kd_world_make();
        kd_entity root = kd_spawn(w[k], KD_TAG(position));
        kd_entity one = kd_spawn_child(w[k], root, KD_TAG(position));
        kd_spawn_child(w[k], root, KD_TAG(position));
        kd_set_parent(w[k], one, k ? root : KD_NO_ENTITY);
        kd_set_parent(w[k], one, root);
    }
    /* one comes last among its siblings in both; its row came and went only in the first world */
    assert_int_equal(kd_world_diff(w[0], w[1], d, 4), 1);
    assert_int_equal(d[0].kind, KD_DIFFERENCE_ORDER);
    kd_world_destroy(w[0]);
    kd_world_destroy(w[1]);
}

/* The order in which sparse values came is the order of iteration over them, and counts in the checksum. */
static void order_of_sparse_values_counts(void **state)
{
    (void)state;
    kd_world *w[2];
    kd_difference d[4];
    char text[128];
    for (int k = 0; k < 2; k++) {
        w[k] = kd_world_make();
        kd_entity e[2] = {kd_spawn(w[k], KD_TAG(position)), kd_spawn(w[k], KD_TAG(position))};
        kd_add(w[k], e[k], spark);
        kd_add(w[k], e[1 - k], spark);
    }
    assert_true(kd_world_checksum(w[0]) != kd_world_checksum(w[1]));
    assert_int_equal(kd_world_diff(w[0], w[1], d, 4), 1);
    assert_int_equal(d[0].kind, KD_DIFFERENCE_ORDER);
    assert_string_equal(kd_difference_text(w[0], w[1], &d[0], text, sizeof text),
                        "entity 0.1: from here on the values of spark come in another order");
    kd_world_destroy(w[0]);
    kd_world_destroy(w[1]);
}

/* ---- JSON ---- */
static void json_shows_a_world_to_people(void **state)
{
    (void)state;
    kd_world *w = kd_world_make();
    kd_json j = {0};
    kd_entity a = kd_spawn(w, KD_VAL(creature, {ANGRY, 1, "rex", {0.1f, 2}}));
    kd_set_name(w, a, "dog");
    kd_spawn_child(w, a, KD_TAG(frozen), KD_VAL(bond, {a, 3}));
    kd_singleton(w, health);
    kd_world_write_json(w, &j);
    assert_string_equal(
        kd_json_text(&j),
        "{\"entities\":[{\"entity\":[0,1],\"name\":\"dog\",\"components\":{\"creature\":{\"mood\":"
        "\"angry\",\"asleep\":true,\"title\":\"rex\",\"weights\":[0.1,2]}}},{\"entity\":[1,1],"
        "\"parent\":[0,1],\"components\":{\"frozen\":true,\"bond\":{\"target\":[0,1],\"weight\":3}}}],"
        "\"singletons\":{\"health\":{\"now\":100,\"most\":100}}}");
    kd_json_fini(&j);
    kd_world_destroy(w);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_restored_world_equals_the_written_one),
        cmocka_unit_test(a_restored_world_goes_on_as_the_written_one),
        cmocka_unit_test(a_restore_into_its_own_world_undoes),
        cmocka_unit_test(an_empty_world_comes_back_empty),
        cmocka_unit_test(a_restore_releases_what_the_old_world_owned),
        cmocka_unit_test(transient_components_stay_behind),
        cmocka_unit_test(a_singleton_made_since_goes_back_to_its_default),
        cmocka_unit_test(what_owns_memory_is_not_written),
        cmocka_unit_test(other_components_are_refused),
        cmocka_unit_test(header_at_fault_is_named),
        cmocka_unit_test(every_truncation_is_refused_and_changes_nothing),
        cmocka_unit_test(flipped_bytes_never_break_a_world),
        cmocka_unit_test(a_restore_without_memory_changes_nothing),
        cmocka_unit_test(files_carry_a_world),
        cmocka_unit_test(each_difference_is_named),
        cmocka_unit_test(order_and_siblings_count),
        cmocka_unit_test(order_of_sparse_values_counts),
        cmocka_unit_test(json_shows_a_world_to_people),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
