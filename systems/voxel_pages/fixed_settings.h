#ifndef KD_SYSTEMS_VOXEL_PAGES_FIXED_SETTINGS_H
#define KD_SYSTEMS_VOXEL_PAGES_FIXED_SETTINGS_H

#include "runtime/core/settings.h"

/* Settings from which buffers and caches were made: they hold while the scene lives. */
typedef struct fixed_settings {
    kd_settings made_with, before; /* when the scene was made; in the frame before */
    bool made;
    uint32_t said; /* bits of those whose change was told */
} fixed_settings;

/** Keep the settings of the first frame; tell, once each, of those that have been changed since and stay as
 * they were. */
void fixed_settings_follow(fixed_settings *f, const kd_settings *now);

#endif
