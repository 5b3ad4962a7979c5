#ifndef KD_ECS_INTERNAL_H
#define KD_ECS_INTERNAL_H

/* What the files of this module share. One idea a file:
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

#include <pthread.h>
#include <stdatomic.h>
#include <string.h>

#include "runtime/core/log.h"
#include "runtime/ecs/layout.h"
#include "runtime/ecs/observer.h"
#include "runtime/ecs/query.h"
#include "runtime/ecs/world.h"

#define ECS_CHUNK_ROWS 256u /* rows that share one change version: a few KiB of a column */
_Static_assert(sizeof(ecs_table) <= 64, "what is asked of every table lies in one cache line");
#define ECS_MAX_DEPTH 65535u
#define ECS_PENDING   0x80000000u /* in kd_entity.generation: made by a command buffer, see commands.c */
#define ECS_NONE      0xffffffffu

/* ---- components ---- */
typedef struct ecs_span {
    uint32_t offset, size;
} ecs_span;

typedef struct ecs_component {
    const kd_component_desc *desc;
    uint32_t size;
    uint32_t span_count; /* bytes that count for the checksum: the fields, merged where they touch */
    ecs_span *spans;
    bool has_entities; /* some field is a KD_ENTITY */
    bool sparse;
    uint32_t side;     /* place + 1 in the world's sides; 0: neither sparse nor with enable bits */
    uint32_t relation; /* place + 1 in the world's relations, sparse too; 0: no relation */
    _Atomic(void *) singleton;
} ecs_component;

/* ---- tables ---- */
typedef struct ecs_archetype {
    kd_component_id *ids; /* ascending */
    uint32_t id_count;
    uint32_t column_count; /* ids that have a size */
    uint16_t
        *column_of; /* by component id: column of a table, 0 absent, ECS_TAG_COLUMN present without data */
    uint32_t column_limit;
    uint32_t *edges; /* by component id: archetype with that component added, or removed if here; ECS_NONE
                        unknown */
    uint32_t edge_limit;
    ecs_table **tables; /* by depth, NULL where none */
    uint32_t depth_limit;
    uint32_t index;
    uint64_t hash;
    bool hooked;   /* some component has on_remove */
    bool observed; /* somebody observes some component */
} ecs_archetype;

static inline kd_entity *ecs_entities(const ecs_table *t)
{
    return (kd_entity *)(void *)t->columns[0].data;
}
static inline kd_entity *ecs_parents(const ecs_table *t)
{
    return t->depth ? (kd_entity *)(void *)t->columns[t->column_count - 1].data : NULL;
}
/* The column's newest version, followed by those of its chunks. */
static inline uint64_t *ecs_versions(const ecs_table *t, uint32_t column)
{
    return t->versions + (size_t)column * (t->chunk_capacity + 1u);
}
/* Copy a value: the common sizes without a call. */
static inline void ecs_copy(void *to, const void *from, uint32_t size)
{
    switch (size) {
    case 4: memcpy(to, from, 4); break;
    case 8: memcpy(to, from, 8); break;
    case 12: memcpy(to, from, 12); break;
    case 16: memcpy(to, from, 16); break;
    case 64: memcpy(to, from, 64); break;
    default: memcpy(to, from, size);
    }
}
static inline void ecs_zero(void *to, uint32_t size)
{
    if (size == 4)
        memset(to, 0, 4);
    else if (size == 8)
        memset(to, 0, 8);
    else
        memset(to, 0, size);
}
static inline uint32_t ecs_column_of(const ecs_table *t, kd_component_id id)
{
    return id < t->column_limit ? t->column_of[id] : 0;
}

/* ---- beside the tables ---- */
/* What a component keeps by entity: the values of a sparse one, and which are disabled. */
typedef struct ecs_side {
    uint32_t *
        *pages; /* by index / ECS_PAGE, NULL where none: place + 1 of the entity's value, 0: it has none */
    uint32_t page_limit;
    uint32_t count, entity_capacity, value_capacity;
    kd_entity *entities; /* by place: in order of adding, the last fills a gap */
    uint8_t *values;
    uint64_t *disabled; /* a bit by entity index */
    uint32_t word_limit, disabled_count;
    uint64_t version; /* of the newest change to any value */
} ecs_side;
#define ECS_PAGE 1024u

/* ---- relations ---- */
/* One entity's items in a pool: [base + skip, base + skip + count) of a block of 1 << (room - 1). */
typedef struct ecs_run {
    uint32_t base, skip;
    uint32_t count : 27, room : 5; /* room 0: no block */
} ecs_run;
#define ECS_RUN_PAGE  256u
#define ECS_MAX_ITEMS 0x7fffffffu

typedef struct ecs_store {
    ecs_run **pages; /* by index / ECS_RUN_PAGE, NULL where none */
    uint32_t page_limit;
    uint32_t used, capacity; /* items of the pool */
    uint32_t value_size;     /* 0: no values */
    bool has_places;
    uint32_t free[32];   /* by size: first item of a free block + 1; the next in its first handle's index */
    kd_entity *entities; /* [capacity] the other end of each pair */
    uint32_t *places;    /* [capacity] targets: at which place of the target's run the source stands */
    uint8_t *values;     /* [capacity] targets */
} ecs_store;

typedef struct ecs_relation {
    ecs_store targets, sources; /* by source, by target */
    uint32_t pair_count;
    uint64_t version; /* of the newest change */
} ecs_relation;

/* ---- entities ---- */
typedef struct ecs_node {
    uint32_t first, last, next, previous; /* entity indices, ECS_NONE where none */
} ecs_node;

/* Where a spawn with these components leads: looked up once for every combination that is in use. */
#define ECS_PATHS       64u
#define ECS_PATH_VALUES 8u
typedef struct ecs_path {
    ecs_table *table; /* NULL: empty */
    uint32_t count, depth;
    bool sparse;  /* some value goes beside the table: its column is 0 */
    bool repeats; /* an owning component is given twice */
    const kd_component_desc *descs[ECS_PATH_VALUES];
    kd_component_id ids[ECS_PATH_VALUES];
    uint16_t columns[ECS_PATH_VALUES];
} ecs_path;

/* ---- names ---- */
typedef struct ecs_name_group {
    char *text;
    uint64_t hash;
    uint32_t first, last; /* entity indices in the order of naming */
} ecs_name_group;
typedef struct ecs_name_link {
    uint32_t group; /* index + 1; 0: no name */
    uint32_t next, previous;
} ecs_name_link;

/* ---- queries ---- */
typedef struct ecs_match {
    ecs_table *table;
    uint64_t marks; /* a version, and a bit for each term whose column bears it in every row */
    uint16_t
        columns[KD_MAX_TERMS]; /* by term; where a table has none to show, one of the two behind the last */
} ecs_match;

struct kd_query {
    kd_world *world;
    kd_query *next;
    char *name;
    uint32_t references;
    uint32_t term_count;
    uint8_t kinds[KD_MAX_TERMS];
    kd_component_id ids[KD_MAX_TERMS];
    kd_entity targets[KD_MAX_TERMS]; /* of terms of relations; generation 0: any */
    uint32_t relation_terms;         /* bits */
    bool by_depth;
    bool has_any;
    uint32_t
        row_terms; /* bits of the terms that are asked row by row: sparse, of relations, with enable bits */
    uint32_t sparse_terms; /* of these, the sparse ones that are accessed */
    ecs_match *matches;
    uint32_t match_count, match_capacity;
    ecs_match *kept_matches; /* while a snapshot is restored: the list of the storage that is put aside */
    uint32_t kept_count, kept_capacity;
};

/* ---- commands ---- */
typedef struct ecs_command_head {
    uint64_t key;
    uint32_t offset; /* into the bytes, in units of 8; ascends in order of recording */
    uint32_t worker;
} ecs_command_head;

struct kd_commands {
    _Alignas(64) kd_world *world; /* workers record side by side: no shared cache line */
    uint32_t worker;
    kd_status failed; /* why a command could not be recorded */
    uint64_t key;
    ecs_command_head *heads;
    uint32_t head_count, head_capacity;
    uint8_t *bytes;
    uint32_t byte_count, byte_capacity; /* in units of 8 */
    uint32_t spawn_count;               /* recorded since the last merge */
    uint32_t spawned_count, spawned_capacity;
    kd_entity *spawned; /* by the last merge that spawned (or the one under way) */
};

/* ---- observers ---- */
typedef struct ecs_observer {
    kd_component_id id;
    uint32_t events;
    kd_observer_fn *fn; /* NULL: taken back */
    void *user;
} ecs_observer;
typedef struct ecs_queued {
    uint32_t event;
    kd_component_id id;
    kd_entity entity;
    uint32_t value; /* in units of 16 bytes, ECS_NONE: none; of a relation, the target and then the value */
} ecs_queued;
typedef struct ecs_event_queue {
    ecs_queued *events;
    uint8_t *units;
    uint32_t count, capacity, unit_count, unit_capacity;
} ecs_event_queue;

/* ---- the world ---- */
struct kd_world {
    ecs_world_head head;
    /* The storage: what restoring a snapshot replaces as a whole (snapshot_restore.c), up to `queries`. */
    uint32_t record_capacity;
    uint32_t free_first; /* means nothing when free_count is 0 */
    uint32_t free_count;
    uint32_t alive_count;
    uint32_t table_capacity;
    ecs_archetype **archetypes;
    uint32_t archetype_count, archetype_capacity;
    uint32_t *archetype_slots; /* open addressing by hash of ids: index + 1 */
    uint32_t archetype_slot_count;

    ecs_node *nodes; /* by entity index, as far as the hierarchy was used */
    uint32_t node_limit, node_capacity;

    ecs_name_link *name_links; /* by entity index, as far as names were used */
    uint32_t name_limit, name_capacity;
    ecs_name_group *name_groups;
    uint32_t name_group_count, name_group_capacity, name_group_free;
    uint32_t *name_slots; /* open addressing by hash of text: group + 1 */
    uint32_t name_slot_count, name_slot_used;

    ecs_side *sides; /* by ecs_component.side - 1, as far as they were used */
    uint32_t side_limit, side_capacity;

    ecs_relation *relations; /* by ecs_component.relation - 1, as far as they were used */
    uint32_t relation_limit, relation_capacity;
    uint32_t pair_count, cascade_count; /* pairs of all relations, and of those that cascade */
    kd_entity *doomed; /* sources that die after their target; room for every cascading pair */
    uint32_t doomed_count, doomed_capacity;

    kd_query *queries; /* the storage ends here */

    _Atomic uint64_t version; /* stamped on write access; raised by kd_world_version */
    uint64_t structure;       /* raised by every structural change: iterators notice */
    const char *last_change;  /* which call that was */

    pthread_mutex_t lock; /* registration of components, singletons, queries */
    _Atomic uint32_t component_count;
    uint32_t desc_slots_used;
    uint32_t side_count; /* components that have a side */
    kd_component_id side_ids[ECS_MAX_COMPONENTS];
    uint32_t relation_count;
    kd_component_id relation_ids[ECS_MAX_COMPONENTS];
    ecs_component components[ECS_MAX_COMPONENTS + 1];

    _Atomic size_t bytes;
    size_t limit_bytes;
    atomic_bool refused;       /* memory ran out, that was said, and none was given back since */
    ecs_path paths[ECS_PATHS]; /* by a hash of the descriptions */
    ecs_observer *observers;   /* in order of registration */
    uint32_t observer_count, observer_capacity;
    bool any_observed;                        /* false: nobody ever asked, and nothing is looked at */
    uint8_t observed[ECS_MAX_COMPONENTS + 1]; /* kd_event bits by component id */
    ecs_event_queue events[2];                /* event_turn says which one receives */
    uint32_t event_turn, event_hold;          /* held while a merge or an observer runs */
    uint32_t merge_number;
    bool merging;
    uint64_t tag_value[8]; /* what a found tag points to */
    kd_commands commands[KD_MAX_WORKERS];
};

_Static_assert(offsetof(kd_world, head) == 0, "inlined lookups read a world as its head");

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
