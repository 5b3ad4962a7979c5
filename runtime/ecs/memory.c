/* Blocks aligned to a cache line. The 64 bytes before a block say how long it is, so that the world can count
 * what it holds and refuse to pass its limit. */

#include <stdlib.h>

#include "runtime/ecs/internal.h"

#define LINE 64u

typedef struct block_head {
    size_t bytes;
} block_head;

static block_head *head_of(void *block) {
    return (block_head *)(void *)((uint8_t *)block - LINE);
}

/* Count `grow` more and `shrink` fewer bytes; false when that would pass the limit. */
static bool account(kd_world *w, size_t grow, size_t shrink) {
    size_t before = atomic_fetch_add_explicit(&w->bytes, grow - shrink, memory_order_relaxed);
    if (w->limit_bytes && grow > shrink && before + (grow - shrink) > w->limit_bytes) {
        atomic_fetch_sub_explicit(&w->bytes, grow - shrink, memory_order_relaxed);
        return false;
    }
    return true;
}

void *ecs_grow(kd_world *w, void *block, size_t keep_bytes, size_t bytes) {
    if (bytes > SIZE_MAX / 4)
        return NULL;
    size_t total = ((bytes + LINE - 1) & ~(size_t)(LINE - 1)) + LINE;
    size_t before = block ? head_of(block)->bytes : 0;
    if (!account(w, total, before))
        return NULL;
    uint8_t *base = aligned_alloc(LINE, total);
    if (!base) {
        account(w, before, total);
        return NULL;
    }
    ((block_head *)(void *)base)->bytes = total;
    if (keep_bytes)
        memcpy(base + LINE, block, keep_bytes);
    if (block)
        free(head_of(block));
    return base + LINE;
}

void ecs_free(kd_world *w, void *block) {
    if (!block)
        return;
    account(w, 0, head_of(block)->bytes);
    free(head_of(block));
}

uint32_t ecs_next_capacity(uint32_t capacity, uint32_t need) {
    uint64_t next = capacity < 8      ? 8
                    : capacity < 2048 ? (uint64_t)capacity * 2
                                      : (uint64_t)capacity + capacity / 4;
    if (next < need)
        next = need;
    next = next < ECS_CHUNK_ROWS ? next : (next + ECS_CHUNK_ROWS - 1) / ECS_CHUNK_ROWS * ECS_CHUNK_ROWS;
    return next > UINT32_MAX ? UINT32_MAX : (uint32_t)next;
}

bool ecs_reserve(kd_world *w, void *array_pointer, uint32_t *capacity, uint32_t count, uint32_t need,
                 size_t item_bytes) {
    if (need <= *capacity)
        return true;
    void *array;
    memcpy(&array, array_pointer, sizeof array);
    uint32_t next = ecs_next_capacity(*capacity, need);
    void *grown = ecs_grow(w, array, count * item_bytes, next * item_bytes);
    if (!grown)
        return false;
    memcpy(array_pointer, &grown, sizeof grown);
    *capacity = next;
    return true;
}
