#ifndef KD_CORE_RANGES_H
#define KD_CORE_RANGES_H

#include <stdbool.h>
#include <stdint.h>

/* Ranges of numbers 0 … end handed out and taken back: places in a buffer, entries of a table. Free ranges
 * are kept in order, never touch each other and never touch `end`, which goes back when what lies before it
 * is free. The lowest place that is large enough is given out, so that the end stays low. Starts as {0}. */
typedef struct kd_range {
    uint32_t first, count;
} kd_range;

typedef struct kd_ranges {
    uint32_t end; /* everything from here on is free */
    kd_range *holes;
    uint32_t hole_count, hole_capacity;
    uint64_t free_count; /* numbers in the holes */
} kd_ranges;

/** Take `count` numbers in a row (0 takes none). Returns the first; UINT32_MAX when they would pass 2^32 - 1.
 *  Cost  the holes below the place */
uint32_t kd_ranges_take(kd_ranges *ranges, uint32_t count);

/** Tell where the next kd_ranges_take of `count` would end at most: what a buffer has to hold. */
uint64_t kd_ranges_bound(const kd_ranges *ranges, uint32_t count);

/** Give back what was taken, whole or in part. Returns false when memory is out: the numbers stay taken.
 *  Cost  the holes above the place */
bool kd_ranges_give(kd_ranges *ranges, uint32_t first, uint32_t count);

/** Get how many numbers are taken. */
static inline uint64_t kd_ranges_taken(const kd_ranges *ranges)
{
    return ranges->end - ranges->free_count;
}

void kd_ranges_fini(kd_ranges *ranges);

#endif
