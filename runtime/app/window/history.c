#include "runtime/app/window/history.h"

#include <stdlib.h>

#include "runtime/core/log.h"

kd_status window_history_open(window_history *h, const kd_profile *profile)
{
    window_history_close(h);
    h->row_count = kd_profile_system_count(profile) + 1;
    h->rows = calloc(h->row_count, sizeof *h->rows);
    return h->rows ? KD_OK : kd_fail(KD_NO_MEMORY, "out of memory for the times of systems");
}

void window_history_add(window_history *h, const kd_profile *profile)
{
    uint32_t at = (h->first + h->count) % WINDOW_HISTORY_FRAMES;
    if (h->count == WINDOW_HISTORY_FRAMES)
        h->first = (h->first + 1) % WINDOW_HISTORY_FRAMES;
    else
        h->count++;
    for (uint32_t i = 0; i < h->row_count; i++) {
        double ms;
        uint64_t runs = kd_profile_newest(profile, i, &ms);
        h->rows[i].ms[at] = runs != h->rows[i].runs ? (float)ms : 0;
        h->rows[i].runs = runs;
    }
}

void window_history_close(window_history *h)
{
    free(h->rows);
    *h = (window_history){0};
}

static int by_value(const void *a, const void *b)
{
    float x = *(const float *)a, y = *(const float *)b;
    return (x > y) - (x < y);
}

window_history_stats window_history_read(const window_history *h, uint32_t row)
{
    float ms[WINDOW_HISTORY_FRAMES];
    uint32_t n = 0;
    for (uint32_t i = 0; i < h->count; i++) {
        float value = h->rows[row].ms[(h->first + i) % WINDOW_HISTORY_FRAMES];
        if (value > 0)
            ms[n++] = value;
    }
    if (!n)
        return (window_history_stats){0};
    qsort(ms, n, sizeof *ms, by_value);
    return (window_history_stats){(ms[(n - 1) / 2] + ms[n / 2]) / 2, ms[(n * 95 + 99) / 100 - 1], ms[n - 1]};
}
