#ifndef KD_ECS_STATISTICS_H
#define KD_ECS_STATISTICS_H

/* Where a world's memory is: by component, by archetype and by query. */

#include "runtime/core/json.h"
#include "runtime/ecs/query.h"

typedef struct kd_component_statistics {
    const kd_component_desc *desc;
    uint32_t entities; /* that have it */
    uint32_t pairs;    /* of a relation, else 0 */
    size_t used_bytes; /* of their values */
    size_t held_bytes; /* with room to grow, and the index of a sparse component */
} kd_component_statistics;
/** Count over all tables. Errors OUT_OF_RANGE for an id the world did not give. */
kd_status kd_component_count_memory(const kd_world *w, kd_component_id id, kd_component_statistics *out);

typedef struct kd_archetype_statistics {
    uint32_t components, tables, entities; /* tables: one for each depth of the hierarchy in use */
    size_t used_bytes, held_bytes;         /* columns, handles and parents; held also versions and indices */
} kd_archetype_statistics;
uint32_t kd_archetype_count(const kd_world *w);
/** Count one archetype, in order of creation. Errors OUT_OF_RANGE. */
kd_status kd_archetype_count_memory(const kd_world *w, uint32_t index, kd_archetype_statistics *out);

typedef struct kd_query_statistics {
    const char *name;    /* "" without one */
    uint32_t references; /* makes not yet destroyed: a leak shows here */
    uint32_t tables;     /* matched */
    size_t held_bytes;
} kd_query_statistics;
uint32_t kd_world_query_count(const kd_world *w);
/** Look at one query, the newest first. Errors OUT_OF_RANGE. */
kd_status kd_query_count_memory(const kd_world *w, uint32_t index, kd_query_statistics *out);

/** Write all of it, and the whole world's bytes, as one JSON object for people and panels. */
void kd_world_write_statistics(const kd_world *w, kd_json *j);

#endif
