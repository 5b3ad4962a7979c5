/* Samples to pictures: passes over tiles, each pixel's sums kept by the thread that has its tile. Sums are
 * added in the order of the samples, so neither threads nor the size of passes change a bit. */

#include "runtime/reference/reference.h"

#include <math.h>
#include <stdatomic.h>
#include <stdlib.h>

#include "components/frame.h"
#include "runtime/core/clock.h"
#include "runtime/core/log.h"
#include "runtime/reference/internal.h"

enum { TILE = 16, DEFAULT_SPP = 64 };
static const double PASS_S = 0.5; /* aim of a pass: progress and interrupts are seen that often */

typedef struct pixel_sums {
    double direct[3], diffuse[3], specular[3], albedo[3], normal[3];
    double ao, depth;
    double squares, indirect_squares; /* of the luminance of samples, whole and indirect part */
} pixel_sums;

struct kd_reference {
    kd_reference_desc desc;
    kd_jobs *jobs;
    reference_scene scene;
    reference_options options;
    sampler_tables tables;
    pixel_sums *pixels;
    uint32_t tiles_x, tiles_y;
    uint32_t begin, end; /* samples of this pass */
    uint32_t done;
    double build_s, trace_s;
    _Atomic uint64_t rays, bad;
};

/* ---- making ---- */

static void read_settings(kd_reference *r, const kd_settings *settings)
{
    float distance = settings->cones_max_distance;
    r->options = (reference_options){.bounces = r->desc.bounces,
                                     .area_bounces = r->desc.bounces - (r->desc.gathered ? 1 : 0),
                                     .centre = r->desc.centre,
                                     .ambient_occlusion = r->desc.ambient_occlusion,
                                     .ao_falloff = settings->ao_falloff,
                                     .ao_intensity = settings->ao_intensity,
                                     .ao_distance = distance > 0 ? distance : INFINITY,
                                     .seed = r->desc.seed};
}

static kd_status make_pixels(kd_reference *r)
{
    const kd_view *view = &r->scene.view;
    r->tiles_x = (view->width + TILE - 1) / TILE;
    r->tiles_y = (view->height + TILE - 1) / TILE;
    r->pixels = calloc((size_t)view->width * view->height, sizeof *r->pixels);
    return r->pixels
               ? KD_OK
               : kd_fail(KD_NO_MEMORY, "reference: out of memory for %ux%u pixels; choose a smaller size",
                         view->width, view->height);
}

kd_status kd_reference_open(kd_world *w, kd_jobs *jobs, const kd_reference_desc *desc, kd_reference **out)
{
    kd_reference *r = calloc(1, sizeof *r);
    *out = NULL;
    if (!r)
        return kd_fail(KD_NO_MEMORY, "reference: out of memory");
    uint64_t began = kd_clock_ns();
    r->desc = *desc;
    r->desc.spp = desc->spp ? desc->spp : DEFAULT_SPP;
    r->jobs = jobs;
    read_settings(r, &kd_singleton(w, kd_frame)->settings);
    sampler_tables_make(&r->tables);
    kd_status status = reference_scene_build(w, desc->lambert, &r->scene);
    if (status == KD_OK)
        status = make_pixels(r);
    r->build_s = (double)(kd_clock_ns() - began) * 1e-9;
    if (status != KD_OK) {
        kd_reference_close(r);
        return status;
    }
    *out = r;
    return KD_OK;
}

void kd_reference_close(kd_reference *r)
{
    if (!r)
        return;
    reference_scene_fini(&r->scene);
    free(r->pixels);
    free(r);
}

/* ---- tracing ---- */

static bool finite3(kd_vec3 v)
{
    return isfinite(v.x) && isfinite(v.y) && isfinite(v.z);
}

static void add3(double sum[3], kd_vec3 v)
{
    sum[0] += (double)v.x;
    sum[1] += (double)v.y;
    sum[2] += (double)v.z;
}

static void add_sample(kd_reference *r, pixel_sums *p, const reference_sample *s)
{
    if (!finite3(s->direct) || !finite3(s->diffuse) || !finite3(s->specular)) {
        atomic_fetch_add_explicit(&r->bad, 1, memory_order_relaxed);
        return;
    }
    double y = (double)reference_luminance(kd_vec3_add(s->direct, kd_vec3_add(s->diffuse, s->specular)));
    add3(p->direct, s->direct);
    add3(p->diffuse, s->diffuse);
    add3(p->specular, s->specular);
    add3(p->albedo, s->albedo);
    add3(p->normal, s->normal);
    p->ao += (double)s->ao;
    p->depth += (double)s->depth;
    double z = (double)reference_luminance(kd_vec3_add(s->diffuse, s->specular));
    p->squares += y * y;
    p->indirect_squares += z * z;
}

static uint64_t trace_pixel(kd_reference *r, uint32_t x, uint32_t y)
{
    pixel_sums *p = &r->pixels[(size_t)y * r->scene.view.width + x];
    uint64_t rays = 0;
    for (uint32_t i = r->begin; i < r->end; i++) {
        reference_sample s;
        reference_path(&r->scene, &r->options, &r->tables, x, y, i, &s);
        add_sample(r, p, &s);
        rays += s.rays;
    }
    return rays;
}

static void trace_tiles(void *user, uint32_t begin, uint32_t end, uint32_t worker)
{
    kd_reference *r = user;
    uint64_t rays = 0;
    (void)worker;
    for (uint32_t tile = begin; tile < end; tile++) {
        uint32_t x0 = tile % r->tiles_x * TILE, y0 = tile / r->tiles_x * TILE;
        for (uint32_t y = y0; y < y0 + TILE && y < r->scene.view.height; y++)
            for (uint32_t x = x0; x < x0 + TILE && x < r->scene.view.width; x++)
                rays += trace_pixel(r, x, y);
    }
    atomic_fetch_add_explicit(&r->rays, rays, memory_order_relaxed);
}

/* Mean over the pixels of the variance of their mean, over its square: what relMSE against the truth would
 * be. 0.01 as there, so that black pixels count little. */
static double estimate_noise(const kd_reference *r, bool indirect)
{
    size_t count = (size_t)r->scene.view.width * r->scene.view.height;
    double n = r->done, sum = 0;
    for (size_t i = 0; i < count; i++) {
        const pixel_sums *p = &r->pixels[i];
        double c[3];
        for (int k = 0; k < 3; k++)
            c[k] = ((indirect ? 0 : p->direct[k]) + p->diffuse[k] + p->specular[k]) / n;
        double mean = 0.2126 * c[0] + 0.7152 * c[1] + 0.0722 * c[2];
        double squares = indirect ? p->indirect_squares : p->squares;
        sum += fmax(squares / n - mean * mean, 0) / n / (mean * mean + 0.01);
    }
    return n > 1 ? sum / (double)count : INFINITY;
}

/* The next pass' samples, from the time that the last one took for each. */
static uint32_t next_pass(const kd_reference *r, double sample_s)
{
    double wanted = sample_s > 0 ? PASS_S / sample_s : 1;
    uint32_t left = r->desc.spp - r->done, most = r->done ? r->done : 1;
    uint32_t pass = wanted < 1 ? 1 : wanted > (double)most ? most : (uint32_t)wanted;
    return pass < left ? pass : left;
}

static bool is_enough(const kd_reference *r)
{
    return r->done == r->desc.spp || (r->desc.time_budget_s > 0 && r->trace_s >= r->desc.time_budget_s) ||
           (r->desc.noise > 0 && r->done >= 16 && estimate_noise(r, false) <= r->desc.noise);
}

kd_status kd_reference_render(kd_reference *r)
{
    double sample_s = 0;
    while (!is_enough(r)) {
        uint64_t began = kd_clock_ns();
        r->begin = r->done;
        r->end = r->done + next_pass(r, sample_s);
        kd_jobs_parallel_for(r->jobs, r->tiles_x * r->tiles_y, 1, trace_tiles, r);
        double pass_s = (double)(kd_clock_ns() - began) * 1e-9;
        sample_s = pass_s / (double)(r->end - r->begin);
        r->trace_s += pass_s;
        r->done = r->end;
        if (r->desc.progress && !r->desc.progress(r->desc.user, r->done, r->desc.spp, pass_s * 1e3))
            return r->done == r->desc.spp ? KD_OK : KD_INTERRUPTED;
    }
    return KD_OK;
}

/* ---- results ---- */

static double component(const reference_options *o, const pixel_sums *p, kd_reference_term term, int k,
                        double n)
{
    switch (term) {
    case KD_REFERENCE_FINAL: return (p->direct[k] + p->diffuse[k] + p->specular[k]) / n;
    case KD_REFERENCE_DIRECT: return p->direct[k] / n;
    case KD_REFERENCE_INDIRECT: return (p->diffuse[k] + p->specular[k]) / n;
    case KD_REFERENCE_DIFFUSE: return p->diffuse[k] / n;
    case KD_REFERENCE_SPECULAR: return p->specular[k] / n;
    case KD_REFERENCE_AO: return fmin(fmax(1 - (double)o->ao_intensity * (1 - p->ao / n), 0), 1);
    case KD_REFERENCE_ALBEDO: return p->albedo[k] / n;
    case KD_REFERENCE_NORMAL: return p->normal[k] / n;
    case KD_REFERENCE_DEPTH: return p->depth / n;
    case KD_REFERENCE_TERM_COUNT: break;
    }
    return 0;
}

void kd_reference_read(const kd_reference *r, kd_reference_term term, float *rgb)
{
    size_t count = (size_t)r->scene.view.width * r->scene.view.height;
    double n = r->done ? r->done : 1;
    for (size_t i = 0; i < count; i++)
        for (int k = 0; k < 3; k++)
            rgb[i * 3 + (size_t)k] = (float)component(&r->options, &r->pixels[i], term, k, n);
}

kd_reference_info kd_reference_get_info(const kd_reference *r)
{
    return (kd_reference_info){.width = r->scene.view.width,
                               .height = r->scene.view.height,
                               .spp = r->done,
                               .triangles = r->scene.triangle_count,
                               .emitters = r->scene.emitter_count,
                               .lights = r->scene.light_count,
                               .rays = r->rays,
                               .build_s = r->build_s,
                               .trace_s = r->trace_s,
                               .noise = estimate_noise(r, false),
                               .indirect_noise = estimate_noise(r, true),
                               .bad_samples = r->bad};
}
