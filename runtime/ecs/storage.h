#ifndef KD_ECS_STORAGE_H
#define KD_ECS_STORAGE_H

/* What a world holds: the types behind every file of this module. What is done with them, and the invariants
 * between them: internal.h. */

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

#endif
