/* Counting what a world holds, on demand: nothing is kept up to date for it. */

#include "runtime/ecs/statistics.h"
#include "runtime/ecs/internal.h"

static size_t side_bytes(const ecs_side *s, uint32_t size)
{
    size_t bytes = s->entity_capacity * sizeof *s->entities + (size_t)s->value_capacity * size +
                   s->page_limit * sizeof *s->pages + s->word_limit * sizeof *s->disabled;
    for (uint32_t page = 0; page < s->page_limit; page++)
        bytes += s->pages[page] ? ECS_PAGE * sizeof *s->pages[page] : 0;
    return bytes;
}

static size_t store_bytes(const ecs_store *s)
{
    size_t item = sizeof *s->entities + (s->has_places ? sizeof *s->places : 0) + s->value_size;
    size_t bytes = s->capacity * item + s->page_limit * sizeof *s->pages;
    for (uint32_t page = 0; page < s->page_limit; page++)
        bytes += s->pages[page] ? ECS_RUN_PAGE * sizeof *s->pages[page] : 0;
    return bytes;
}

static void count_relation(const ecs_relation *r, kd_component_statistics *out)
{
    out->pairs = r->pair_count;
    for (uint32_t index = 0; index < r->targets.page_limit * ECS_RUN_PAGE; index++)
        out->entities += ecs_run_of(&r->targets, index).count != 0;
    out->used_bytes = (size_t)r->pair_count * r->targets.value_size;
    out->held_bytes = store_bytes(&r->targets) + store_bytes(&r->sources);
}

kd_status kd_component_count_memory(const kd_world *w, kd_component_id id, kd_component_statistics *out)
{
    *out = (kd_component_statistics){.desc = kd_component_info(w, id)};
    if (!out->desc)
        return KD_OUT_OF_RANGE;
    if (ecs_relation_of(w, id)) {
        count_relation(ecs_relation_of(w, id), out);
        return KD_OK;
    }
    size_t size = out->desc->size;
    for (uint32_t i = 0; i < w->head.table_count; i++) {
        const ecs_table *t = w->head.tables[i];
        if (!ecs_column_of(t, id))
            continue;
        out->entities += t->count;
        out->held_bytes += t->capacity * size;
    }
    const ecs_side *s = ecs_side_of(w, id);
    if (s) {
        out->entities += s->count;
        out->held_bytes += side_bytes(s, (uint32_t)size);
    }
    out->used_bytes = out->entities * size;
    return KD_OK;
}

/* ---- archetypes ---- */
uint32_t kd_archetype_count(const kd_world *w)
{
    return w->archetype_count;
}

static void count_table(const ecs_table *t, kd_archetype_statistics *out)
{
    size_t row = 0;
    for (uint32_t c = 0; c < t->column_count; c++)
        row += t->columns[c].size;
    out->tables++;
    out->entities += t->count;
    out->used_bytes += t->count * row;
    out->held_bytes += t->capacity * row + sizeof *t + (t->column_count + 2u) * sizeof *t->columns;
    if (t->versions)
        out->held_bytes += (t->chunk_capacity + 1u) * t->column_count * sizeof *t->versions;
}

kd_status kd_archetype_count_memory(const kd_world *w, uint32_t index, kd_archetype_statistics *out)
{
    *out = (kd_archetype_statistics){0};
    if (index >= w->archetype_count)
        return KD_OUT_OF_RANGE;
    const ecs_archetype *a = w->archetypes[index];
    out->components = a->id_count;
    out->held_bytes = sizeof *a + a->id_count * sizeof *a->ids + a->column_limit * sizeof *a->column_of +
                      a->edge_limit * sizeof *a->edges + a->depth_limit * sizeof *a->tables;
    for (uint32_t depth = 0; depth < a->depth_limit; depth++)
        if (a->tables[depth])
            count_table(a->tables[depth], out);
    return KD_OK;
}

/* ---- queries ---- */
uint32_t kd_world_query_count(const kd_world *w)
{
    uint32_t count = 0;
    for (const kd_query *q = w->queries; q; q = q->next)
        count++;
    return count;
}

kd_status kd_query_count_memory(const kd_world *w, uint32_t index, kd_query_statistics *out)
{
    const kd_query *q = w->queries;
    *out = (kd_query_statistics){.name = ""};
    for (; q && index; index--)
        q = q->next;
    if (!q)
        return KD_OUT_OF_RANGE;
    *out = (kd_query_statistics){q->name ? q->name : "", q->references, q->match_count,
                                 sizeof *q + q->match_capacity * sizeof *q->matches};
    return KD_OK;
}

/* ---- all of it ---- */
static void write_count(kd_json *j, const char *key, uint64_t value)
{
    kd_json_key(j, key);
    kd_json_uint(j, value);
}

static void write_components(const kd_world *w, kd_json *j)
{
    kd_json_key(j, "components");
    kd_json_array_begin(j);
    for (kd_component_id id = 1; id <= kd_component_count(w); id++) {
        kd_component_statistics s;
        kd_component_count_memory(w, id, &s);
        kd_json_object_begin(j);
        kd_json_key(j, "name");
        kd_json_string(j, s.desc->name);
        write_count(j, "entities", s.entities);
        if (s.desc->flags & KD_COMPONENT_RELATION)
            write_count(j, "pairs", s.pairs);
        write_count(j, "used_bytes", s.used_bytes);
        write_count(j, "held_bytes", s.held_bytes);
        kd_json_object_end(j);
    }
    kd_json_array_end(j);
}

static void write_archetypes(const kd_world *w, kd_json *j)
{
    kd_json_key(j, "archetypes");
    kd_json_array_begin(j);
    for (uint32_t i = 0; i < w->archetype_count; i++) {
        const ecs_archetype *a = w->archetypes[i];
        kd_archetype_statistics s;
        kd_archetype_count_memory(w, i, &s);
        kd_json_object_begin(j);
        kd_json_key(j, "components");
        kd_json_array_begin(j);
        for (uint32_t c = 0; c < a->id_count; c++)
            kd_json_string(j, w->components[a->ids[c]].desc->name);
        kd_json_array_end(j);
        write_count(j, "tables", s.tables);
        write_count(j, "entities", s.entities);
        write_count(j, "used_bytes", s.used_bytes);
        write_count(j, "held_bytes", s.held_bytes);
        kd_json_object_end(j);
    }
    kd_json_array_end(j);
}

static void write_queries(const kd_world *w, kd_json *j)
{
    kd_query_statistics s;
    kd_json_key(j, "queries");
    kd_json_array_begin(j);
    for (uint32_t i = 0; kd_query_count_memory(w, i, &s) == KD_OK; i++) {
        kd_json_object_begin(j);
        kd_json_key(j, "name");
        kd_json_string(j, s.name);
        write_count(j, "references", s.references);
        write_count(j, "tables", s.tables);
        write_count(j, "held_bytes", s.held_bytes);
        kd_json_object_end(j);
    }
    kd_json_array_end(j);
}

void kd_world_write_statistics(const kd_world *w, kd_json *j)
{
    kd_json_object_begin(j);
    write_count(j, "entities", kd_entity_count(w));
    write_count(j, "bytes", kd_world_bytes(w));
    write_components(w, j);
    write_archetypes(w, j);
    write_queries(w, j);
    kd_json_object_end(j);
}
