#include "runtime/core/settings.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

#include "runtime/core/log.h"

#define WORD(name, text) text,
static const char *const binding_words[] = {KD_BINDING_LIST(WORD) NULL};
static const char *const layers_words[] = {KD_SVO_LAYERS_LIST(WORD) NULL};
static const char *const build_words[] = {KD_SVO_BUILD_LIST(WORD) NULL};
static const char *const bounces_words[] = {KD_BOUNCES_LIST(WORD) NULL};
static const char *const tiles_words[] = {KD_TILES_LIST(WORD) NULL};
static const char *const leak_words[] = {KD_LEAK_LIST(WORD) NULL};
static const char *const interpolation_words[] = {KD_CONES_LIST(WORD) NULL};
static const char *const tonemap_words[] = {KD_TONEMAP_LIST(WORD) NULL};
static const char *const channel_words[] = {KD_CHANNEL_LIST(WORD) NULL};
static const char *const separating_words[] = {"6", "26", NULL};
static const char *const depth_words[] = {"8", "16", NULL};
static const char *const resolution_words[] = {"128", "256", "512", "1024", NULL};

static const kd_setting_row rows[] = {
#define ROW(type_, group, name, default_, min_, max_, words_, unit_, doc_)                                   \
    {.key = #group "." #name,                                                                                \
     .type = KD_SETTING_##type_,                                                                             \
     .offset = offsetof(kd_settings, group##_##name),                                                        \
     .default_value = (double)(default_),                                                                    \
     .min = (min_),                                                                                          \
     .max = (max_),                                                                                          \
     .words = (words_),                                                                                      \
     .unit = (unit_),                                                                                        \
     .doc = (doc_)},
    KD_SETTINGS_LIST(ROW)
#undef ROW
};
enum { ROW_COUNT = sizeof rows / sizeof rows[0], NEAR_MISSES = 3 };

kd_settings kd_settings_defaults(void)
{
    return (kd_settings){
#define DEFAULT(type, group, name, default_, min, max, words, unit, doc) .group##_##name = (default_),
        KD_SETTINGS_LIST(DEFAULT)
#undef DEFAULT
    };
}

const kd_setting_row *kd_settings_rows(size_t *count)
{
    *count = ROW_COUNT;
    return rows;
}

const kd_setting_row *kd_settings_find(const char *key, size_t key_length)
{
    for (size_t i = 0; i < ROW_COUNT; i++)
        if (strlen(rows[i].key) == key_length && memcmp(rows[i].key, key, key_length) == 0)
            return &rows[i];
    return NULL;
}

/* ---- an unknown key: name those that look alike ---- */

/* Edit distance, letters compared without case. Source: Wagner, Fischer 1974. */
static size_t distance(const char *a, size_t a_length, const char *b)
{
    size_t row[64], b_length = strlen(b);
    for (size_t j = 0; j <= b_length; j++)
        row[j] = j;
    for (size_t i = 1; i <= a_length; i++) {
        size_t diagonal = row[0];
        row[0] = i;
        for (size_t j = 1; j <= b_length; j++) {
            size_t changed = diagonal + (strncasecmp(&a[i - 1], &b[j - 1], 1) != 0);
            size_t added = row[j - 1] + 1, removed = row[j] + 1;
            diagonal = row[j];
            row[j] = changed < added ? changed : added;
            row[j] = removed < row[j] ? removed : row[j];
        }
    }
    return row[b_length];
}

/* 0 is closest; a key that is the last part of a row's key ("span") counts as one slip. */
static size_t unlikeness(const char *key, size_t key_length, const kd_setting_row *row)
{
    const char *last = strchr(row->key, '.') + 1;
    size_t whole = distance(key, key_length, row->key);
    size_t part = distance(key, key_length, last) + 1;
    return whole < part ? whole : part;
}

static kd_status fail_unknown(const char *key, size_t key_length)
{
    char misses[NEAR_MISSES * 40] = "";
    size_t used = 0;
    size_t allowed = key_length / 3 < 2 ? 2 : key_length / 3 > 4 ? 4 : key_length / 3;
    int named = 0;
    for (size_t d = 0; d <= allowed && key_length < 64; d++)
        for (size_t i = 0; i < ROW_COUNT && named < NEAR_MISSES; i++)
            if (unlikeness(key, key_length, &rows[i]) == d) {
                used += (size_t)snprintf(misses + used, sizeof misses - used, "%s%s", named ? ", " : "",
                                         rows[i].key);
                named++;
            }
    if (named)
        return kd_fail(KD_USAGE,
                       "--set %.*s: no such setting; did you mean %s? (`kandil help settings` lists all)",
                       (int)(key_length < 80 ? key_length : 80), key, misses);
    return kd_fail(KD_USAGE, "--set %.*s: no such setting; `kandil help settings` lists all",
                   (int)(key_length < 80 ? key_length : 80), key);
}

/* ---- values ---- */

/* Say what a row takes, as "0.0001 to 100 m" or "aces, reinhard or linear". */
static const char *describe(const kd_setting_row *row, char *out, size_t out_size)
{
    const char *unit = row->unit ? row->unit : "", *blank = row->unit ? " " : "";
    if (row->type == KD_SETTING_BOOL) {
        snprintf(out, out_size, "on or off");
    } else if (row->words) {
        size_t used = 0;
        for (size_t i = 0; row->words[i] && used < out_size; i++) {
            const char *between = i == 0 ? "" : row->words[i + 1] ? ", " : " or ";
            used += (size_t)snprintf(out + used, out_size - used, "%s%s", between, row->words[i]);
        }
    } else {
        snprintf(out, out_size, "a%s number from %.9g to %.9g%s%s",
                 row->type == KD_SETTING_I32 ? " whole" : "", row->min, row->max, blank, unit);
    }
    return out;
}

static int find_word(const char *const *words, const char *text)
{
    for (int i = 0; words[i]; i++)
        if (strcmp(words[i], text) == 0)
            return i;
    return -1;
}

static bool parse_bool(const char *text, double *value)
{
    static const char *const words[] = {"false", "true", "off", "on", "no", "yes", "0", "1", NULL};
    int word = find_word(words, text);
    *value = word & 1;
    return word >= 0;
}

static bool parse_number(const kd_setting_row *row, const char *text, double *value)
{
    char *end = NULL;
    if (!text[0] || strchr(" \t\n\r\f\v", text[0]))
        return false;
    *value = row->type == KD_SETTING_I32 ? (double)strtol(text, &end, 10) : strtod(text, &end);
    if (*end || !isfinite(*value) || *value < row->min || *value > row->max)
        return false;
    return !row->words || find_word(row->words, text) >= 0;
}

static bool parse_value(const kd_setting_row *row, const char *text, double *value)
{
    if (row->type == KD_SETTING_BOOL)
        return parse_bool(text, value);
    if (row->type == KD_SETTING_ENUM) {
        int word = find_word(row->words, text);
        *value = word;
        return word >= 0;
    }
    return parse_number(row, text, value);
}

static void store(kd_settings *settings, const kd_setting_row *row, double value)
{
    unsigned char *place = (unsigned char *)settings + row->offset;
    bool as_bool = value != 0;
    float as_float = (float)value;
    if (row->type == KD_SETTING_BOOL)
        memcpy(place, &as_bool, sizeof as_bool);
    else if (row->type == KD_SETTING_F32)
        memcpy(place, &as_float, sizeof as_float);
    else
        memcpy(place, &(int32_t){(int32_t)value}, sizeof(int32_t));
}

kd_status kd_settings_set(kd_settings *settings, const char *assignment)
{
    const char *equals = strchr(assignment, '=');
    if (!equals || equals == assignment)
        return kd_fail(KD_USAGE,
                       "--set %.80s: not of the form KEY=VALUE; write for example --set voxels.span=0.05",
                       assignment);
    const kd_setting_row *row = kd_settings_find(assignment, (size_t)(equals - assignment));
    if (!row)
        return fail_unknown(assignment, (size_t)(equals - assignment));
    double value;
    if (!parse_value(row, equals + 1, &value)) {
        char allowed[128];
        return kd_fail(KD_USAGE, "--set %s: \"%.40s\" is not allowed; give %s", row->key, equals + 1,
                       describe(row, allowed, sizeof allowed));
    }
    store(settings, row, value);
    return KD_OK;
}

double kd_settings_value(const kd_settings *settings, const kd_setting_row *row)
{
    const unsigned char *place = (const unsigned char *)settings + row->offset;
    bool as_bool;
    float as_float;
    int32_t as_int;
    switch (row->type) {
    case KD_SETTING_BOOL: memcpy(&as_bool, place, sizeof as_bool); return as_bool;
    case KD_SETTING_F32: memcpy(&as_float, place, sizeof as_float); return (double)as_float;
    default: memcpy(&as_int, place, sizeof as_int); return as_int;
    }
}

/* The shortest decimals that read back equal; people read this, so only tiny numbers have an exponent. */
static void format_float(double value, char *out, size_t out_size)
{
    for (int decimals = 0; decimals <= 12; decimals++) {
        snprintf(out, out_size, "%.*f", decimals, value);
        if (strtof(out, NULL) == (float)value)
            return;
    }
    snprintf(out, out_size, "%.9g", value);
}

const char *kd_settings_format(const kd_settings *settings, const kd_setting_row *row, char *out,
                               size_t out_size)
{
    double value = kd_settings_value(settings, row);
    if (row->type == KD_SETTING_BOOL)
        snprintf(out, out_size, "%s", value != 0 ? "on" : "off");
    else if (row->type == KD_SETTING_ENUM)
        snprintf(out, out_size, "%s", row->words[(int)value]);
    else if (row->type == KD_SETTING_I32)
        snprintf(out, out_size, "%d", (int)value);
    else
        format_float(value, out, out_size);
    return out;
}
