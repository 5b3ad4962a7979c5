#include "runtime/app/options_read.h"

#include <ctype.h>
#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "runtime/app/options.h"
#include "runtime/core/file.h"
#include "runtime/core/log.h"
#include "runtime/core/nearest.h"
#include "runtime/reference/reference.h"

int app_find_word(const char *const *words, const char *word)
{
    for (int i = 0; words[i]; i++)
        if (strcmp(words[i], word) == 0)
            return i;
    return -1;
}

kd_status app_read_integer(const char *option, const char *text, int64_t min, int64_t max, int64_t *out)
{
    char *end;
    errno = 0;
    long long value = strtoll(text, &end, 10);
    if (end == text || *end || errno || isspace((unsigned char)*text))
        return kd_fail(KD_USAGE, "%s: '%s' is not a whole number; give one from %lld to %lld", option, text,
                       (long long)min, (long long)max);
    if (value < min || value > max)
        return kd_fail(KD_USAGE, "%s: %s is out of range; give a number from %lld to %lld", option, text,
                       (long long)min, (long long)max);
    *out = value;
    return KD_OK;
}

kd_status app_read_real(const char *option, const char *text, double min, double max, double *out)
{
    char *end;
    double value = strtod(text, &end);
    if (end == text || *end || !isfinite(value) || isspace((unsigned char)*text))
        return kd_fail(KD_USAGE, "%s: '%s' is not a number; give one from %g to %g", option, text, min, max);
    if (value < min || value > max)
        return kd_fail(KD_USAGE, "%s: %s is out of range; give a number from %g to %g", option, text, min,
                       max);
    *out = value;
    return KD_OK;
}

kd_status app_read_word(const char *option, const char *text, const char *const *words, int *out)
{
    char list[256] = "";
    *out = app_find_word(words, text);
    if (*out >= 0)
        return KD_OK;
    for (int i = 0; words[i]; i++) {
        strncat(list, i ? ", " : "", sizeof list - strlen(list) - 1);
        strncat(list, words[i], sizeof list - strlen(list) - 1);
    }
    const char *near = kd_nearest_word(text, words);
    if (near)
        return kd_fail(KD_USAGE, "%s: unknown word '%s'; did you mean '%s'? There are %s", option, text, near,
                       list);
    return kd_fail(KD_USAGE, "%s: unknown word '%s'; choose one of %s", option, text, list);
}

kd_status app_read_path(const char *option, const char *text, const char **out)
{
    if (!*text)
        return kd_fail(KD_USAGE, "%s: the path is empty; give one", option);
    if (strlen(text) >= KD_PATH_MAX - 64)
        return kd_fail(KD_USAGE, "%s: the path has %zu characters; give a shorter one", option, strlen(text));
    *out = text;
    return KD_OK;
}

/* ---- what the path tracer is asked for ---- */

kd_status app_read_frame(app_options *o, const char *text)
{
    return app_read_integer("--frame", text, 0, 100000000, &o->tracing.frame);
}

kd_status app_read_spp(app_options *o, const char *text)
{
    int64_t value = 0;
    kd_status status = app_read_integer("--spp", text, 1, 1 << 24, &value);
    o->tracing.spp = (uint32_t)value;
    return status;
}

static kd_status read_bounces(app_options *o, const char *option, const char *text)
{
    int64_t value = KD_REFERENCE_ENDLESS;
    kd_status status = strcmp(text, "inf") == 0 ? KD_OK : app_read_integer(option, text, 0, 4096, &value);
    o->tracing.bounces = (int32_t)value;
    o->tracing.bounces_said = true;
    return status;
}

kd_status app_read_bounces(app_options *o, const char *text)
{
    o->tracing.gathered = false;
    return read_bounces(o, "--bounces", text);
}

kd_status app_read_gathers(app_options *o, const char *text)
{
    o->tracing.gathered = true;
    return read_bounces(o, "--gathers", text);
}

/* Read "a,b,c" as bits by the index of each word. */
static kd_status read_list(const char *option, const char *text, const char *const *words, uint32_t *bits)
{
    kd_status status = KD_OK;
    while (status == KD_OK) {
        char word[32];
        size_t length = strcspn(text, ",");
        int index = 0;
        snprintf(word, sizeof word, "%.*s", (int)(length < sizeof word ? length : sizeof word - 1), text);
        status = app_read_word(option, word, words, &index);
        if (status == KD_OK)
            *bits |= 1u << index;
        if (!text[length])
            break;
        text += length + 1;
    }
    return status;
}

kd_status app_read_terms(app_options *o, const char *text)
{
    return read_list("--terms", text, app_term_words, &o->tracing.terms);
}

kd_status app_read_techniques(app_options *o, const char *text)
{
    return read_list("--gi", text, app_gi_words, &o->techniques);
}

kd_status app_read_html(app_options *o, const char *text)
{
    return app_read_path("--html", text, &o->html);
}

kd_status app_read_report(app_options *o, const char *text)
{
    return app_read_path("--report", text, &o->report);
}

kd_status app_read_temporal(app_options *o, const char *text)
{
    (void)text;
    o->temporal = true;
    return KD_OK;
}

kd_status app_read_lambert(app_options *o, const char *text)
{
    (void)text;
    o->tracing.lambert = true;
    return KD_OK;
}

kd_status app_read_pixel(app_options *o, const char *text)
{
    static const char *const words[] = {"area", "centre", NULL};
    int word = 0;
    kd_status status = app_read_word("--pixel", text, words, &word);
    o->tracing.centre = word == 1;
    return status;
}

kd_status app_read_time_budget(app_options *o, const char *text)
{
    return app_read_real("--time-budget", text, 0, 1e9, &o->tracing.time_budget_s);
}

kd_status app_read_noise(app_options *o, const char *text)
{
    return app_read_real("--noise", text, 0, 1, &o->tracing.noise);
}
