#include "runtime/script/pool.h"

#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

enum { CHUNK_BYTES = 1 << 16, MOST = SCRIPT_POOL_STEP * SCRIPT_POOL_CLASSES };

static size_t class_of(size_t size)
{
    return (size + SCRIPT_POOL_STEP - 1) / SCRIPT_POOL_STEP - 1;
}

static bool add_chunk(script_pool *pool)
{
    void **chunk = malloc(CHUNK_BYTES);
    if (!chunk)
        return false;
    *chunk = pool->chunks;
    pool->chunks = chunk;
    pool->rest = (char *)chunk + SCRIPT_POOL_STEP; /* which keeps blocks aligned */
    pool->rest_bytes = CHUNK_BYTES - SCRIPT_POOL_STEP;
    return true;
}

static void *take(script_pool *pool, size_t size)
{
    if (size > MOST)
        return malloc(size);
    size_t class = class_of(size), bytes = (class + 1) * SCRIPT_POOL_STEP;
    void *block = pool->free[class];
    if (block) {
        memcpy(&pool->free[class], block, sizeof block);
        return block;
    }
    if (pool->rest_bytes < bytes && !add_chunk(pool)) /* what is left of the old one is lost */
        return NULL;
    block = pool->rest;
    pool->rest += bytes;
    pool->rest_bytes -= bytes;
    return block;
}

void script_pool_free(script_pool *pool, void *block, size_t size)
{
    if (!block || size > MOST) {
        free(block);
        return;
    }
    memcpy(block, &pool->free[class_of(size)], sizeof block);
    pool->free[class_of(size)] = block;
}

void *script_pool_resize(script_pool *pool, void *block, size_t old_size, size_t new_size)
{
    if (!block)
        return take(pool, new_size);
    if (old_size > MOST && new_size > MOST)
        return realloc(block, new_size);
    if (old_size <= MOST && new_size <= MOST && class_of(old_size) == class_of(new_size))
        return block;
    void *other = take(pool, new_size);
    if (!other)
        return NULL;
    memcpy(other, block, old_size < new_size ? old_size : new_size);
    script_pool_free(pool, block, old_size);
    return other;
}

void script_pool_fini(script_pool *pool)
{
    for (void *chunk = pool->chunks, *before; chunk; chunk = before) {
        memcpy(&before, chunk, sizeof before);
        free(chunk);
    }
    *pool = (script_pool){0};
}
