/* The builds of the tree beside each other, on a scene in which everything is rebuilt every frame. */
#include <stdio.h>
#include <string.h>

#include "runtime/app/voxel_bench/internal.h"

static kd_status measure(const voxel_bench *b, const char *build, rig_figures *f)
{
    char build_set[48];
    const char *sets[] = {"svo.layers=one", build ? build_set : NULL, NULL};
    snprintf(build_set, sizeof build_set, "svo.build=%s", build ? build : "");
    return voxel_bench_measure(b, sets, f);
}

static kd_status measure_row(const voxel_bench *b, const char *build, bool *begun)
{
    rig_figures f;
    char name[48];
    snprintf(name, sizeof name, "builds/%s", build ? build : "orderfree");
    if (!voxel_bench_wanted(b, name))
        return KD_OK;
    kd_status status = measure(b, build, &f);
    if (status != KD_OK)
        return status;
    if (!*begun)
        voxel_bench_head("build");
    *begun = true;
    voxel_bench_row(b, name, strchr(name, '/') + 1, &f);
    voxel_bench_traffic(b, name, &f);
    return KD_OK;
}

kd_status voxel_bench_builds(const voxel_bench *b)
{
    const char *key = "svo.build";
    const kd_setting_row *row = kd_settings_find(key, strlen(key));
    bool begun = false;
    if (!row)
        return measure_row(b, NULL, &begun);
    kd_status status = KD_OK;
    for (const char *const *word = row->words; *word && status == KD_OK; word++)
        status = measure_row(b, *word, &begun);
    return status;
}
