#include "runtime/app/voxel_bench/voxel_bench.h"

#include <stdio.h>
#include <string.h>

#include "runtime/app/bench_report.h"
#include "runtime/app/interrupt.h"
#include "runtime/app/voxel_bench/dump.h"
#include "runtime/app/voxel_bench/internal.h"
#include "runtime/app/voxel_bench/traffic.h"
#include "runtime/core/file.h"
#include "runtime/core/log.h"

#define DEFAULT_SCENE "samples/01_cornell_walker.lua"
enum { DEFAULT_FRAMES = 12 };

static kd_status choose_scene(const app_options *options, const char *name, const char **scene)
{
    *scene = options->second ? options->second : DEFAULT_SCENE;
    if (options->second || kd_file_exists(*scene))
        return KD_OK;
    return kd_fail(KD_NOT_FOUND, "%s: the default scene is not here; name one: `kandil bench %s SCENE`",
                   *scene, name);
}

kd_status voxel_bench_begin(voxel_bench *b, const app_options *options, kd_json *json, const char *name)
{
    rig r;
    *b = (voxel_bench){.options = options,
                       .json = json,
                       .name = name,
                       .frames = options->frames > 0 ? (uint32_t)options->frames : DEFAULT_FRAMES};
    kd_status status = choose_scene(options, name, &b->scene);
    if (status != KD_OK)
        return status;
    app_interrupt_install();
    status = rig_open(&r, options, b->scene, (const char *[]){NULL});
    if (status != KD_OK)
        return status;
    b->threads = kd_jobs_threads(r.jobs);
    b->span_m = (double)r.scene.settings.voxels_span;
    b->extent_m = b->span_m * r.scene.settings.voxels_resolution;
    b->max_ssbo_bytes = kd_gpu_get_info(r.gpu)->max_ssbo_bytes;
    b->copy_rate = traffic_copy_rate(r.gpu);
    printf("%s: %s; %s, %u threads; copying moves %.1f GB/s (read and written); medians of %u frames\n", name,
           b->scene, kd_gpu_get_info(r.gpu)->renderer, b->threads, b->copy_rate * 1e-9, b->frames);
    voxel_bench_value(b, "copy", 0, "GB/s", b->copy_rate * 1e-9, 0);
    rig_close(&r);
    return KD_OK;
}

kd_status voxel_bench_measure(const voxel_bench *b, const char *const *sets, rig_figures *out)
{
    rig r;
    kd_status status = rig_open(&r, b->options, b->scene, sets);
    if (status != KD_OK)
        return status;
    status = rig_run(&r, VOXEL_BENCH_WARM_UP);
    if (status == KD_OK)
        status = rig_measure(&r, b->frames, NULL, NULL, out);
    rig_close(&r);
    return status;
}

bool voxel_bench_wanted(const voxel_bench *b, const char *name)
{
    return !b->options->bench_case || strstr(name, b->options->bench_case);
}

/* ---- rows ---- */

void voxel_bench_value(const voxel_bench *b, const char *name, uint64_t n, const char *unit, double value,
                       double limit)
{
    app_bench_report_row(b->json, &(kd_bench_row){.bench = b->name,
                                                  .name = name,
                                                  .n = (uint32_t)n,
                                                  .threads = b->threads,
                                                  .unit = unit,
                                                  .median = value,
                                                  .min = value,
                                                  .max = value,
                                                  .limit = limit});
}

void voxel_bench_head(const char *first)
{
    printf("%-26s %9s %9s %8s | %8s %9s %11s %8s %8s | %8s %7s\n", first, "voxels", "cells", "nodes", "io",
           "transform", "reconstruct", "average", "sum ms", "ns/voxel", "MB");
}

static uint64_t all_nodes(const rig_figures *f)
{
    return f->nodes[0] + f->nodes[1] + f->nodes[2] + f->nodes[3];
}

static double per_voxel_ns(const rig_figures *f)
{
    return f->voxels ? rig_tree_ms(f) * 1e6 / (double)f->voxels : 0;
}

void voxel_bench_row(const voxel_bench *b, const char *name, const char *label, const rig_figures *f)
{
    char key[96];
    printf("%-26s %9llu %9llu %8llu | %8.2f %9.2f %11.2f %8.2f %8.2f | %8.1f %7.1f%s\n", label,
           (unsigned long long)f->voxels, (unsigned long long)f->cells, (unsigned long long)all_nodes(f),
           f->stages[RIG_IO].median_ms, f->stages[RIG_TRANSFORM].median_ms, f->stages[RIG_BUILD].median_ms,
           f->stages[RIG_FILTER].median_ms, rig_total_ms(f), per_voxel_ns(f), (double)f->gpu_bytes * 1e-6,
           f->warnings ? "  (incomplete: see the warnings)" : "");
    fflush(stdout);
    for (int s = 0; s < RIG_STAGE_COUNT; s++) {
        double limit = b->copy_rate > 0 ? (double)traffic_of(f, (rig_stage)s) / b->copy_rate * 1e3 : 0;
        snprintf(key, sizeof key, "%s/%s", name, rig_stage_names[s]);
        app_bench_report_row(b->json, &(kd_bench_row){.bench = b->name,
                                                      .name = key,
                                                      .n = (uint32_t)f->voxels,
                                                      .threads = b->threads,
                                                      .unit = "ms",
                                                      .median = f->stages[s].median_ms,
                                                      .min = f->stages[s].min_ms,
                                                      .max = f->stages[s].max_ms,
                                                      .limit = limit});
    }
}

void voxel_bench_traffic(const voxel_bench *b, const char *name, const rig_figures *f)
{
    char key[96];
    printf("%-26s %-12s %10s %10s %8s %8s\n", name, "must move", "MB", "ms", "GB/s", "of copy");
    for (int s = 0; s < RIG_STAGE_COUNT; s++) {
        double bytes = (double)traffic_of(f, (rig_stage)s), ms = f->stages[s].median_ms;
        double rate = ms > 0 ? bytes / (ms * 1e-3) : 0;
        printf("%-26s %-12s %10.2f %10.2f %8.3f %7.1f%%\n", "", rig_stage_names[s], bytes * 1e-6, ms,
               rate * 1e-9, b->copy_rate > 0 ? 100 * rate / b->copy_rate : 0);
        snprintf(key, sizeof key, "%s/%s/bandwidth", name, rig_stage_names[s]);
        voxel_bench_value(b, key, f->voxels, "GB/s", rate * 1e-9, b->copy_rate * 1e-9);
    }
    printf("%-26s caches %.1f MB, pages %.1f MB, tree %.1f MB\n", "", (double)f->cache_bytes * 1e-6,
           (double)f->page_bytes * 1e-6, (double)f->tree_bytes * 1e-6);
}

void voxel_bench_fit(const voxel_bench *b, const char *name, const rig_figures *rows, uint32_t count)
{
    enum { MOST = 16 };
    double x[MOST], y[MOST];
    char key[96];
    count = count < MOST ? count : MOST;
    if (count < 2)
        return;
    for (uint32_t i = 0; i < count; i++) {
        x[i] = (double)rows[i].voxels * 1e-6;
        y[i] = rig_tree_ms(&rows[i]);
    }
    fit_line line = fit_points(x, y, count);
    printf(
        "transform + reconstruct + average = %.2f ms + %.1f ms a million voxels (%.1f ns a voxel), R2 %.4f\n",
        line.intercept, line.slope, line.slope, line.r2);
    snprintf(key, sizeof key, "%s/slope", name);
    voxel_bench_value(b, key, count, "ns/voxel", line.slope, 0);
    snprintf(key, sizeof key, "%s/intercept", name);
    voxel_bench_value(b, key, count, "ms", line.intercept, 0);
    snprintf(key, sizeof key, "%s/r2", name);
    voxel_bench_value(b, key, count, "share", line.r2, 0);
}

/* ---- the two benches ---- */

/* Nothing is measured: the scene as the command line has it, after its frames. */
static kd_status write_dump(const app_options *options, const char *scene)
{
    rig r;
    app_interrupt_install();
    kd_status status = rig_open(&r, options, scene, (const char *[]){NULL});
    if (status != KD_OK)
        return status;
    status = rig_run(&r, options->frames > 0 ? (uint32_t)options->frames : 1);
    if (status == KD_OK)
        status = dump_write(&r, options->dump);
    rig_close(&r);
    return status;
}

kd_status app_bench_voxels(const app_options *options, kd_json *json)
{
    voxel_bench b;
    kd_status status = voxel_bench_begin(&b, options, json, "voxels");
    if (status == KD_OK)
        status = voxel_bench_cascades(&b);
    return status == KD_OK ? voxel_bench_characters(&b) : status;
}

kd_status app_bench_svo(const app_options *options, kd_json *json)
{
    voxel_bench b;
    const char *scene;
    kd_status status = choose_scene(options, "svo", &scene);
    if (status == KD_OK && options->dump)
        return write_dump(options, scene);
    if (status == KD_OK)
        status = voxel_bench_begin(&b, options, json, "svo");
    if (status == KD_OK)
        status = voxel_bench_builds(&b);
    return status == KD_OK ? voxel_bench_layers(&b) : status;
}
