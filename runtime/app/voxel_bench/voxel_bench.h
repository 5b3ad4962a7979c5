#ifndef KD_APP_VOXEL_BENCH_VOXEL_BENCH_H
#define KD_APP_VOXEL_BENCH_VOXEL_BENCH_H

#include "runtime/app/options.h"
#include "runtime/core/json.h"

/** `kandil bench voxels`: the stages of the voxel scene over resolutions of the cascades and over counts of
 *  skinned characters, with the line through their costs.
 *  Errors with one message; INTERRUPTED; rows so far are in `json`
 *  Source  Yalciner 2016, tables 5.1 to 5.3 */
kd_status app_bench_voxels(const app_options *options, kd_json *json);

/** `kandil bench svo`: builds side by side, one layer against two, and what the tree holds (--dump). Errors
 * as above */
kd_status app_bench_svo(const app_options *options, kd_json *json);

#endif
