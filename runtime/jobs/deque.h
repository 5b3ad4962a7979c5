#ifndef KD_JOBS_DEQUE_H
#define KD_JOBS_DEQUE_H

/* A Chase-Lev deque of jobs: the owner pushes and takes at the bottom, thieves take at the top. Jobs are
 * stored by value in a ring, so that submitting allocates nothing; a full ring is doubled and the old one
 * kept, since a thief may still be reading it.
 *
 * Source: Chase, Lev 2005; memory orders after Le, Pop, Cohen, Zappa Nardelli 2013, figure 1, with these
 * differences. Where they put a sequentially consistent fence between two accesses, the accesses themselves
 * are sequentially consistent (the same instructions on x86, and thread sanitizer understands them):
 *
 * - The last job may be wanted by the owner and a thief at once. take() writes bottom, then reads top;
 *   steal() reads top, then bottom. In the single order of these four either the thief sees the lowered
 *   bottom and leaves, or the owner sees the raised top; if the owner sees top == bottom it goes through the
 *   same compare-exchange as the thief: one wins.
 * - push() writes the slot, then bottom; a thief that reads this bottom (which acquires) sees the slot.
 * - A thief reads the slot before it owns it. The owner reuses a slot only after reading a top beyond it. Top
 *   never returns to a value, so the thief's compare-exchange then fails, and what it read is dropped. Slots
 *   are atomic words, so that this read is no data race.
 * - push() is sequentially consistent because the pool reads its mask of sleeping workers next: see sleep.c.
 *
 * tests/unit/jobs_model.c runs this file through every execution that the memory model allows to a few
 * operations. */

#include <stdalign.h>
#include <stdatomic.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdlib.h>

#include "runtime/jobs/jobs.h"

typedef struct job {
    kd_job_fn *fn; /* NULL: a piece of a parallel_for, whose frame is `user` */
    void *user;
    kd_job_counter *counter;
    uint64_t range; /* begin | end << 32 */
} job;

typedef struct job_slot {
    _Atomic uint64_t words[4];
} job_slot;

typedef struct job_ring {
    struct job_ring *older;
    int64_t size; /* a power of two */
    job_slot slots[];
} job_ring;

typedef struct job_deque {
    alignas(128) _Atomic int64_t top;
    alignas(128) _Atomic int64_t bottom; /* written by the owner alone */
    int64_t known_top;                   /* the owner's: top was here once, and may be further by now */
    _Atomic(job_ring *) ring;
} job_deque;

static inline job_ring *job_ring_make(int64_t size, job_ring *older)
{
    job_ring *ring = malloc(sizeof(job_ring) + (size_t)size * sizeof(job_slot));
    if (ring) {
        ring->older = older;
        ring->size = size;
    }
    return ring;
}

static inline void job_slot_write(job_ring *ring, int64_t index, const job *j)
{
    job_slot *slot = &ring->slots[index & (ring->size - 1)];
    atomic_store_explicit(&slot->words[0], (uint64_t)(uintptr_t)j->fn, memory_order_relaxed);
    atomic_store_explicit(&slot->words[1], (uint64_t)(uintptr_t)j->user, memory_order_relaxed);
    atomic_store_explicit(&slot->words[2], (uint64_t)(uintptr_t)j->counter, memory_order_relaxed);
    atomic_store_explicit(&slot->words[3], j->range, memory_order_relaxed);
}

static inline job job_slot_read(job_ring *ring, int64_t index)
{
    job_slot *slot = &ring->slots[index & (ring->size - 1)];
    return (job){
        .fn = (kd_job_fn *)(uintptr_t)atomic_load_explicit(&slot->words[0], memory_order_relaxed),
        .user = (void *)(uintptr_t)atomic_load_explicit(&slot->words[1], memory_order_relaxed),
        .counter = (kd_job_counter *)(uintptr_t)atomic_load_explicit(&slot->words[2], memory_order_relaxed),
        .range = atomic_load_explicit(&slot->words[3], memory_order_relaxed),
    };
}

static inline bool job_deque_init(job_deque *d, int64_t size)
{
    job_ring *ring = job_ring_make(size, NULL);
    atomic_init(&d->top, 0);
    atomic_init(&d->bottom, 0);
    d->known_top = 0;
    atomic_init(&d->ring, ring);
    return ring != NULL;
}

static inline void job_deque_fini(job_deque *d)
{
    for (job_ring *ring = atomic_load(&d->ring); ring;) {
        job_ring *older = ring->older;
        free(ring);
        ring = older;
    }
}

/* Owner: get a ring with room for n more jobs. NULL when memory is out. */
static inline job_ring *job_deque_reserve(job_deque *d, int64_t n)
{
    job_ring *ring = atomic_load_explicit(&d->ring, memory_order_relaxed);
    int64_t bottom = atomic_load_explicit(&d->bottom, memory_order_relaxed);
    if (bottom - d->known_top + n <= ring->size)
        return ring; /* without a look at what thieves write */
    int64_t top = d->known_top = atomic_load_explicit(&d->top, memory_order_acquire);
    if (bottom - top + n <= ring->size)
        return ring;
    int64_t size = ring->size * 2;
    while (size < bottom - top + n)
        size *= 2;
    job_ring *larger = job_ring_make(size, ring);
    if (!larger)
        return NULL;
    for (int64_t i = top; i < bottom; i++) {
        job moved = job_slot_read(ring, i);
        job_slot_write(larger, i, &moved);
    }
    atomic_store_explicit(&d->ring, larger, memory_order_release);
    return larger;
}

/* Owner: publish the n jobs that were written at bottom, bottom + 1, … of the reserved ring. */
static inline void job_deque_publish(job_deque *d, int64_t n)
{
    int64_t bottom = atomic_load_explicit(&d->bottom, memory_order_relaxed);
    atomic_store_explicit(&d->bottom, bottom + n, memory_order_seq_cst);
}

static inline bool job_deque_push(job_deque *d, const job *j)
{
    job_ring *ring = job_deque_reserve(d, 1);
    if (!ring)
        return false;
    job_slot_write(ring, atomic_load_explicit(&d->bottom, memory_order_relaxed), j);
    job_deque_publish(d, 1);
    return true;
}

/* Owner: take the job pushed last. */
static inline bool job_deque_take(job_deque *d, job *out)
{
    int64_t bottom = atomic_load_explicit(&d->bottom, memory_order_relaxed) - 1;
    if (atomic_load_explicit(&d->top, memory_order_relaxed) > bottom)
        return false; /* top only grows: empty it is */
    job_ring *ring = atomic_load_explicit(&d->ring, memory_order_relaxed);
    atomic_store_explicit(&d->bottom, bottom, memory_order_seq_cst);
    int64_t top = atomic_load_explicit(&d->top, memory_order_seq_cst);
    bool taken = top <= bottom;
    if (taken)
        *out = job_slot_read(ring, bottom);
    if (top < bottom)
        return true;
    if (taken)
        taken = atomic_compare_exchange_strong_explicit(&d->top, &top, top + 1, memory_order_seq_cst,
                                                        memory_order_relaxed);
    atomic_store_explicit(&d->bottom, bottom + 1, memory_order_release);
    return taken;
}

/* Any thread: how many jobs there seem to be; *top is where stealing would begin. */
static inline int64_t job_deque_look(job_deque *d, int64_t *top)
{
    *top = atomic_load_explicit(&d->top, memory_order_seq_cst);
    return atomic_load_explicit(&d->bottom, memory_order_seq_cst) - *top;
}

/* Thief: take the job at `top`, which a look has found there. False when somebody was faster. */
static inline bool job_deque_steal(job_deque *d, int64_t top, job *out)
{
    job_ring *ring = atomic_load_explicit(&d->ring, memory_order_acquire);
    *out = job_slot_read(ring, top);
    return atomic_compare_exchange_strong_explicit(&d->top, &top, top + 1, memory_order_seq_cst,
                                                   memory_order_relaxed);
}

static inline bool job_deque_is_empty(job_deque *d)
{
    return atomic_load_explicit(&d->bottom, memory_order_relaxed) <=
           atomic_load_explicit(&d->top, memory_order_relaxed);
}

#endif
