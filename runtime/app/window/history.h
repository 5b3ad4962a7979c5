#ifndef KD_APP_WINDOW_HISTORY_H
#define KD_APP_WINDOW_HISTORY_H

/* Times of the latest frames, system by system, for curves and tables that follow what happens now. */

#include "runtime/profile/profile.h"

enum { WINDOW_HISTORY_FRAMES = 128 };

typedef struct window_history_row {
    uint64_t runs;
    float ms[WINDOW_HISTORY_FRAMES]; /* a ring; 0: it did not run */
} window_history_row;

typedef struct window_history {
    window_history_row *rows; /* of the systems, then of the frame */
    uint32_t row_count, first, count;
} window_history;

/** Begin anew for the rows of a profile. Errors NO_MEMORY */
kd_status window_history_open(window_history *h, const kd_profile *profile);
/** Take over the frame that has ended. */
void window_history_add(window_history *h, const kd_profile *profile);
void window_history_close(window_history *h);

typedef struct window_history_stats {
    float median_ms, p95_ms, max_ms;
} window_history_stats;
/** Of the frames in which it ran. */
window_history_stats window_history_read(const window_history *h, uint32_t row);

#endif
