/* Every case at tiny sizes: all rows come, once, with sensible figures. Times are never asserted. */
#include <setjmp.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

#include "runtime/bench/bench.h"

typedef struct row_log {
    kd_bench_row rows[128];
    int count;
} row_log;

static void keep(void *user, const kd_bench_row *row)
{
    row_log *log = user;
    assert_in_range(log->count, 0, 127);
    log->rows[log->count++] = *row;
}

static int count_rows(const row_log *log, const char *name, uint32_t threads)
{
    int count = 0;
    for (int i = 0; i < log->count; i++)
        count += strcmp(log->rows[i].name, name) == 0 && log->rows[i].threads == threads;
    return count;
}

static void check_figures(const row_log *log)
{
    for (int i = 0; i < log->count; i++) {
        const kd_bench_row *row = &log->rows[i];
        if (!(row->min <= row->median && row->median <= row->max && row->limit >= 0) || !row->unit[0])
            fail_msg("%s, %u threads: %g %g %g limit %g", row->name, row->threads, row->min, row->median,
                     row->max, row->limit);
    }
}

static void ecs_gives_every_row_once(void **state)
{
    static const char *const names[] = {
        "iter2",
        "frag8",
        "frag256",
        "iter2_1of8_match",
        "get_random",
        "get_random_lookup",
        "destroy_bulk",
        "add1_sparse",
        "remove1_sparse",
        "is_alive_random",
        "create3",
        "create3_recycle",
        "create3_bulk",
        "prefab_inst3",
        "prefab_inst3_bulk",
        "create3_onset_observer",
        "changed_none_per_query",
        "changed_1of16_scan",
        "changed_mark_modified",
        "mem_bytes_per_entity",
        "destroy",
        "destroy_random",
        "add1",
        "remove1",
        "addremove1_each",
        "deferred_add_in_iter",
        "deferred_delete_in_iter",
        "snapshot_binary",
        "snapshot_restore",
        "tree_create",
        "tree_mem_B_per_node",
        "tree_overhead_B_per_node",
        "tree4",
        "progress_empty_frame",
        "progress_per_system_100",
        "world_init_fini",
    };
    static row_log log;
    (void)state;
    assert_int_equal(kd_bench_ecs(&(kd_bench_desc){.threads = 2, .n = 300, .sink = keep, .user = &log}),
                     KD_OK);
    for (size_t i = 0; i < sizeof names / sizeof *names; i++)
        if (count_rows(&log, names[i], 1) != 1)
            fail_msg("%s: %d rows", names[i], count_rows(&log, names[i], 1));
    assert_int_equal(count_rows(&log, "iter2", 2), 1);
    assert_int_equal(count_rows(&log, "progress_empty_frame", 2), 1);
    assert_int_equal(count_rows(&log, "progress_per_system_100", 2), 1);
    assert_int_equal(log.count, sizeof names / sizeof *names + 3);
    check_figures(&log);
}

static void jobs_give_every_row_once_for_each_pool(void **state)
{
    static const char *const names[] = {
        "empty_job",        "empty_job_batch",     "work_job",     "work_job_batch",
        "forkjoin_latency", "parfor_empty_grain1", "saxpy10M",     "chain1000",
        "dag1000",          "dag1000_rebuilt",     "dag1000_work",
    };
    static row_log log;
    (void)state;
    assert_int_equal(kd_bench_jobs(&(kd_bench_desc){.threads = 2, .n = 50, .sink = keep, .user = &log}),
                     KD_OK);
    for (size_t i = 0; i < sizeof names / sizeof *names; i++)
        for (uint32_t threads = 1; threads <= 2; threads++)
            assert_int_equal(count_rows(&log, names[i], threads), 1);
    assert_int_equal(log.count, 2 * sizeof names / sizeof *names);
    check_figures(&log);
}

static void limits_and_parts_of_names_choose_cases(void **state)
{
    static row_log log, one;
    (void)state;
    assert_int_equal(kd_bench_limits(&(kd_bench_desc){.threads = 1, .n = 500, .sink = keep, .user = &log}),
                     KD_OK);
    assert_int_equal(log.count, 4);
    check_figures(&log);
    kd_bench_desc desc = {.threads = 1, .n = 10, .only = "frag", .sink = keep, .user = &one};
    assert_int_equal(kd_bench_ecs(&desc), KD_OK);
    assert_int_equal(one.count, 2);
    assert_string_equal(one.rows[0].name, "frag8");
    assert_string_equal(one.rows[1].name, "frag256");
}

static void a_single_entity_is_a_size_too(void **state)
{
    static row_log log;
    (void)state;
    assert_int_equal(kd_bench_ecs(&(kd_bench_desc){.threads = 1, .n = 1, .sink = keep, .user = &log}), KD_OK);
    assert_int_equal(log.count, 36);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(ecs_gives_every_row_once),
        cmocka_unit_test(jobs_give_every_row_once_for_each_pool),
        cmocka_unit_test(limits_and_parts_of_names_choose_cases),
        cmocka_unit_test(a_single_entity_is_a_size_too),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
