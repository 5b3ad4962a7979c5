/* Free cells are joined in runs along x: runs that touch in neighbouring rows belong together, those at a
 * border belong to the outside, and what remains is inside. A surface of n cells has about n runs, however
 * large the grid is. */
#include "systems/voxel_cache/fill.h"

#include <stdbool.h>
#include <stdlib.h>

typedef struct run {
    uint32_t first, end; /* cells along x */
    uint32_t parent;     /* joined runs form a tree; run 0 is the outside */
} run;

typedef struct runs {
    run *items;
    uint32_t count, capacity;
    uint32_t *rows; /* [rows + 1] first run of each row */
} runs;

static uint32_t root_of(run *r, uint32_t i)
{
    while (r[i].parent != i) {
        r[i].parent = r[r[i].parent].parent;
        i = r[i].parent;
    }
    return i;
}

static void join(run *r, uint32_t a, uint32_t b)
{
    a = root_of(r, a);
    b = root_of(r, b);
    r[a > b ? a : b].parent = a > b ? b : a; /* the outside stays a root */
}

static kd_status push(runs *all, uint32_t first, uint32_t end)
{
    if (all->count == all->capacity) {
        if (all->capacity > UINT32_MAX / 2)
            return KD_TOO_LARGE;
        uint32_t capacity = all->capacity ? all->capacity * 2 : 1024;
        run *grown = realloc(all->items, capacity * sizeof *grown);
        if (!grown)
            return KD_NO_MEMORY;
        all->items = grown;
        all->capacity = capacity;
    }
    all->items[all->count] = (run){first, end, all->count};
    all->count++;
    return KD_OK;
}

/* The first cell from `x` on whose bit is `wanted`; `end` when there is none. Whole words are skipped. */
static uint64_t next_bit(const uint32_t *mask, uint64_t at, uint64_t end, uint32_t wanted)
{
    while (at < end) {
        uint32_t word = mask[at >> 5] ^ (wanted ? 0 : UINT32_MAX);
        word >>= at & 31;
        if (word) {
            at += (uint32_t)__builtin_ctz(word);
            break;
        }
        at = (at | 31) + 1;
    }
    return at < end ? at : end;
}

static kd_status list_row(runs *all, const uint32_t *mask, uint64_t begin, uint32_t size)
{
    kd_status status = KD_OK;
    for (uint64_t at = begin; at < begin + size && !status;) {
        uint64_t first = next_bit(mask, at, begin + size, 0), end = next_bit(mask, first, begin + size, 1);
        if (first < end)
            status = push(all, (uint32_t)(first - begin), (uint32_t)(end - begin));
        at = end;
    }
    return status;
}

/* Join the runs of two rows that share cells. */
static void join_rows(runs *all, uint32_t row, uint32_t other)
{
    uint32_t i = all->rows[row], j = all->rows[other];
    while (i < all->rows[row + 1] && j < all->rows[other + 1]) {
        const run *a = &all->items[i], *b = &all->items[j];
        if (a->first < b->end && b->first < a->end)
            join(all->items, i, j);
        if (a->end < b->end)
            i++;
        else
            j++;
    }
}

static void join_all(runs *all, const uint32_t size[3])
{
    for (uint32_t z = 0, row = 0; z < size[2]; z++)
        for (uint32_t y = 0; y < size[1]; y++, row++) {
            bool border = y == 0 || z == 0 || y == size[1] - 1 || z == size[2] - 1;
            for (uint32_t i = all->rows[row]; i < all->rows[row + 1]; i++)
                if (border || all->items[i].first == 0 || all->items[i].end == size[0])
                    join(all->items, 0, i);
            if (y)
                join_rows(all, row, row - 1);
            if (z)
                join_rows(all, row, row - size[1]);
        }
}

static void set_bits(uint32_t *mask, uint64_t first, uint64_t end)
{
    for (; first < end; first++)
        mask[first >> 5] |= 1u << (first & 31);
}

static void fill_inner(const runs *all, uint32_t *mask, const uint32_t size[3])
{
    uint32_t rows = size[1] * size[2];
    for (uint32_t row = 0; row < rows; row++)
        for (uint32_t i = all->rows[row]; i < all->rows[row + 1]; i++)
            if (root_of(all->items, i) != 0) {
                uint64_t begin = (uint64_t)row * size[0];
                set_bits(mask, begin + all->items[i].first, begin + all->items[i].end);
            }
}

kd_status fill_enclosed(uint32_t *mask, const uint32_t size[3])
{
    uint32_t rows = size[1] * size[2];
    runs all = {.rows = malloc((rows + (size_t)1) * sizeof *all.rows)};
    kd_status status = all.rows ? push(&all, 0, 0) : KD_NO_MEMORY; /* the outside */
    for (uint32_t row = 0; row < rows && !status; row++) {
        all.rows[row] = all.count;
        status = list_row(&all, mask, (uint64_t)row * size[0], size[0]);
    }
    if (!status) {
        all.rows[rows] = all.count;
        join_all(&all, size);
        fill_inner(&all, mask, size);
    }
    free(all.items);
    free(all.rows);
    return status;
}
