/* The order in which a system's commands are merged: its runs of a frame one behind the other, and in a run
 * what was recorded before, in and after each loop, whichever workers ran the rows and however they were cut.
 */
#include "runtime/ecs/system.h"
#include "runtime/jobs/jobs.h"
#include "tests/unit/ecs_fixture.h"

enum { ROWS = 10000, RUNS = 3, PLACES = 5 };

typedef struct stamp {
    uint32_t order, row;
} stamp;
KD_COMPONENT_DEFINE(stamp, "stamp", KD_FIELD(stamp, order, KD_U32, NULL, "of run and place"),
                    KD_FIELD(stamp, row, KD_U32, NULL, "whose row recorded it"));

typedef struct recorder {
    kd_query *rows;
    uint32_t order;
} recorder;

static void record_rows(kd_iter *rows, kd_commands *commands, void *user)
{
    const recorder *r = user;
    for (uint32_t i = 0; i < rows->count; i++)
        kd_commands_spawn(commands, &KD_VAL(stamp, {r->order, rows->entities[i].index}), 1);
}

static void record_alone(kd_system_context *c, recorder *r)
{
    kd_commands_spawn(c->commands, &KD_VAL(stamp, {r->order++, 0}), 1);
}

static void record_loop(kd_system_context *c, recorder *r)
{
    assert_int_equal(kd_query_parallel(r->rows, c->jobs, c->command_key, record_rows, r), KD_OK);
    r->order++;
}

static void record(kd_system_context *c)
{
    recorder *r = c->user;
    record_alone(c, r);
    record_loop(c, r);
    record_alone(c, r);
    record_loop(c, r);
    record_alone(c, r);
}

/* The same by hand: a key for each row. */
static void record_range(void *user, uint32_t begin, uint32_t end, uint32_t worker)
{
    kd_system_context *c = user;
    kd_commands *commands = kd_world_commands(c->world, worker);
    for (uint32_t row = begin; row < end; row++) {
        kd_commands_key(commands, c->command_key + row);
        kd_commands_spawn(commands, &KD_VAL(stamp, {((const recorder *)c->user)->order, row}), 1);
    }
}

static void record_by_hand(kd_system_context *c)
{
    recorder *r = c->user;
    kd_jobs_parallel_for(c->jobs, ROWS, 7, record_range, c);
    r->order++;
}

static void check_order(kd_world *w, uint32_t orders, uint32_t count)
{
    kd_query *q = kd_query_make(w, &(kd_query_desc){.terms = {KD_READ(stamp)}});
    stamp last = {0, 0};
    for (kd_iter it = kd_query_iter(q); kd_iter_next(&it);) {
        const stamp *s = KD_COLUMN(&it, stamp, 0);
        for (uint32_t i = 0; i < it.count; last = s[i++])
            assert_true(s[i].order == last.order ? s[i].row >= last.row : s[i].order == last.order + 1);
    }
    assert_int_equal(last.order, orders - 1);
    assert_int_equal(kd_query_count(q), count);
}

static void check_runs(uint32_t threads, void (*run)(kd_system_context *), uint32_t orders, uint32_t count)
{
    kd_world *w = kd_world_make();
    kd_jobs *jobs = kd_jobs_make(threads);
    kd_schedule *s = kd_schedule_make(w, jobs, NULL);
    recorder r = {kd_query_make(w, &(kd_query_desc){.terms = {KD_READ(health)}}), 0};
    const kd_component_desc *const descs[] = {&health_desc};
    const void *const columns[] = {NULL};
    assert_int_equal(kd_spawn_n(w, ROWS, descs, columns, 1, NULL), KD_OK);
    assert_int_equal(kd_schedule_add(s, &(kd_system_desc){.name = "record",
                                                          .components = {KD_CHANGES(health)},
                                                          .rate = {.every_s = 0.01},
                                                          .run = run,
                                                          .user = &r}),
                     KD_OK);
    kd_schedule_set_step(s, 0.01 * RUNS);
    assert_int_equal(kd_schedule_run(s), KD_OK);
    check_order(w, orders, count);
    kd_schedule_destroy(s);
    kd_jobs_destroy(jobs);
    kd_world_destroy(w);
}

static void commands_are_merged_in_the_order_of_runs_and_loops(void **state)
{
    (void)state;
    for (uint32_t threads = 1; threads <= 4; threads++)
        check_runs(threads, record, RUNS * PLACES, RUNS * (2 * ROWS + 3));
}

static void keys_set_by_hand_are_of_one_run(void **state)
{
    (void)state;
    for (uint32_t threads = 1; threads <= 4; threads++)
        check_runs(threads, record_by_hand, RUNS, RUNS * ROWS);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(commands_are_merged_in_the_order_of_runs_and_loops),
        cmocka_unit_test(keys_set_by_hand_are_of_one_run),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
