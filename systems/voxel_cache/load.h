#ifndef KD_SYSTEMS_VOXEL_CACHE_LOAD_H
#define KD_SYSTEMS_VOXEL_CACHE_LOAD_H

#include "runtime/asset/voxel_file.h"
#include "runtime/jobs/jobs.h"

/* Levels of .kvox files on their way to caches: opened one by one, unpacked together by all workers. */
typedef struct voxel_load {
    uint32_t cache; /* kd_voxel_scene.caches */
    kd_voxel_key key;
    kd_voxel_file own; /* a file of the disk cache; empty when `file` is somebody else's */
    const kd_voxel_file *file;
    const kd_voxel_level *level;
    kd_voxel_words words;    /* of all its blocks, one after the other */
    uint32_t *starts;        /* [block_count]: first word of each block */
    _Atomic uint32_t failed; /* blocks that could not be read */
} voxel_load;

typedef struct voxel_loads {
    voxel_load *items;
    uint32_t count, capacity;
    uint64_t voxels;
} voxel_loads;

/** Add a level; takes over `own`. Errors NO_MEMORY */
kd_status loads_add(voxel_loads *loads, uint32_t cache, kd_voxel_key key, const kd_voxel_file *given,
                    kd_voxel_file *own);

/** Unpack every block of every level. jobs may be NULL. */
void loads_unpack(voxel_loads *loads, kd_jobs *jobs);

/** Free the words and close the files; the list's memory stays. */
void loads_clear(voxel_loads *loads);
void loads_fini(voxel_loads *loads);

#endif
