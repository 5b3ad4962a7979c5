#ifndef KD_ECS_SNAPSHOT_FORMAT_H
#define KD_ECS_SNAPSHOT_FORMAT_H

/* The bytes of a snapshot, shared by writer and reader. Every record begins at a multiple of 8; what is
 * shorter is filled up with zeros. In order:
 *
 *   snapshot_header
 *   component_count × snapshot_component, name      ascending by name
 *   table_count × snapshot_table, u32 components[], kd_entity entities[], parents[] when depth > 0, columns[]
 *   free_count × kd_entity     index and next generation, the one given next first
 *   resting × kd_entity        indices never given again, generation 0: entity_limit - alive_count -
 * free_count child_count × u32          all children; those of one parent in their order name_count ×
 * snapshot_name, text, u32 indices[] singleton_count × snapshot_singleton, value side_count × snapshot_side,
 * kd_entity entities[], values[], u32 disabled[]      by component relation_count × snapshot_relation,
 * kd_entity sources[], u32 counts[], kd_entity targets[], u32 places[], values[]     by component; sources
 * ascend, counts says how many of the targets are each one's */

#include <stdint.h>

#include "runtime/core/status.h"
#include "runtime/ecs/component.h"

#define SNAPSHOT_MAGIC      "KDWORLD\n"
#define SNAPSHOT_VERSION    2u
#define SNAPSHOT_BYTE_ORDER 0x01020304u
#define SNAPSHOT_HASHED     32u /* the checksum covers everything from this offset on */

typedef struct snapshot_header {
    char magic[8];
    uint32_t version, byte_order;
    uint64_t size, checksum;
    /* ---- 32 */
    uint32_t component_count, table_count, entity_limit, alive_count;
    uint32_t free_count, child_count, name_count, singleton_count;
    uint32_t side_count, relation_count;
} snapshot_header;
_Static_assert(sizeof(snapshot_header) == 72, "the header is written as it lies");

typedef struct snapshot_component {
    uint32_t size, name_size; /* bytes; the name's without a zero */
    uint64_t fields;          /* snapshot_field_hash */
} snapshot_component;

typedef struct snapshot_table {
    uint32_t depth, row_count, component_count, unused;
} snapshot_table;

typedef struct snapshot_name {
    uint32_t text_size, entity_count;
} snapshot_name;

typedef struct snapshot_singleton {
    uint32_t component, size;
} snapshot_singleton;

/* What a component keeps beside the tables: the values of a sparse one in their order, and who is disabled.
 */
typedef struct snapshot_side {
    uint32_t component, value_count, disabled_count, unused;
} snapshot_side;

/* The pairs of a relation. A place is where the source stands among the sources of that target. */
typedef struct snapshot_relation {
    uint32_t component, source_count, pair_count, unused;
} snapshot_relation;

/* The lists of a relation as they lie in the bytes, at addresses of any alignment. */
typedef struct snapshot_pairs {
    const uint8_t *sources, *counts, *targets, *places, *values;
    uint32_t source_count, pair_count;
} snapshot_pairs;
struct kd_world;
/** Relate as the lists say; the relation has no pair yet. Returns KD_BAD_FORMAT, without a message, for lists
 * that contradict themselves or the world's entities, KD_NO_MEMORY. */
kd_status snapshot_relate(struct kd_world *w, uint32_t component, const snapshot_pairs *pairs);

/** Hash what the fields are called and how they lie; enumerations also by their words; and how the
 *  component is stored. */
uint64_t snapshot_field_hash(const kd_component_desc *desc);

#endif
