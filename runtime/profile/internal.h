#ifndef KD_PROFILE_INTERNAL_H
#define KD_PROFILE_INTERNAL_H

#include "runtime/profile/profile.h"
#include "runtime/profile/trace.h"

/* What the reports need to know of a profile besides its statistics. */
const char *profile_clock(const kd_profile *p);
/** Get a system's samples, of the clock that is reported; `system` may be the count, for the frame. The
 * oldest kept lies at .first; entry i at (first + i) % count. */
typedef struct profile_samples {
    const uint64_t *ns;
    uint64_t first, count;
} profile_samples;
profile_samples profile_system_samples(const kd_profile *p, uint32_t system);

/* ---- writers ---- */
#define PROFILE_COUNTERS "counter" /* category of names that are counters */
static inline bool profile_is_counter(const kd_trace *trace, kd_trace_name name)
{
    const char *category;
    kd_trace_name_text(trace, name, &category);
    return category[0] == 'c' && category[1] == 'o';
}
kd_status profile_write_perfetto(const kd_trace *trace, const char *path);
kd_status profile_write_chrome(const kd_profile *p, const kd_trace *trace, const char *path);

#endif
