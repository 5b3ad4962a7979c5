#ifndef KD_CORE_ARENA_H
#define KD_CORE_ARENA_H

#include <stddef.h>

/* A bump allocator over a chain of blocks. A reset keeps the memory, so that a steady frame allocates
 * nothing. */
typedef struct kd_arena_block kd_arena_block;
typedef struct kd_arena {
    kd_arena_block *first;
    kd_arena_block *current;
    size_t block_bytes; /* size of the next block; 0 means 64 KiB */
    size_t used_bytes;  /* given out since the last reset */
} kd_arena;

/** Give out size bytes, aligned to 64, zeroed. Returns NULL when memory is out. */
void *kd_arena_alloc(kd_arena *arena, size_t size);

/** Give out a printf-formatted copy. Returns NULL when memory is out. */
char *kd_arena_printf(kd_arena *arena, const char *format, ...) __attribute__((format(printf, 2, 3)));

/** Take everything back at once; the blocks stay. */
void kd_arena_reset(kd_arena *arena);

/** Free the blocks. */
void kd_arena_fini(kd_arena *arena);

#define KD_ARENA_NEW(arena, type, count) ((type *)kd_arena_alloc((arena), sizeof(type) * (size_t)(count)))

#endif
