/* Access of a system, seen where it begins: at queries, at values found by handle, at singletons. */
#include "runtime/ecs/watch.h"

#include <stdio.h>

#include "runtime/ecs/internal.h"

_Thread_local ecs_watch *ecs_watching;

ecs_declared ecs_watch_declared(const ecs_watch *watch, const kd_component_desc *desc)
{
    ecs_declared found = ECS_NOT_DECLARED;
    for (const kd_component_use *u = watch->uses; u < watch->uses + KD_MAX_COMPONENT_USES && u->desc; u++)
        if (ecs_same_component(u->desc, desc) && found != ECS_DECLARED_WRITE)
            found = u->write ? ECS_DECLARED_WRITE : ECS_DECLARED_READ;
    return found;
}

static const char *name_of(const kd_query *q)
{
    return q->name ? q->name : "without a name";
}

/* Complain unless the component is declared at least so. */
static void require(ecs_watch *watch, const kd_component_desc *desc, ecs_declared least, const char *what,
                    const char *name)
{
    ecs_declared declared = ecs_watch_declared(watch, desc);
    if (declared >= least || watch->status != KD_OK)
        return;
    bool writes = least == ECS_DECLARED_WRITE;
    watch->status = kd_fail(KD_USAGE, "system %s: %s%s %s component %s, which the system %s; list it with %s",
                            watch->system, what, name, writes ? "writes" : "reads", desc->name,
                            declared == ECS_DECLARED_READ ? "declares as read" : "does not declare",
                            writes ? "KD_CHANGES" : "KD_USES");
}

static void count_rows(ecs_watch *watch, const kd_query *q)
{
    for (uint32_t i = 0; i < q->match_count; i++)
        watch->rows += q->matches[i].table->count;
    watch->tables += q->match_count;
}

static void keep_query(ecs_watch *watch, const kd_query *q)
{
    if (watch->query_count == ECS_WATCHED_QUERIES)
        return;
    ecs_watched_query *kept = &watch->queries[watch->query_count++];
    snprintf(kept->name, sizeof kept->name, "%s", name_of(q));
    kept->term_count = q->term_count;
    memcpy(kept->ids, q->ids, sizeof kept->ids);
}

void ecs_watch_query(const kd_query *q)
{
    ecs_watch *watch = ecs_watching;
    count_rows(watch, q);
    if (!watch->checked)
        return;
    keep_query(watch, q);
    for (uint32_t i = 0; i < q->term_count; i++) {
        const kd_component_desc *desc = q->world->components[q->ids[i]].desc;
        if (q->kinds[i] == KD_TERM_WRITE || q->kinds[i] == KD_TERM_OPTIONAL_WRITE)
            require(watch, desc, ECS_DECLARED_WRITE, "query ", name_of(q));
        else if (q->kinds[i] != KD_TERM_WITH && q->kinds[i] != KD_TERM_WITHOUT)
            require(watch, desc, ECS_DECLARED_READ, "query ", name_of(q));
    }
}

void ecs_watch_value(const kd_world *w, kd_component_id id, bool write)
{
    ecs_watch *watch = ecs_watching;
    if (watch && watch->checked && id && id <= kd_component_count(w))
        require(watch, w->components[id].desc, write ? ECS_DECLARED_WRITE : ECS_DECLARED_READ,
                write ? "kd_find_mut" : "kd_find or kd_singleton", "");
}

const char *ecs_watch_query_name(const ecs_watch *watch, kd_component_id id)
{
    for (uint32_t i = watch->query_count; i-- > 0;)
        for (uint32_t term = 0; term < watch->queries[i].term_count; term++)
            if (watch->queries[i].ids[term] == id)
                return watch->queries[i].name;
    return NULL;
}
