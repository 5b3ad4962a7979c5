/* Three cascades of 64^3 … 1024^3 over the same part of the scene: the voxels become smaller as the cascades
 * hold more. Everything is rebuilt every frame, as the paper does. */
#include <stdio.h>
#include <string.h>

#include "runtime/app/voxel_bench/internal.h"

static const uint32_t resolutions[] = {64, 128, 256, 512, 1024};
enum { RESOLUTIONS = sizeof resolutions / sizeof *resolutions, CASCADES = 3 };

/* Why cascades of a resolution cannot be had here; NULL when they can. */
static const char *missing(uint32_t resolution, char *text, size_t size)
{
    char word[16];
    bool offered = false;
    const char *key = "voxels.resolution";
    const kd_setting_row *row = kd_settings_find(key, strlen(key));
    snprintf(word, sizeof word, "%u", resolution);
    for (const char *const *w = row->words; *w; w++)
        offered = offered || strcmp(*w, word) == 0;
    if (resolution <= KD_DENSE)
        snprintf(text, size, "it has no sparse level: the dense one has %d^3 cells already", KD_DENSE);
    else if (!offered)
        snprintf(text, size, "the setting %s does not offer it", key);
    else
        return NULL;
    return text;
}

static kd_status measure(const voxel_bench *b, uint32_t resolution, rig_figures *f)
{
    char resolution_set[40], span_set[40], cascades_set[40];
    const char *sets[] = {resolution_set, span_set, cascades_set, "svo.layers=one", NULL};
    snprintf(resolution_set, sizeof resolution_set, "voxels.resolution=%u", resolution);
    snprintf(span_set, sizeof span_set, "voxels.span=%.9g", b->extent_m / resolution);
    snprintf(cascades_set, sizeof cascades_set, "voxels.cascades=%d", CASCADES);
    return voxel_bench_measure(b, sets, f);
}

kd_status voxel_bench_cascades(const voxel_bench *b)
{
    rig_figures rows[RESOLUTIONS];
    char name[32], label[48], why[RESOLUTIONS][128];
    uint32_t count = 0, left_out = 0, left[RESOLUTIONS];
    kd_status status = KD_OK;
    bool begun = false;
    for (uint32_t i = 0; i < RESOLUTIONS && status == KD_OK; i++) {
        uint32_t n = resolutions[i];
        snprintf(name, sizeof name, "cascades/%u", n);
        if (!voxel_bench_wanted(b, name))
            continue;
        if (missing(n, why[left_out], sizeof why[left_out])) {
            left[left_out++] = n;
            continue;
        }
        if (!begun)
            voxel_bench_head("span, cascades");
        begun = true;
        status = measure(b, n, &rows[count]);
        snprintf(label, sizeof label, "%.2f mm  %d x %u^3", b->extent_m / n * 1e3, CASCADES, n);
        if (status == KD_OK)
            voxel_bench_row(b, name, label, &rows[count++]);
    }
    for (uint32_t i = 0; i < left_out; i++)
        printf("left out: %d x %u^3: %s\n", CASCADES, left[i], why[i]);
    if (status == KD_OK && count) {
        voxel_bench_fit(b, "cascades", rows, count);
        voxel_bench_traffic(b, "cascades", &rows[count - 1]);
    }
    return status;
}
