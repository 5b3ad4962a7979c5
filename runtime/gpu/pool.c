#include <stdlib.h>
#include <string.h>

#include "runtime/gpu/internal.h"

enum { INDEX_BITS = 20, MAX_ITEMS = (1 << INDEX_BITS) - 1, GENERATION_MASK = 0xfff };

static bool grow(gpu_pool *pool)
{
    uint32_t capacity = pool->capacity ? pool->capacity * 2 : 64;
    char *items = realloc(pool->items, capacity * pool->item_size);
    if (items)
        pool->items = items;
    uint16_t *generations = realloc(pool->generations, capacity * sizeof *generations);
    if (generations)
        pool->generations = generations;
    uint32_t *free_slots = realloc(pool->free_slots, capacity * sizeof *free_slots);
    if (free_slots)
        pool->free_slots = free_slots;
    if (!items || !generations || !free_slots)
        return false;
    memset(generations + pool->capacity, 0, (capacity - pool->capacity) * sizeof *generations);
    pool->capacity = capacity;
    return true;
}

uint32_t gpu_pool_add(gpu_pool *pool, void **item)
{
    uint32_t index;
    if (pool->free_count) {
        index = pool->free_slots[--pool->free_count];
    } else {
        if (pool->count == MAX_ITEMS || (pool->count == pool->capacity && !grow(pool)))
            return 0;
        index = pool->count++;
    }
    pool->generations[index] = (uint16_t)((pool->generations[index] + 1) & GENERATION_MASK);
    *item = pool->items + index * pool->item_size;
    memset(*item, 0, pool->item_size);
    return (uint32_t)pool->generations[index] << INDEX_BITS | (index + 1);
}

void *gpu_pool_find(const gpu_pool *pool, uint32_t id)
{
    uint32_t index = (id & MAX_ITEMS) - 1; /* wraps for id 0 */
    if (index >= pool->count || pool->generations[index] != id >> INDEX_BITS ||
        !(pool->generations[index] & 1))
        return NULL;
    return pool->items + index * pool->item_size;
}

void gpu_pool_remove(gpu_pool *pool, uint32_t id)
{
    uint32_t index = (id & MAX_ITEMS) - 1;
    if (!gpu_pool_find(pool, id))
        return;
    pool->generations[index] = (uint16_t)((pool->generations[index] + 1) & GENERATION_MASK);
    pool->free_slots[pool->free_count++] = index;
}

uint32_t gpu_pool_next(const gpu_pool *pool, uint32_t id)
{
    for (uint32_t index = id & MAX_ITEMS; index < pool->count; index++)
        if (pool->generations[index] & 1)
            return (uint32_t)pool->generations[index] << INDEX_BITS | (index + 1);
    return 0;
}

void gpu_pool_fini(gpu_pool *pool)
{
    free(pool->items);
    free(pool->generations);
    free(pool->free_slots);
    *pool = (gpu_pool){0};
}
