#ifndef ALLOCATION_FIXTURE_H
#define ALLOCATION_FIXTURE_H

/* Memory that runs out when a test says so. The linker leads every allocation of the program under test here
 * (tests/CMakeLists.txt wraps these names for tests called *_allocation.c); what the C library allocates for
 * itself is let be. Allocations of all threads count. */

#define _GNU_SOURCE
#include <errno.h>
#include <pthread.h>
#include <stdatomic.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <sys/mman.h>

/* How an injected failure goes on: one allocation fails, or all from then on. */
typedef enum failure_kind { FAIL_ONCE, FAIL_ON } failure_kind;

static struct {
    _Atomic long countdown; /* allocations that still succeed; negative: none is to fail */
    _Atomic long failed;
    failure_kind kind;
} allocation = {.countdown = -1};

/* Let the k-th allocation from now on fail (from 0). */
static inline void allocations_fail_at(long k, failure_kind kind)
{
    allocation.kind = kind;
    atomic_store(&allocation.failed, 0);
    atomic_store(&allocation.countdown, k);
}

/* Let memory be there again. Returns how many allocations failed. */
static inline long allocations_succeed(void)
{
    atomic_store(&allocation.countdown, -1);
    return atomic_load(&allocation.failed);
}

static inline bool allocation_fails(void)
{
    long left = atomic_load(&allocation.countdown);
    while (left > 0)
        if (atomic_compare_exchange_weak(&allocation.countdown, &left, left - 1))
            return false;
    if (left < 0 || (allocation.kind == FAIL_ONCE && atomic_load(&allocation.failed)))
        return false;
    atomic_fetch_add(&allocation.failed, 1);
    errno = ENOMEM;
    return true;
}

void *__real_malloc(size_t size);
void *__real_calloc(size_t count, size_t size);
void *__real_realloc(void *block, size_t size);
void *__real_aligned_alloc(size_t alignment, size_t size);
char *__real_strdup(const char *text);
FILE *__real_fdopen(int fd, const char *mode);
void *__real_mmap(void *address, size_t size, int protection, int flags, int fd, off_t offset);
void *__real_mremap(void *address, size_t size, size_t new_size, int flags, void *new_address);
int __real_pthread_create(pthread_t *thread, const pthread_attr_t *attributes, void *(*fn)(void *),
                          void *user);
int __wrap_pthread_create(pthread_t *thread, const pthread_attr_t *attributes, void *(*fn)(void *),
                          void *user);
void *__wrap_malloc(size_t size);
void *__wrap_calloc(size_t count, size_t size);
void *__wrap_realloc(void *block, size_t size);
void *__wrap_aligned_alloc(size_t alignment, size_t size);
char *__wrap_strdup(const char *text);
FILE *__wrap_fdopen(int fd, const char *mode);
void *__wrap_mmap(void *address, size_t size, int protection, int flags, int fd, off_t offset);
void *__wrap_mremap(void *address, size_t size, size_t new_size, int flags, void *new_address);

void *__wrap_malloc(size_t size)
{
    return allocation_fails() ? NULL : __real_malloc(size);
}
void *__wrap_calloc(size_t count, size_t size)
{
    return allocation_fails() ? NULL : __real_calloc(count, size);
}
void *__wrap_realloc(void *block, size_t size)
{
    return allocation_fails() ? NULL : __real_realloc(block, size);
}
void *__wrap_aligned_alloc(size_t alignment, size_t size)
{
    return allocation_fails() ? NULL : __real_aligned_alloc(alignment, size);
}
char *__wrap_strdup(const char *text)
{
    return allocation_fails() ? NULL : __real_strdup(text);
}
FILE *__wrap_fdopen(int fd, const char *mode)
{
    return allocation_fails() ? NULL : __real_fdopen(fd, mode);
}
void *__wrap_mmap(void *address, size_t size, int protection, int flags, int fd, off_t offset)
{
    return allocation_fails() ? MAP_FAILED : __real_mmap(address, size, protection, flags, fd, offset);
}
void *__wrap_mremap(void *address, size_t size, size_t new_size, int flags, void *new_address)
{
    return allocation_fails() ? MAP_FAILED : __real_mremap(address, size, new_size, flags, new_address);
}

int __wrap_pthread_create(pthread_t *thread, const pthread_attr_t *attributes, void *(*fn)(void *),
                          void *user)
{
    return allocation_fails() ? EAGAIN : __real_pthread_create(thread, attributes, fn, user);
}

#endif
