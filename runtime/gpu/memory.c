#include <stdlib.h>
#include <string.h>

#include "runtime/gpu/internal.h"

/* Add to the row of that name, or to a new one while there is room. */
static void add(kd_gpu_memory_row *rows, uint32_t *count, uint32_t capacity, const char *name, size_t bytes)
{
    uint32_t i = 0;
    while (i < *count && strcmp(rows[i].name, name) != 0)
        i++;
    if (i == capacity)
        return;
    if (i == *count)
        rows[(*count)++] = (kd_gpu_memory_row){.name = name};
    rows[i].bytes += bytes;
    rows[i].count++;
}

static int compare(const void *a, const void *b)
{
    const kd_gpu_memory_row *left = a, *right = b;
    if (left->bytes != right->bytes)
        return left->bytes < right->bytes ? 1 : -1;
    return strcmp(left->name, right->name);
}

uint32_t kd_gpu_memory(const kd_gpu *gpu, kd_gpu_memory_row *rows, uint32_t capacity)
{
    uint32_t count = 0;
    for (uint32_t id = 0; (id = gpu_pool_next(&gpu->buffers, id)) != 0;) {
        const gpu_buffer *buffer = gpu_pool_find(&gpu->buffers, id);
        add(rows, &count, capacity, buffer->name, buffer->size);
    }
    for (uint32_t id = 0; (id = gpu_pool_next(&gpu->textures, id)) != 0;) {
        const gpu_texture *texture = gpu_pool_find(&gpu->textures, id);
        if (texture->bytes)
            add(rows, &count, capacity, texture->name, texture->bytes);
    }
    for (uint32_t id = 0; (id = gpu_pool_next(&gpu->readbacks, id)) != 0;) {
        const gpu_readback *readback = gpu_pool_find(&gpu->readbacks, id);
        add(rows, &count, capacity, readback->name, readback->area_bytes * readback->depth);
    }
    if (count)
        qsort(rows, count, sizeof *rows, compare);
    return count;
}
