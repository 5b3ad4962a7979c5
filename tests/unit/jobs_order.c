/* Order among jobs: after a counter, before all others, along the edges of a graph; and jobs sent by threads
 * that are no workers. Each case with one thread (inline) and with several. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include <dirent.h>
#include <malloc.h>
#include <pthread.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

#include "runtime/core/log.h"
#include "runtime/jobs/graph.h"
#include "runtime/jobs/jobs.h"

static const uint32_t thread_counts[] = {1, 2, 4};
#define FOR_EACH_POOL(jobs)                                                                                  \
    for (size_t pool_index = 0; pool_index < sizeof thread_counts / sizeof thread_counts[0]; pool_index++)   \
        for (kd_jobs *jobs = kd_jobs_make(thread_counts[pool_index]); jobs;                                  \
             kd_jobs_destroy(jobs), jobs = NULL)

static void sleep_us(long us)
{
    nanosleep(&(struct timespec){.tv_nsec = us * 1000}, NULL);
}

static void increment(void *user, uint32_t worker)
{
    (void)worker;
    atomic_fetch_add((atomic_int *)user, 1);
}

/* ---- after a counter ---- */

typedef struct stage {
    atomic_int begun, *before;
    int expected, wrong;
} stage;

static void check_stage(void *user, uint32_t worker)
{
    (void)worker;
    stage *s = user;
    s->wrong += atomic_load(s->before) != s->expected;
    atomic_fetch_add(&s->begun, 1);
}

static void jobs_run_after_the_counter_they_follow(void **state)
{
    (void)state;
    FOR_EACH_POOL(jobs)
    {
        for (int round = 0; round < 200; round++) {
            atomic_int ran = 0;
            kd_job_counter first = {0}, second = {0}, third = {0};
            stage b = {.before = &ran, .expected = 20}, c = {.before = &b.begun, .expected = 1};
            for (int i = 0; i < 20; i++)
                kd_jobs_run(jobs, increment, &ran, &first);
            kd_jobs_run_after(jobs, &first, check_stage, &b, &second);
            kd_jobs_run_after(jobs, &second, check_stage, &c, &third);
            kd_jobs_wait(jobs, &third);
            assert_int_equal(b.begun + c.begun, 2);
            assert_int_equal(b.wrong + c.wrong, 0);
            assert_int_equal(first.pending + second.pending + third.pending, 0);
        }
    }
}

static void many_jobs_may_follow_one_counter(void **state)
{
    (void)state;
    FOR_EACH_POOL(jobs)
    {
        atomic_int ran = 0;
        kd_job_counter gate = {.pending = 1}, done = {0};
        for (int i = 0; i < 1000; i++)
            kd_jobs_run_after(jobs, &gate, increment, &ran, &done);
        assert_int_equal(ran, 0);
        assert_int_equal(done.pending, 1000);
        kd_jobs_lower(jobs, &gate, 1);
        kd_jobs_wait(jobs, &done);
        assert_int_equal(ran, 1000);
        assert_int_equal(gate.pending, 0);
    }
}

static void a_counter_at_zero_lets_jobs_go_at_once(void **state)
{
    (void)state;
    FOR_EACH_POOL(jobs)
    {
        atomic_int ran = 0;
        kd_job_counter zero = {0}, done = {0};
        kd_jobs_run_after(jobs, &zero, increment, &ran, &done);
        kd_jobs_wait(jobs, &done);
        assert_int_equal(ran, 1);
    }
}

typedef struct relay {
    kd_jobs *jobs;
    kd_job_counter *done;
    atomic_int left;
} relay;

/* A frame of its own counter each hop: the counter dies with the job while the next one hangs in its list. */
static void hop(void *user, uint32_t worker)
{
    relay *r = user;
    (void)worker;
    if (atomic_fetch_sub(&r->left, 1) <= 1)
        return;
    kd_job_counter local = {.pending = 1};
    kd_jobs_run_after(r->jobs, &local, hop, r, r->done);
    kd_jobs_lower(r->jobs, &local, 1);
}

static void counters_may_die_as_soon_as_they_are_zero(void **state)
{
    (void)state;
    FOR_EACH_POOL(jobs)
    {
        kd_job_counter done = {0};
        relay r = {.jobs = jobs, .done = &done, .left = 20000};
        kd_jobs_run(jobs, hop, &r, &done);
        kd_jobs_wait(jobs, &done);
        assert_int_equal(r.left, 0);
    }
}

/* ---- first ---- */

typedef struct diary {
    kd_jobs *jobs;
    char text[8];
    int length;
} diary;

static void write_plain(void *user, uint32_t worker)
{
    (void)worker;
    diary *d = user;
    d->text[d->length++] = 'p';
}

static void write_first(void *user, uint32_t worker)
{
    (void)worker;
    diary *d = user;
    d->text[d->length++] = 'f';
}

static void submit_mixed(void *user, uint32_t worker)
{
    (void)worker;
    diary *d = user;
    for (int i = 0; i < 3; i++)
        kd_jobs_run(d->jobs, write_plain, d, NULL);
    kd_jobs_run_first(d->jobs, write_first, d, NULL);
    kd_jobs_run_first(d->jobs, write_first, d, NULL);
}

static void first_jobs_overtake_all_that_wait(void **state)
{
    (void)state;
    kd_jobs *jobs = kd_jobs_make(1);
    diary d = {.jobs = jobs};
    kd_jobs_run(jobs, submit_mixed, &d, NULL);
    assert_string_equal(d.text, "ffppp");
    kd_jobs_destroy(jobs);
}

static void first_jobs_all_run(void **state)
{
    (void)state;
    FOR_EACH_POOL(jobs)
    {
        atomic_int ran = 0;
        kd_job_counter counter = {0};
        for (int i = 0; i < 1000; i++)
            (i & 1 ? kd_jobs_run_first : kd_jobs_run)(jobs, increment, &ran, &counter);
        kd_jobs_wait(jobs, &counter);
        assert_int_equal(ran, 1000);
    }
}

/* ---- graphs ---- */

enum { NODES = 300 };

typedef struct checked_node {
    struct checked_graph *graph;
    uint32_t index;
    atomic_int ran;
} checked_node;

typedef struct checked_graph {
    checked_node nodes[NODES];
    uint32_t before[NODES][4];
    uint32_t before_count[NODES];
    atomic_int early, wrong_place;
    uint32_t lane_every;
} checked_graph;

static void run_checked(void *user, uint32_t worker)
{
    checked_node *n = user;
    checked_graph *g = n->graph;
    for (uint32_t i = 0; i < g->before_count[n->index]; i++)
        if (atomic_load(&g->nodes[g->before[n->index][i]].ran) == 0)
            atomic_fetch_add(&g->early, 1);
    if (n->index % g->lane_every == 0 && worker != KD_GPU_LANE)
        atomic_fetch_add(&g->wrong_place, 1);
    atomic_fetch_add(&n->ran, 1);
}

static uint32_t next_random(uint32_t *s)
{
    *s ^= *s << 13;
    *s ^= *s >> 17;
    *s ^= *s << 5;
    return *s;
}

static void build_random(kd_job_graph *g, checked_graph *c, uint32_t seed)
{
    memset(c, 0, sizeof *c);
    c->lane_every = 7;
    kd_job_graph_clear(g);
    for (uint32_t i = 0; i < NODES; i++) {
        c->nodes[i] = (checked_node){.graph = c, .index = i};
        kd_job_node node = kd_job_graph_add(g, run_checked, &c->nodes[i]);
        kd_job_graph_place(g, node,
                           i % c->lane_every == 0 ? KD_NODE_LANE
                           : i % 11 == 0          ? KD_NODE_FIRST
                                                  : KD_NODE_ANYWHERE);
        c->before_count[i] = i ? next_random(&seed) % 5 : 0;
        for (uint32_t k = 0; k < c->before_count[i]; k++) {
            c->before[i][k] = next_random(&seed) % i; /* now and then the same one twice */
            kd_job_graph_edge(g, c->before[i][k], node);
        }
    }
}

static void graphs_keep_their_order(void **state)
{
    (void)state;
    static checked_graph c;
    FOR_EACH_POOL(jobs)
    {
        kd_job_graph *g = kd_job_graph_make(jobs);
        for (uint32_t seed = 1; seed <= 40; seed++) {
            build_random(g, &c, seed);
            assert_int_equal(kd_job_graph_count(g), NODES);
            for (int run = 1; run <= 3; run++) {
                assert_int_equal(kd_job_graph_run(g), KD_OK);
                for (uint32_t i = 0; i < NODES; i++)
                    assert_int_equal(c.nodes[i].ran, run);
            }
            assert_int_equal(c.early, 0);
            assert_int_equal(c.wrong_place, 0);
        }
        kd_job_graph_destroy(g);
    }
}

static void ignore(void *user, kd_log_level level, const char *text)
{
    (void)level;
    snprintf(user, 256, "%s", text);
}

static void a_circle_is_refused_and_nothing_runs(void **state)
{
    (void)state;
    char said[256] = "";
    kd_jobs *jobs = kd_jobs_make(2);
    kd_job_graph *g = kd_job_graph_make(jobs);
    atomic_int ran = 0;
    kd_job_node a = kd_job_graph_add(g, increment, &ran), b = kd_job_graph_add(g, increment, &ran),
                c = kd_job_graph_add(g, increment, &ran);
    kd_job_graph_edge(g, a, b);
    kd_job_graph_edge(g, b, c);
    kd_job_graph_edge(g, c, b);
    kd_log_set_sink(ignore, said);
    assert_int_equal(kd_job_graph_run(g), KD_OUT_OF_RANGE);
    kd_log_set_sink(NULL, NULL);
    assert_non_null(strstr(said, "2 of 3 nodes"));
    assert_int_equal(ran, 0);
    kd_job_graph_clear(g);
    assert_int_equal(kd_job_graph_run(g), KD_OK); /* an empty one is fine */
    kd_job_graph_destroy(g);
    kd_jobs_destroy(jobs);
}

/* An edge from it, an edge to it, a place for it, and an edge to a node that comes only later. */
static void a_node_that_is_not_there_is_refused_and_nothing_runs(void **state)
{
    (void)state;
    kd_jobs *jobs = kd_jobs_make(2);
    kd_job_graph *g = kd_job_graph_make(jobs);
    for (int way = 0; way < 4; way++) {
        char said[256] = "";
        atomic_int ran = 0;
        kd_job_graph_clear(g);
        kd_job_node a = kd_job_graph_add(g, increment, &ran);
        assert_int_equal(kd_job_graph_run(g), KD_OK); /* sorted once: what follows is looked at again */
        if (way == 0)
            kd_job_graph_edge(g, 1000000, a);
        else if (way == 1)
            kd_job_graph_edge(g, a, 1000000);
        else if (way == 2)
            kd_job_graph_place(g, 1000000, KD_NODE_LANE);
        else
            kd_job_graph_edge(g, a, 1);
        kd_job_graph_add(g, increment, &ran);
        kd_log_set_sink(ignore, said);
        assert_int_equal(kd_job_graph_run(g), KD_OUT_OF_RANGE);
        assert_int_equal(kd_job_graph_run(g), KD_OUT_OF_RANGE); /* it stays so */
        kd_log_set_sink(NULL, NULL);
        assert_non_null(strstr(said, way == 3 ? "node 1 was named" : "node 1000000 was named"));
        assert_int_equal(ran, 1);
    }
    kd_job_graph_clear(g);
    assert_int_equal(kd_job_graph_run(g), KD_OK);
    kd_job_graph_destroy(g);
    kd_jobs_destroy(jobs);
}

#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
/* Every malloc and realloc of the process shows in the heap's bytes in use, as long as nothing is freed in
 * between: the counts before and after a frame are equal, and so is the highest count. */
static void rebuilding_a_graph_allocates_nothing(void **state)
{
    (void)state;
    static checked_graph c;
    kd_jobs *jobs = kd_jobs_make(2);
    kd_job_graph *g = kd_job_graph_make(jobs);
    for (int warm = 0; warm < 50; warm++) {
        build_random(g, &c, 5);
        assert_int_equal(kd_job_graph_run(g), KD_OK);
    }
    struct mallinfo2 before = mallinfo2();
    for (uint32_t frame = 0; frame < 50; frame++) {
        build_random(g, &c, 5);
        assert_int_equal(kd_job_graph_run(g), KD_OK);
        struct mallinfo2 after = mallinfo2();
        assert_int_equal(after.uordblks, before.uordblks);
        assert_int_equal(after.arena, before.arena);
        assert_int_equal(after.hblkhd, before.hblkhd);
    }
    kd_job_graph_destroy(g);
    kd_jobs_destroy(jobs);
}
#endif

/* ---- foreign threads ---- */

typedef struct outsider {
    kd_jobs *jobs;
    atomic_int *ran;
    int ranges;
    atomic_bool left;
} outsider;

static void count_range(void *user, uint32_t begin, uint32_t end, uint32_t worker)
{
    (void)worker;
    atomic_fetch_add((atomic_int *)user, (int)(end - begin));
}

static void *submit_from_outside(void *user)
{
    outsider *o = user;
    atomic_int own = 0;
    for (int round = 0; round < 50; round++) {
        kd_job_counter counter = {0}, later = {0};
        for (int i = 0; i < 20; i++)
            kd_jobs_run(o->jobs, increment, o->ran, &counter);
        kd_jobs_run_first(o->jobs, increment, o->ran, &counter);
        kd_jobs_run_lane(o->jobs, increment, o->ran, &counter);
        kd_jobs_run_after(o->jobs, &counter, increment, &own, &later);
        kd_jobs_wait(o->jobs, &later);
        atomic_int covered = 0;
        kd_jobs_parallel_for(o->jobs, 1000, round & 1 ? 7 : 0, count_range, &covered);
        o->ranges += covered == 1000;
    }
    o->ranges += own == 50;
    atomic_store(&o->left, true);
    return NULL;
}

static void foreign_threads_may_submit_and_wait(void **state)
{
    (void)state;
    FOR_EACH_POOL(jobs)
    {
        atomic_int ran = 0;
        outsider outsiders[3];
        pthread_t threads[3];
        for (int i = 0; i < 3; i++) {
            outsiders[i] = (outsider){.jobs = jobs, .ran = &ran};
            assert_int_equal(pthread_create(&threads[i], NULL, submit_from_outside, &outsiders[i]), 0);
        }
        while (!outsiders[0].left || !outsiders[1].left || !outsiders[2].left) {
            atomic_int own = 0; /* worker 0 goes on with its own work, which lets theirs in */
            kd_job_counter counter = {0};
            kd_jobs_run(jobs, increment, &own, &counter);
            kd_jobs_run_lane(jobs, increment, &own, &counter);
            kd_jobs_wait(jobs, &counter);
            assert_int_equal(own, 2);
            sleep_us(20);
        }
        for (int i = 0; i < 3; i++) {
            pthread_join(threads[i], NULL);
            assert_int_equal(outsiders[i].ranges, 51);
        }
        assert_int_equal(ran, 3 * 50 * 22);
    }
}

/* ---- idle ---- */

#if !defined(__SANITIZE_THREAD__) /* it runs a thread of its own */

/* The state letter of every thread but ours: true when all sleep. */
static bool others_sleep(void)
{
    DIR *tasks = opendir("/proc/self/task");
    bool asleep = tasks != NULL;
    for (struct dirent *entry; tasks && (entry = readdir(tasks));) {
        char path[300], letter = 0;
        if (entry->d_name[0] == '.' || atoi(entry->d_name) == getpid())
            continue;
        snprintf(path, sizeof path, "/proc/self/task/%s/stat", entry->d_name);
        FILE *file = fopen(path, "r");
        if (file && fscanf(file, "%*d %*s %c", &letter) == 1)
            asleep = asleep && letter == 'S';
        if (file)
            fclose(file);
    }
    if (tasks)
        closedir(tasks);
    return asleep;
}

static void idle_workers_fall_asleep(void **state)
{
    (void)state;
    kd_jobs *jobs = kd_jobs_make(4);
    atomic_int ran = 0;
    kd_job_counter counter = {0};
    for (int i = 0; i < 100; i++)
        kd_jobs_run(jobs, increment, &ran, &counter);
    kd_jobs_wait(jobs, &counter);
    int in_a_row = 0; /* asleep at ten looks one millisecond apart: no spinning between them */
    for (int look = 0; look < 20000 && in_a_row < 10; look++) {
        in_a_row = others_sleep() ? in_a_row + 1 : 0;
        sleep_us(1000);
    }
    assert_int_equal(in_a_row, 10);
    kd_jobs_destroy(jobs);
}
#endif

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(jobs_run_after_the_counter_they_follow),
        cmocka_unit_test(many_jobs_may_follow_one_counter),
        cmocka_unit_test(a_counter_at_zero_lets_jobs_go_at_once),
        cmocka_unit_test(counters_may_die_as_soon_as_they_are_zero),
        cmocka_unit_test(first_jobs_overtake_all_that_wait),
        cmocka_unit_test(first_jobs_all_run),
        cmocka_unit_test(graphs_keep_their_order),
        cmocka_unit_test(a_circle_is_refused_and_nothing_runs),
        cmocka_unit_test(a_node_that_is_not_there_is_refused_and_nothing_runs),
#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
        cmocka_unit_test(rebuilding_a_graph_allocates_nothing),
#endif
        cmocka_unit_test(foreign_threads_may_submit_and_wait),
#if !defined(__SANITIZE_THREAD__)
        cmocka_unit_test(idle_workers_fall_asleep),
#endif
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
