#include "systems/voxel_pages/fixed_settings.h"

#include <string.h>

#include "runtime/core/log.h"

static const char *const keys[] = {
    "voxels.span",    "voxels.resolution", "voxels.cascades", "voxels.separating", "voxels.fill",
    "voxels.binding", "svo.layers",        "svo.build",       "light.leak",        "film.supersample",
    "film.subframes", "film.layers",       "film.png_depth"};

static void tell(const fixed_settings *f, const kd_settings *now, const kd_setting_row *row)
{
    char is[48], wanted[48];
    kd_log(KD_LOG_WARNING,
           "settings: %s stays %s while the scene lives, %s is not used; say it before the first frame: "
           "--set %s=…, or "
           "kandil.set while the scenario loads",
           row->key, kd_settings_format(&f->made_with, row, is, sizeof is),
           kd_settings_format(now, row, wanted, sizeof wanted), row->key);
}

void fixed_settings_follow(fixed_settings *f, const kd_settings *now)
{
    if (!f->made)
        f->made_with = f->before = *now;
    f->made = true;
    if (memcmp(&f->before, now, sizeof *now) == 0)
        return;
    f->before = *now;
    for (uint32_t i = 0; i < sizeof keys / sizeof *keys; i++) {
        const kd_setting_row *row = kd_settings_find(keys[i], strlen(keys[i]));
        if (f->said >> i & 1 || kd_settings_value(&f->made_with, row) == kd_settings_value(now, row))
            continue;
        f->said |= 1u << i;
        tell(f, now, row);
    }
}
