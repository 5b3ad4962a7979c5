#ifndef KD_JOBS_QUEUE_H
#define KD_JOBS_QUEUE_H

/* A queue of jobs under a mutex, first in first out: for what is rare, so that the deques stay single-owner.
 * `count` is read without the lock to skip an empty queue; who puts raises it before looking for sleepers. */

#include <pthread.h>
#include <stdalign.h>
#include <stdatomic.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdlib.h>

#include "runtime/jobs/deque.h"

typedef struct job_queue {
    alignas(128) _Atomic uint32_t count;
    uint32_t size, head; /* all but count under lock */
    job *ring;
    pthread_mutex_t lock;
} job_queue;

static inline bool job_queue_init(job_queue *q, uint32_t size)
{
    pthread_mutex_init(&q->lock, NULL);
    atomic_init(&q->count, 0);
    q->size = size;
    q->head = 0;
    q->ring = malloc(sizeof(job) * size);
    return q->ring != NULL;
}

static inline void job_queue_fini(job_queue *q)
{
    pthread_mutex_destroy(&q->lock);
    free(q->ring);
}

/* Under lock: double the ring. */
static inline bool job_queue_grow(job_queue *q, uint32_t count)
{
    job *larger = malloc(sizeof(job) * q->size * 2);
    if (!larger)
        return false;
    for (uint32_t i = 0; i < count; i++)
        larger[i] = q->ring[(q->head + i) % q->size];
    free(q->ring);
    q->ring = larger;
    q->head = 0;
    q->size *= 2;
    return true;
}

/* False when memory is out; nothing is queued then. */
static inline bool job_queue_put(job_queue *q, const job *j)
{
    pthread_mutex_lock(&q->lock);
    uint32_t count = atomic_load_explicit(&q->count, memory_order_relaxed);
    bool ok = count < q->size || job_queue_grow(q, count);
    if (ok) {
        q->ring[(q->head + count) % q->size] = *j;
        atomic_fetch_add(&q->count, 1);
    }
    pthread_mutex_unlock(&q->lock);
    return ok;
}

static inline bool job_queue_take(job_queue *q, job *out)
{
    if (atomic_load_explicit(&q->count, memory_order_relaxed) == 0)
        return false;
    pthread_mutex_lock(&q->lock);
    bool taken = atomic_load_explicit(&q->count, memory_order_relaxed) > 0;
    if (taken) {
        *out = q->ring[q->head];
        q->head = (q->head + 1) % q->size;
        atomic_fetch_sub(&q->count, 1);
    }
    pthread_mutex_unlock(&q->lock);
    return taken;
}

#endif
