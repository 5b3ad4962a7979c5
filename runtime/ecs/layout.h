#ifndef KD_ECS_LAYOUT_H
#define KD_ECS_LAYOUT_H

/* The part of a world's layout that lookups inlined in world.h read: entity records and tables. No interface:
 * it changes without notice. Shared words are read through the compiler's atomic built-ins, so that C++ can
 * include this too. */

#include <stdint.h>

#include "runtime/ecs/component.h"

#define ECS_MAX_COMPONENTS 512u
#define ECS_TAG_COLUMN     0xffffu
#define ECS_DESC_SLOTS     2048u /* of the address hash; a power of two, kept at most half full */

/* Where an entity lies, in one word, so that a lookup reads one cache line to know that a handle is alive and
 * where. Living: row, index of the table, generation of the handle. Dead: next free index, next generation
 * with ECS_NO_TABLE, which no table's index reaches, and 0. An index whose generations are used up is never
 * given again, so that an old handle cannot come alive. */
#define ECS_ROW_BITS       27u
#define ECS_TABLE_BITS     20u
#define ECS_ROW_MASK       ((1u << ECS_ROW_BITS) - 1)
#define ECS_TABLE_MASK     ((1u << ECS_TABLE_BITS) - 1)
#define ECS_MAX_GENERATION ((1u << (64 - ECS_ROW_BITS - ECS_TABLE_BITS)) - 1)
#define ECS_MAX_TABLES     (1u << (ECS_TABLE_BITS - 1))
#define ECS_NO_TABLE       ECS_MAX_TABLES
#define ECS_DEAD           ((ecs_record)ECS_NO_TABLE << ECS_ROW_BITS) /* resting for ever, or never given */
typedef uint64_t ecs_record;

static inline ecs_record ecs_record_make(uint32_t table, uint32_t row, uint32_t generation)
{
    return (uint64_t)generation << (ECS_ROW_BITS + ECS_TABLE_BITS) | (uint64_t)table << ECS_ROW_BITS | row;
}
static inline uint32_t ecs_record_row(ecs_record r)
{
    return (uint32_t)r & ECS_ROW_MASK;
}
static inline uint32_t ecs_record_table(ecs_record r)
{
    return (uint32_t)(r >> ECS_ROW_BITS) & ECS_TABLE_MASK;
}
static inline uint32_t ecs_record_generation(ecs_record r)
{
    return (uint32_t)(r >> (ECS_ROW_BITS + ECS_TABLE_BITS));
}

/* The record of a dead index that waits to be given again. */
static inline ecs_record ecs_record_make_free(uint32_t next_free, uint32_t next_generation)
{
    return ecs_record_make(ECS_NO_TABLE | next_generation, next_free, 0);
}
static inline uint32_t ecs_record_next_generation(ecs_record r)
{
    return ecs_record_table(r) & ~ECS_NO_TABLE;
}

typedef struct ecs_column {
    uint8_t *data;
    uint32_t size;
    uint32_t id; /* 0 for entities and parents */
} ecs_column;

/* The first cache line says what is there, the second where the entities and the first three components lie.
 */
typedef struct ecs_table {
    uint32_t count, capacity;
    const uint16_t
        *column_of; /* by component id, the archetype's: 0 absent, ECS_TAG_COLUMN present without data */
    uint32_t column_limit;
    uint32_t index;
    uint64_t *versions; /* [column_count][1 + chunk_capacity]: newest of the column, then of each chunk */
    uint32_t chunk_capacity;
    uint16_t column_count; /* all, with entities and parents */
    uint16_t depth;
    uint16_t parents;  /* the parents' column, or the one behind the last without data */
    uint32_t incoming; /* rows about to arrive while a subtree is moved */
    struct ecs_archetype *archetype;
    /* 0: entities; then components by id; then, when depth > 0, parents. Behind these column_count, so that a
     * query need not ask, one without data, and one whose data is the value of a tag. */
    ecs_column columns[];
} ecs_table;

/* Where the values of a component lie: a look-up goes from the record straight to the column. */
typedef struct ecs_places {
    uint8_t **columns; /* by table index, NULL where there is none */
    uint32_t limit;    /* tables in `columns` */
    uint32_t size;     /* of a value */
} ecs_places;

/* First member of every kd_world. */
typedef struct ecs_world_head {
    ecs_record *records;
    uint32_t entity_limit; /* indices ever given */
    uint32_t table_count;
    uint32_t sparse_count; /* components that are kept beside the tables */
    ecs_table **tables;
    ecs_places *places;                                 /* [ECS_MAX_COMPONENTS + 1], by component id */
    const kd_component_desc *desc_keys[ECS_DESC_SLOTS]; /* written once each, read without a lock */
    uint16_t desc_ids[ECS_DESC_SLOTS];
} ecs_world_head;

static inline uint32_t ecs_desc_slot(const kd_component_desc *desc)
{
    return (uint32_t)(((uint64_t)(uintptr_t)desc >> 3) * 0x9e3779b97f4a7c15u >> 53) & (ECS_DESC_SLOTS - 1);
}

#endif
