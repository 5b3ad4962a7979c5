#include "runtime/app/comparison.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "runtime/app/app.h"
#include "runtime/compare/compare.h"
#include "runtime/core/color.h"
#include "runtime/core/file.h"
#include "runtime/core/json.h"
#include "runtime/core/log.h"

/* ---- measuring ---- */

static double mean_of(const app_picture *p)
{
    size_t count = (size_t)p->width * p->height * 3;
    double sum = 0;
    for (size_t i = 0; i < count; i++)
        sum += (double)p->rgb[i];
    return sum / (double)count;
}

/* Radiance may not be negative; a filter that made it so is taken as black. */
static void clip_negative(app_picture *p)
{
    for (size_t i = 0; i < (size_t)p->width * p->height * 3; i++)
        p->rgb[i] = fmaxf(p->rgb[i], 0);
}

static kd_status measure_radiance(app_pair *pair)
{
    uint32_t w = pair->test.width, h = pair->test.height;
    app_difference *d = &pair->difference;
    kd_flip_exposures exposures;
    clip_negative(&pair->test);
    clip_negative(&pair->reference);
    d->relative_mse = kd_relative_mse(pair->test.rgb, pair->reference.rgb, w, h);
    d->mean_ratio = mean_of(&pair->test) / mean_of(&pair->reference);
    kd_status status = kd_flip_exposures_of(pair->reference.rgb, w, h, &exposures);
    return status == KD_OK
               ? kd_flip_hdr(pair->test.rgb, pair->reference.rgb, w, h, 0, &exposures, NULL, &d->hdr_flip)
               : status;
}

kd_status app_pair_measure(app_pair *pair, float exposure, kd_tonemap curve, bool light)
{
    app_difference *d = &pair->difference;
    uint32_t w = pair->test.width, h = pair->test.height;
    *d = (app_difference){NAN, NAN, NAN, NAN, NAN};
    kd_status status = app_picture_encode(&pair->test, exposure, curve, &pair->shown[0]);
    if (status == KD_OK)
        status = app_picture_encode(&pair->reference, exposure, curve, &pair->shown[1]);
    if (status != KD_OK)
        return status;
    pair->map = malloc((size_t)w * h * sizeof *pair->map);
    if (!pair->map)
        return kd_fail(KD_NO_MEMORY, "no memory for pictures of %ux%u; choose a smaller size", w, h);
    status = kd_flip_ldr(pair->shown[0].rgb, pair->shown[1].rgb, w, h, 0, pair->map, &d->flip);
    if (status == KD_OK)
        status = kd_ssim(pair->shown[0].rgb, pair->shown[1].rgb, w, h, &d->ssim);
    if (status == KD_OK && light && !pair->test.encoded && !pair->reference.encoded)
        status = measure_radiance(pair);
    return status;
}

void app_pair_fini(app_pair *pair)
{
    app_picture_fini(&pair->test);
    app_picture_fini(&pair->reference);
    app_picture_fini(&pair->shown[0]);
    app_picture_fini(&pair->shown[1]);
    free(pair->map);
    *pair = (app_pair){0};
}

kd_status app_pair_heat(const app_pair *pair, app_picture *out)
{
    kd_status status = app_picture_make(out, pair->test.width, pair->test.height);
    out->encoded = true;
    for (size_t i = 0; status == KD_OK && i < (size_t)out->width * out->height; i++)
        kd_heat_color(pair->map[i], out->rgb + i * 3);
    return status;
}

/* ---- the table ---- */

static void print_figure(double value, const char *format, int width)
{
    char text[32] = "-";
    if (!isnan(value))
        snprintf(text, sizeof text, format, value);
    printf(" %*s", width, text);
}

void app_comparison_print(const app_comparison *c)
{
    printf("%s, %ux%u, against %s\n", c->title, c->width, c->height, c->reference);
    printf("%-24s %9s %9s %9s %9s %9s %9s %9s %9s\n", "", "FLIP", "HDR-FLIP", "relMSE", "SSIM", "mean",
           "ms/frame", "MiB", "traced s");
    for (uint32_t r = 0; r < c->row_count; r++) {
        const app_row *row = &c->rows[r];
        for (uint32_t i = row->first_pair; i < row->first_pair + row->pair_count; i++) {
            const app_difference *d = &c->pairs[i].difference;
            printf("%-24s", c->pairs[i].name);
            print_figure(d->flip, "%.4f", 9);
            print_figure(d->hdr_flip, "%.4f", 9);
            print_figure(d->relative_mse, "%.4g", 9);
            print_figure(d->ssim, "%.4f", 9);
            print_figure(d->mean_ratio, "%.4f", 9);
            print_figure(i == row->first_pair ? row->frame_ms : NAN, "%.1f", 9);
            bool bytes = i == row->first_pair && row->gpu_bytes;
            print_figure(bytes ? (double)row->gpu_bytes / (1 << 20) : NAN, "%.1f", 9);
            print_figure(c->pairs[i].tracer_s, "%.3g", 9);
            printf("\n");
        }
    }
}

/* ---- JSON ---- */

static void put_double(kd_json *j, const char *key, double value)
{
    kd_json_key(j, key);
    kd_json_double(j, value);
}

static void put_pair(kd_json *j, const app_pair *pair)
{
    kd_json_object_begin(j);
    kd_json_key(j, "picture");
    kd_json_string(j, pair->name);
    put_double(j, "flip_ldr", pair->difference.flip);
    put_double(j, "flip_hdr", pair->difference.hdr_flip);
    put_double(j, "relmse", pair->difference.relative_mse);
    put_double(j, "ssim", pair->difference.ssim);
    put_double(j, "mean_ratio", pair->difference.mean_ratio);
    put_double(j, "traced_s", pair->tracer_s);
    kd_json_object_end(j);
}

static void put_row(kd_json *j, const app_comparison *c, const app_row *row)
{
    kd_json_object_begin(j);
    kd_json_key(j, "technique");
    kd_json_string(j, row->name);
    put_double(j, "frame_ms", row->frame_ms);
    put_double(j, "gi_ms", row->gi_ms);
    kd_json_key(j, "gpu_bytes");
    kd_json_uint(j, row->gpu_bytes);
    kd_json_key(j, "terms");
    kd_json_array_begin(j);
    for (uint32_t i = row->first_pair; i < row->first_pair + row->pair_count; i++)
        put_pair(j, &c->pairs[i]);
    kd_json_array_end(j);
    kd_json_object_end(j);
}

kd_status app_comparison_write_json(const char *path, const app_comparison *c)
{
    kd_json j = {.indent = 2};
    kd_json_object_begin(&j);
    kd_json_key(&j, "kandil");
    kd_json_string(&j, KD_VERSION);
    kd_json_key(&j, "scene");
    kd_json_string(&j, c->title);
    kd_json_key(&j, "reference");
    kd_json_string(&j, c->reference);
    kd_json_key(&j, "size");
    kd_json_array_begin(&j);
    kd_json_uint(&j, c->width);
    kd_json_uint(&j, c->height);
    kd_json_array_end(&j);
    kd_json_key(&j, "techniques");
    kd_json_array_begin(&j);
    for (uint32_t r = 0; r < c->row_count; r++)
        put_row(&j, c, &c->rows[r]);
    kd_json_array_end(&j);
    kd_json_object_end(&j);
    const char *text = kd_json_text(&j);
    kd_status status =
        text ? kd_file_write(path, text, strlen(text)) : kd_fail(KD_NO_MEMORY, "%s: out of memory", path);
    kd_json_fini(&j);
    return status;
}
