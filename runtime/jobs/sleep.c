/* Sleeping and waking: one place a worker, so that a wake-up reaches the one that is meant.
 *
 * No wake-up is lost. Who sleeps first sets its bit in `parked` (and in `waiting` when it waits for a
 * counter), then looks at the deques, the queues and its counter once more. Who submits or finishes first
 * publishes, then reads the mask. All four are sequentially consistent, so at least one of the two sees the
 * other. */
#include "runtime/core/clock.h"
#include "runtime/jobs/pool.h"

enum {
    SPIN_NS = 20000, /* about the price of a sleep and a wake-up: longer would waste more than it saves */
    MAX_PAUSES = 32, /* looking at a deque takes its cache line away: look less often when nothing comes */
};

static void unpark(job_worker *w)
{
    pthread_mutex_lock(&w->lock);
    w->signaled = true;
    pthread_cond_signal(&w->signal);
    pthread_mutex_unlock(&w->lock);
}

bool jobs_wake(kd_jobs *jobs, uint32_t worker)
{
    uint64_t bit = (uint64_t)1 << worker;
    if (!(atomic_fetch_and(&jobs->parked, ~bit) & bit))
        return false;
    unpark(&jobs->workers[worker]);
    return true;
}

/* Wake up to n sleepers, the highest first: worker 0 has the lane to care for. */
void jobs_wake_sleepers(kd_jobs *jobs, uint32_t n)
{
    while (n > 0) {
        uint64_t parked = atomic_load(&jobs->parked);
        if (!parked)
            return;
        if (jobs_wake(jobs, 63u - (uint32_t)__builtin_clzll(parked)))
            n--;
    }
}

void jobs_wake_waiting(kd_jobs *jobs)
{
    for (uint64_t waiting = atomic_load(&jobs->waiting); waiting; waiting &= waiting - 1)
        jobs_wake(jobs, (uint32_t)__builtin_ctzll(waiting));
    if (atomic_load(&jobs->outside_waiting) > 0) {
        pthread_mutex_lock(&jobs->outside_lock);
        pthread_cond_broadcast(&jobs->outside_signal);
        pthread_mutex_unlock(&jobs->outside_lock);
    }
}

bool jobs_work_is_visible(kd_jobs *jobs, const job_worker *w)
{
    int64_t top;
    for (uint32_t i = 0; i < jobs->threads; i++)
        if (job_deque_look(&jobs->workers[i].deque, &top) > 0)
            return true;
    if (atomic_load(&jobs->first.count) > 0 || atomic_load(&jobs->inbox.count) > 0)
        return true;
    return w->index == KD_GPU_LANE && !jobs->lane_busy && atomic_load(&jobs->lane.count) > 0;
}

/* Sleep until there may be work, the counter may be zero (NULL: none is awaited) or the pool stops. */
static void park(kd_jobs *jobs, job_worker *w, kd_job_counter *counter)
{
    uint64_t bit = (uint64_t)1 << w->index;
    atomic_fetch_or(&jobs->parked, bit);
    if (counter)
        atomic_fetch_or(&jobs->waiting, bit);
    bool ready = counter ? atomic_load(&counter->pending) == 0 : atomic_load(&jobs->stop);
    if (!ready && !jobs_work_is_visible(jobs, w)) {
        pthread_mutex_lock(&w->lock);
        while (!w->signaled)
            pthread_cond_wait(&w->signal, &w->lock);
        w->signaled = false;
        pthread_mutex_unlock(&w->lock);
    }
    if (counter)
        atomic_fetch_and(&jobs->waiting, ~bit);
    atomic_fetch_and(&jobs->parked, ~bit);
}

static void pause_briefly(void)
{
#if defined(__x86_64__) || defined(__i386__)
    __builtin_ia32_pause();
#elif defined(__aarch64__)
    __asm__ volatile("isb");
#endif
}

/* Nothing was found: pause, ever longer, then sleep. */
void jobs_idle(kd_jobs *jobs, job_worker *w, kd_job_counter *counter, jobs_idle_state *state)
{
    uint64_t now = kd_clock_ns();
    if (state->until_ns == 0)
        *state = (jobs_idle_state){.until_ns = now + SPIN_NS, .pauses = 1};
    if (now >= state->until_ns) {
        park(jobs, w, counter);
        *state = (jobs_idle_state){0};
        return;
    }
    for (uint32_t i = 0; i < state->pauses; i++)
        pause_briefly();
    state->pauses = state->pauses < MAX_PAUSES ? state->pauses * 2 : MAX_PAUSES;
}
