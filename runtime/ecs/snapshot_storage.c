/* The storage of a world (records, tables, hierarchy, names, what lies beside the tables) as one thing that
 * can be put aside while another one is built, and then put back or given up. Queries keep two lists of
 * matches meanwhile. */

#include "runtime/ecs/snapshot_reader.h"

static void swap_bytes(void *restrict a, void *restrict b, size_t size)
{
    uint8_t *restrict x = a, *restrict y = b;
    for (size_t i = 0; i < size; i++) {
        uint8_t byte = x[i];
        x[i] = y[i];
        y[i] = byte;
    }
}

void snapshot_swap_storage(kd_world *w, snapshot_storage *other)
{
    snapshot_storage now = {w->head.records, w->head.entity_limit, w->head.table_count,
                            w->head.tables,  w->head.places,       {0}};
    w->head.records = other->records;
    w->head.entity_limit = other->entity_limit;
    w->head.table_count = other->table_count;
    w->head.tables = other->tables;
    w->head.places = other->places;
    other->records = now.records;
    other->entity_limit = now.entity_limit;
    other->table_count = now.table_count;
    other->tables = now.tables;
    other->places = now.places;
    swap_bytes((uint8_t *)w + STORAGE_BEGIN, other->rest, sizeof other->rest);
    for (kd_query *q = w->queries; q; q = q->next) {
        swap_bytes(&q->matches, &q->kept_matches, sizeof q->matches);
        swap_bytes(&q->match_count, &q->kept_count, sizeof q->match_count);
        swap_bytes(&q->match_capacity, &q->kept_capacity, sizeof q->match_capacity);
    }
    memset(w->paths, 0, sizeof w->paths);
}

void snapshot_drop_storage(kd_world *w, snapshot_storage *next)
{
    ecs_tables_fini(w);
    ecs_sides_fini(w);
    ecs_relations_fini(w);
    ecs_names_fini(w);
    ecs_free(w, w->head.records);
    ecs_free(w, w->nodes);
    snapshot_swap_storage(w, next);
    for (kd_query *q = w->queries; q; q = q->next) {
        ecs_free(w, q->kept_matches);
        q->kept_matches = NULL;
        q->kept_count = q->kept_capacity = 0;
    }
}
