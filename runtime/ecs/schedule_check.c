/* Writes that a system does not declare. Before it runs every chunk of every column that it may not write is
 * hashed, and after it again: whichever way it was written, the difference shows. Sparse values, the values
 * of a relation's pairs and singletons count as one chunk each. */
#include <stdio.h>
#include <stdlib.h>

#define XXH_INLINE_ALL
#include <xxhash.h>

#include "runtime/ecs/internal.h"
#include "runtime/ecs/schedule_internal.h"

struct schedule_check {
    kd_jobs *pool; /* of one thread */
    bool may_write[ECS_MAX_COMPONENTS + 1];
    bool has_single[ECS_MAX_COMPONENTS + 1]; /* before: the first to ask for a singleton makes it */
    uint64_t structure;
    uint64_t *hashes; /* of all chunks, in order of walking */
    uint32_t count, capacity;
    bool failed;
    ecs_watched_query queries[ECS_WATCHED_QUERIES]; /* of the system that runs */
};

/* One chunk of what is compared. */
typedef struct chunk {
    kd_component_id id;
    const char *kind;
    const ecs_table *table; /* NULL: beside the tables */
    uint32_t row, count;
    uint64_t hash;
} chunk;

typedef bool chunk_fn(kd_schedule *s, const schedule_system *system, uint32_t index, const chunk *at);

/* ---- walking ---- */

static bool walk_column(kd_schedule *s, const schedule_system *system, const ecs_table *t, uint32_t column,
                        uint32_t *index, chunk_fn *visit)
{
    const ecs_column *c = &t->columns[column];
    for (uint32_t row = 0; row < t->count; row += ECS_CHUNK_ROWS) {
        uint32_t count = t->count - row < ECS_CHUNK_ROWS ? t->count - row : ECS_CHUNK_ROWS;
        chunk at = {c->id, "rows", t,
                    row,   count,  XXH3_64bits(c->data + (size_t)row * c->size, (size_t)count * c->size)};
        if (!visit(s, system, (*index)++, &at))
            return false;
    }
    return true;
}

static bool walk_tables(kd_schedule *s, const schedule_system *system, uint32_t *index, chunk_fn *visit)
{
    const kd_world *w = s->world;
    for (uint32_t i = 0; i < w->head.table_count; i++) {
        const ecs_table *t = w->head.tables[i];
        for (uint32_t column = 1; t->count && column < t->column_count; column++) {
            kd_component_id id = t->columns[column].id;
            if (id && !s->check->may_write[id] && !walk_column(s, system, t, column, index, visit))
                return false;
        }
    }
    return true;
}

static uint64_t hash_pairs(const ecs_relation *r, uint32_t size)
{
    XXH3_state_t state;
    XXH3_64bits_reset(&state);
    for (uint32_t index = 0; index < r->targets.page_limit * ECS_RUN_PAGE; index++) {
        ecs_run run = ecs_run_of(&r->targets, index);
        if (run.count)
            XXH3_64bits_update(&state, r->targets.values + (size_t)(run.base + run.skip) * size,
                               (size_t)run.count * size);
    }
    return XXH3_64bits_digest(&state);
}

static bool walk_beside(kd_schedule *s, const schedule_system *system, kd_component_id id, uint32_t *index,
                        chunk_fn *visit)
{
    const kd_world *w = s->world;
    uint32_t size = w->components[id].size;
    const ecs_side *side = ecs_side_of(w, id);
    const ecs_relation *r = ecs_relation_of(w, id);
    const void *single = s->check->has_single[id] ? kd_singleton_find(w, id) : NULL;
    chunk at = {.id = id};
    if (side && side->count) {
        at.kind = "sparse values";
        at.hash = XXH3_64bits(side->values, (size_t)side->count * size);
        if (!visit(s, system, (*index)++, &at))
            return false;
    }
    if (r && r->pair_count) {
        at.kind = "values of its pairs";
        at.hash = hash_pairs(r, size);
        if (!visit(s, system, (*index)++, &at))
            return false;
    }
    at.kind = "the singleton";
    at.hash = single ? XXH3_64bits(single, size) : 0;
    return !single || visit(s, system, (*index)++, &at);
}

static bool walk_rest(kd_schedule *s, const schedule_system *system, uint32_t *index, chunk_fn *visit)
{
    for (kd_component_id id = 1; id <= kd_component_count(s->world); id++)
        if (!s->check->may_write[id] && s->world->components[id].size &&
            !walk_beside(s, system, id, index, visit))
            return false;
    return true;
}

static void walk(kd_schedule *s, const schedule_system *system, chunk_fn *visit)
{
    uint32_t index = 0;
    if (walk_tables(s, system, &index, visit))
        walk_rest(s, system, &index, visit);
}

/* ---- before ---- */

static bool note(kd_schedule *s, const schedule_system *system, uint32_t index, const chunk *at)
{
    schedule_check *c = s->check;
    (void)system;
    if (index == c->capacity) {
        uint32_t larger = c->capacity ? c->capacity * 2 : 1024;
        uint64_t *hashes = realloc(c->hashes, larger * sizeof *hashes);
        c->failed = !hashes;
        if (c->failed)
            return false;
        c->hashes = hashes;
        c->capacity = larger;
    }
    c->hashes[index] = at->hash;
    c->count = index + 1;
    return true;
}

void schedule_check_begin(kd_schedule *s, const schedule_system *system)
{
    schedule_check *c = s->check;
    c->count = 0;
    c->failed = false;
    c->structure = s->world->structure;
    for (kd_component_id id = 1; id <= ECS_MAX_COMPONENTS; id++) {
        bool known = id <= kd_component_count(s->world);
        c->may_write[id] =
            known && ecs_watch_declared(&system->watch, s->world->components[id].desc) == ECS_DECLARED_WRITE;
        c->has_single[id] = known && kd_singleton_find(s->world, id);
    }
    walk(s, system, note);
}

/* ---- after ---- */

/* The components of a table: "position+velocity". */
static const char *table_text(const kd_world *w, const ecs_table *t, char *text, size_t size)
{
    size_t used = 0;
    text[0] = 0;
    for (uint32_t i = 0; i < t->archetype->id_count && used < size; i++)
        used += (size_t)snprintf(text + used, size - used, "%s%s", i ? "+" : "",
                                 w->components[t->archetype->ids[i]].desc->name);
    return text;
}

static kd_status complain(const kd_schedule *s, const schedule_system *system, const chunk *at)
{
    const kd_component_desc *desc = s->world->components[at->id].desc;
    bool read = ecs_watch_declared(&system->watch, desc) == ECS_DECLARED_READ;
    const char *query = ecs_watch_query_name(&system->watch, at->id);
    char table[160], where[320];
    if (at->table)
        snprintf(where, sizeof where, "rows %u to %u of the table %s, from entity %u on", (unsigned)at->row,
                 (unsigned)(at->row + at->count - 1), table_text(s->world, at->table, table, sizeof table),
                 (unsigned)ecs_entities(at->table)[at->row].index);
    else
        snprintf(where, sizeof where, "%s", at->kind);
    return kd_fail(KD_USAGE,
                   "system %s: wrote component %s, which it %s (%s; %s%s); list it with KD_CHANGES, or write "
                   "through no pointer to const",
                   system->desc.name, desc->name, read ? "declares as read" : "does not declare", where,
                   query ? "shown by query " : "no query of this frame showed it", query ? query : "");
}

static bool compare(kd_schedule *s, const schedule_system *system, uint32_t index, const chunk *at)
{
    schedule_check *c = s->check;
    if (index < c->count && c->hashes[index] == at->hash)
        return true;
    c->failed = true;
    complain(s, system, at);
    return false;
}

kd_status schedule_check_end(kd_schedule *s, schedule_system *system)
{
    schedule_check *c = s->check;
    if (c->failed)
        return kd_fail(KD_NO_MEMORY, "system %s: out of memory to check its access", system->desc.name);
    if (system->watch.status != KD_OK)
        return system->watch.status;
    if (c->structure != s->world->structure)
        return kd_fail(KD_USAGE,
                       "system %s: %s changed the world's structure; record it with context->commands, or "
                       "declare the system exclusive",
                       system->desc.name, s->world->last_change);
    walk(s, system, compare);
    return c->failed ? KD_USAGE : KD_OK;
}

/* ---- switching ---- */

kd_status kd_schedule_check(kd_schedule *s, bool checked)
{
    if (!checked) {
        schedule_check_destroy(s->check);
        s->check = NULL;
    } else if (!s->check) {
        schedule_check *c = calloc(1, sizeof *c);
        if (c)
            c->pool = kd_jobs_make(1);
        if (!c || !c->pool) {
            free(c);
            return kd_fail(KD_NO_MEMORY, "out of memory to check the access of systems");
        }
        s->check = c;
    }
    return KD_OK;
}

void schedule_check_destroy(schedule_check *c)
{
    if (!c)
        return;
    kd_jobs_destroy(c->pool);
    free(c->hashes);
    free(c);
}

void schedule_watch(const kd_schedule *s, schedule_system *system)
{
    ecs_watch *watch = &system->watch;
    watch->checked = s->check && !system->desc.exclusive;
    watch->active = watch->checked || s->measured;
    watch->status = KD_OK;
    watch->query_count = 0;
    watch->queries = s->check ? s->check->queries : NULL;
}

kd_jobs *schedule_pool(const kd_schedule *s)
{
    return s->check ? s->check->pool : s->jobs;
}
