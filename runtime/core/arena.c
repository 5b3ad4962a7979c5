/* A chain of blocks, each filled from its front. `current` is the block being filled; blocks behind it in the
 * chain are kept from before the last reset and count as empty, whatever their `used` says. */
#include "runtime/core/arena.h"

#include <stdarg.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { ALIGNMENT = 64, DEFAULT_BLOCK_BYTES = 64 * 1024 };

struct kd_arena_block {
    kd_arena_block *next;
    size_t capacity, used; /* of the bytes behind this header */
};

static unsigned char *block_bytes(kd_arena_block *block)
{
    return (unsigned char *)block + ALIGNMENT;
}

static kd_arena_block *make_block(size_t capacity)
{
    kd_arena_block *block = aligned_alloc(ALIGNMENT, ALIGNMENT + capacity);
    if (block)
        *block = (kd_arena_block){.capacity = capacity};
    return block;
}

/* Make `current` a block with room: the next kept one that is large enough, else a new one behind it. */
static kd_arena_block *advance(kd_arena *arena, size_t size)
{
    kd_arena_block *last = arena->current;
    for (kd_arena_block *b = last ? last->next : arena->first; b; last = b, b = b->next) {
        b->used = 0;
        if (b->capacity >= size)
            return arena->current = b;
    }
    size_t capacity = arena->block_bytes ? (arena->block_bytes + ALIGNMENT - 1) / ALIGNMENT * ALIGNMENT
                                         : (size_t)DEFAULT_BLOCK_BYTES;
    kd_arena_block *block = make_block(size > capacity ? size : capacity);
    if (!block)
        return NULL;
    *(last ? &last->next : &arena->first) = block;
    return arena->current = block;
}

void *kd_arena_alloc(kd_arena *arena, size_t size)
{
    if (size > SIZE_MAX / 2)
        return NULL;
    size_t rounded = (size + ALIGNMENT - 1) / ALIGNMENT * ALIGNMENT;
    kd_arena_block *block = arena->current;
    if (!block || block->capacity - block->used < rounded)
        block = advance(arena, rounded);
    if (!block)
        return NULL;
    void *result = block_bytes(block) + block->used;
    block->used += rounded;
    arena->used_bytes += rounded;
    return memset(result, 0, size);
}

char *kd_arena_printf(kd_arena *arena, const char *format, ...)
{
    va_list args, again;
    va_start(args, format);
    va_copy(again, args);
    int length = vsnprintf(NULL, 0, format, args);
    char *text = length < 0 ? NULL : kd_arena_alloc(arena, (size_t)length + 1);
    if (text)
        vsnprintf(text, (size_t)length + 1, format, again);
    va_end(again);
    va_end(args);
    return text;
}

void kd_arena_reset(kd_arena *arena)
{
    arena->current = arena->first;
    arena->used_bytes = 0;
    if (arena->first)
        arena->first->used = 0;
}

void kd_arena_fini(kd_arena *arena)
{
    for (kd_arena_block *b = arena->first; b;) {
        kd_arena_block *next = b->next;
        free(b);
        b = next;
    }
    *arena = (kd_arena){.block_bytes = arena->block_bytes};
}
