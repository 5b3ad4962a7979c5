#ifndef KD_APP_VOXELIZE_H
#define KD_APP_VOXELIZE_H

#include "runtime/app/options.h"

/** `kandil voxelize`: voxelize all that a scene shows, at the spans of its cascades, into a .kvox file.
 * Errors with one message; INTERRUPTED leaves nothing behind. */
kd_status app_voxelize(const app_options *options);

/** `kandil info FILE.kvox`. Every block is unpacked to see that it is sound. Errors with one message */
kd_status app_voxel_info(const char *path);

struct kd_voxel_file;
/** Open a file that was asked for: it serves, or one message says why it does not. */
kd_status app_voxel_file_open(struct kd_voxel_file *file, const char *path);

#endif
