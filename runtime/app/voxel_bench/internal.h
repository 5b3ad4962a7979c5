#ifndef KD_APP_VOXEL_BENCH_INTERNAL_H
#define KD_APP_VOXEL_BENCH_INTERNAL_H

#include "runtime/app/voxel_bench/fit.h"
#include "runtime/app/voxel_bench/rig.h"
#include "runtime/core/json.h"

/* What the parts of a bench share. */
typedef struct voxel_bench {
    const app_options *options;
    kd_json *json;
    const char *name;  /* "voxels", "svo" */
    const char *scene; /* path */
    uint32_t frames;   /* measured, for each row */
    uint32_t threads;
    double copy_rate;        /* bytes a second, both ways */
    double span_m, extent_m; /* finest voxel and edge of the finest cascade, as the scene asks for them */
    int64_t max_ssbo_bytes;
} voxel_bench;

enum { VOXEL_BENCH_WARM_UP = 3 };

/** Open the scene once for what all parts need to know, and print the head. Errors with one message */
kd_status voxel_bench_begin(voxel_bench *b, const app_options *options, kd_json *json, const char *name);

/** Tell whether --case asks for a case. */
bool voxel_bench_wanted(const voxel_bench *b, const char *name);

/** Open the bench's scene with settings on top (rig_open), warm up and measure. Errors with one message */
kd_status voxel_bench_measure(const voxel_bench *b, const char *const *sets, rig_figures *out);

/** Print the head of a table of stages. `first`: title of the first column */
void voxel_bench_head(const char *first);

/** Print a row of such a table and add its stages to the JSON file as NAME/STAGE; the limit of each is
 * copying what it must move. `label`: the first column */
void voxel_bench_row(const voxel_bench *b, const char *name, const char *label, const rig_figures *f);

/** Print and add bytes and bandwidth of each stage. */
void voxel_bench_traffic(const voxel_bench *b, const char *name, const rig_figures *f);

/** Print and add the line through the tree's cost (transform, build, filter) over voxels. */
void voxel_bench_fit(const voxel_bench *b, const char *name, const rig_figures *rows, uint32_t count);

/** Add one figure to the JSON file. */
void voxel_bench_value(const voxel_bench *b, const char *name, uint64_t n, const char *unit, double value,
                       double limit);

/* ---- parts ---- */
kd_status voxel_bench_cascades(const voxel_bench *b);
kd_status voxel_bench_characters(const voxel_bench *b);
kd_status voxel_bench_builds(const voxel_bench *b);
kd_status voxel_bench_layers(const voxel_bench *b);

#endif
