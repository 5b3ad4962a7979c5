/* Queries keep a flat list of the tables they match. A table is appended when it is made, so walking a query
 * never searches; equal queries share one list and are counted. With by_depth the list is kept sorted by the
 * tables' depth. */

#include "runtime/ecs/internal.h"

/* ---- matching ---- */
bool ecs_query_matches(const kd_query *q, const ecs_table *t)
{
    bool any = !q->has_any;
    for (uint32_t i = 0; i < q->term_count; i++) {
        const ecs_component *c = &q->world->components[q->ids[i]];
        if (c->sparse || (c->side && q->kinds[i] == KD_TERM_WITHOUT)) { /* its rows will be asked */
            any |= q->kinds[i] == KD_TERM_ANY;
            continue;
        }
        bool here = ecs_column_of(t, q->ids[i]) != 0;
        switch (q->kinds[i]) {
        case KD_TERM_READ:
        case KD_TERM_WRITE:
        case KD_TERM_WITH:
            if (!here)
                return false;
            break;
        case KD_TERM_WITHOUT:
            if (here)
                return false;
            break;
        case KD_TERM_ANY: any |= here; break;
        default: break;
        }
    }
    return any;
}

/* Where a term's values lie: a column of the table, or one of the two that stand behind them. */
static uint16_t column_shown(const kd_query *q, const ecs_table *t, uint32_t term)
{
    uint32_t c = ecs_term_accessed(q->kinds[term]) ? ecs_column_of(t, q->ids[term]) : 0;
    return (uint16_t)(c == ECS_TAG_COLUMN ? t->column_count + 1u : c ? c : t->column_count);
}

static void insert_match(kd_query *q, ecs_table *t)
{
    uint32_t at = q->match_count++;
    while (q->by_depth && at && q->matches[at - 1].table->depth > t->depth) {
        q->matches[at] = q->matches[at - 1];
        at--;
    }
    ecs_match *m = &q->matches[at];
    *m = (ecs_match){.table = t};
    for (uint32_t i = 0; i < q->term_count; i++)
        m->columns[i] = column_shown(q, t, i);
}

static bool reserve_match(kd_world *w, kd_query *q)
{
    return ecs_reserve(w, &q->matches, &q->match_capacity, q->match_count, q->match_count + 1,
                       sizeof *q->matches);
}

bool ecs_queries_add_table(kd_world *w, ecs_table *t)
{
    for (kd_query *q = w->queries; q; q = q->next)
        if (!reserve_match(w, q))
            return false;
    for (kd_query *q = w->queries; q; q = q->next)
        if (ecs_query_matches(q, t))
            insert_match(q, t);
    return true;
}

/* ---- making ---- */
static void query_free(kd_world *w, kd_query *q)
{
    ecs_free(w, q->name);
    ecs_free(w, q->matches);
    ecs_free(w, q);
}

static bool fill_terms(kd_world *w, kd_query *q, const kd_query_desc *desc)
{
    q->by_depth = desc->by_depth;
    for (uint32_t i = 0; i < KD_MAX_TERMS && desc->terms[i].kind != KD_TERM_END; i++) {
        q->ids[i] = kd_component_ensure(w, desc->terms[i].desc);
        q->kinds[i] = (uint8_t)desc->terms[i].kind;
        q->has_any |= desc->terms[i].kind == KD_TERM_ANY;
        q->term_count = i + 1;
        if (!q->ids[i])
            return false;
        const ecs_component *c = &w->components[q->ids[i]];
        q->targets[i] = desc->terms[i].target;
        if (c->relation && (q->targets[i].generation & ECS_PENDING))
            q->targets[i] = kd_entity_resolve(w, q->targets[i]);
        if (q->targets[i].generation && !c->relation) {
            kd_fail(KD_UNSUPPORTED, "query %s: component %s is no relation and has no target",
                    desc->name ? desc->name : "without a name", c->desc->name);
            return false;
        }
        q->relation_terms |= (uint32_t)(c->relation != 0) << i;
        q->row_terms |= (uint32_t)(c->side != 0 || c->relation) << i;
        q->sparse_terms |= (uint32_t)(c->sparse && ecs_term_accessed(q->kinds[i])) << i;
    }
    return true;
}

static bool queries_equal(const kd_query *a, const kd_query *b)
{
    return a->term_count == b->term_count && a->by_depth == b->by_depth &&
           memcmp(a->kinds, b->kinds, a->term_count) == 0 &&
           memcmp(a->ids, b->ids, a->term_count * sizeof a->ids[0]) == 0 &&
           memcmp(a->targets, b->targets, a->term_count * sizeof a->targets[0]) == 0;
}

/* The lock is held. */
static kd_query *query_add(kd_world *w, const kd_query *like, const char *name)
{
    kd_query *q = ecs_grow(w, NULL, 0, sizeof *q);
    if (!q)
        return NULL;
    *q = *like;
    size_t length = name ? strlen(name) + 1 : 0;
    q->name = length ? ecs_grow(w, NULL, 0, length) : NULL;
    if (length && q->name)
        memcpy(q->name, name, length);
    bool done = !length || q->name;
    for (uint32_t i = 0; i < w->head.table_count && done; i++) {
        done = reserve_match(w, q);
        if (done && ecs_query_matches(q, w->head.tables[i]))
            insert_match(q, w->head.tables[i]);
    }
    if (!done) {
        query_free(w, q);
        return NULL;
    }
    q->next = w->queries;
    w->queries = q;
    return q;
}

kd_query *kd_query_make(kd_world *w, const kd_query_desc *desc)
{
    kd_query like = {.world = w};
    if (!fill_terms(w, &like, desc))
        return NULL;
    pthread_mutex_lock(&w->lock);
    kd_query *q = w->queries;
    while (q && !queries_equal(q, &like))
        q = q->next;
    if (!q)
        q = query_add(w, &like, desc->name);
    if (q)
        q->references++;
    pthread_mutex_unlock(&w->lock);
    return q;
}

void kd_query_destroy(kd_query *q)
{
    if (!q)
        return;
    kd_world *w = q->world;
    pthread_mutex_lock(&w->lock);
    if (--q->references == 0) {
        kd_query **link = &w->queries;
        while (*link != q)
            link = &(*link)->next;
        *link = q->next;
        query_free(w, q);
    }
    pthread_mutex_unlock(&w->lock);
}

void ecs_queries_fini(kd_world *w)
{
    while (w->queries) {
        kd_query *q = w->queries;
        w->queries = q->next;
        query_free(w, q);
    }
}

uint32_t kd_query_count(kd_query *q)
{
    uint32_t count = 0;
    if (q->row_terms) {
        for (kd_iter it = ecs_query_iter(q); kd_iter_next(&it);)
            count += it.count;
        return count;
    }
    for (uint32_t i = 0; i < q->match_count; i++)
        count += q->matches[i].table->count;
    return count;
}
