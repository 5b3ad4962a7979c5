#include "runtime/core/allocations.h"

#include <stdatomic.h>
#include <string.h>

static _Atomic uint64_t taken_count, taken_bytes;

kd_allocations kd_allocations_so_far(void)
{
    return (kd_allocations){atomic_load_explicit(&taken_count, memory_order_relaxed),
                            atomic_load_explicit(&taken_bytes, memory_order_relaxed)};
}

static void take(size_t bytes)
{
    atomic_fetch_add_explicit(&taken_count, 1, memory_order_relaxed);
    atomic_fetch_add_explicit(&taken_bytes, bytes, memory_order_relaxed);
}

/* ---- the linker's names: real is the C library's or a sanitizer's, wrap stands in its place ---- */

/* A program that is not linked so lacks them, and never calls what calls them. */
#define WEAK __attribute__((weak))

void *__real_malloc(size_t size) WEAK;
void *__real_calloc(size_t count, size_t size) WEAK;
void *__real_realloc(void *block, size_t size) WEAK;
void *__real_aligned_alloc(size_t alignment, size_t size) WEAK;
char *__real_strdup(const char *text) WEAK;
char *__real_strndup(const char *text, size_t most) WEAK;
void *__wrap_malloc(size_t size);
void *__wrap_calloc(size_t count, size_t size);
void *__wrap_realloc(void *block, size_t size);
void *__wrap_aligned_alloc(size_t alignment, size_t size);
char *__wrap_strdup(const char *text);
char *__wrap_strndup(const char *text, size_t most);

void *__wrap_malloc(size_t size)
{
    take(size);
    return __real_malloc(size);
}

void *__wrap_calloc(size_t count, size_t size)
{
    take(count * size);
    return __real_calloc(count, size);
}

void *__wrap_realloc(void *block, size_t size)
{
    take(size);
    return __real_realloc(block, size);
}

void *__wrap_aligned_alloc(size_t alignment, size_t size)
{
    take(size);
    return __real_aligned_alloc(alignment, size);
}

char *__wrap_strdup(const char *text)
{
    take(strlen(text) + 1);
    return __real_strdup(text);
}

char *__wrap_strndup(const char *text, size_t most)
{
    take(strnlen(text, most) + 1);
    return __real_strndup(text, most);
}
