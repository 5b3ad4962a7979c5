/* Making and destroying a pool. */
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "runtime/core/log.h"
#include "runtime/jobs/pool.h"

enum {
    DEQUE_SIZE = 1024,
    QUEUE_SIZE = 64,
};

_Thread_local jobs_thread_record jobs_thread;

uint32_t kd_jobs_worker(const kd_jobs *jobs)
{
    return !jobs || jobs_thread.jobs == jobs ? jobs_thread.worker : 0;
}

uint32_t kd_jobs_threads(const kd_jobs *jobs)
{
    return jobs->threads;
}

static bool init_worker(kd_jobs *jobs, uint32_t index)
{
    job_worker *w = &jobs->workers[index];
    w->jobs = jobs;
    w->index = index;
    memset(w->seen_top, 0xFF, sizeof w->seen_top); /* -1: nothing seen */
    pthread_mutex_init(&w->lock, NULL);
    pthread_cond_init(&w->signal, NULL);
    return job_deque_init(&w->deque, DEQUE_SIZE);
}

static bool init_queues(kd_jobs *jobs)
{
    pthread_mutex_init(&jobs->after_lock, NULL);
    pthread_mutex_init(&jobs->outside_lock, NULL);
    pthread_cond_init(&jobs->outside_signal, NULL);
    bool ok = job_queue_init(&jobs->lane, QUEUE_SIZE);
    ok = job_queue_init(&jobs->first, QUEUE_SIZE) && ok;
    return job_queue_init(&jobs->inbox, QUEUE_SIZE) && ok;
}

static void fini_queues(kd_jobs *jobs)
{
    jobs_after_fini(jobs);
    job_queue_fini(&jobs->lane);
    job_queue_fini(&jobs->first);
    job_queue_fini(&jobs->inbox);
    pthread_mutex_destroy(&jobs->after_lock);
    pthread_mutex_destroy(&jobs->outside_lock);
    pthread_cond_destroy(&jobs->outside_signal);
}

static bool start_worker(job_worker *w)
{
    return pthread_create(&w->thread, NULL, jobs_worker_main, w) == 0;
}

static uint32_t processor_count(void)
{
    long online = sysconf(_SC_NPROCESSORS_ONLN);
    return online < 1 ? 1 : online > JOBS_MAX_WORKERS ? JOBS_MAX_WORKERS : (uint32_t)online;
}

static kd_jobs *no_pool(uint32_t threads)
{
    kd_log(KD_LOG_ERROR, "jobs: no memory, or no leave, for %u threads; ask for fewer", (unsigned)threads);
    return NULL;
}

kd_jobs *kd_jobs_make(uint32_t threads)
{
    threads = threads == 0 ? processor_count() : threads > JOBS_MAX_WORKERS ? JOBS_MAX_WORKERS : threads;
    size_t size = sizeof(kd_jobs) + threads * sizeof(job_worker);
    kd_jobs *jobs = aligned_alloc(128, (size + 127) / 128 * 128);
    if (!jobs)
        return no_pool(threads);
    memset(jobs, 0, size);
    jobs->threads = threads;
    jobs->owner = &jobs_thread;
    bool ok = init_queues(jobs);
    for (uint32_t i = 0; i < threads; i++)
        ok = init_worker(jobs, i) && ok;
    atomic_init(&jobs->alive.pending, threads - 1);
    jobs->started = 1;
    while (ok && jobs->started < threads && start_worker(&jobs->workers[jobs->started]))
        jobs->started++;
    if (ok && jobs->started == threads)
        return jobs;
    atomic_fetch_sub(&jobs->alive.pending, threads - jobs->started); /* those never lived */
    kd_jobs_destroy(jobs);
    return no_pool(threads);
}

void kd_jobs_destroy(kd_jobs *jobs)
{
    if (!jobs)
        return;
    atomic_store(&jobs->stop, true);
    for (uint32_t i = 1; i < jobs->threads; i++)
        jobs_wake(jobs, i);
    kd_jobs_wait(jobs, &jobs->alive);
    for (uint32_t i = 1; i < jobs->started; i++)
        pthread_join(jobs->workers[i].thread, NULL);
    jobs_drain_inline(jobs);
    for (uint32_t i = 0; i < jobs->threads; i++) {
        job_deque_fini(&jobs->workers[i].deque);
        pthread_mutex_destroy(&jobs->workers[i].lock);
        pthread_cond_destroy(&jobs->workers[i].signal);
    }
    fini_queues(jobs);
    free(jobs);
}

/* ---- watching ---- */

void kd_jobs_set_hooks(kd_jobs *jobs, const kd_jobs_hooks *hooks)
{
    jobs->hooks = hooks ? *hooks : (kd_jobs_hooks){0};
}

uint32_t kd_jobs_set_label(kd_jobs *jobs, uint32_t worker, uint32_t label)
{
    uint32_t before = jobs->workers[worker].label;
    jobs->workers[worker].label = label;
    return before;
}
