/* Blocks aligned to a cache line. The 64 bytes before a block say how long it is, so that the world can count
 * what it holds and refuse to pass its limit. Large blocks are mapped on their own: they grow by moving pages
 * instead of bytes, and ask for huge pages, which spares a random access most of its address translation. */

#define _GNU_SOURCE /* mremap, MADV_HUGEPAGE */
#include <stdlib.h>
#include <sys/mman.h>

#include "runtime/ecs/internal.h"

#define LINE       64u
#define HUGE_BYTES ((size_t)2 << 20)
#define MAP_BYTES  (2 * HUGE_BYTES) /* from here on a block is mapped; below, the heap measured faster */

typedef struct block_head {
    size_t bytes;
    size_t mapped; /* length of the mapping; 0: from the heap */
} block_head;

static block_head *head_of(void *block)
{
    return (block_head *)(void *)((uint8_t *)block - LINE);
}

/* Count `grow` more and `shrink` fewer bytes; false when that would pass the limit. */
static bool account(kd_world *w, size_t grow, size_t shrink)
{
    size_t before = atomic_fetch_add_explicit(&w->bytes, grow - shrink, memory_order_relaxed);
    if (w->limit_bytes && grow > shrink && before + (grow - shrink) > w->limit_bytes) {
        atomic_fetch_sub_explicit(&w->bytes, grow - shrink, memory_order_relaxed);
        return false;
    }
    return true;
}

/* Address space for `bytes`, beginning at a multiple of a huge page so that the kernel can use them. */
static uint8_t *map_place(size_t bytes)
{
    uint8_t *raw =
        mmap(NULL, bytes + HUGE_BYTES, PROT_NONE, MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
    if (raw == MAP_FAILED)
        return NULL;
    size_t before = (HUGE_BYTES - ((uintptr_t)raw & (HUGE_BYTES - 1))) & (HUGE_BYTES - 1);
    if (before)
        munmap(raw, before);
    munmap(raw + before + bytes, HUGE_BYTES - before);
    return raw + before;
}

static uint8_t *map_new(size_t bytes)
{
    uint8_t *place = map_place(bytes);
    if (!place)
        return NULL;
    if (mprotect(place, bytes, PROT_READ | PROT_WRITE)) {
        munmap(place, bytes);
        return NULL;
    }
    madvise(place, bytes, MADV_HUGEPAGE); /* a wish: without it everything works, slower */
    return place;
}

static uint8_t *map_grow(uint8_t *base, size_t old_bytes, size_t bytes)
{
    uint8_t *place = map_place(bytes);
    if (!place)
        return NULL;
    uint8_t *moved = mremap(base, old_bytes, bytes, MREMAP_MAYMOVE | MREMAP_FIXED, place);
    if (moved == MAP_FAILED) /* the place may be gone and somebody else's by now: it is left alone */
        return NULL;
    madvise(moved, bytes, MADV_HUGEPAGE);
    return moved;
}

static void release(uint8_t *base, size_t mapped)
{
    if (mapped)
        munmap(base, mapped);
    else
        free(base);
}

/* A block of `total` bytes, head included, with what the old one held; the old one is gone on success. */
static uint8_t *resize(void *block, size_t keep_bytes, size_t total, size_t mapped)
{
    block_head *old = block ? head_of(block) : NULL;
    size_t old_mapped = old ? old->mapped : 0;
    if (mapped && old_mapped)
        return mapped == old_mapped ? (uint8_t *)old : map_grow((uint8_t *)old, old_mapped, mapped);
    uint8_t *base = mapped ? map_new(mapped) : aligned_alloc(LINE, total);
    if (base && keep_bytes)
        memcpy(base + LINE, block, keep_bytes);
    if (base && old)
        release((uint8_t *)old, old_mapped);
    return base;
}

/* Whole huge pages: one that is touched while the mapping still ends inside it stays small. */
static size_t mapping_of(size_t total)
{
    return total >= MAP_BYTES ? (total + HUGE_BYTES - 1) & ~(HUGE_BYTES - 1) : 0;
}

/* Say it once, until the world gives memory back: a thousand spawns that fail are one piece of news. */
static void *refuse(kd_world *w, size_t bytes, bool by_limit)
{
    if (atomic_exchange_explicit(&w->refused, true, memory_order_relaxed))
        return NULL;
    if (by_limit)
        kd_fail(KD_NO_MEMORY,
                "world: %zu more bytes would pass its limit, it holds %zu; raise the limit or destroy "
                "entities",
                bytes, kd_world_bytes(w));
    else
        kd_fail(KD_NO_MEMORY,
                "world: no memory for %zu more bytes, it holds %zu; destroy entities or give the "
                "program more memory",
                bytes, kd_world_bytes(w));
    return NULL;
}

void *ecs_grow(kd_world *w, void *block, size_t keep_bytes, size_t bytes)
{
    if (bytes > SIZE_MAX / 4)
        return refuse(w, bytes, false);
    size_t total = ((bytes + LINE - 1) & ~(size_t)(LINE - 1)) + LINE;
    size_t mapped = mapping_of(total), before = block ? head_of(block)->bytes : 0;
    if (!account(w, total, before))
        return refuse(w, total - before, true);
    uint8_t *base = resize(block, keep_bytes, total, mapped);
    if (!base) {
        account(w, before, total);
        return refuse(w, total - before, false);
    }
    *(block_head *)(void *)base = (block_head){total, mapped};
    return base + LINE;
}

void ecs_free(kd_world *w, void *block)
{
    if (!block)
        return;
    account(w, 0, head_of(block)->bytes);
    if (atomic_load_explicit(&w->refused, memory_order_relaxed))
        atomic_store_explicit(&w->refused, false, memory_order_relaxed);
    release((uint8_t *)head_of(block), head_of(block)->mapped);
}

uint32_t ecs_next_capacity(uint32_t capacity, uint32_t need)
{
    uint64_t next = capacity < 8      ? 8
                    : capacity < 2048 ? (uint64_t)capacity * 2
                                      : (uint64_t)capacity + capacity / 4;
    if (next < need)
        next = need;
    next = next < ECS_CHUNK_ROWS ? next : (next + ECS_CHUNK_ROWS - 1) / ECS_CHUNK_ROWS * ECS_CHUNK_ROWS;
    return next > UINT32_MAX ? UINT32_MAX : (uint32_t)next;
}

bool ecs_reserve(kd_world *w, void *array_pointer, uint32_t *capacity, uint32_t count, uint32_t need,
                 size_t item_bytes)
{
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
