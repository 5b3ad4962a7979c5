#ifndef KD_ECS_WATCH_H
#define KD_ECS_WATCH_H

/* What the system that runs on this thread may touch, and what its queries have shown it. */

#include <string.h>

#include "runtime/ecs/system.h"

/** Two descriptions of one name are one component, wherever they lie. */
static inline bool ecs_same_component(const kd_component_desc *a, const kd_component_desc *b)
{
    return a == b || strcmp(a->name, b->name) == 0;
}

enum { ECS_WATCHED_QUERIES = 32 };

/* What a query showed; the query itself may be gone by the time that somebody asks. */
typedef struct ecs_watched_query {
    char name[60];
    uint32_t term_count;
    kd_component_id ids[KD_MAX_TERMS];
} ecs_watched_query;

typedef struct ecs_watch {
    const char *system;
    const kd_component_use *uses; /* as in kd_system_desc */
    bool active;                  /* checked or counted: else only the name serves, for assertions */
    bool checked;                 /* complain about what is not declared */
    kd_status status;             /* of the first complaint of this run */
    uint64_t rows, tables;        /* shown by its queries, over all runs */
    uint32_t query_count;         /* of this frame; those beyond the array are not kept */
    ecs_watched_query *queries;   /* [ECS_WATCHED_QUERIES] while it is checked */
} ecs_watch;

extern _Thread_local ecs_watch *ecs_watching; /* NULL: no system runs on this thread */

/** A query's iteration begins, or its rows are shared among workers. */
void ecs_watch_query(const kd_query *q);
/** Name of the newest query of this frame that shows the component to the system; NULL when there was none.
 */
const char *ecs_watch_query_name(const ecs_watch *watch, kd_component_id id);
/** How the system declares the component: as written, as read, or not at all. */
typedef enum ecs_declared { ECS_NOT_DECLARED, ECS_DECLARED_READ, ECS_DECLARED_WRITE } ecs_declared;
ecs_declared ecs_watch_declared(const ecs_watch *watch, const kd_component_desc *desc);

#endif
