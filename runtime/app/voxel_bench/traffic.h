#ifndef KD_APP_VOXEL_BENCH_TRAFFIC_H
#define KD_APP_VOXEL_BENCH_TRAFFIC_H

/* What a stage must move through memory, and how fast memory is. */

#include "runtime/app/voxel_bench/rig.h"

/** Measure copying on the device: the best of some, by its own copy and by a compute pass.
 *  Returns bytes a second, read and written ones counted; 0 when there is no memory for it */
double traffic_copy_rate(kd_gpu *gpu);

/** Get the bytes that a stage must move when everything is rebuilt: every input read once, every output
 *  written once, sums of attributes written and read. What caches spare or repeat is not in it. */
uint64_t traffic_of(const rig_figures *f, rig_stage stage);

#endif
