#ifndef KD_APP_GPU_TIMING_H
#define KD_APP_GPU_TIMING_H

/* When the GPU ran what: by pairs of timestamps that arrive some frames later, or by finishing before and
 * after and reading the CPU's clock. Parts of a system are told apart by their programs. */

#include "runtime/gpu/gpu.h"
#include "runtime/profile/profile.h"

typedef struct app_gpu_timing app_gpu_timing;

/** Make one that feeds the profile; `idle_row` is the row of the time in which a frame's GPU did nothing.
 *  sync    finish round each system; else timestamps
 *  passes  also tell apart what runs within a system
 *  Returns NULL when memory is out */
app_gpu_timing *app_gpu_timing_make(kd_gpu *gpu, kd_profile *profile, uint32_t frame_row, uint32_t idle_row,
                                    bool sync, bool passes);
void app_gpu_timing_destroy(app_gpu_timing *g);

void app_gpu_timing_begin(app_gpu_timing *g, uint32_t system);
void app_gpu_timing_end(app_gpu_timing *g, uint32_t system);
/** Feed what has arrived. Called after kd_gpu_end_frame; with `all` it waits for everything. */
void app_gpu_timing_collect(app_gpu_timing *g, bool all);

#endif
