#include "runtime/app/bench_report.h"

#include <string.h>

#include "runtime/core/file.h"
#include "runtime/core/log.h"

static void put_number(kd_json *j, const char *key, double value)
{
    kd_json_key(j, key);
    kd_json_double(j, value);
}

void app_bench_report_begin(kd_json *j)
{
    kd_json_object_begin(j);
    kd_json_key(j, "rows");
    kd_json_array_begin(j);
}

void app_bench_report_row(kd_json *j, const kd_bench_row *row)
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

void app_bench_report_end(kd_json *j)
{
    kd_json_array_end(j);
    kd_json_object_end(j);
}

kd_status app_bench_report_write(const kd_json *j, const char *path)
{
    const char *text = kd_json_text(j);
    if (!text)
        return kd_fail(KD_NO_MEMORY, "%s: out of memory; run fewer cases with --case", path);
    return kd_file_write(path, text, strlen(text));
}
