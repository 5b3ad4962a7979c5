/* Components, entities and values of a world. */

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

/* ---- components ---- */
static void component_gets_ids_from_one_upwards(void **state)
{
    kd_world *w = *state;
    assert_int_equal(kd_component_count(w), 0);
    assert_int_equal(KD_ID(w, position), 1);
    assert_int_equal(KD_ID(w, frozen), 2);
    assert_int_equal(KD_ID(w, position), 1);
    assert_int_equal(kd_component_count(w), 2);
    assert_ptr_equal(kd_component_info(w, 1), &position_desc);
    assert_null(kd_component_info(w, 0));
    assert_null(kd_component_info(w, 3));
}

static void component_is_found_by_name(void **state)
{
    kd_world *w = *state;
    assert_int_equal(kd_component_find(w, "velocity"), 0);
    kd_component_id id = KD_ID(w, velocity);
    assert_int_equal(kd_component_find(w, "velocity"), id);
    assert_int_equal(kd_component_find(w, "veloc"), 0);
}

static void component_copies_of_a_description_agree(void **state)
{
    kd_world *w = *state;
    kd_component_desc copy = position_desc;
    assert_int_equal(KD_ID(w, position), kd_component_ensure(w, &copy));
    assert_int_equal(kd_component_count(w), 1);
}

static void component_of_one_name_and_another_size_is_refused(void **state)
{
    kd_world *w = *state;
    kd_component_desc other = velocity_desc;
    other.name = "position";
    other.size = 4;
    KD_ID(w, position);
    kd_log_set_sink(silent, NULL);
    assert_int_equal(kd_component_ensure(w, &other), 0);
    kd_log_set_sink(NULL, NULL);
}

static void component_table_fills_up_with_an_error(void **state)
{
    kd_world *w = *state;
    static char names[520][16];
    static kd_component_desc many[520];
    kd_component_id ids[520];
    kd_log_set_sink(silent, NULL);
    for (int i = 0; i < 520; i++) {
        snprintf(names[i], sizeof names[i], "c%d", i);
        many[i] = (kd_component_desc){.name = names[i], .size = 4, .align = 4};
        ids[i] = kd_component_ensure(w, &many[i]);
        assert_int_equal(ids[i], i < 512 ? i + 1 : 0);
    }
    kd_log_set_sink(NULL, NULL);
    kd_value values[512];
    for (int i = 0; i < 512; i++)
        values[i] = (kd_value){&many[i], &ids[i]};
    kd_entity e = kd_spawn_values(w, values, 512);
    assert_non_null(kd_find_id(w, e, 512));
    assert_int_equal(*(const uint32_t *)kd_find_id(w, e, 77), 77);
}

static void worlds_have_ids_of_their_own(void **state)
{
    kd_world *a = *state, *b = kd_world_make();
    KD_ID(a, position);
    assert_int_equal(KD_ID(a, velocity), 2);
    assert_int_equal(KD_ID(b, velocity), 1);
    kd_entity in_a = kd_spawn(a, KD_VAL(velocity, {1, 2, 3}), KD_VAL(position, {4, 5, 6}));
    kd_entity in_b = kd_spawn(b, KD_VAL(velocity, {7, 8, 9}));
    assert_entity(in_a, in_b); /* both are the first of their world */
    assert_true(kd_find(a, in_a, velocity)->x == 1 && kd_find(b, in_b, velocity)->x == 7);
    assert_false(kd_has(b, in_b, position));
    kd_world_destroy(b);
    assert_true(kd_find(a, in_a, position)->z == 6);
}

/* ---- entities ---- */
static void spawn_writes_all_values(void **state)
{
    kd_world *w = *state;
    kd_entity e =
        kd_spawn(w, KD_VAL(velocity, {1, 2, 3}), KD_TAG(frozen), KD_VAL(position, {4, 5, 6}), KD_TAG(health));
    assert_true(kd_alive(w, e));
    assert_int_equal(kd_entity_count(w), 1);
    assert_true(kd_find(w, e, velocity)->y == 2 && kd_find(w, e, position)->z == 6);
    assert_int_equal(kd_find(w, e, health)->now, 100); /* its default */
    assert_true(kd_has(w, e, frozen));
    assert_false(kd_has(w, e, bond));
}

static void spawn_without_values_makes_an_empty_entity(void **state)
{
    kd_world *w = *state;
    kd_entity e = kd_spawn_values(w, NULL, 0);
    assert_true(kd_alive(w, e));
    assert_int_equal(kd_set(w, e, position, {1, 1, 1}), KD_OK);
    kd_remove(w, e, position);
    assert_true(kd_alive(w, e));
}

static void spawn_takes_the_last_of_a_component_given_twice(void **state)
{
    kd_world *w = *state;
    kd_entity e = kd_spawn(w, KD_VAL(position, {1, 1, 1}), KD_VAL(position, {2, 2, 2}));
    assert_true(kd_find(w, e, position)->x == 2);
}

static void spawn_reads_values_that_lie_in_the_world(void **state)
{
    kd_world *w = *state;
    kd_entity first = kd_spawn(w, KD_VAL(position, {1, 2, 3}), KD_TAG(health));
    for (int i = 0; i < 5000; i++) { /* the column moves in memory while it is read */
        kd_value values[] = {{&position_desc, kd_find(w, first, position)}, {&health_desc, NULL}};
        kd_entity e = kd_spawn_values(w, values, 2);
        assert_true(kd_find(w, e, position)->z == 3);
    }
    for (int i = 0; i < 5000; i++) {
        kd_entity e = kd_spawn(w, KD_TAG(health));
        assert_int_equal(kd_set_value(w, e, (kd_value){&position_desc, kd_find(w, first, position)}), KD_OK);
        assert_true(kd_find(w, e, position)->y == 2);
    }
}

static void spawn_n_copies_columns_and_fills_defaults(void **state)
{
    kd_world *w = *state;
    enum { N = 1000 };
    static position p[N];
    static kd_entity out[N];
    for (int i = 0; i < N; i++)
        p[i] = (position){(float)i, 0, 0};
    const kd_component_desc *descs[] = {&health_desc, &position_desc, &frozen_desc};
    const void *columns[] = {NULL, p, NULL};
    assert_int_equal(kd_spawn_n(w, N, descs, columns, 3, out), KD_OK);
    assert_int_equal(kd_spawn_n(w, N, descs, NULL, 3, NULL), KD_OK);
    assert_int_equal(kd_spawn_n(w, 0, descs, columns, 3, out), KD_OK);
    assert_int_equal(kd_entity_count(w), 2 * N);
    for (int i = 0; i < N; i++) {
        assert_true(kd_find(w, out[i], position)->x == (float)i);
        assert_int_equal(kd_find(w, out[i], health)->most, 100);
        assert_true(kd_has(w, out[i], frozen));
    }
}

static void destroyed_handle_is_dead_and_harmless(void **state)
{
    kd_world *w = *state;
    kd_entity e = kd_spawn(w, KD_VAL(position, {1, 2, 3}));
    kd_destroy(w, e);
    assert_false(kd_alive(w, e));
    assert_null(kd_find(w, e, position));
    assert_null(kd_find_mut(w, e, position));
    assert_int_equal(kd_set(w, e, position, {0}), KD_NOT_FOUND);
    assert_int_equal(kd_set_name(w, e, "x"), KD_NOT_FOUND);
    assert_int_equal(kd_set_parent(w, e, KD_NO_ENTITY), KD_NOT_FOUND);
    assert_string_equal(kd_get_name(w, e), "");
    assert_entity(kd_get_parent(w, e), KD_NO_ENTITY);
    assert_entity(kd_first_child(w, e), KD_NO_ENTITY);
    assert_entity(kd_next_sibling(w, e), KD_NO_ENTITY);
    kd_remove(w, e, position);
    kd_destroy(w, e);
    kd_entity next = kd_spawn(w, KD_VAL(position, {4, 5, 6}));
    assert_int_equal(next.index, e.index); /* the index comes back with another generation */
    assert_int_not_equal(next.generation, e.generation);
    assert_null(kd_find(w, e, position));
    assert_int_equal(kd_entity_count(w), 1);
}

static void handles_never_made_are_dead(void **state)
{
    kd_world *w = *state;
    kd_entity wrong[] = {KD_NO_ENTITY,     {0, 1},         {7, 1}, {UINT32_MAX, UINT32_MAX},
                         {0, 0x80000000u}, {0, UINT32_MAX}};
    for (size_t i = 0; i < sizeof wrong / sizeof *wrong; i++) {
        assert_false(kd_alive(w, wrong[i]));
        assert_null(kd_find(w, wrong[i], position));
        assert_entity(kd_entity_resolve(w, wrong[i]), KD_NO_ENTITY);
        kd_destroy(w, wrong[i]);
    }
}

/* One index is used so often that its generations run out: it must rest, not begin again at the first. */
static void lookup_finds_what_find_finds(void **state)
{
    kd_world *w = *state;
    kd_entity e[300];
    for (int i = 0; i < 300; i++) { /* four tables; half of them have a position */
        e[i] = i % 2 ? kd_spawn(w, KD_VAL(position, {(float)i, 0, 0})) : kd_spawn(w, KD_VAL(health, {i, i}));
        if (i % 3 == 0)
            kd_add(w, e[i], velocity);
    }
    for (int i = 0; i < 300; i += 7)
        kd_destroy(w, e[i]);
    kd_lookup l = KD_LOOKUP(w, position);
    for (int i = 0; i < 300; i++)
        assert_ptr_equal(kd_lookup_find(&l, e[i]), kd_find(w, e[i], position));
    assert_non_null(kd_lookup_find(&l, e[1]));
    assert_null(kd_lookup_find(&l, e[2]));
    assert_null(kd_lookup_find(&l, e[7]));
    for (uint32_t index = 0; index < 400; index++) { /* dead, living and unknown ones */
        assert_null(kd_lookup_find(&l, (kd_entity){index, 0}));
        assert_null(kd_lookup_find(&l, (kd_entity){index, UINT32_MAX}));
        assert_null(kd_lookup_find(&l, (kd_entity){index, ECS_MAX_GENERATION}));
        assert_null(kd_find(w, ((kd_entity){index, 0}), position));
    }
    kd_lookup none = KD_LOOKUP(w, bond); /* nobody has one */
    assert_null(kd_lookup_find(&none, e[1]));
}

static void index_rests_when_its_generations_are_used_up(void **state)
{
    kd_world *w = *state;
    kd_entity first = kd_spawn(w, KD_TAG(frozen)), e = first;
    uint32_t used = 1;
    for (; e.index == first.index && used < 1u << 20; used++) {
        kd_destroy(w, e);
        e = kd_spawn(w, KD_TAG(frozen));
        assert_false(kd_alive(w, first));
    }
    assert_int_not_equal(e.index, first.index);
    assert_int_equal(e.generation, 1);
    assert_in_range(used, 1u << 16, 1u << 18);
    assert_int_equal(kd_entity_count(w), 1);
    kd_destroy(w, e);
    assert_int_equal(kd_spawn(w, KD_TAG(frozen)).index, e.index);
}

static void same_calls_give_the_same_handles(void **state)
{
    kd_world *a = *state, *b = kd_world_make();
    kd_entity in_a[300], in_b[300];
    for (uint32_t i = 0; i < 300; i++) {
        in_a[i] = kd_spawn(a, KD_VAL(position, {1, 2, 3}));
        in_b[i] = kd_spawn(b, KD_VAL(position, {1, 2, 3}));
        if (i % 3 == 2) {
            kd_destroy(a, in_a[i / 2]);
            kd_destroy(b, in_b[i / 2]);
        }
    }
    assert_memory_equal(in_a, in_b, sizeof in_a);
    assert_true(kd_world_checksum(a) == kd_world_checksum(b));
    kd_world_destroy(b);
}

/* ---- values ---- */
static void set_adds_and_replaces(void **state)
{
    kd_world *w = *state;
    kd_entity e = kd_spawn(w, KD_VAL(position, {1, 2, 3}));
    kd_entity other = kd_spawn(w, KD_VAL(position, {9, 9, 9}));
    assert_int_equal(kd_set(w, e, health, {5, 6}), KD_OK);
    assert_int_equal(kd_find(w, e, health)->most, 6);
    assert_true(kd_find(w, e, position)->z == 3 && kd_find(w, other, position)->x == 9);
    assert_int_equal(kd_set(w, e, health, {7, 8}), KD_OK);
    assert_int_equal(kd_find(w, e, health)->now, 7);
    assert_int_equal(kd_set_value(w, e, KD_TAG(health)), KD_OK);
    assert_int_equal(kd_find(w, e, health)->now, 100); /* NULL sets the default */
    assert_int_equal(kd_add(w, e, frozen), KD_OK);
    assert_int_equal(kd_add(w, e, frozen), KD_OK);
    assert_true(kd_has(w, e, frozen) && !kd_has(w, other, frozen));
}

static void remove_takes_one_component_away(void **state)
{
    kd_world *w = *state;
    kd_entity e = kd_spawn(w, KD_VAL(position, {1, 2, 3}), KD_VAL(velocity, {4, 5, 6}), KD_TAG(frozen));
    kd_remove(w, e, velocity);
    assert_null(kd_find(w, e, velocity));
    assert_true(kd_find(w, e, position)->y == 2 && kd_has(w, e, frozen));
    kd_remove(w, e, velocity);
    kd_remove(w, e, health); /* never had */
    kd_remove(w, e, frozen);
    assert_false(kd_has(w, e, frozen));
}

static void columns_are_aligned_to_a_cache_line(void **state)
{
    kd_world *w = *state;
    kd_query *q = kd_query_make(w, &(kd_query_desc){.terms = {KD_READ(position), KD_READ(health)}});
    for (int i = 0; i < 3000; i++)
        kd_spawn(w, KD_TAG(position), KD_TAG(health));
    for (kd_iter it = kd_query_iter(q); kd_iter_next(&it);) {
        assert_int_equal((uintptr_t)KD_COLUMN(&it, position, 0) % 64, 0);
        assert_int_equal((uintptr_t)KD_COLUMN(&it, health, 1) % 64, 0);
    }
}

/* ---- hooks ---- */
static void hook_runs_on_remove_set_destroy_and_end(void **state)
{
    kd_world *w = kd_world_make();
    (void)state;
    owner_releases = 0;
    kd_entity a = kd_spawn(w, KD_VAL(owner, {owned(1)}), KD_TAG(frozen));
    kd_entity b = kd_spawn(w, KD_VAL(owner, {owned(2)}));
    kd_entity c = kd_spawn(w, KD_VAL(owner, {owned(3)}));
    kd_add(w, a, position); /* moving keeps it */
    assert_int_equal(owner_releases, 0);
    assert_int_equal(*kd_find(w, a, owner)->memory, 1);
    kd_remove(w, a, owner);
    assert_int_equal(owner_releases, 1);
    kd_set(w, b, owner, {owned(4)}); /* replaces the old one */
    assert_int_equal(owner_releases, 2);
    assert_int_equal(*kd_find(w, b, owner)->memory, 4);
    kd_destroy(w, b);
    assert_int_equal(owner_releases, 3);
    assert_int_equal(*kd_find(w, c, owner)->memory, 3);
    ((owner *)kd_singleton_ensure(w, &owner_desc))->memory = owned(5);
    kd_world_destroy(w);
    assert_int_equal(owner_releases, 5);
}

/* ---- singletons, names ---- */
static void singleton_starts_as_default_and_stays_in_place(void **state)
{
    kd_world *w = *state;
    assert_null(kd_singleton_find(w, KD_ID(w, health)));
    health *h = kd_singleton(w, health);
    assert_int_equal(h->now, 100);
    h->now = 3;
    for (int i = 0; i < 2000; i++)
        kd_spawn(w, KD_TAG(health));
    size_t before = kd_world_bytes(w);
    assert_ptr_equal(kd_singleton(w, health), h);
    assert_ptr_equal(kd_singleton_find(w, KD_ID(w, health)), h);
    assert_int_equal(kd_world_bytes(w), before);
    assert_int_equal(h->now, 3);
}

static void name_finds_the_one_named_first(void **state)
{
    kd_world *w = *state;
    kd_entity a = kd_spawn(w, KD_TAG(frozen)), b = kd_spawn(w, KD_TAG(frozen)),
              c = kd_spawn(w, KD_TAG(frozen));
    assert_entity(kd_find_named(w, "lamp"), KD_NO_ENTITY);
    kd_set_name(w, b, "lamp");
    kd_set_name(w, a, "lamp");
    kd_set_name(w, c, "lamp");
    assert_entity(kd_find_named(w, "lamp"), b);
    assert_entity(kd_next_named(w, b), a);
    assert_entity(kd_next_named(w, a), c);
    assert_entity(kd_next_named(w, c), KD_NO_ENTITY);
    kd_set_name(w, b, "sun");
    assert_entity(kd_find_named(w, "lamp"), a);
    kd_destroy(w, a);
    assert_entity(kd_find_named(w, "lamp"), c);
    kd_set_name(w, c, NULL);
    assert_entity(kd_find_named(w, "lamp"), KD_NO_ENTITY);
    assert_string_equal(kd_get_name(w, c), "");
    assert_string_equal(kd_get_name(w, b), "sun");
    assert_entity(kd_find_named(w, ""), KD_NO_ENTITY);
    assert_entity(kd_find_named(w, NULL), KD_NO_ENTITY);
}

static void names_survive_many_changes(void **state)
{
    kd_world *w = *state;
    enum { N = 700 };
    static kd_entity e[N];
    static int named[N];
    char name[16];
    uint64_t random = 11;
    for (int i = 0; i < N; i++) {
        e[i] = kd_spawn(w, KD_TAG(frozen));
        named[i] = -1;
    }
    for (int step = 0; step < 20000; step++) { /* unique names: the hash gets full, holes close */
        uint32_t i = random_below(&random, N);
        named[i] = random_below(&random, 3) ? (int)i + N * (int)random_below(&random, 3) : -1;
        snprintf(name, sizeof name, "n%d", named[i]);
        assert_int_equal(kd_set_name(w, e[i], named[i] < 0 ? "" : name), KD_OK);
    }
    for (int i = 0; i < N * 3; i++) {
        snprintf(name, sizeof name, "n%d", i);
        assert_entity(kd_find_named(w, name), named[i % N] == i ? e[i % N] : KD_NO_ENTITY);
    }
}

/* ---- statistics ---- */
static void checksum_tells_worlds_apart(void **state)
{
    kd_world *a = *state, *b = kd_world_make();
    kd_entity in_a = kd_spawn(a, KD_VAL(position, {1, 2, 3}), KD_TAG(health));
    kd_entity in_b = kd_spawn(b, KD_VAL(position, {1, 2, 3}), KD_TAG(health));
    assert_true(kd_world_checksum(a) == kd_world_checksum(b));
    kd_find_mut(b, in_b, position)->y += 1e-6f;
    assert_true(kd_world_checksum(a) != kd_world_checksum(b));
    kd_find_mut(b, in_b, position)->y = 2;
    assert_true(kd_world_checksum(a) == kd_world_checksum(b));
    kd_add(b, in_b, frozen);
    assert_true(kd_world_checksum(a) != kd_world_checksum(b));
    kd_remove(b, in_b, frozen);
    kd_set_name(b, in_b, "x");
    assert_true(kd_world_checksum(a) != kd_world_checksum(b));
    kd_set_name(b, in_b, "");
    assert_true(kd_world_checksum(a) == kd_world_checksum(b));
    kd_entity child_b = kd_spawn(b, KD_TAG(frozen)), child_a = kd_spawn(a, KD_TAG(frozen));
    kd_set_parent(b, child_b, in_b);
    assert_true(kd_world_checksum(a) != kd_world_checksum(b));
    kd_set_parent(a, child_a, in_a);
    assert_true(kd_world_checksum(a) == kd_world_checksum(b));
    kd_world_destroy(b);
}

static void checksum_leaves_padding_out(void **state)
{
    kd_world *a = *state, *b = kd_world_make();
    padded p, q;
    memset(&p, 0xff, sizeof p);
    memset(&q, 0, sizeof q);
    p.flag = q.flag = 1;
    p.value = q.value = 77;
    kd_spawn_values(a, &(kd_value){&padded_desc, &p}, 1);
    kd_spawn_values(b, &(kd_value){&padded_desc, &q}, 1);
    assert_true(kd_world_checksum(a) == kd_world_checksum(b));
    kd_world_destroy(b);
}

static void bytes_grow_with_the_world_and_stay_near_the_payload(void **state)
{
    kd_world *w = *state;
    size_t empty = kd_world_bytes(w);
    for (int i = 0; i < 100000; i++)
        kd_spawn(w, KD_TAG(position), KD_TAG(velocity), KD_TAG(health));
    double each = (double)(kd_world_bytes(w) - empty) / 100000;
    assert_true(each >= 32 + 16);          /* payload, handle, record */
    assert_true(each <= (32 + 16) * 1.27); /* columns grow by a quarter at most, versions are small */
}

static void limit_makes_calls_fail_and_leaves_the_world_whole(void **state)
{
    kd_world *w = *state;
    kd_entity last = KD_NO_ENTITY, e;
    uint32_t count = 0;
    kd_world_limit_bytes(w, kd_world_bytes(w) + 100000);
    while ((e = kd_spawn(w, KD_VAL(position, {1, 2, 3}), KD_TAG(health))).generation) {
        last = e;
        count++;
    }
    assert_in_range(count, 100, 100000 / 20);
    assert_int_equal(kd_entity_count(w), count);
    assert_true(kd_find(w, last, position)->z == 3);
    const kd_component_desc *descs[] = {&position_desc};
    assert_int_equal(kd_spawn_n(w, 100000, descs, NULL, 1, NULL), KD_NO_MEMORY);
    kd_world_limit_bytes(w, 0);
    assert_true(kd_alive(w, kd_spawn(w, KD_VAL(position, {1, 2, 3}), KD_TAG(health))));
}

static void values_lie_where_their_type_may_or_are_refused(void **state)
{
    (void)state;
    static const kd_component_desc wide = {.name = "wide", .size = 192, .align = 64};
    static const kd_component_desc wider = {.name = "wider", .size = 256, .align = 128};
    kd_world *w = kd_world_make();
    for (int i = 0; i < 3; i++) {
        kd_entity e = kd_spawn(w, ((kd_value){&wide, NULL}), KD_TAG(position));
        assert_int_equal((uintptr_t)kd_find_id(w, e, kd_component_ensure(w, &wide)) % 64, 0);
    }
    kd_log_set_sink(silent, NULL);
    assert_int_equal(kd_component_ensure(w, &wider), 0);
    kd_log_set_sink(NULL, NULL);
    kd_world_destroy(w);
}

#define OWNED_PAIR KD_VAL(owner, {owned(1)}), KD_VAL(owner, {owned(2)})

/* By every way to spawn: a path, more values than a path has, a child, many at once, a recorded command. */
static void spawn_releases_the_first_of_an_owning_component_given_twice(void **state)
{
    kd_world *w = *state;
    enum { MANY = 40 };
    kd_value many[MANY] = {OWNED_PAIR};
    for (int i = 2; i < MANY; i++)
        many[i] = KD_TAG(position);
    owner_releases = 0;
    kd_entity e[6];
    e[0] = kd_spawn(w, OWNED_PAIR, KD_TAG(position));
    e[1] = kd_spawn_values(w, many, MANY);
    e[2] = kd_spawn_child(w, e[0], OWNED_PAIR);
    assert_int_equal(owner_releases, 3);
    const owner first[2] = {{owned(1)}, {owned(1)}}, second[2] = {{owned(2)}, {owned(2)}};
    assert_int_equal(kd_spawn_n(w, 2, (const kd_component_desc *const[]){&owner_desc, &owner_desc},
                                (const void *const[]){first, second}, 2, e + 3),
                     KD_OK);
    assert_int_equal(owner_releases, 5);
    e[5] = kd_commands_spawn(kd_world_commands(w, 0), (kd_value[]){OWNED_PAIR}, 2);
    assert_int_equal(kd_world_merge(w), KD_OK);
    assert_int_equal(owner_releases, 6);
    for (int i = 0; i < 6; i++)
        assert_int_equal(*kd_find(w, e[i], owner)->memory, 2);
}

int main(void)
{
#define CASE(test) cmocka_unit_test_setup_teardown(test, make, drop)
    const struct CMUnitTest tests[] = {
        CASE(component_gets_ids_from_one_upwards),
        CASE(component_is_found_by_name),
        CASE(component_copies_of_a_description_agree),
        CASE(component_of_one_name_and_another_size_is_refused),
        CASE(component_table_fills_up_with_an_error),
        CASE(worlds_have_ids_of_their_own),
        CASE(spawn_writes_all_values),
        CASE(spawn_without_values_makes_an_empty_entity),
        CASE(spawn_takes_the_last_of_a_component_given_twice),
        CASE(spawn_releases_the_first_of_an_owning_component_given_twice),
        CASE(spawn_reads_values_that_lie_in_the_world),
        CASE(spawn_n_copies_columns_and_fills_defaults),
        CASE(destroyed_handle_is_dead_and_harmless),
        CASE(handles_never_made_are_dead),
        CASE(lookup_finds_what_find_finds),
        CASE(index_rests_when_its_generations_are_used_up),
        CASE(same_calls_give_the_same_handles),
        CASE(set_adds_and_replaces),
        CASE(remove_takes_one_component_away),
        CASE(columns_are_aligned_to_a_cache_line),
        CASE(hook_runs_on_remove_set_destroy_and_end),
        CASE(singleton_starts_as_default_and_stays_in_place),
        CASE(name_finds_the_one_named_first),
        CASE(names_survive_many_changes),
        CASE(checksum_tells_worlds_apart),
        CASE(checksum_leaves_padding_out),
        CASE(bytes_grow_with_the_world_and_stay_near_the_payload),
        CASE(limit_makes_calls_fail_and_leaves_the_world_whole),
        cmocka_unit_test(values_lie_where_their_type_may_or_are_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
