/* `kandil compare A B`: two picture files. */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "runtime/app/comparison.h"
#include "runtime/app/technique.h"
#include "runtime/core/file.h"
#include "runtime/core/log.h"

static bool is_picture(const char *path)
{
    return kd_path_has_extension(path, ".exr") || kd_path_has_extension(path, ".png");
}

kd_status app_comparison_report(const app_options *o, const char *title, const char *reference,
                                app_pair *pairs, uint32_t count)
{
    app_row row = {.name = "picture", .frame_ms = NAN, .gi_ms = NAN, .pair_count = count};
    app_comparison c = {.title = title,
                        .width = pairs->test.width,
                        .height = pairs->test.height,
                        .rows = &row,
                        .pairs = pairs,
                        .row_count = 1,
                        .pair_count = count};
    snprintf(c.reference, sizeof c.reference, "%.120s", reference);
    app_comparison_print(&c);
    kd_status status = o->json ? app_comparison_write_json(o->json, &c) : KD_OK;
    if (status == KD_OK && o->html)
        status = app_comparison_write_html(o->html, &c);
    return status;
}

static kd_status read_pair(const app_options *o, app_pair *pair)
{
    kd_status status = app_picture_read(o->subject, &pair->test);
    if (status == KD_OK)
        status = app_picture_read(o->second, &pair->reference);
    if (status != KD_OK)
        return status;
    const app_picture *t = &pair->test, *r = &pair->reference;
    if (t->width != r->width || t->height != r->height)
        return kd_fail(KD_BAD_FORMAT, "%s: has %ux%u pixels, but %s has %ux%u; give pictures of one size",
                       o->subject, t->width, t->height, o->second, r->width, r->height);
    snprintf(pair->name, sizeof pair->name, "%.60s", kd_path_name(o->subject));
    return KD_OK;
}

static kd_status settings_of(const app_options *o, kd_settings *out)
{
    kd_status status = KD_OK;
    *out = kd_settings_defaults();
    for (uint32_t i = 0; i < o->set_count && status == KD_OK; i++)
        status = app_is_entity_field(o->sets[i])
                     ? kd_fail(KD_USAGE, "--set %s: two pictures have no entities; leave it out", o->sets[i])
                     : kd_settings_set(out, o->sets[i]);
    return status;
}

static kd_status compare_pictures(const app_options *o, const kd_settings *settings)
{
    app_pair pair = {.tracer_s = NAN};
    kd_status status = read_pair(o, &pair);
    if (status == KD_OK)
        status = app_pair_measure(&pair, app_picture_exposure(&pair.reference, settings),
                                  (kd_tonemap)settings->view_tonemap, true);
    if (status == KD_OK)
        status = app_comparison_report(o, o->subject, o->second, &pair, 1);
    app_pair_fini(&pair);
    return status;
}

kd_status app_compare_run(const app_options *o)
{
    kd_settings settings;
    if (!is_picture(o->subject) && o->temporal)
        return kd_fail(KD_USAGE,
                       "--temporal compares two frames; give two .exr that `kandil run --layers` wrote");
    if (!is_picture(o->subject))
        return o->second
                   ? kd_fail(KD_USAGE, "unexpected argument '%s'; give two pictures, or one scene", o->second)
                   : app_compare_techniques(o);
    if (!o->second)
        return kd_fail(KD_USAGE, "compare needs a second picture; write `kandil compare %s REFERENCE`",
                       o->subject);
    if (!is_picture(o->second))
        return kd_fail(KD_USAGE, "%s: unknown kind of picture; give an .exr or .png file", o->second);
    if (o->report)
        return kd_fail(KD_USAGE,
                       "--report is for techniques of a scene; give --html FILE or --json FILE with two "
                       "pictures");
    kd_status status = settings_of(o, &settings);
    if (status != KD_OK)
        return status;
    return o->temporal ? app_compare_temporal(o, &settings) : compare_pictures(o, &settings);
}
