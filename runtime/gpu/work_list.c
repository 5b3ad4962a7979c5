#include "runtime/gpu/work_list.h"

static const size_t WORD = sizeof(uint32_t), HEAD = 4 * sizeof(uint32_t);

kd_status kd_gpu_fit_work_list(kd_gpu *gpu, kd_gpu_buffer *list, uint32_t items, const char *name)
{
    return kd_gpu_ensure_buffer(gpu, list, HEAD + items * WORD, 0, name);
}

void kd_gpu_clear_work_list(kd_gpu *gpu, kd_gpu_buffer list)
{
    kd_gpu_fill_buffer(gpu, list, 0, HEAD, 0);
    kd_gpu_fill_buffer(gpu, list, WORD, 2 * WORD, 1); /* groups along y and z */
}
