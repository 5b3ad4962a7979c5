#ifndef KD_CORE_ALLOCATIONS_H
#define KD_CORE_ALLOCATIONS_H

/* How often this program's own code takes memory from the heap: a steady frame should not. The linker leads its
 * calls here (cmake/allocations.cmake); what drivers and other libraries take is theirs. */

#include <stddef.h>
#include <stdint.h>

typedef struct kd_allocations {
    uint64_t count, bytes; /* ever taken, the bytes as they were asked for; zeros where nothing is counted */
} kd_allocations;

/** Threading: any. */
kd_allocations kd_allocations_so_far(void);

#endif
