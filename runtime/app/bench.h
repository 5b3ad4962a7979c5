#ifndef KD_APP_BENCH_H
#define KD_APP_BENCH_H

#include "runtime/app/options.h"

/** Measure what the command line asks for, print a table and write the JSON file. */
kd_status app_bench_run(const app_options *options);

#endif
