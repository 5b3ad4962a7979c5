/* `kandil bench`: rows go to a table on standard output as they come, and at the end to the JSON file. */
#include "runtime/app/bench.h"

#include <stdio.h>

#include "runtime/app/bench_report.h"
#include "runtime/app/voxel_bench/voxel_bench.h"
#include "runtime/bench/bench.h"
#include "runtime/core/file.h"

static void take_row(void *user, const kd_bench_row *row)
{
    printf("%-7s %-25s %9u %7u %11.4g %11.4g %11.4g ", row->bench, row->name, row->n, row->threads,
           row->median, row->min, row->max);
    if (row->limit > 0)
        printf("%11.4g %s\n", row->limit, row->unit);
    else
        printf("%11s %s\n", "-", row->unit);
    fflush(stdout);
    app_bench_report_row(user, row);
}

static bool wanted(const app_options *options, app_bench bench)
{
    return options->bench == APP_BENCH_ALL || options->bench == bench;
}

static kd_status measure_runtime(const app_options *options, kd_json *j)
{
    kd_bench_desc desc = {.threads = options->threads,
                          .n = options->bench_n,
                          .only = options->bench_case,
                          .sink = take_row,
                          .user = j};
    printf("%-7s %-25s %9s %7s %11s %11s %11s %11s unit\n", "bench", "case", "n", "threads", "median", "min",
           "max", "limit");
    kd_status status = kd_bench_limits(&desc);
    if (status == KD_OK && wanted(options, APP_BENCH_ECS))
        status = kd_bench_ecs(&desc);
    if (status == KD_OK && wanted(options, APP_BENCH_JOBS))
        status = kd_bench_jobs(&desc);
    return status;
}

static kd_status measure(const app_options *options, kd_json *j)
{
    kd_status status = KD_OK;
    if (wanted(options, APP_BENCH_ECS) || wanted(options, APP_BENCH_JOBS))
        status = measure_runtime(options, j);
    if (status == KD_OK && wanted(options, APP_BENCH_VOXELS))
        status = app_bench_voxels(options, j);
    if (status == KD_OK && wanted(options, APP_BENCH_SVO))
        status = app_bench_svo(options, j);
    return status;
}

/* Find out what would fail at the end. */
static kd_status check_output(const app_options *options)
{
    kd_file_out probe;
    kd_status status = options->json ? kd_file_out_open(&probe, options->json) : KD_OK;
    if (options->json && status == KD_OK)
        kd_file_out_cancel(&probe);
    return status;
}

kd_status app_bench_run(const app_options *options)
{
    kd_json j = {.indent = 1};
    kd_status status = check_output(options);
    if (status != KD_OK)
        return status;
    app_bench_report_begin(&j);
    status = measure(options, &j);
    app_bench_report_end(&j);
    if (status == KD_OK && options->json)
        status = app_bench_report_write(&j, options->json);
    kd_json_fini(&j);
    return status;
}
