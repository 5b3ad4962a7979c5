#ifndef KD_SYSTEMS_VOXEL_CACHE_DISK_H
#define KD_SYSTEMS_VOXEL_CACHE_DISK_H

#include <stdatomic.h>

#include "runtime/asset/voxel_file.h"
#include "runtime/core/file.h"
#include "runtime/gpu/gpu.h"

/* A folder of .kvox files, one a cache, named by key and driver: drivers round otherwise, and what a run
 * shows must not depend on who has run before. Files appear whole, by rename; any may be deleted at any time.
 */
typedef struct voxel_disk {
    char folder[KD_PATH_MAX]; /* "": none */
    uint64_t driver;
    atomic_bool broken; /* writing has failed: it was said, and nothing more is written */
    uint64_t written;   /* bytes of this run */
} voxel_disk;

/** Choose the folder: KANDIL_CACHE (empty: none), else kandil/voxels below XDG_CACHE_HOME or ~/.cache. Makes
 * nothing yet. */
void disk_init(voxel_disk *disk, const kd_gpu_info *driver);

/** Open the file of a key. Returns false when there is none that serves; one that is cut, damaged or foreign
 * is named. */
bool disk_open(const voxel_disk *disk, kd_voxel_key key, kd_voxel_file *file);

/** Write the file of a key. Where that fails, one warning is said and nothing is written any more. Threading:
 * one at a time */
void disk_save(voxel_disk *disk, kd_voxel_key key, const void *bytes, size_t size);

/** Delete what was used longest ago, if this run has written anything and the folder holds more than 1 GiB.
 */
void disk_fini(voxel_disk *disk);

#endif
