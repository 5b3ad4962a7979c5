/* `kandil bench`: rows go to a table on standard output as they come, and at the end to the JSON file. */
#include "runtime/app/bench.h"

#include <stdio.h>
#include <string.h>

#include "runtime/bench/bench.h"
#include "runtime/core/file.h"
#include "runtime/core/json.h"
#include "runtime/core/log.h"

static void put_number(kd_json *j, const char *key, double value)
{
    kd_json_key(j, key);
    kd_json_double(j, value);
}

static void put_row(kd_json *j, const kd_bench_row *row)
{
    kd_json_object_begin(j);
    kd_json_key(j, "bench");
    kd_json_string(j, row->bench);
    kd_json_key(j, "case");
    kd_json_string(j, row->name);
    kd_json_key(j, "n");
    kd_json_uint(j, row->n);
    kd_json_key(j, "threads");
    kd_json_uint(j, row->threads);
    kd_json_key(j, "unit");
    kd_json_string(j, row->unit);
    put_number(j, "median", row->median);
    put_number(j, "min", row->min);
    put_number(j, "max", row->max);
    kd_json_key(j, "limit");
    if (row->limit > 0)
        kd_json_double(j, row->limit);
    else
        kd_json_null(j);
    kd_json_object_end(j);
}

static void take_row(void *user, const kd_bench_row *row)
{
    printf("%-7s %-25s %9u %7u %11.4g %11.4g %11.4g ", row->bench, row->name, row->n, row->threads,
           row->median, row->min, row->max);
    if (row->limit > 0)
        printf("%11.4g %s\n", row->limit, row->unit);
    else
        printf("%11s %s\n", "-", row->unit);
    fflush(stdout);
    put_row(user, row);
}

static kd_status measure(const app_options *options, const kd_bench_desc *desc)
{
    bool all = options->bench == APP_BENCH_ALL;
    kd_status status = kd_bench_limits(desc);
    if (status == KD_OK && (all || options->bench == APP_BENCH_ECS))
        status = kd_bench_ecs(desc);
    if (status == KD_OK && (all || options->bench == APP_BENCH_JOBS))
        status = kd_bench_jobs(desc);
    return status;
}

static kd_status write_json(const char *path, const kd_json *j)
{
    const char *text = kd_json_text(j);
    if (!text)
        return kd_fail(KD_NO_MEMORY, "%s: out of memory; run fewer cases with --case", path);
    return kd_file_write(path, text, strlen(text));
}

kd_status app_bench_run(const app_options *options)
{
    kd_json j = {.indent = 1};
    kd_bench_desc desc = {.threads = options->threads,
                          .n = options->bench_n,
                          .only = options->bench_case,
                          .sink = take_row,
                          .user = &j};
    kd_json_object_begin(&j);
    kd_json_key(&j, "rows");
    kd_json_array_begin(&j);
    printf("%-7s %-25s %9s %7s %11s %11s %11s %11s unit\n", "bench", "case", "n", "threads", "median", "min",
           "max", "limit");
    kd_status status = measure(options, &desc);
    kd_json_array_end(&j);
    kd_json_object_end(&j);
    if (status == KD_OK && options->json)
        status = write_json(options->json, &j);
    kd_json_fini(&j);
    return status;
}
