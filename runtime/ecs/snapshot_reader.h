#ifndef KD_ECS_SNAPSHOT_READER_H
#define KD_ECS_SNAPSHOT_READER_H

/* What the files that restore a snapshot share. One idea a file:
 *   snapshot_restore.c   the order of things: header, components, all parts, and then one storage for another
 *   snapshot_storage.c   a world's storage put aside, put back, or given up
 *   snapshot_tables.c    tables, handles that are free, children
 *   snapshot_beside.c    names, singletons, sparse values, enable bits, relations */

#include "runtime/ecs/internal.h"
#include "runtime/ecs/snapshot_format.h"

/* ---- storage ---- */
#define STORAGE_BEGIN offsetof(kd_world, record_capacity)
#define STORAGE_END   offsetof(kd_world, queries)

typedef struct snapshot_storage {
    ecs_record *records;
    uint32_t entity_limit, table_count;
    ecs_table **tables;
    ecs_places *places;
    uint8_t rest[STORAGE_END - STORAGE_BEGIN];
} snapshot_storage;

/** Exchange the world's storage with `other`; the queries' lists of matches go with it. */
void snapshot_swap_storage(kd_world *w, snapshot_storage *other);
/** Release the storage that the world has now, hooks and all, and leave it with `next`. */
void snapshot_drop_storage(kd_world *w, snapshot_storage *next);

/* ---- reading ---- */
typedef struct snapshot_reader {
    kd_world *w;
    const char *name; /* of the file, for messages */
    const uint8_t *data;
    size_t at, size;
    snapshot_header header;
    kd_component_id ids[ECS_MAX_COMPONENTS]; /* by place in the component table */
    const uint8_t *singletons;
    snapshot_storage aside; /* what the world held before */
    ecs_table **lenders;    /* [table_count] the old table whose columns a new one will take; NULL: none */
} snapshot_reader;

kd_status snapshot_damaged(const snapshot_reader *in, const char *what);
kd_status snapshot_no_memory(const snapshot_reader *in);
/** Take the next `size` bytes and their filling, NULL when there are fewer. */
const void *snapshot_take(snapshot_reader *in, uint64_t size);
bool snapshot_take_record(snapshot_reader *in, void *record, size_t size);
/** Check what a program may use as an index or a text without asking: bools, words of enumerations, strings.
 */
bool snapshot_values_are_sane(const kd_component_desc *desc, const uint8_t *values, uint32_t count);

/* Lists lie at addresses of any alignment. */
static inline uint32_t snapshot_u32(const void *list, uint32_t i)
{
    uint32_t value;
    memcpy(&value, (const uint8_t *)list + (size_t)i * sizeof value, sizeof value);
    return value;
}
static inline kd_entity snapshot_entity(const void *list, uint32_t i)
{
    kd_entity e;
    memcpy(&e, (const uint8_t *)list + (size_t)i * sizeof e, sizeof e);
    return e;
}

/* ---- parts ---- */
kd_status snapshot_read_table(snapshot_reader *in);
/** Let the new tables have the columns of the old ones that they are to take, and fill them: cannot fail. */
void snapshot_take_columns(snapshot_reader *in);
/** Give up tables that take columns, before the storage is dropped. */
void snapshot_leave_columns(snapshot_reader *in);
kd_status snapshot_read_free(snapshot_reader *in);
kd_status snapshot_read_children(snapshot_reader *in);

kd_status snapshot_read_name(snapshot_reader *in);
kd_status snapshot_check_singletons(snapshot_reader *in);
/** Go over the checked singletons: make room for each, or write them when nothing can fail any more. */
kd_status snapshot_walk_singletons(const snapshot_reader *in, bool write);
/** Give those that a snapshot may hold their default value; one that it does not hold was never asked for
 * then. */
void snapshot_reset_singletons(kd_world *w);
/** `last`: component of the side (relation) before, ECS_NONE at first. */
kd_status snapshot_read_side(snapshot_reader *in, uint32_t *last);
kd_status snapshot_read_relation(snapshot_reader *in, uint32_t *last);

#endif
