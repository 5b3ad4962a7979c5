#ifndef KD_GPU_WORK_LIST_H
#define KD_GPU_WORK_LIST_H

/* A buffer in which one pass lists what the next one works on: arguments of an indirect dispatch of groups of
 * 64, the count, and the items, one word each. Shaders fill it through shaders/include/work_list_fill.glsl
 * and read it through work_list.glsl; it is dispatched by kd_gpu_dispatch_indirect(gpu, program, list, 0). */

#include "runtime/gpu/gpu.h"

/* What one dispatch takes everywhere. */
#define KD_WORK_LIST_MOST (65535u * 64u)

/** Make room for `items` items. Errors KD_GPU */
kd_status kd_gpu_fit_work_list(kd_gpu *gpu, kd_gpu_buffer *list, uint32_t items, const char *name);
/** Empty it. The caller sees to a storage barrier before it is filled. */
void kd_gpu_clear_work_list(kd_gpu *gpu, kd_gpu_buffer list);

#endif
