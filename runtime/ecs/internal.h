#ifndef KD_ECS_INTERNAL_H
#define KD_ECS_INTERNAL_H

/* What the files of this module share: the functions here, the types in storage.h. One idea a file:
 *   memory.c       aligned blocks, counted against the world
 *   component.c    descriptions and their ids in one world
 *   archetype.c    sets of components, and where adding or removing one leads
 *   table.c        the entities of an archetype at one depth, struct of arrays
 *   rows.c         rows that come, go and move; versions of what changed
 *   entity.c       handles
 *   spawn.c        making entities
 *   value.c        the values of one entity
 *   destroy.c      one death, many deaths
 *   hierarchy.c    parents, ordered children, depth
 *   sparse.c       values and enable bits kept by entity, beside the tables
 *   pairs.c        the store of a relation: targets by source, sources by target
 *   relation.c     relating, and what happens to pairs when an entity dies
 *   query.c        cached lists of matching tables
 *   iterate.c      walking them; row_terms.c where rows are asked one by one
 *   parallel.c     a query's rows shared among workers
 *   commands*.c    changes recorded by workers; merged in a defined order
 *   observer.c     events wait until the outermost change is complete
 *   instance.c     copies of subtrees
 *   snapshot_*.c diff.c  a world as bytes and as JSON; what makes two worlds different
 *   statistics.c   where the memory is
 *   validate.c     the invariants below, checked
 *   schedule*.c    systems: their graph, how often they run, what they did
 *   watch.c        what the running system touches, held against what it declares
 *   names.c path.c singleton.c checksum.c reflect.c world.c
 *
 * Invariants
 *   - The record of a living entity says table, row and generation, and that row of the table's entity column
 * holds its handle; the record of a dead one has generation 0 (layout.h).
 *   - A table's rows are dense; removing a row moves the last one into its place.
 *   - Rows of every column are 64-byte aligned at row 0 and valid for [0, count).
 *   - Only the owner of the world changes structure; registration (components, singletons, queries) takes the
 * lock. */

#include "runtime/ecs/storage.h"

/* memory.c: blocks aligned to 64 bytes. */
/** Make `block` (NULL: none yet) `bytes` long, keeping its first keep_bytes. Returns NULL, block untouched,
 * when out. */
void *ecs_grow(kd_world *w, void *block, size_t keep_bytes, size_t bytes);
void ecs_free(kd_world *w, void *block);
/** Make room for `need` items in a growing array; new items are not set. */
bool ecs_reserve(kd_world *w, void *array_pointer, uint32_t *capacity, uint32_t count, uint32_t need,
                 size_t item_bytes);
/** Next capacity of an array that must hold need. */
uint32_t ecs_next_capacity(uint32_t capacity, uint32_t need);

/* component.c */
static inline const ecs_component *ecs_component_of(const kd_world *w, kd_component_id id)
{
    return &w->components[id];
}
/** Write a value, or the component's default when value is NULL. */
static inline void ecs_write_value(const kd_world *w, kd_component_id id, void *to, const void *value)
{
    const ecs_component *c = &w->components[id];
    const void *from = value ? value : c->desc->default_value;
    if (from == to)
        return;
    if (from)
        ecs_copy(to, from, c->size);
    else
        ecs_zero(to, c->size);
}
void ecs_release_value(const kd_world *w, kd_component_id id, void *value); /* runs on_remove */
/** Why kd_component_ensure gave no id for this description: BAD_FORMAT, TOO_LARGE, UNSUPPORTED or NO_MEMORY.
 */
kd_status ecs_component_refusal(const kd_world *w, const kd_component_desc *desc);

/* archetype.c */
/** The archetype of these components, ids ascending. NULL when out. */
ecs_archetype *ecs_archetype_ensure(kd_world *w, const kd_component_id *ids, uint32_t count);
ecs_archetype *ecs_archetype_toggle(kd_world *w, ecs_archetype *a, kd_component_id id); /* NULL when out */
void ecs_archetype_free(kd_world *w, ecs_archetype *a);
bool ecs_archetypes_init(kd_world *w); /* the empty set, and room for what tables note; false when out */

/* table.c */
ecs_table *ecs_table_ensure(kd_world *w, ecs_archetype *a, uint32_t depth); /* NULL when out */
ecs_table *ecs_neighbour_ensure(kd_world *w, const ecs_table *t, kd_component_id id);
/** The table that an entity of `t` lies in when `id` is added, or removed if it has it. NULL when out. */
static inline ecs_table *ecs_neighbour(kd_world *w, const ecs_table *t, kd_component_id id)
{
    const ecs_archetype *a = t->archetype;
    uint32_t edge = id < a->edge_limit ? a->edges[id] : ECS_NONE;
    if (edge == ECS_NONE)
        return ecs_neighbour_ensure(w, t, id);
    const ecs_archetype *b = w->archetypes[edge];
    return t->depth < b->depth_limit && b->tables[t->depth] ? b->tables[t->depth]
                                                            : ecs_neighbour_ensure(w, t, id);
}
bool ecs_table_reserve(kd_world *w, ecs_table *t, uint32_t rows);
void ecs_table_note_places(kd_world *w, const ecs_table *t); /* the columns have moved */
void ecs_tables_fini(kd_world *w);

/* Raise, never lower: two threads may stamp one word, and most of the time it holds the value already. */
static inline void ecs_raise_version(uint64_t *word, uint64_t version)
{
    uint64_t old = __atomic_load_n(word, __ATOMIC_RELAXED);
    while (old < version &&
           !__atomic_compare_exchange_n(word, &old, version, true, __ATOMIC_RELAXED, __ATOMIC_RELAXED)) {
    }
}

/* rows.c */
/** Give the entity a row at the end, which must have room; its values are not set. */
uint32_t ecs_table_append(kd_world *w, ecs_table *t, kd_entity e);
/** Take a row out, moving the last one into its place. Runs no hooks. */
void ecs_table_remove(kd_world *w, ecs_table *t, uint32_t row);
/** Move an entity's row to the end of `to`, which must have room; the last row fills the gap. The tables have
 * the same columns in the same order, but for `dropped` of t and `added` of `to`, which is left unset (0 or
 * ECS_TAG_COLUMN: none; a parent column that only `to` has is not counted). Returns the new row. */
uint32_t ecs_table_move_row(kd_world *w, ecs_table *t, uint32_t row, ecs_table *to, kd_entity e,
                            uint32_t dropped, uint32_t added);
/** Move n rows, beginning at `row`, to the end of `to`, which must have room; the last rows fill the gap: all
 * lies as if they were moved one by one, so it does not matter which rows are found to be moved together. */
void ecs_table_move_rows(kd_world *w, ecs_table *t, uint32_t row, uint32_t n, ecs_table *to);
void ecs_table_release_rows(kd_world *w, ecs_table *t, uint32_t row,
                            uint32_t count);                                   /* on_remove of every value */
void ecs_table_stamp(kd_world *w, ecs_table *t, uint32_t row, uint32_t count); /* rows came or moved */
void ecs_column_stamp(kd_world *w, ecs_table *t, uint32_t column, uint32_t row, uint32_t count);

/* commands.c */
/** Is `key` this one or one of those behind it that are the same system's? */
static inline bool ecs_key_follows(uint64_t key, uint64_t first)
{
    return key >= first && key >> 32 == first >> 32;
}
kd_entity ecs_commands_resolve(const kd_world *w, kd_entity e); /* KD_NO_ENTITY when unknown */
void ecs_commands_fini(kd_world *w);

/* entity.c */
bool ecs_handles_reserve(kd_world *w, uint32_t n);
kd_entity ecs_handle_take(kd_world *w); /* the index freed last comes first; room was reserved */
void ecs_handle_give(kd_world *w, kd_entity e);
/** Where does the entity lie, if it is alive? A pending handle becomes the lasting one. */
static inline bool ecs_settle(const kd_world *w, kd_entity *e, ecs_table **t, uint32_t *row)
{
    ecs_record r = e->index < w->head.entity_limit ? w->head.records[e->index] : 0;
    if (ecs_record_generation(r) != e->generation || !e->generation) {
        *e = e->generation & ECS_PENDING ? ecs_commands_resolve(w, *e) : KD_NO_ENTITY;
        r = e->index < w->head.entity_limit ? w->head.records[e->index] : 0;
        if (ecs_record_generation(r) != e->generation || !e->generation)
            return false;
    }
    *t = w->head.tables[ecs_record_table(r)];
    *row = ecs_record_row(r);
    return true;
}
static inline bool ecs_locate(const kd_world *w, kd_entity e, ecs_table **t, uint32_t *row)
{
    return ecs_settle(w, &e, t, row);
}
static inline ecs_table *ecs_table_of(const kd_world *w, uint32_t index)
{
    return w->head.tables[ecs_record_table(w->head.records[index])];
}
static inline uint32_t ecs_row_of(const kd_world *w, uint32_t index)
{
    return ecs_record_row(w->head.records[index]);
}
/* Note that the entity lies at this row now. */
static inline void ecs_place(kd_world *w, kd_entity e, const ecs_table *t, uint32_t row)
{
    w->head.records[e.index] = ecs_record_make(t->index, row, e.generation);
}
static inline kd_entity ecs_handle_at(const kd_world *w, uint32_t index)
{
    return (kd_entity){index, ecs_record_generation(w->head.records[index])};
}
static inline void ecs_structure_changed(kd_world *w, const char *call)
{
    w->structure++;
    w->last_change = call;
}

/* spawn.c */
/** Make an entity; pointers in `values` (NULL: default) may be changed by the call. */
kd_entity ecs_spawn_ids(kd_world *w, const kd_component_id *ids, const void **values, uint32_t count);
bool ecs_rows_grow(kd_world *w, ecs_table *t, uint32_t rows, const void **values, uint32_t count);
/** Make room for n more rows, and let values that lie in this table's own columns follow them to their new
 * place. */
static inline bool ecs_rows_reserve(kd_world *w, ecs_table *t, uint32_t n, const void **values,
                                    uint32_t count)
{
    if (n <= t->capacity - t->count)
        return true;
    return n <= UINT32_MAX - t->count && ecs_rows_grow(w, t, t->count + n, values, count);
}

/* value.c */
kd_status ecs_set_id(kd_world *w, kd_entity e, kd_component_id id, const void *value);
static inline void *ecs_value_at(const kd_world *w, const ecs_table *t, uint32_t column, uint32_t row)
{
    if (column == ECS_TAG_COLUMN)
        return (void *)(uintptr_t)w->tag_value;
    return t->columns[column].data + (size_t)row * t->columns[column].size;
}

/* sparse.c */
ecs_side *ecs_side_ensure(kd_world *w, kd_component_id id); /* NULL when out */
static inline bool ecs_is_sparse(const kd_world *w, kd_component_id id)
{
    return w->head.sparse_count && id <= ECS_MAX_COMPONENTS && w->components[id].sparse;
}
static inline ecs_side *ecs_side_of(const kd_world *w, kd_component_id id)
{
    uint32_t side = w->components[id].side;
    return side && side <= w->side_limit ? &w->sides[side - 1] : NULL;
}
/** Place of the entity's value, ECS_NONE when it has none. */
static inline uint32_t ecs_side_place(const ecs_side *s, uint32_t index)
{
    const uint32_t *page = s && index / ECS_PAGE < s->page_limit ? s->pages[index / ECS_PAGE] : NULL;
    return page ? page[index % ECS_PAGE] - 1 : ECS_NONE;
}
static inline bool ecs_side_disabled(const ecs_side *s, uint32_t index)
{
    return s && index / 64 < s->word_limit && s->disabled[index / 64] >> index % 64 & 1;
}
/** Value of a sparse component, NULL when the entity lacks it. */
void *ecs_side_find(const kd_world *w, kd_component_id id, uint32_t index);
/** Make room for n more values, and for entity `index` among them. */
bool ecs_side_reserve(kd_world *w, kd_component_id id, uint32_t index, uint32_t n);
/** Add a value (NULL: the default) for an entity that lacks it; room was reserved. `value` may not lie in the
 * side. */
void ecs_side_add(kd_world *w, kd_component_id id, kd_entity e, const void *value);
kd_status ecs_side_set(kd_world *w, kd_component_id id, kd_entity e, const void *value);
void ecs_side_remove(kd_world *w, kd_component_id id, uint32_t index); /* runs on_remove */
void ecs_side_stamp(kd_world *w, ecs_side *s);
bool ecs_side_disable(kd_world *w, kd_component_id id, uint32_t index, bool disabled); /* false when out */
void ecs_sides_drop(kd_world *w, uint32_t index); /* everything the entity has beside the tables */
void ecs_sides_fini(kd_world *w);

/* pairs.c: the store; events, hooks and cascades are relation.c's */
ecs_relation *ecs_relation_ensure(kd_world *w, kd_component_id id); /* NULL when out */
static inline ecs_relation *ecs_relation_of(const kd_world *w, kd_component_id id)
{
    uint32_t relation = w->components[id].relation;
    return relation && relation <= w->relation_limit ? &w->relations[relation - 1] : NULL;
}
static inline ecs_run ecs_run_of(const ecs_store *s, uint32_t index)
{
    const ecs_run *page = index / ECS_RUN_PAGE < s->page_limit ? s->pages[index / ECS_RUN_PAGE] : NULL;
    return page ? page[index % ECS_RUN_PAGE] : (ecs_run){0};
}
static inline void *ecs_pair_value(const kd_world *w, kd_component_id id, const ecs_relation *r,
                                   uint32_t item)
{
    uint32_t size = w->components[id].size;
    return size ? r->targets.values + (size_t)item * size : (void *)(uintptr_t)w->tag_value;
}
/** Place of the target in the source's run, ECS_NONE when they are not related. */
uint32_t ecs_pair_place(const ecs_relation *r, kd_entity source, kd_entity target);
/** Item of a pair in the pool, of the source's first one when there is no target. ECS_NONE when there is
 * none. */
uint32_t ecs_pair_item(const ecs_relation *r, kd_entity source, kd_entity target);
bool ecs_pair_reserve(kd_world *w, ecs_relation *r, uint32_t source, uint32_t target);
/** Add a pair that is not there yet, room was reserved; returns its item, whose value is not set. */
uint32_t ecs_pair_add(kd_world *w, ecs_relation *r, kd_entity source, kd_entity target);
/** Lead the pair to another target. False when out, nothing changed. */
bool ecs_pair_retarget(kd_world *w, ecs_relation *r, kd_entity source, uint32_t item, kd_entity target);
void ecs_pair_remove(kd_world *w, ecs_relation *r, uint32_t source, uint32_t place); /* runs no hook */
/** Make the run of an entity that has none, with `count` items that are not set. False when out. */
bool ecs_run_make(kd_world *w, ecs_store *s, uint32_t index, uint32_t count);
void ecs_relations_fini(kd_world *w);

/* relation.c */
bool ecs_doomed_reserve(kd_world *w, kd_component_id id, uint32_t pairs); /* for so many pairs more */
/** Refuse a component that needs a target; says so and returns false. */
bool ecs_needs_no_target(const kd_world *w, kd_component_id id);
kd_status ecs_relate_id(kd_world *w, kd_entity source, kd_component_id id, const void *value,
                        kd_entity target);
void ecs_relation_stamp(kd_world *w, ecs_relation *r);
void *ecs_relation_find(const kd_world *w, kd_component_id id, kd_entity source); /* first value, or NULL */
void ecs_relation_remove(kd_world *w, kd_component_id id, kd_entity source);      /* all its pairs */
/** Take away all pairs of an entity that dies; sources that go with it are put down as doomed. */
void ecs_relations_drop(kd_world *w, kd_entity e);
void ecs_relations_added(kd_world *w, kd_entity source); /* tells of all pairs that a copy came with */

/* hierarchy.c */
bool ecs_hierarchy_reserve(kd_world *w, uint32_t index);
void ecs_hierarchy_link(kd_world *w, uint32_t child, uint32_t parent); /* as last child; has no parent now */
void ecs_hierarchy_unlink(kd_world *w, uint32_t child, uint32_t parent);
/** The next entity of root's subtree in preorder, ECS_NONE at its end. */
uint32_t ecs_subtree_next(const kd_world *w, uint32_t root, uint32_t at);
static inline uint32_t ecs_first_child(const kd_world *w, uint32_t index)
{
    return index < w->node_limit ? w->nodes[index].first : ECS_NONE;
}

/* names.c */
void ecs_name_drop(kd_world *w, uint32_t index);
void ecs_names_fini(kd_world *w);

/* query.c */
static inline bool ecs_term_accessed(uint8_t kind)
{
    return kind == KD_TERM_READ || kind == KD_TERM_WRITE || kind == KD_TERM_OPTIONAL ||
           kind == KD_TERM_OPTIONAL_WRITE || kind == KD_TERM_ANY;
}
bool ecs_query_matches(const kd_query *q, const ecs_table *t);
bool ecs_queries_add_table(kd_world *w, ecs_table *t); /* false when out, nothing added */
void ecs_queries_fini(kd_world *w);

/* iterate.c, row_terms.c */
kd_iter ecs_query_iter(kd_query *q); /* without telling who watches */
void ecs_iter_show(kd_iter *it, const ecs_match *m, uint32_t begin, uint32_t end);
/** Show the first run of matching rows in [begin, end) that agree in their row terms. */
bool ecs_iter_row_run(kd_iter *it, const ecs_match *m, uint32_t begin, uint32_t end);
/** Some required sparse component has no value at all: nothing can match. */
bool ecs_query_lacks_values(const kd_query *q);
/** Narrow a fresh iterator to the rows [begin, end) of one matched table; ecs_iter_next_limited shows them.
 */
void ecs_iter_limit(kd_iter *it, uint32_t match, uint32_t begin, uint32_t end);
bool ecs_iter_next_limited(kd_iter *it);
/** Show the longest run of rows from `begin` on that match and agree in their row terms; returns its end,
 * which is `begin` when that row does not match. */
uint32_t ecs_iter_show_run(kd_iter *it, const ecs_match *m, uint32_t begin, uint32_t end);
/** Did an accessed column of this chunk change after it->changed_since? */
bool ecs_iter_chunk_changed(const kd_iter *it, const ecs_match *m, uint32_t chunk);

/* query_pairs.c: queries that are led by the sources of a target */
/** Target that term i asks for, generation 0: any. */
kd_entity ecs_term_target(const kd_iter *it, uint32_t i);
bool ecs_iter_is_led(const kd_iter *it);
bool ecs_iter_next_led(kd_iter *it);

/* observer.c */
/** Queue an event; `value` (may be NULL) is copied. */
void ecs_event_queue_add(kd_world *w, kd_event event, kd_entity e, kd_component_id id, const void *value);
void ecs_pair_event_queue_add(kd_world *w, kd_event event, kd_entity source, kd_component_id id,
                              kd_entity target, const void *value);
static inline void ecs_pair_event(kd_world *w, kd_event event, kd_entity source, kd_component_id id,
                                  kd_entity target, const void *value)
{
    if (w->any_observed && w->observed[id] & event)
        ecs_pair_event_queue_add(w, event, source, id, target, value);
}
static inline void ecs_event(kd_world *w, kd_event event, kd_entity e, kd_component_id id, const void *value)
{
    if (w->observed[id] & event)
        ecs_event_queue_add(w, event, e, id, value);
}
/** Queue these events (bits) for all components of a row, sparse ones included. */
void ecs_event_row(kd_world *w, uint32_t events, const ecs_table *t, uint32_t row);
void ecs_archetype_observe(const kd_world *w, ecs_archetype *a);
void ecs_events_tell(kd_world *w);
/** Called at the end of every public change: the outermost tells what waits. */
static inline void ecs_events_settle(kd_world *w)
{
    if (w->any_observed)
        ecs_events_tell(w);
}
void ecs_observers_fini(kd_world *w);

/* singleton.c */
void ecs_singletons_fini(kd_world *w);

#endif
