#ifndef KD_APP_STATS_H
#define KD_APP_STATS_H

#include "runtime/app/scene.h"
#include "runtime/app/timing.h"
#include "runtime/jobs/jobs.h"

/** Write what `--stats` promises: field names are a contract. Errors as kd_file_write, NO_MEMORY */
kd_status app_stats_write(const char *path, const app_scene *scene, const app_timing *timing, kd_gpu *gpu,
                          const kd_jobs *jobs, uint64_t frames);

#endif
