/* Rows of tables: they come at the end, and the last one fills the place of one that goes. A table's chunks
 * bear versions: those of column 0, the entities, say when rows came or moved, which counts for every column;
 * those of another column when it was accessed for writing. */

#include "runtime/ecs/internal.h"

/* ---- change versions ---- */
void ecs_column_stamp(kd_world *w, ecs_table *t, uint32_t column, uint32_t row, uint32_t count)
{
    uint64_t version = atomic_load_explicit(&w->version, memory_order_relaxed),
             *words = ecs_versions(t, column);
    ecs_raise_version(&words[0], version);
    for (uint32_t i = row / ECS_CHUNK_ROWS; i <= (row + count - 1) / ECS_CHUNK_ROWS; i++)
        ecs_raise_version(&words[1 + i], version);
}

void ecs_table_stamp(kd_world *w, ecs_table *t, uint32_t row, uint32_t count)
{
    ecs_column_stamp(w, t, 0, row, count);
}

/* One row came or moved. The owner of the world is alone here. */
static inline void stamp_row(const kd_world *w, const ecs_table *t, uint32_t row)
{
    uint64_t version = atomic_load_explicit(&((kd_world *)(uintptr_t)w)->version, memory_order_relaxed);
    uint64_t *words = t->versions, *chunk = &words[1 + row / ECS_CHUNK_ROWS];
    if (__atomic_load_n(chunk, __ATOMIC_RELAXED) < version) {
        __atomic_store_n(chunk, version, __ATOMIC_RELAXED);
        __atomic_store_n(words, version, __ATOMIC_RELAXED);
    }
}

/* ---- one row ---- */
static inline void copy_row(const ecs_column *to, uint32_t to_row, const ecs_column *from, uint32_t from_row)
{
    ecs_copy(to->data + (size_t)to_row * to->size, from->data + (size_t)from_row * from->size, to->size);
}

static inline uint32_t append(kd_world *w, ecs_table *t, kd_entity e)
{
    uint32_t row = t->count++;
    ecs_entities(t)[row] = e;
    ecs_place(w, e, t, row);
    stamp_row(w, t, row);
    return row;
}

uint32_t ecs_table_append(kd_world *w, ecs_table *t, kd_entity e)
{
    return append(w, t, e);
}

/* The last row's entity lies at `row` now. */
static inline void settle_gap(kd_world *w, const ecs_table *t, uint32_t row, uint32_t last)
{
    kd_entity moved = ecs_entities(t)[last];
    ecs_entities(t)[row] = moved;
    ecs_place(w, moved, t, row);
    stamp_row(w, t, row);
}

void ecs_table_remove(kd_world *w, ecs_table *t, uint32_t row)
{
    uint32_t last = --t->count;
    if (row == last)
        return;
    settle_gap(w, t, row, last);
    for (const ecs_column *c = t->columns + 1, *end = t->columns + t->column_count; c < end; c++)
        copy_row(c, row, c, last);
}

/* A value goes from `at` to `to`, and the last one of its column takes its place (`last` may be `at`). */
static inline void move_value(uint8_t *to, uint8_t *at, const uint8_t *last, uint32_t size)
{
    if (size == 12) {
        memcpy(to, at, 12);
        memcpy(at, last, 12);
    } else if (size == 8) {
        memcpy(to, at, 8);
        memcpy(at, last, 8);
    } else if (size == 4) {
        memcpy(to, at, 4);
        memcpy(at, last, 4);
    } else if (size == 16) {
        memcpy(to, at, 16);
        memcpy(at, last, 16);
    } else {
        memcpy(to, at, size);
        if (at != last)
            memcpy(at, last, size);
    }
}

uint32_t ecs_table_move_row(kd_world *w, ecs_table *t, uint32_t row, ecs_table *to, kd_entity e,
                            uint32_t dropped, uint32_t added)
{
    uint32_t to_row = append(w, to, e), last = --t->count;
    const ecs_column *a = to->columns + 1, *b = t->columns + 1;
    for (uint32_t c = 1, count = t->column_count; c < count; c++, b++) {
        uint8_t *at = b->data + (size_t)row * b->size;
        const uint8_t *end = b->data + (size_t)last * b->size;
        if (c == dropped) {
            if (row != last)
                ecs_copy(at, end, b->size);
            continue;
        }
        a += c == added;
        move_value(a->data + (size_t)to_row * b->size, at, end, b->size);
        a++;
    }
    if (row != last)
        settle_gap(w, t, row, last);
    return to_row;
}

/* ---- many rows ---- */
static void copy_rows(const ecs_column *to, uint32_t to_row, const ecs_column *from, uint32_t from_row,
                      uint32_t n)
{
    memcpy(to->data + (size_t)to_row * to->size, from->data + (size_t)from_row * from->size,
           (size_t)n * to->size);
}

static void place_rows(kd_world *w, const ecs_table *t, uint32_t row, uint32_t n)
{
    const kd_entity *entities = ecs_entities(t);
    for (uint32_t i = row; i < row + n; i++)
        ecs_place(w, entities[i], t, i);
}

void ecs_table_move_rows(kd_world *w, ecs_table *t, uint32_t row, uint32_t n, ecs_table *to)
{
    uint32_t first = to->count, after = t->count - row - n, fill = n < after ? n : after;
    const ecs_column *a = to->columns + 1, *a_end = a + to->archetype->column_count;
    const ecs_column *b = t->columns + 1, *b_end = b + t->archetype->column_count;
    copy_rows(&to->columns[0], first, &t->columns[0], row, n);
    while (a < a_end && b < b_end) {
        if (a->id == b->id)
            copy_rows(a++, first, b++, row, n);
        else if (a->id < b->id)
            a++;
        else
            b++;
    }
    if (to->depth && t->depth)
        copy_rows(a_end, first, b_end, row, n);
    to->count += n;
    place_rows(w, to, first, n);
    ecs_table_stamp(w, to, first, n);
    for (uint32_t c = 0; c < t->column_count; c++)
        for (uint32_t i = 0; i < fill; i++) /* the last one first, as when rows are moved one by one */
            copy_row(&t->columns[c], row + i, &t->columns[c], t->count - 1 - i);
    t->count -= n;
    if (fill) {
        place_rows(w, t, row, fill);
        ecs_table_stamp(w, t, row, fill);
    }
}

void ecs_table_release_rows(kd_world *w, ecs_table *t, uint32_t row, uint32_t count)
{
    if (!t->archetype->hooked)
        return;
    for (uint32_t i = 0; i < t->archetype->id_count; i++) {
        kd_component_id id = t->archetype->ids[i];
        if (!w->components[id].desc->on_remove)
            continue;
        uint32_t c = t->column_of[id];
        for (uint32_t r = row; r < row + count; r++)
            ecs_release_value(w, id,
                              c == ECS_TAG_COLUMN ? (void *)w->tag_value
                                                  : t->columns[c].data + (size_t)r * t->columns[c].size);
    }
}
