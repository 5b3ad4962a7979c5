/* Systems that do not do what they declare are caught, with names; those that do are left alone. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include <signal.h>
#include <stdio.h>
#include <string.h>
#include <sys/wait.h>
#include <unistd.h>

#include "runtime/core/log.h"
#include "runtime/ecs/relation.h"
#include "runtime/ecs/system.h"
#include "runtime/jobs/jobs.h"

typedef struct place {
    uint32_t value;
} place;
typedef struct speed {
    uint32_t value;
} speed;
typedef struct mark {
    uint32_t value;
} mark;
KD_COMPONENT_DEFINE(place, "place", KD_FIELD(place, value, KD_U32, NULL, "a number"));
KD_COMPONENT_DEFINE(speed, "speed", KD_FIELD(speed, value, KD_U32, NULL, "a number"));
typedef struct trust_given trust_given;
KD_TAG_DEFINE(trust_given, "trust_given");
typedef struct trust {
    uint32_t value;
} trust;
KD_RELATION_DEFINE(trust, "trust", 0, KD_FIELD(trust, value, KD_U32, NULL, "a number"));
KD_COMPONENT_DEFINE_FLAGS(mark, "mark", KD_COMPONENT_SPARSE, KD_FIELD(mark, value, KD_U32, NULL, "a number"));

static char message[1024];

static void keep_message(void *user, kd_log_level level, const char *text)
{
    (void)user;
    (void)level;
    strncpy(message, text, sizeof message - 1);
}

/* A world of 1000 entities with place and speed, the first of which has a mark; one system. */
static kd_status run_one(kd_system_desc desc, uint32_t threads, bool checked)
{
    kd_world *w = kd_world_make();
    kd_jobs *jobs = kd_jobs_make(threads);
    kd_schedule *s = kd_schedule_make(w, jobs, NULL);
    for (uint32_t i = 0; i < 1000; i++) {
        kd_entity e = kd_spawn(w, KD_VAL(place, {i}), KD_VAL(speed, {1}));
        if (i == 0)
            kd_set(w, e, mark, {5});
    }
    kd_relate_with(w, kd_spawn(w, KD_TAG(trust_given)), trust, kd_spawn_values(w, NULL, 0), {7});
    kd_singleton(w, speed)->value = 3;
    desc.name = "guilty";
    assert_int_equal(kd_schedule_add(s, &desc), KD_OK);
    assert_int_equal(kd_schedule_check(s, checked), KD_OK);
    message[0] = 0;
    kd_log_set_sink(keep_message, NULL);
    kd_status status = kd_schedule_run(s);
    if (status == KD_OK)
        status = kd_schedule_run(s);
    kd_log_set_sink(NULL, NULL);
    kd_schedule_destroy(s);
    kd_jobs_destroy(jobs);
    kd_world_destroy(w);
    return status;
}

static void assert_caught(kd_system_desc desc, const char *first, const char *second, const char *third)
{
    for (uint32_t threads = 1; threads <= 2; threads++) {
        assert_int_equal(run_one(desc, threads, true), KD_USAGE);
        assert_non_null(strstr(message, "system guilty"));
        assert_non_null(strstr(message, first));
        assert_non_null(strstr(message, second));
        assert_non_null(strstr(message, third));
    }
}

static kd_query *query(kd_system_context *c, const kd_query_desc *desc)
{
    kd_query *q = kd_query_make(c->world, desc);
    assert_non_null(q);
    return q;
}

/* ---- queries over what is not declared ---- */

static void move(kd_system_context *c)
{
    kd_query *q = query(c, &(kd_query_desc){.terms = {KD_WRITE(place), KD_READ(speed)}, .name = "move"});
    for (kd_iter it = kd_query_iter(q); kd_iter_next(&it);) {
        place *p = KD_COLUMN_MUT(&it, place, 0);
        const speed *v = KD_COLUMN(&it, speed, 1);
        for (uint32_t i = 0; i < it.count; i++)
            p[i].value += v[i].value;
    }
    kd_query_destroy(q);
}

static void declared_system_passes(void **state)
{
    (void)state;
    assert_int_equal(
        run_one((kd_system_desc){.components = {KD_CHANGES(place), KD_USES(speed)}, .run = move}, 2, true),
        KD_OK);
    assert_string_equal(message, "");
    assert_int_equal(run_one((kd_system_desc){.exclusive = true, .run = move}, 2, true), KD_OK);
    assert_int_equal(run_one((kd_system_desc){.components = {KD_USES(place)}, .run = move}, 2, false), KD_OK);
}

static void query_over_undeclared_component_is_caught(void **state)
{
    (void)state;
    assert_caught((kd_system_desc){.components = {KD_CHANGES(place)}, .run = move}, "query move reads",
                  "component speed", "does not declare");
    assert_caught((kd_system_desc){.components = {KD_USES(place), KD_USES(speed)}, .run = move},
                  "query move writes", "component place", "declares as read");
}

static void shift_rows(kd_iter *rows, kd_commands *commands, void *user)
{
    place *p = KD_COLUMN_MUT(rows, place, 0);
    (void)commands;
    (void)user;
    for (uint32_t i = 0; i < rows->count; i++)
        p[i].value++;
}

static void shift_in_parallel(kd_system_context *c)
{
    kd_query *q = query(c, &(kd_query_desc){.terms = {KD_WRITE(place)}, .name = "shift"});
    assert_int_equal(kd_query_parallel(q, c->jobs, c->command_key, shift_rows, NULL), KD_OK);
    kd_query_destroy(q);
}

static void parallel_query_is_caught_too(void **state)
{
    (void)state;
    assert_caught((kd_system_desc){.components = {KD_USES(place)}, .run = shift_in_parallel},
                  "query shift writes", "component place", "KD_CHANGES");
    assert_int_equal(
        run_one((kd_system_desc){.components = {KD_CHANGES(place)}, .run = shift_in_parallel}, 2, true),
        KD_OK);
}

/* ---- writes behind the query's back ---- */

/* Write row 300 through the pointer of a read column. */
static void write_through_read_column(kd_system_context *c)
{
    kd_query *q = query(c, &(kd_query_desc){.terms = {KD_READ(place)}, .name = "look"});
    for (kd_iter it = kd_query_iter(q); kd_iter_next(&it);)
        ((place *)(uintptr_t)KD_COLUMN(&it, place, 0))[300].value++;
    kd_query_destroy(q);
}

static void write_through_read_column_is_caught(void **state)
{
    (void)state;
    assert_caught((kd_system_desc){.components = {KD_USES(place)}, .run = write_through_read_column},
                  "wrote component place, which it declares as read",
                  "rows 256 to 511 of the table place+speed", "shown by query look");
}

static void ask_to_write_read_column(kd_system_context *c)
{
    kd_query *q = query(c, &(kd_query_desc){.terms = {KD_READ(place)}, .name = "look"});
    kd_iter it = kd_query_iter(q);
    if (kd_iter_next(&it) && KD_COLUMN_MUT(&it, place, 0))
        strcpy(message, "it was given");
    kd_query_destroy(q);
}

/* In a child, with its messages in a file: where the library has assertions this ends it. */
static void asking_to_write_a_read_column_names_system_and_query(void **state)
{
    (void)state;
    FILE *said = tmpfile();
    assert_non_null(said);
    pid_t child = fork();
    if (child == 0) {
        signal(SIGABRT, SIG_DFL); /* cmocka catches it */
        dup2(fileno(said), STDERR_FILENO);
        kd_world *w = kd_world_make();
        kd_schedule *s = kd_schedule_make(w, NULL, NULL);
        kd_spawn(w, KD_VAL(place, {1}));
        kd_schedule_add(s, &(kd_system_desc){.name = "guilty",
                                             .components = {KD_CHANGES(place)},
                                             .run = ask_to_write_read_column});
        message[0] = 0;
        kd_schedule_run(s);
        _exit(message[0] != 0);
    }
    int status = 0;
    assert_int_equal(waitpid(child, &status, 0), child);
    assert_true(WIFSIGNALED(status) ? WTERMSIG(status) == SIGABRT : WEXITSTATUS(status) == 0);
    rewind(said);
    char text[1024] = "";
    assert_true(fread(text, 1, sizeof text - 1, said) > 0);
    fclose(said);
    assert_non_null(
        strstr(text, "system guilty: query look: component place is written but declared as read"));
}

/* A pointer that was kept from an earlier frame, to a component that is not declared at all. */
static void write_kept_pointer(kd_system_context *c)
{
    static const speed *kept;
    kd_query *q = query(c, &(kd_query_desc){.terms = {KD_WITH(speed)}});
    if (c->frame == 0) {
        kd_iter it = kd_query_iter(q);
        assert_true(kd_iter_next(&it));
        kept = kd_find_id(c->world, it.entities[999], KD_ID(c->world, speed));
    }
    ((speed *)(uintptr_t)kept)->value++;
    kd_query_destroy(q);
}

static void write_through_kept_pointer_is_caught(void **state)
{
    (void)state;
    assert_caught((kd_system_desc){.components = {KD_USES(speed)}, .run = write_kept_pointer},
                  "wrote component speed", "rows 768 to 999", "from entity");
}

static void write_sparse(kd_system_context *c)
{
    kd_query *q = query(c, &(kd_query_desc){.terms = {KD_READ(mark)}, .name = "marks"});
    for (kd_iter it = kd_query_iter(q); kd_iter_next(&it);)
        ((mark *)(uintptr_t)KD_COLUMN(&it, mark, 0))->value++;
    kd_query_destroy(q);
}

static void write_pair(kd_system_context *c)
{
    kd_query *q = query(c, &(kd_query_desc){.terms = {KD_WITH(trust_given)}, .name = "trustful"});
    for (kd_iter it = kd_query_iter(q); kd_iter_next(&it);)
        ((trust *)(uintptr_t)kd_target_values(c->world, it.entities[0], trust))->value++;
    kd_query_destroy(q);
}

static void write_singleton(kd_system_context *c)
{
    kd_singleton(c->world, speed)->value++;
}

static void sparse_values_and_singletons_are_compared(void **state)
{
    (void)state;
    assert_caught((kd_system_desc){.components = {KD_USES(mark)}, .run = write_sparse},
                  "wrote component mark", "sparse values", "shown by query marks");
    assert_caught((kd_system_desc){.components = {KD_USES(trust)}, .run = write_pair},
                  "wrote component trust", "values of its pairs", "declares as read");
    assert_caught((kd_system_desc){.components = {KD_USES(speed)}, .run = write_singleton},
                  "wrote component speed", "the singleton", "declares as read");
    assert_caught((kd_system_desc){.components = {KD_USES(place)}, .run = write_singleton}, "kd_singleton",
                  "component speed", "does not declare");
    assert_int_equal(
        run_one((kd_system_desc){.components = {KD_CHANGES(speed)}, .run = write_singleton}, 1, true), KD_OK);
}

static void ask_for_singleton(kd_system_context *c)
{
    assert_int_equal(kd_singleton(c->world, place)->value, 0);
}

static void first_to_ask_for_a_singleton_makes_it(void **state)
{
    (void)state;
    assert_int_equal(
        run_one((kd_system_desc){.components = {KD_USES(place)}, .run = ask_for_singleton}, 1, true), KD_OK);
}

/* ---- values by handle, structure ---- */

static void find_values(kd_system_context *c)
{
    kd_query *q = query(c, &(kd_query_desc){.terms = {KD_WITH(place)}});
    kd_iter it = kd_query_iter(q);
    assert_true(kd_iter_next(&it) && kd_has(c->world, it.entities[0], speed)); /* asking is free */
    assert_true(!c->user || kd_find(c->world, it.entities[0], speed)->value);
    kd_query_destroy(q);
}

static void find_to_write(kd_system_context *c)
{
    kd_query *q = query(c, &(kd_query_desc){.terms = {KD_WITH(speed)}});
    kd_iter it = kd_query_iter(q);
    assert_true(kd_iter_next(&it));
    kd_find_mut(c->world, it.entities[0], speed)->value++;
    kd_query_destroy(q);
}

/* Where the library has assertions the call is seen, where it has none what it did. */
static void value_found_to_write_is_caught(void **state)
{
    (void)state;
    assert_caught((kd_system_desc){.components = {KD_USES(speed)}, .run = find_to_write}, "component speed",
                  "declares as read", "KD_CHANGES");
    assert_int_equal(
        run_one((kd_system_desc){.components = {KD_CHANGES(speed)}, .run = find_to_write}, 1, true), KD_OK);
}

/* This file is compiled with assertions, so that the inlined look-up tells. */
static void found_value_of_undeclared_component_is_caught(void **state)
{
    (void)state;
    int yes;
    assert_int_equal(run_one((kd_system_desc){.components = {KD_USES(place)}, .run = find_values}, 1, true),
                     KD_OK);
    assert_caught((kd_system_desc){.components = {KD_USES(place)}, .run = find_values, .user = &yes},
                  "kd_find", "component speed", "KD_USES");
}

static void spawn_at_once(kd_system_context *c)
{
    kd_spawn(c->world, KD_VAL(place, {1}));
}

static void structure_changed_at_once_is_caught(void **state)
{
    (void)state;
    assert_caught((kd_system_desc){.components = {KD_CHANGES(place)}, .run = spawn_at_once}, "kd_spawn",
                  "structure", "commands");
}

/* ---- order ---- */

/* Both write place: 2 p + 1 against 2 (p + 1), unless one of them says so. */
static void twice(kd_system_context *c)
{
    kd_singleton(c->world, place)->value *= 2;
}
static void plus_one(kd_system_context *c)
{
    kd_singleton(c->world, place)->value++;
}

static uint32_t value_after(uint64_t seed, bool declared)
{
    kd_world *w = kd_world_make();
    kd_schedule *s = kd_schedule_make(w, NULL, NULL);
    kd_system_desc a = {.name = "twice", .components = {KD_CHANGES(place)}, .run = twice};
    kd_system_desc b = {.name = "plus one", .components = {KD_CHANGES(place)}, .run = plus_one};
    if (!declared)
        memset(b.components, 0, sizeof b.components);
    assert_int_equal(kd_schedule_add(s, &a), KD_OK);
    assert_int_equal(kd_schedule_add(s, &b), KD_OK);
    kd_schedule_randomize(s, seed);
    for (int frame = 0; frame < 4; frame++)
        assert_int_equal(kd_schedule_run(s), KD_OK);
    uint32_t value = kd_singleton(w, place)->value;
    kd_schedule_destroy(s);
    kd_world_destroy(w);
    return value;
}

static void shuffling_shows_a_missing_declaration(void **state)
{
    (void)state;
    int differ[2] = {0, 0};
    for (int declared = 0; declared < 2; declared++)
        for (uint64_t seed = 1; seed <= 20; seed++)
            differ[declared] += value_after(seed, declared) != value_after(0, declared);
    assert_true(differ[0] > 0);
    assert_int_equal(differ[1], 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(declared_system_passes),
        cmocka_unit_test(query_over_undeclared_component_is_caught),
        cmocka_unit_test(parallel_query_is_caught_too),
        cmocka_unit_test(write_through_read_column_is_caught),
        cmocka_unit_test(asking_to_write_a_read_column_names_system_and_query),
        cmocka_unit_test(write_through_kept_pointer_is_caught),
        cmocka_unit_test(sparse_values_and_singletons_are_compared),
        cmocka_unit_test(first_to_ask_for_a_singleton_makes_it),
        cmocka_unit_test(found_value_of_undeclared_component_is_caught),
        cmocka_unit_test(value_found_to_write_is_caught),
        cmocka_unit_test(structure_changed_at_once_is_caught),
        cmocka_unit_test(shuffling_shows_a_missing_declaration),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
