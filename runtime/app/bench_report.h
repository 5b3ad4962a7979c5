#ifndef KD_APP_BENCH_REPORT_H
#define KD_APP_BENCH_REPORT_H

/* Rows of `kandil bench` for its JSON file. */

#include "runtime/bench/bench.h"
#include "runtime/core/json.h"

/** Begin the file: {"rows": [ … */
void app_bench_report_begin(kd_json *j);
/** Add a row. */
void app_bench_report_row(kd_json *j, const kd_bench_row *row);
void app_bench_report_end(kd_json *j);
/** Write it. Errors as kd_file_write; NO_MEMORY when it outgrew memory */
kd_status app_bench_report_write(const kd_json *j, const char *path);

#endif
