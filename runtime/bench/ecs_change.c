/* Structure: making and destroying entities, adding and removing components, at once and by commands; what a
 * world holds; snapshots. */
#include <stdlib.h>
#include <string.h>

#include "runtime/bench/ecs_cases.h"
#include "runtime/ecs/instance.h"
#include "runtime/ecs/snapshot.h"

/* ---- making ---- */

static void bench_create(bench_run *run, uint32_t n, kd_entity *e)
{
    bench b = bench_begin(run, "create3", n, "ns/entity", n);
    while (bench_wanted(run, b.name) && bench_more(&b)) {
        kd_world *w = bench_world(run);
        if (!w)
            return;
        bench_start(&b);
        bench_fill(w, e, n);
        bench_stop(&b);
        kd_world_destroy(w);
    }
    bench_report(&b);
}

static void bench_create_again(bench_run *run, uint32_t n, kd_entity *e)
{
    bench b = bench_begin(run, "create3_recycle", n, "ns/entity", n);
    kd_world *w = bench_wanted(run, b.name) ? bench_world(run) : NULL;
    while (w && bench_more(&b)) {
        bench_start(&b);
        bench_fill(w, e, n);
        bench_stop(&b);
        for (uint32_t i = 0; i < n; i++)
            kd_destroy(w, e[i]);
    }
    bench_report(&b);
    kd_world_destroy(w);
}

static void bench_create_bulk(bench_run *run, uint32_t n)
{
    static const kd_component_desc *const descs[] = {&bench_position_desc, &bench_velocity_desc,
                                                     &bench_health_desc};
    if (!bench_wanted(run, "create3_bulk"))
        return;
    void *columns[] = {bench_alloc(run, n, sizeof(bench_position)),
                       bench_alloc(run, n, sizeof(bench_velocity)),
                       bench_alloc(run, n, sizeof(bench_health))};
    bench b = bench_begin(run, "create3_bulk", n, "ns/entity", n);
    while (bench_more(&b)) {
        kd_world *w = bench_world(run);
        if (!w)
            break;
        bench_start(&b);
        kd_status status = kd_spawn_n(w, n, descs, (const void *const *)columns, 3, NULL);
        bench_stop(&b);
        if (status != KD_OK)
            bench_fail(run);
        kd_world_destroy(w);
    }
    bench_report(&b);
    for (int i = 0; i < 3; i++)
        free(columns[i]);
}

/* One prototype, copied one by one or in one call. */
static void bench_copies(bench_run *run, uint32_t n, kd_entity *e, bool bulk)
{
    bench b = bench_begin(run, bulk ? "prefab_inst3_bulk" : "prefab_inst3", n, "ns/entity", n);
    kd_world *w = bench_wanted(run, b.name) ? bench_world(run) : NULL;
    if (!w)
        return;
    kd_entity one = kd_spawn(w, KD_VAL(bench_position, {1, 2, 3}), KD_VAL(bench_velocity, {1, 2, 3}),
                             KD_VAL(bench_health, {1, 2}));
    while (bench_more(&b)) {
        kd_status status = KD_OK;
        bench_start(&b);
        for (uint32_t i = 0; i < (bulk ? 1 : n) && status == KD_OK; i++)
            status = kd_instantiate(w, one, KD_NO_ENTITY, bulk ? n : 1, &e[i]);
        bench_stop(&b);
        if (status != KD_OK)
            bench_fail(run);
        kd_destroy_n(w, e, n);
    }
    bench_report(&b);
    kd_world_destroy(w);
}

static void bench_memory(bench_run *run, uint32_t n, kd_entity *e)
{
    kd_world *w = bench_wanted(run, "mem_bytes_per_entity") ? bench_world(run) : NULL;
    if (!w)
        return;
    size_t before = kd_world_bytes(w);
    bench_fill(w, e, n);
    bench_value(run, "mem_bytes_per_entity", n, "bytes/entity", (double)(kd_world_bytes(w) - before) / n);
    kd_world_destroy(w);
}

void bench_ecs_create(bench_run *run, uint32_t n, kd_entity *e)
{
    bench_create(run, n, e);
    bench_create_again(run, n, e);
    bench_create_bulk(run, n);
    bench_copies(run, n, e, false);
    bench_copies(run, n, e, true);
    bench_memory(run, n, e);
}

/* ---- changing ---- */

static void bench_destroy(bench_run *run, uint32_t n, kd_entity *e, bool random)
{
    bench b = bench_begin(run, random ? "destroy_random" : "destroy", n, "ns/entity", n);
    while (bench_wanted(run, b.name) && bench_more(&b)) {
        kd_world *w = bench_world(run);
        if (!w)
            return;
        bench_fill(w, e, n);
        if (random)
            bench_shuffle(e, n);
        bench_start(&b);
        for (uint32_t i = 0; i < n; i++)
            kd_destroy(w, e[i]);
        bench_stop(&b);
        kd_world_destroy(w);
    }
    bench_report(&b);
}

/* All that have a position, by query. */
static void bench_destroy_bulk(bench_run *run, uint32_t n, kd_entity *e)
{
    bench b = bench_begin(run, "destroy_bulk", n, "ns/entity", n);
    while (bench_wanted(run, b.name) && bench_more(&b)) {
        kd_world *w = bench_world(run);
        if (!w)
            return;
        bench_fill(w, e, n);
        kd_query *q = kd_query_make(w, &(kd_query_desc){.terms = {KD_WITH(bench_position)}});
        bench_start(&b);
        kd_status status = q ? kd_destroy_query(q) : KD_NO_MEMORY;
        bench_stop(&b);
        if (status != KD_OK)
            bench_fail(run);
        kd_world_destroy(w);
    }
    bench_report(&b);
}

static void bench_add_remove(bench_run *run, kd_world *w, uint32_t n, const kd_entity *e)
{
    bench add = bench_begin(run, "add1", n, "ns/entity", n);
    bench remove = bench_begin(run, "remove1", n, "ns/entity", n);
    while (bench_more(&add)) {
        bench_start(&add);
        for (uint32_t i = 0; i < n; i++)
            kd_add(w, e[i], bench_extra);
        bench_stop(&add);
        bench_start(&remove);
        for (uint32_t i = 0; i < n; i++)
            kd_remove(w, e[i], bench_extra);
        bench_stop(&remove);
    }
    bench_report(&add);
    bench_report(&remove);
}

static void bench_sparse_add_remove(bench_run *run, kd_world *w, uint32_t n, const kd_entity *e)
{
    bench add = bench_begin(run, "add1_sparse", n, "ns/entity", n);
    bench remove = bench_begin(run, "remove1_sparse", n, "ns/entity", n);
    while (bench_more(&add)) {
        bench_start(&add);
        for (uint32_t i = 0; i < n; i++)
            kd_add(w, e[i], bench_sparse);
        bench_stop(&add);
        bench_start(&remove);
        for (uint32_t i = 0; i < n; i++)
            kd_remove(w, e[i], bench_sparse);
        bench_stop(&remove);
    }
    bench_report(&add);
    bench_report(&remove);
}

static void bench_add_remove_each(bench_run *run, kd_world *w, uint32_t n, const kd_entity *e)
{
    bench b = bench_begin(run, "addremove1_each", n, "ns/entity", n);
    while (bench_more(&b)) {
        bench_start(&b);
        for (uint32_t i = 0; i < n; i++) {
            kd_add(w, e[i], bench_extra);
            kd_remove(w, e[i], bench_extra);
        }
        bench_stop(&b);
    }
    bench_report(&b);
}

static void bench_deferred_add(bench_run *run, kd_world *w, uint32_t n, const kd_entity *e)
{
    kd_query *q = bench_moving(w);
    kd_commands *c = kd_world_commands(w, 0);
    bench b = bench_begin(run, "deferred_add_in_iter", n, "ns/entity", n);
    while (bench_more(&b)) {
        bench_start(&b);
        for (kd_iter it = kd_query_iter(q); kd_iter_next(&it);)
            for (uint32_t i = 0; i < it.count; i++)
                kd_commands_set(c, it.entities[i], KD_TAG(bench_extra));
        kd_status status = kd_world_merge(w);
        bench_stop(&b);
        if (status != KD_OK)
            bench_fail(run);
        for (uint32_t i = 0; i < n; i++)
            kd_remove(w, e[i], bench_extra);
    }
    bench_report(&b);
}

static void bench_deferred_delete(bench_run *run, kd_world *w, uint32_t n, kd_entity *e)
{
    kd_query *q = bench_moving(w);
    kd_commands *c = kd_world_commands(w, 0);
    bench b = bench_begin(run, "deferred_delete_in_iter", n, "ns/entity", n);
    while (bench_more(&b)) {
        bench_start(&b);
        for (kd_iter it = kd_query_iter(q); kd_iter_next(&it);)
            for (uint32_t i = 0; i < it.count; i++)
                kd_commands_destroy(c, it.entities[i]);
        kd_status status = kd_world_merge(w);
        bench_stop(&b);
        if (status != KD_OK)
            bench_fail(run);
        bench_fill(w, e, n);
    }
    bench_report(&b);
}

void bench_ecs_change(bench_run *run, uint32_t n, kd_entity *e)
{
    bench_destroy(run, n, e, false);
    bench_destroy(run, n, e, true);
    bench_destroy_bulk(run, n, e);
    kd_world *w = bench_world(run);
    if (!w)
        return;
    bench_fill(w, e, n);
    if (bench_wanted(run, "add1") || bench_wanted(run, "remove1"))
        bench_add_remove(run, w, n, e);
    if (bench_wanted(run, "add1_sparse") || bench_wanted(run, "remove1_sparse"))
        bench_sparse_add_remove(run, w, n, e);
    if (bench_wanted(run, "addremove1_each"))
        bench_add_remove_each(run, w, n, e);
    if (bench_wanted(run, "deferred_add_in_iter"))
        bench_deferred_add(run, w, n, e);
    if (bench_wanted(run, "deferred_delete_in_iter"))
        bench_deferred_delete(run, w, n, e);
    kd_world_destroy(w);
}

/* ---- snapshots ---- */

/* The bound: a copy of the payload. */
static double plain_copy(bench_run *run, uint32_t n)
{
    size_t size = sizeof(bench_position) + sizeof(bench_velocity) + sizeof(bench_health);
    char *from = bench_alloc(run, n, size), *to = bench_alloc(run, n, size);
    bench b = bench_begin(run, "plain", n, "ns/entity", n);
    while (from && to && bench_more(&b)) {
        bench_start(&b);
        memcpy(to, from, n * size);
        bench_stop(&b);
        bench_sink = to[n - 1];
    }
    free(from);
    free(to);
    return bench_median(&b);
}

void bench_ecs_snapshot(bench_run *run, uint32_t n, kd_entity *e)
{
    kd_world *w = bench_wanted(run, "snapshot_binary") || bench_wanted(run, "snapshot_restore")
                      ? bench_world(run)
                      : NULL;
    if (!w)
        return;
    kd_snapshot s = {0};
    bench write = bench_begin(run, "snapshot_binary", n, "ns/entity", n);
    bench restore = bench_begin(run, "snapshot_restore", n, "ns/entity", n);
    write.limit = restore.limit = plain_copy(run, n);
    bench_fill(w, e, n);
    while (bench_more(&write)) {
        bench_start(&write);
        kd_status status = kd_snapshot_write(w, &s);
        bench_stop(&write);
        bench_start(&restore);
        if (status == KD_OK)
            status = kd_snapshot_restore(w, s.data, s.size);
        bench_stop(&restore);
        if (status != KD_OK)
            run->status = status;
    }
    bench_report(&write);
    bench_report(&restore);
    kd_snapshot_fini(&s);
    kd_world_destroy(w);
}
