#ifndef KD_CORE_PROGRESS_H
#define KD_CORE_PROGRESS_H

#include <stdbool.h>
#include <stdint.h>

/** Hear of work that may take long: `done` of `total` parts, which `what` names. Return false to have the
 * rest of it left undone. Threading: that of the work */
typedef bool kd_progress_sink(void *user, uint64_t done, uint64_t total, const char *what);

/** Hand in the one who hears of it; NULL: nobody, and all work is done. */
void kd_progress_set_sink(kd_progress_sink *sink, void *user);

/** Tell how far some work is, before its part number `done` (from 0) begins. Returns false when it should
 * end. */
bool kd_progress(uint64_t done, uint64_t total, const char *what);

#endif
