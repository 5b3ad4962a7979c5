#include "runtime/core/ranges.h"

#include <assert.h>
#include <stdlib.h>
#include <string.h>

static void remove_hole(kd_ranges *r, uint32_t at)
{
    r->hole_count--;
    memmove(r->holes + at, r->holes + at + 1, (r->hole_count - at) * sizeof *r->holes);
}

/* The first hole that is large enough; hole_count when none is. */
static uint32_t find_hole(const kd_ranges *r, uint32_t count)
{
    uint32_t at = 0;
    if (r->free_count < count)
        return r->hole_count;
    while (at < r->hole_count && r->holes[at].count < count)
        at++;
    return at;
}

uint32_t kd_ranges_take(kd_ranges *r, uint32_t count)
{
    uint32_t at = find_hole(r, count), first = r->end;
    if (count == 0 || at == r->hole_count) {
        if (count > UINT32_MAX - r->end)
            return UINT32_MAX;
        r->end += count;
        return first;
    }
    first = r->holes[at].first;
    r->holes[at].first += count;
    r->holes[at].count -= count;
    r->free_count -= count;
    if (r->holes[at].count == 0)
        remove_hole(r, at);
    return first;
}

uint64_t kd_ranges_bound(const kd_ranges *r, uint32_t count)
{
    return find_hole(r, count) < r->hole_count ? r->end : (uint64_t)r->end + count;
}

/* Number of holes that lie below `first`. */
static uint32_t holes_below(const kd_ranges *r, uint32_t first)
{
    uint32_t low = 0, high = r->hole_count;
    while (low < high) {
        uint32_t middle = (low + high) / 2;
        if (r->holes[middle].first < first)
            low = middle + 1;
        else
            high = middle;
    }
    return low;
}

static bool insert_hole(kd_ranges *r, uint32_t at, kd_range hole)
{
    if (r->hole_count == r->hole_capacity) {
        uint32_t capacity = r->hole_capacity ? r->hole_capacity * 2 : 16;
        kd_range *grown = realloc(r->holes, capacity * sizeof *grown);
        if (!grown)
            return false;
        r->holes = grown;
        r->hole_capacity = capacity;
    }
    memmove(r->holes + at + 1, r->holes + at, (r->hole_count - at) * sizeof *r->holes);
    r->holes[at] = hole;
    r->hole_count++;
    return true;
}

static void take_back_end(kd_ranges *r, uint32_t first, bool joins_before)
{
    r->end = first;
    if (joins_before) {
        kd_range last = r->holes[--r->hole_count];
        r->end = last.first;
        r->free_count -= last.count;
    }
}

bool kd_ranges_give(kd_ranges *r, uint32_t first, uint32_t count)
{
    if (count == 0)
        return true;
    assert(first < r->end && count <= r->end - first);
    uint32_t at = holes_below(r, first);
    bool before = at > 0 && r->holes[at - 1].first + r->holes[at - 1].count == first;
    bool after = at < r->hole_count && first + count == r->holes[at].first;
    if (first + count == r->end) {
        take_back_end(r, first, before);
        return true;
    }
    if (!before && !after && !insert_hole(r, at, (kd_range){first, count}))
        return false;
    r->free_count += count;
    if (before) {
        r->holes[at - 1].count += count + (after ? r->holes[at].count : 0);
        if (after)
            remove_hole(r, at);
    } else if (after) {
        r->holes[at].first = first;
        r->holes[at].count += count;
    }
    return true;
}

void kd_ranges_fini(kd_ranges *r)
{
    free(r->holes);
    *r = (kd_ranges){0};
}
