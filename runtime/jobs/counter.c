/* Counters, and jobs that wait for one.
 *
 * Such jobs hang in a list at the counter; a bit in `pending` says so. The bit is never there alone: who
 * lowers the rest takes list and bit away in the step that makes the word zero, and from then on touches the
 * counter no more, since whoever waits for it may free it. */
#include <assert.h>

#include "runtime/jobs/pool.h"

enum { AFTER_BLOCK = 64 };

struct jobs_after_block {
    jobs_after_block *older;
    job_after items[AFTER_BLOCK];
};

/* Under after_lock: get a place for one job more. NULL when memory is out. */
static job_after *after_get(kd_jobs *jobs)
{
    if (!jobs->after_free) {
        jobs_after_block *block = malloc(sizeof *block);
        if (!block)
            return NULL;
        block->older = jobs->after_blocks;
        jobs->after_blocks = block;
        for (uint32_t i = 0; i < AFTER_BLOCK; i++)
            block->items[i].next = i + 1 < AFTER_BLOCK ? &block->items[i + 1] : NULL;
        jobs->after_free = block->items;
    }
    job_after *after = jobs->after_free;
    jobs->after_free = after->next;
    return after;
}

/* Hang the job into the list at `before`. False when that is zero, or memory is out. */
static bool hold_back(kd_jobs *jobs, kd_job_counter *before, const job *j)
{
    pthread_mutex_lock(&jobs->after_lock);
    uint32_t pending = atomic_load(&before->pending);
    job_after *after = pending ? after_get(jobs) : NULL;
    while (after && pending &&
           !atomic_compare_exchange_weak(&before->pending, &pending, pending | JOBS_HAS_AFTER))
        ;
    bool held = after && pending;
    if (after) { /* the bit keeps who lowers it out until the lock is given back */
        job_after **list = held ? &before->after : &jobs->after_free;
        *after = (job_after){*j, *list};
        *list = after;
    }
    pthread_mutex_unlock(&jobs->after_lock);
    return held;
}

/* Let jobs go that waited. The newest comes first in the list and so is taken last. */
static void release(kd_jobs *jobs, job_after *after)
{
    job_after *last = NULL;
    for (job_after *a = after; a; a = a->next) {
        jobs_enqueue(jobs, &a->waiting);
        last = a;
    }
    pthread_mutex_lock(&jobs->after_lock);
    if (last) {
        last->next = jobs->after_free;
        jobs->after_free = after;
    }
    pthread_mutex_unlock(&jobs->after_lock);
    if (jobs_runs_inline(jobs))
        jobs_drain_inline(jobs);
}

/* Lower the last n of a counter for which jobs wait, if they still are the last. */
static bool lower_last(kd_jobs *jobs, kd_job_counter *counter, uint32_t n, job_after **after)
{
    uint32_t pending = n | JOBS_HAS_AFTER;
    pthread_mutex_lock(&jobs->after_lock);
    *after = counter->after;
    counter->after = NULL;
    bool lowered = atomic_compare_exchange_strong(&counter->pending, &pending, 0);
    if (!lowered)
        counter->after = *after;
    pthread_mutex_unlock(&jobs->after_lock);
    return lowered;
}

void kd_jobs_lower(kd_jobs *jobs, kd_job_counter *counter, uint32_t n)
{
    uint32_t pending = n; /* guessed: then one exchange is enough */
    job_after *after = NULL;
    while (!atomic_compare_exchange_strong(&counter->pending, &pending, pending - n)) {
        if (pending != (n | JOBS_HAS_AFTER))
            continue;
        if (lower_last(jobs, counter, n, &after)) {
            jobs_wake_waiting(jobs);
            release(jobs, after);
            return;
        }
        pending = n;
    }
    if (pending == n)
        jobs_wake_waiting(jobs);
}

void kd_jobs_run_after(kd_jobs *jobs, kd_job_counter *before, kd_job_fn *fn, void *user,
                       kd_job_counter *counter)
{
    job j = {.fn = fn, .user = user, .counter = counter};
    assert(fn && before != counter);
    jobs_raise(counter, 1);
    if (hold_back(jobs, before, &j))
        return;
    kd_jobs_wait(jobs, before); /* returns at once, or memory is out */
    jobs_enqueue(jobs, &j);
    if (jobs_runs_inline(jobs))
        jobs_drain_inline(jobs);
}

void jobs_after_fini(kd_jobs *jobs)
{
    for (jobs_after_block *block = jobs->after_blocks; block;) {
        jobs_after_block *older = block->older;
        free(block);
        block = older;
    }
}
