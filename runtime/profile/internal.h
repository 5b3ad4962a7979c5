#ifndef KD_PROFILE_INTERNAL_H
#define KD_PROFILE_INTERNAL_H

#include "runtime/profile/profile.h"

/* What the reports need to know of a profile besides its statistics. */
uint32_t profile_system_count(const kd_profile *p);
kd_profile_system profile_system(const kd_profile *p, uint32_t index);
const char *profile_clock(const kd_profile *p);

#endif
