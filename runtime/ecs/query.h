#ifndef KD_ECS_QUERY_H
#define KD_ECS_QUERY_H

/* Cached queries over a world's tables.
 *
 *     kd_query *q = kd_query_make(w, &(kd_query_desc){.terms = {KD_READ(velocity), KD_WRITE(position)}});
 *     for (kd_iter it = kd_query_iter(q); kd_iter_next(&it);) {
 *         const velocity *v = KD_COLUMN(&it, velocity, 0);
 *         position *p = KD_COLUMN_MUT(&it, position, 1);
 *         for (uint32_t i = 0; i < it.count; i++) …
 *     }
 *
 * A column is always an array of it.count values (or NULL for an absent optional term). Iteration order:
 * tables in order of creation, rows in order; by hierarchy depth first when the query asks for it.
 *
 * A term of a relation asks for any target (KD_WITH(likes)) or for one (KD_PAIR(likes, alice)). A query that
 * requires a pair visits the sources of that target alone, in the order of kd_sources, and looks at no other
 * row; kd_query_parallel goes through all rows instead. To ask the same about many targets make one query
 * with KD_WITH(likes) and begin with kd_query_iter_to.
 *
 * Terms of sparse components and of components with enable bits are asked row by row: a chunk is then a run
 * of rows that agree (and whose sparse values lie one behind the other). Queries without such terms pay
 * nothing. Changes of a sparse component are seen for the component as a whole. */

#include "runtime/ecs/world.h"

typedef enum kd_term_kind {
    KD_TERM_END,
    KD_TERM_READ,
    KD_TERM_WRITE,
    KD_TERM_OPTIONAL, /* read */
    KD_TERM_OPTIONAL_WRITE,
    KD_TERM_WITH, /* must be there, not accessed */
    KD_TERM_WITHOUT,
    KD_TERM_ANY, /* at least one of the ANY terms must be there; read, NULL when absent */
} kd_term_kind;

typedef struct kd_term {
    kd_term_kind kind;
    const kd_component_desc *desc;
    kd_entity target; /* of a relation; KD_ANY_TARGET: any, and a column then has the first one's values */
} kd_term;
#define KD_ANY_TARGET                                                                                        \
    {                                                                                                        \
        0, 0                                                                                                 \
    }
#define KD_READ(type)                                                                                        \
    {                                                                                                        \
        KD_TERM_READ, &type##_desc, KD_ANY_TARGET                                                            \
    }
#define KD_WRITE(type)                                                                                       \
    {                                                                                                        \
        KD_TERM_WRITE, &type##_desc, KD_ANY_TARGET                                                           \
    }
#define KD_OPTIONAL(type)                                                                                    \
    {                                                                                                        \
        KD_TERM_OPTIONAL, &type##_desc, KD_ANY_TARGET                                                        \
    }
#define KD_OPTIONAL_WRITE(type)                                                                              \
    {                                                                                                        \
        KD_TERM_OPTIONAL_WRITE, &type##_desc, KD_ANY_TARGET                                                  \
    }
#define KD_WITH(type)                                                                                        \
    {                                                                                                        \
        KD_TERM_WITH, &type##_desc, KD_ANY_TARGET                                                            \
    }
#define KD_WITHOUT(type)                                                                                     \
    {                                                                                                        \
        KD_TERM_WITHOUT, &type##_desc, KD_ANY_TARGET                                                         \
    }
#define KD_ANY(type)                                                                                         \
    {                                                                                                        \
        KD_TERM_ANY, &type##_desc, KD_ANY_TARGET                                                             \
    }
/* Terms of a relation with one target, for the pair instead of the component. */
#define KD_PAIR(type, target)                                                                                \
    {                                                                                                        \
        KD_TERM_WITH, &type##_desc, target                                                                   \
    }
#define KD_READ_PAIR(type, target)                                                                           \
    {                                                                                                        \
        KD_TERM_READ, &type##_desc, target                                                                   \
    }
#define KD_WRITE_PAIR(type, target)                                                                          \
    {                                                                                                        \
        KD_TERM_WRITE, &type##_desc, target                                                                  \
    }
#define KD_OPTIONAL_PAIR(type, target)                                                                       \
    {                                                                                                        \
        KD_TERM_OPTIONAL, &type##_desc, target                                                               \
    }
#define KD_WITHOUT_PAIR(type, target)                                                                        \
    {                                                                                                        \
        KD_TERM_WITHOUT, &type##_desc, target                                                                \
    }

#define KD_MAX_TERMS 16

typedef struct kd_query_desc {
    kd_term terms[KD_MAX_TERMS]; /* ended by a zero term */
    bool by_depth;               /* visit parents before children */
    const char *name;            /* for statistics and assertions; NULL is allowed */
} kd_query_desc;

typedef struct kd_query kd_query;
struct kd_jobs;

/** Make a query or find the equal one made before (counted). Returns NULL when memory is out, and with a
 * message for a component that cannot be registered or a target of one that is no relation. Threading: any.
 */
kd_query *kd_query_make(kd_world *w, const kd_query_desc *desc);
void kd_query_destroy(kd_query *q);   /* gives one count back; kd_world_destroy frees those that are left */
uint32_t kd_query_count(kd_query *q); /* matching entities */

typedef struct kd_iter {
    uint32_t count;            /* rows in this chunk */
    const kd_entity *entities; /* [count] */
    const kd_entity *parents;  /* [count]; NULL for entities without parent (depth 0) */
    void *columns[KD_MAX_TERMS];
    kd_query *query;
    uint32_t marked;        /* bits of the terms whose columns bear the present version in all these rows */
    uint64_t changed_since; /* 0: visit all; else only chunks in which an accessed term changed after this
                               version */
    kd_entity target;       /* see kd_query_iter_to */
    uint32_t next_table, next_row, row_limit;
    void *internal[3];
} kd_iter;

/** Begin to iterate. An iterator owns nothing and may be abandoned at any row. */
kd_iter kd_query_iter(kd_query *q);
/** The same for one target: it takes the place of that of the first term of a relation, KD_NO_ENTITY that of
 * none. A dead target has no sources. */
kd_iter kd_query_iter_to(kd_query *q, kd_entity target);
/** Show the next rows: a table's, or with changed_since a run of its changed chunks. Structural changes while
 * iterating assert; without assertions they are reported once and the iteration ends. */
bool kd_iter_next(kd_iter *it);
/** Called with some of the matching rows, on any worker: `rows` is used like an iterator that kd_iter_next
 * has just advanced (columns are got from it, it is not advanced). */
typedef void kd_rows_fn(kd_iter *rows, kd_commands *commands, void *user);
/** Visit all matching rows, shared among the workers of `jobs` (NULL: here, as the worker that the caller
 * runs on). What is too short to gain from a second thread runs on the calling one. Calls may come in any
 * order and cut the rows anywhere: change only what belongs to the rows, and record commands row by row, then
 * they are merged in the order of rows at any thread count. command_key  of the commands recorded, to which
 * the row's number is added; a system gives context->command_key. Under the key that the caller's own
 * commands have, loops and what is recorded round them are merged in the order of the program Errors
 * NO_MEMORY, only for queries of more than 256 tables; nothing was visited Threading    a worker of `jobs`
 * (the thread that made it is one) that may access the components */
kd_status kd_query_parallel(kd_query *q, struct kd_jobs *jobs, uint64_t command_key, kd_rows_fn *fn,
                            void *user);

/** Take the world's change counter: keep it and set it as an iterator's changed_since to see what is accessed
 * for writing, added, moved or given another parent after this call (chunk by chunk). Rows that an iterator
 * shows already may count as accessed when it came to them: call it outside of loops that write. Threading:
 * any. */
uint64_t kd_world_version(const kd_world *w);

void ecs_iter_check(const kd_iter *it, uint32_t index, size_t size);
/** Column of term `index` to read. A term that the query does not have asserts; without assertions it must
 * not be asked for. */
static inline const void *kd_iter_column(const kd_iter *it, uint32_t index, size_t size)
{
#ifndef NDEBUG
    ecs_iter_check(it, index, size);
#endif
    (void)size;
    return it->columns[index];
}
void *ecs_iter_mark(kd_iter *it, uint32_t index);
/** Column of term `index` to write; asserts that the term is there and declared WRITE (without assertions it
 * gives NULL), and marks the chunk changed. */
static inline void *kd_iter_column_mut(kd_iter *it, uint32_t index, size_t size)
{
#ifndef NDEBUG
    ecs_iter_check(it, index, size);
#endif
    (void)size;
    return it->marked >> index & 1 ? it->columns[index] : ecs_iter_mark(it, index);
}
/** Targets of the rows' pairs that term `index` shows: [count]. The term is of a relation and has a column.
 */
const kd_entity *kd_iter_targets(const kd_iter *it, uint32_t index);
#define KD_COLUMN(it, type, index)     ((const type *)kd_iter_column((it), (index), sizeof(type)))
#define KD_COLUMN_MUT(it, type, index) ((type *)kd_iter_column_mut((it), (index), sizeof(type)))

#endif
