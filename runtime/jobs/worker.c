/* What a worker does: find a job, run it, sum up what has ended.
 *
 * Finished jobs of one counter are subtracted together, before a job of another counter begins or the worker
 * runs dry: the counter could not have become zero earlier, and workers do not fight for its cache line. */
#include "runtime/core/clock.h"
#include "runtime/jobs/pool.h"

enum {
    TRIAL = 2,     /* steals after a rest, to see whether jobs are still tiny */
    STRETCH = 8,   /* steals that are timed together */
    TINY_NS = 250, /* what a steal costs thief and owner, with what the job finds cold: a shorter one is not
                      worth it */
    REST_MIN_NS = 1000,
    REST_MAX_NS = 8000, /* less than a loop must last to be split at all */
};

/* Count a steal. A thief of tiny jobs hinders their owner more than it helps: it rests, ever longer as long
 * as they stay tiny. Some are timed together, without the time in which there was nothing to steal.
 */
static void count_steal(job_worker *w)
{
    if (w->idle_ns)
        w->stretch_ns += kd_clock_ns() - w->idle_ns;
    w->idle_ns = 0;
    uint32_t stretch = w->rest_ns ? TRIAL : STRETCH;
    if (++w->stolen < stretch)
        return;
    uint64_t now = kd_clock_ns(), longer = w->rest_ns * 2;
    bool tiny = now - w->stretch_ns < stretch * TINY_NS;
    w->stolen = 0;
    w->rest_ns = !tiny ? 0 : longer < REST_MIN_NS ? REST_MIN_NS : longer < REST_MAX_NS ? longer : REST_MAX_NS;
    w->rest_until_ns = now + w->rest_ns;
    w->stretch_ns = now;
}

/* Nothing was stolen, or nothing is to be. */
static bool steal_nothing(job_worker *w)
{
    if (!w->idle_ns)
        w->idle_ns = kd_clock_ns();
    return false;
}

static bool rests(job_worker *w)
{
    if (w->rest_until_ns && kd_clock_ns() >= w->rest_until_ns)
        w->rest_until_ns = 0;
    return w->rest_until_ns != 0;
}

static bool steal_any(kd_jobs *jobs, job_worker *w, job *out)
{
    if (rests(w))
        return steal_nothing(w);
    for (uint32_t i = 0; i < jobs->threads; i++) {
        uint32_t victim = w->victim;
        w->victim = victim + 1 < jobs->threads ? victim + 1 : 0;
        if (victim == w->index)
            continue;
        job_deque *deque = &jobs->workers[victim].deque;
        int64_t top, seen = w->seen_top[victim];
        int64_t count = job_deque_look(deque, &top);
        w->seen_top[victim] = count == 1 ? top : -1;
        if ((count > 1 || (count == 1 && seen == top)) && job_deque_steal(deque, top, out)) {
            w->victim = victim; /* there may be more */
            count_steal(w);
            return true;
        }
    }
    return steal_nothing(w);
}

void jobs_execute(kd_jobs *jobs, job_worker *w, const job *j, jobs_finished *run)
{
    if (run->counter != j->counter)
        jobs_flush(jobs, run);
    uint32_t label = j->fn ? 0 : jobs_piece_label(j), outer = w->label;
    w->label = label;
    if (jobs->hooks.begin)
        jobs->hooks.begin(jobs->hooks.user, w->index, label);
    if (j->fn)
        j->fn(j->user, w->index);
    else
        jobs_run_piece(jobs, w, j);
    if (jobs->hooks.end)
        jobs->hooks.end(jobs->hooks.user, w->index, label);
    w->label = outer;
    run->counter = j->counter;
    run->count += j->counter != NULL;
}

static bool find_job(kd_jobs *jobs, job_worker *w, job *out)
{
    return job_queue_take(&jobs->first, out) || job_deque_take(&w->deque, out) ||
           job_queue_take(&jobs->inbox, out) || steal_any(jobs, w, out);
}

/* Run one job if there is one: the lane's before all others. */
bool jobs_run_one(kd_jobs *jobs, job_worker *w, jobs_finished *run)
{
    job j;
    if (w->index == KD_GPU_LANE && !jobs->lane_busy && job_queue_take(&jobs->lane, &j)) {
        jobs->lane_busy = true;
        jobs_execute(jobs, w, &j, run);
        jobs->lane_busy = false;
        return true;
    }
    if (!find_job(jobs, w, &j))
        return false;
    jobs_execute(jobs, w, &j, run);
    return true;
}

/* Single thread: run all that the last job left behind. */
void jobs_drain_inline(kd_jobs *jobs)
{
    jobs_finished run = {0};
    jobs->inside = true;
    for (;;) {
        if (jobs_run_one(jobs, &jobs->workers[0], &run))
            continue;
        if (!run.counter)
            break;
        jobs_flush(jobs, &run); /* may let jobs go that waited */
    }
    jobs->inside = false;
}

void *jobs_worker_main(void *user)
{
    job_worker *w = user;
    kd_jobs *jobs = w->jobs;
    jobs_thread.jobs = jobs;
    jobs_thread.worker = w->index;
    jobs_finished run = {0};
    jobs_idle_state state = {0};
    for (;;) {
        if (jobs_run_one(jobs, w, &run)) {
            state.until_ns = 0;
            continue;
        }
        jobs_flush(jobs, &run);
        if (atomic_load(&jobs->stop) && !jobs_work_is_visible(jobs, w))
            break;
        jobs_idle(jobs, w, NULL, &state);
    }
    run = (jobs_finished){&jobs->alive, 1};
    jobs_flush(jobs, &run);
    return NULL;
}
