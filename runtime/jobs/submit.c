/* Submitting: to the worker's own deque, and to the queues for what is rare. */
#include <assert.h>
#include <stdlib.h>

#include "runtime/core/log.h"
#include "runtime/jobs/pool.h"

/* For jobs that no other place can take: there is no way on. */
static void put_or_stop(job_queue *queue, const job *j, const char *what)
{
    if (job_queue_put(queue, j))
        return;
    kd_log(KD_LOG_ERROR, "out of memory (%u jobs wait %s); stopping", (unsigned)atomic_load(&queue->count),
           what);
    abort();
}

/* Publish a job whose counter is raised already. */
void jobs_enqueue(kd_jobs *jobs, const job *j)
{
    job_worker *w = &jobs->workers[kd_jobs_worker(jobs)];
    bool inside = jobs_is_worker(jobs);
    if (!inside)
        put_or_stop(&jobs->inbox, j, "that other threads sent");
    if (!inside || job_deque_push(&w->deque, j)) {
        jobs_wake_some(jobs, 1);
        return;
    }
    jobs_finished run = {0}; /* no memory for a larger ring: do it now */
    jobs_execute(jobs, w, j, &run);
    jobs_flush(jobs, &run);
}

void jobs_submit(kd_jobs *jobs, const job *j)
{
    jobs_raise(j->counter, 1);
    jobs_enqueue(jobs, j);
}

void kd_jobs_run(kd_jobs *jobs, kd_job_fn *fn, void *user, kd_job_counter *counter)
{
    assert(fn);
    if (jobs_runs_inline(jobs)) {
        jobs->inside = true;
        fn(user, 0);
        jobs_drain_inline(jobs);
        return;
    }
    jobs_submit(jobs, &(job){.fn = fn, .user = user, .counter = counter});
}

void kd_jobs_run_n(kd_jobs *jobs, kd_job_fn *fn, void *const *users, uint32_t n, kd_job_counter *counter)
{
    job_worker *w = &jobs->workers[kd_jobs_worker(jobs)];
    bool batch = n > 1 && jobs_is_worker(jobs) && !jobs_runs_inline(jobs);
    job_ring *ring = batch ? job_deque_reserve(&w->deque, n) : NULL;
    if (!ring) {
        for (uint32_t i = 0; i < n; i++)
            kd_jobs_run(jobs, fn, users[i], counter);
        return;
    }
    jobs_raise(counter, n);
    int64_t bottom = atomic_load_explicit(&w->deque.bottom, memory_order_relaxed);
    for (uint32_t i = 0; i < n; i++) /* the first one last, because the owner takes from the bottom */
        job_slot_write(ring, bottom + i, &(job){.fn = fn, .user = users[n - 1 - i], .counter = counter});
    job_deque_publish(&w->deque, n);
    jobs_wake_some(jobs, n < jobs->threads ? n : jobs->threads - 1);
}

void kd_jobs_run_first(kd_jobs *jobs, kd_job_fn *fn, void *user, kd_job_counter *counter)
{
    job j = {.fn = fn, .user = user, .counter = counter};
    assert(fn);
    if (jobs_runs_inline(jobs)) {
        kd_jobs_run(jobs, fn, user, counter);
        return;
    }
    jobs_raise(counter, 1);
    if (job_queue_put(&jobs->first, &j))
        jobs_wake_some(jobs, 1);
    else
        jobs_enqueue(jobs, &j);
}

void kd_jobs_run_lane(kd_jobs *jobs, kd_job_fn *fn, void *user, kd_job_counter *counter)
{
    assert(fn);
    jobs_raise(counter, 1);
    put_or_stop(&jobs->lane, &(job){.fn = fn, .user = user, .counter = counter}, "for the GPU lane");
    if (jobs_runs_inline(jobs))
        jobs_drain_inline(jobs);
    else if (atomic_load(&jobs->parked) & 1)
        jobs_wake(jobs, KD_GPU_LANE);
}
