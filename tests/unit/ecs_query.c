/* Queries: which rows they visit, in which order, and what they see as changed. */

#include <sys/wait.h>
#include <unistd.h>

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

/* Sum of position.x over the rows visited: names the set of entities when every x is a power of two. */
static uint32_t visited(kd_query *q, uint32_t term)
{
    uint32_t sum = 0;
    for (kd_iter it = kd_query_iter(q); kd_iter_next(&it);) {
        const position *p = KD_COLUMN(&it, position, term);
        for (uint32_t i = 0; i < it.count; i++)
            sum += (uint32_t)p[i].x;
    }
    return sum;
}

/* Bit 0: position alone; 1: and velocity; 2: and health; 3: both; each bit frozen as well in 4 … 7. */
static void spawn_eight_kinds(kd_world *w)
{
    for (uint32_t kind = 0; kind < 8; kind++) {
        kd_entity e = kd_spawn(w, KD_VAL(position, {(float)(1u << kind), 0, 0}));
        if (kind & 1)
            kd_set(w, e, velocity, {1, 1, 1});
        if (kind & 2)
            kd_add(w, e, health);
        if (kind & 4)
            kd_add(w, e, frozen);
    }
}

static void query_matches_by_its_terms(void **state)
{
    kd_world *w = *state;
    static const struct {
        kd_query_desc desc;
        uint32_t expected;
    } cases[] = {
        {{.terms = {KD_READ(position)}}, 0xff},
        {{.terms = {KD_READ(position), KD_READ(velocity)}}, 0xaa},
        {{.terms = {KD_READ(position), KD_WITH(health)}}, 0xcc},
        {{.terms = {KD_READ(position), KD_WITHOUT(velocity)}}, 0x55},
        {{.terms = {KD_READ(position), KD_WITHOUT(velocity), KD_WITHOUT(frozen)}}, 0x05},
        {{.terms = {KD_READ(position), KD_OPTIONAL(velocity)}}, 0xff},
        {{.terms = {KD_READ(position), KD_ANY(velocity), KD_ANY(health)}}, 0xee},
        {{.terms = {KD_READ(position), KD_ANY(velocity), KD_ANY(health), KD_WITH(frozen)}}, 0xe0},
        {{.terms = {KD_READ(position), KD_WITH(bond)}}, 0x00},
        {{.terms = {KD_READ(position), KD_WITHOUT(bond)}}, 0xff},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases;
         i += 2) /* half of them before the tables are made … */
        kd_query_make(w, &cases[i].desc);
    spawn_eight_kinds(w);
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) { /* … half after */
        kd_query *q = kd_query_make(w, &cases[i].desc);
        assert_int_equal(visited(q, 0), cases[i].expected);
        assert_int_equal(kd_query_count(q), __builtin_popcount(cases[i].expected));
    }
}

static void query_without_terms_visits_everything(void **state)
{
    kd_world *w = *state;
    kd_query *q = kd_query_make(w, &(kd_query_desc){0});
    spawn_eight_kinds(w);
    kd_spawn_values(w, NULL, 0);
    assert_int_equal(kd_query_count(q), 9);
}

static void optional_column_is_null_where_absent(void **state)
{
    kd_world *w = *state;
    kd_query *q = kd_query_make(
        w, &(kd_query_desc){.terms = {KD_READ(position), KD_OPTIONAL(velocity), KD_OPTIONAL(frozen)}});
    spawn_eight_kinds(w);
    uint32_t rows = 0;
    for (kd_iter it = kd_query_iter(q); kd_iter_next(&it); rows += it.count) {
        assert_int_equal(it.count, 1);
        uint32_t kind = (uint32_t)__builtin_ctz((uint32_t)KD_COLUMN(&it, position, 0)->x);
        assert_int_equal(KD_COLUMN(&it, velocity, 1) != NULL, (kind & 1) != 0);
        assert_int_equal(it.columns[2] != NULL, (kind & 4) != 0);
    }
    assert_int_equal(rows, 8);
}

static void equal_queries_are_one_and_counted(void **state)
{
    kd_world *w = *state;
    const kd_query_desc moving = {.terms = {KD_READ(velocity), KD_WRITE(position)}};
    const kd_query_desc sorted = {.terms = {KD_READ(velocity), KD_WRITE(position)}, .by_depth = true};
    const kd_query_desc read = {.terms = {KD_READ(velocity), KD_READ(position)}};
    kd_query *a = kd_query_make(w, &moving), *b = kd_query_make(w, &moving);
    size_t bytes = kd_world_bytes(w);
    assert_ptr_equal(a, b);
    assert_ptr_not_equal(a, kd_query_make(w, &sorted));
    assert_ptr_not_equal(a, kd_query_make(w, &read));
    kd_query_destroy(kd_query_make(w, &sorted)); /* the third count of it */
    kd_query_destroy(a);
    spawn_eight_kinds(w);
    assert_int_equal(visited(b, 1), 0xaa); /* still held by b */
    kd_query_destroy(b);
    assert_true(kd_world_bytes(w) > bytes);
    kd_query_destroy(NULL);
}

static void rows_come_in_order_of_tables_and_rows(void **state)
{
    kd_world *w = *state;
    kd_query *q = kd_query_make(w, &(kd_query_desc){.terms = {KD_READ(position)}});
    kd_entity expected[6];
    expected[0] = kd_spawn(w, KD_TAG(position), KD_TAG(velocity));
    expected[3] = kd_spawn(w, KD_TAG(position));
    expected[1] = kd_spawn(w, KD_TAG(velocity), KD_TAG(position));
    expected[4] = kd_spawn(w, KD_TAG(position));
    expected[5] = kd_spawn(w, KD_TAG(position), KD_TAG(frozen));
    expected[2] = kd_spawn(w, KD_TAG(position), KD_TAG(velocity));
    uint32_t at = 0;
    for (kd_iter it = kd_query_iter(q); kd_iter_next(&it);)
        for (uint32_t i = 0; i < it.count; i++)
            assert_entity(it.entities[i], expected[at++]);
    assert_int_equal(at, 6);
}

static void written_values_stay(void **state)
{
    kd_world *w = *state;
    enum { N = 5000 };
    static kd_entity e[N];
    kd_query *q = kd_query_make(w, &(kd_query_desc){.terms = {KD_READ(velocity), KD_WRITE(position)}});
    for (int i = 0; i < N; i++)
        e[i] = kd_spawn(w, KD_VAL(position, {(float)i, 0, 0}), KD_VAL(velocity, {1, 2, 3}));
    for (int step = 0; step < 3; step++)
        for (kd_iter it = kd_query_iter(q); kd_iter_next(&it);) {
            const velocity *v = KD_COLUMN(&it, velocity, 0);
            position *p = KD_COLUMN_MUT(&it, position, 1);
            for (uint32_t i = 0; i < it.count; i++)
                p[i] = (position){p[i].x + v[i].x, p[i].y + v[i].y, p[i].z + v[i].z};
        }
    for (int i = 0; i < N; i++) {
        const position *p = kd_find(w, e[i], position);
        assert_true(p->x == (float)i + 3 && p->y == 6 && p->z == 9);
    }
}

/* ---- change detection ---- */
static uint32_t rows_changed(kd_query *q, uint64_t since)
{
    uint32_t rows = 0;
    kd_iter it = kd_query_iter(q);
    for (it.changed_since = since; kd_iter_next(&it);)
        rows += it.count;
    return rows;
}

static void changes_are_seen_by_chunk(void **state)
{
    kd_world *w = *state;
    enum { N = 10000, CHUNK = 256 };
    static kd_entity e[N];
    kd_query *q = kd_query_make(w, &(kd_query_desc){.terms = {KD_READ(position)}});
    kd_query *other = kd_query_make(w, &(kd_query_desc){.terms = {KD_READ(velocity)}});
    for (int i = 0; i < N; i++)
        e[i] = kd_spawn(w, KD_TAG(position), KD_TAG(velocity));
    assert_int_equal(rows_changed(q, 0), N); /* 0 visits all */
    uint64_t since = kd_world_version(w);
    assert_int_equal(rows_changed(q, since), 0);
    (void)kd_find(w, e[5000], position); /* reading is no change */
    assert_int_equal(rows_changed(q, since), 0);
    kd_find_mut(w, e[5000], position)->x = 1;
    kd_find_mut(w, e[9999], position)->x = 1; /* the last chunk is shorter: 10000 - 39 * 256 = 16 rows */
    assert_int_equal(rows_changed(q, since), CHUNK + 16);
    assert_int_equal(rows_changed(other, since), 0);
    since = kd_world_version(w);
    assert_int_equal(rows_changed(q, since), 0);
    kd_set(w, e[0], position, {1, 2, 3});
    kd_set(w, e[256], position, {1, 2, 3}); /* neighbouring chunks come as one run */
    kd_iter it = kd_query_iter(q);
    it.changed_since = since;
    assert_true(kd_iter_next(&it));
    assert_int_equal(it.count, 2 * CHUNK);
    assert_entity(it.entities[0], e[0]);
    assert_false(kd_iter_next(&it));
}

static void changes_are_seen_after_writing_a_column(void **state)
{
    kd_world *w = *state;
    kd_query *read = kd_query_make(w, &(kd_query_desc){.terms = {KD_READ(position)}});
    kd_query *write = kd_query_make(w, &(kd_query_desc){.terms = {KD_WRITE(position), KD_WITH(health)}});
    for (int i = 0; i < 100; i++)
        kd_spawn(w, KD_TAG(position));
    for (int i = 0; i < 50; i++)
        kd_spawn(w, KD_TAG(position), KD_TAG(health));
    uint64_t since = kd_world_version(w);
    for (kd_iter it = kd_query_iter(write); kd_iter_next(&it);)
        (void)KD_COLUMN(&it, position, 0); /* only read */
    assert_int_equal(rows_changed(read, since), 0);
    for (kd_iter it = kd_query_iter(write); kd_iter_next(&it);)
        KD_COLUMN_MUT(&it, position, 0)->x = 1;
    assert_int_equal(rows_changed(read, since), 50);
}

static void changes_include_rows_that_came_or_moved(void **state)
{
    kd_world *w = *state;
    kd_query *q = kd_query_make(w, &(kd_query_desc){.terms = {KD_READ(position)}});
    kd_query *tags = kd_query_make(w, &(kd_query_desc){.terms = {KD_WITH(frozen)}});
    kd_entity first = kd_spawn(w, KD_TAG(position));
    for (int i = 1; i < 1000; i++)
        kd_spawn(w, KD_TAG(position));
    uint64_t since = kd_world_version(w);
    kd_spawn(w, KD_TAG(position)); /* row 1000 in the last chunk: 1001 - 3 * 256 = 233 rows */
    assert_int_equal(rows_changed(q, since), 233);
    since = kd_world_version(w);
    kd_destroy(w, first); /* the last row moves into the first chunk */
    assert_int_equal(rows_changed(q, since), 256);
    since = kd_world_version(w);
    assert_int_equal(rows_changed(tags, since), 0);
    kd_spawn(w, KD_TAG(frozen)); /* a query that accesses nothing sees arrivals */
    assert_int_equal(rows_changed(tags, since), 1);
}

/* ---- order by depth ---- */
static void depth_order_visits_parents_first(void **state)
{
    kd_world *w = *state;
    kd_query *q = kd_query_make(w, &(kd_query_desc){.terms = {KD_READ(position)}, .by_depth = true});
    enum { N = 400 };
    kd_entity e[N];
    bool seen[N] = {false};
    uint64_t random = 5;
    for (int i = 0; i < N; i++) {
        e[i] = random_below(&random, 2) ? kd_spawn(w, KD_TAG(position))
                                        : kd_spawn(w, KD_TAG(position), KD_TAG(frozen));
        if (i)
            assert_int_equal(kd_set_parent(w, e[random_below(&random, (uint32_t)i)], e[i]), KD_OK);
    }
    uint32_t rows = 0, depth = 0;
    for (kd_iter it = kd_query_iter(q); kd_iter_next(&it); rows += it.count)
        for (uint32_t i = 0; i < it.count; i++) {
            kd_entity parent = kd_get_parent(w, it.entities[i]);
            assert_true(!parent.generation || seen[parent.index]);
            assert_true(kd_get_depth(w, it.entities[i]) >= depth);
            depth = kd_get_depth(w, it.entities[i]);
            assert_int_equal(it.parents != NULL, depth > 0);
            if (depth)
                assert_entity(it.parents[i], parent);
            seen[it.entities[i].index] = true;
        }
    assert_int_equal(rows, N);
    assert_true(depth > 3);
}

/* ---- misuse ---- */
static int errors;
static void count_errors(void *user, kd_log_level level, const char *text)
{
    (void)user;
    errors += level == KD_LOG_ERROR && strstr(text, "kd_commands") && strstr(text, "kd_spawn") &&
              strstr(text, "movers");
}

/* With assertions the child aborts; without, the iteration ends after one message. Both name call and query.
 */
static void structure_changed_while_iterating_is_caught(void **state)
{
    kd_world *w = *state;
    kd_query *q = kd_query_make(w, &(kd_query_desc){.terms = {KD_READ(position)}, .name = "movers"});
    kd_spawn(w, KD_TAG(position));
    kd_spawn(w, KD_TAG(position), KD_TAG(health));
    pid_t child = fork();
    assert_true(child >= 0);
    if (!child) {
        int rows = 0;
        if (!freopen("/dev/null", "w", stderr))
            _exit(9);
        kd_log_set_sink(count_errors, NULL);
        for (kd_iter it = kd_query_iter(q); kd_iter_next(&it); rows++)
            kd_spawn(w, KD_TAG(position));
        _exit(rows == 1 && errors == 1 ? 0 : 1);
    }
    int status;
    waitpid(child, &status, 0);
    assert_true((WIFSIGNALED(status) && WTERMSIG(status) == SIGABRT) ||
                (WIFEXITED(status) && WEXITSTATUS(status) == 0));
}

/* With assertions the child aborts; without, there is no column. */
static void a_term_that_is_not_there_has_no_column_to_write(void **state)
{
    kd_world *w = *state;
    kd_query *q = kd_query_make(w, &(kd_query_desc){.terms = {KD_WRITE(position)}});
    kd_spawn(w, KD_TAG(position));
    pid_t child = fork();
    assert_true(child >= 0);
    if (!child) {
        if (!freopen("/dev/null", "w", stderr))
            _exit(9);
        kd_iter it = kd_query_iter(q);
        if (!kd_iter_next(&it))
            _exit(8);
        for (uint32_t term = 1; term < KD_MAX_TERMS; term++)
            if (KD_COLUMN_MUT(&it, position, term))
                _exit(1);
        _exit(0);
    }
    int status;
    waitpid(child, &status, 0);
    assert_true((WIFSIGNALED(status) && WTERMSIG(status) == SIGABRT) ||
                (WIFEXITED(status) && WEXITSTATUS(status) == 0));
}

static void iterator_left_by_break_leaves_nothing_behind(void **state)
{
    kd_world *w = *state;
    kd_query *q = kd_query_make(w, &(kd_query_desc){.terms = {KD_READ(position)}});
    for (int i = 0; i < 10; i++)
        kd_spawn(w, KD_TAG(position));
    for (kd_iter it = kd_query_iter(q); kd_iter_next(&it);)
        break;
    kd_spawn(w, KD_TAG(position));
    assert_int_equal(rows_changed(q, 0), 11);
}

int main(void)
{
#define CASE(test) cmocka_unit_test_setup_teardown(test, make, drop)
    const struct CMUnitTest tests[] = {
        CASE(query_matches_by_its_terms),
        CASE(query_without_terms_visits_everything),
        CASE(optional_column_is_null_where_absent),
        CASE(equal_queries_are_one_and_counted),
        CASE(rows_come_in_order_of_tables_and_rows),
        CASE(written_values_stay),
        CASE(changes_are_seen_by_chunk),
        CASE(changes_are_seen_after_writing_a_column),
        CASE(changes_include_rows_that_came_or_moved),
        CASE(depth_order_visits_parents_first),
        CASE(structure_changed_while_iterating_is_caught),
        CASE(a_term_that_is_not_there_has_no_column_to_write),
        CASE(iterator_left_by_break_leaves_nothing_behind),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
