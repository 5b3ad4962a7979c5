/* Waiting: workers help meanwhile, foreign threads sleep. */
#include "runtime/jobs/pool.h"

static void wait_helping(kd_jobs *jobs, job_worker *w, kd_job_counter *counter)
{
    jobs_finished run = {0};
    jobs_idle_state state = {0};
    for (;;) {
        uint32_t known = run.counter == counter ? run.count : 0;
        if ((atomic_load_explicit(&counter->pending, memory_order_acquire) & ~JOBS_HAS_AFTER) == known)
            break;
        if (jobs_run_one(jobs, w, &run)) {
            state.until_ns = 0;
            continue;
        }
        jobs_flush(jobs, &run);
        if (atomic_load_explicit(&counter->pending, memory_order_acquire) != 0)
            jobs_idle(jobs, w, counter, &state);
    }
    jobs_flush(jobs, &run);
}

static void wait_outside(kd_jobs *jobs, kd_job_counter *counter)
{
    atomic_fetch_add(&jobs->outside_waiting, 1);
    pthread_mutex_lock(&jobs->outside_lock);
    while (atomic_load(&counter->pending) != 0)
        pthread_cond_wait(&jobs->outside_signal, &jobs->outside_lock);
    pthread_mutex_unlock(&jobs->outside_lock);
    atomic_fetch_sub(&jobs->outside_waiting, 1);
}

void kd_jobs_wait(kd_jobs *jobs, kd_job_counter *counter)
{
    if (atomic_load_explicit(&counter->pending, memory_order_acquire) == 0)
        return;
    if (!jobs_is_worker(jobs)) {
        wait_outside(jobs, counter);
        return;
    }
    bool outermost = jobs_runs_inline(jobs);
    if (outermost)
        jobs->inside = true; /* foreign threads may have sent jobs: what those submit must not nest */
    wait_helping(jobs, &jobs->workers[kd_jobs_worker(jobs)], counter);
    if (outermost)
        jobs_drain_inline(jobs);
}
