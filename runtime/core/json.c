#include "runtime/core/json.h"

#include <assert.h>
#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static void append(kd_json *j, const char *bytes, size_t count)
{
    if (j->failed)
        return;
    if (j->size + count + 1 > j->capacity) {
        size_t capacity = (j->size + count + 1) * 2;
        capacity = capacity < 1024 ? 1024 : capacity;
        char *text = realloc(j->text, capacity);
        if (!text) {
            j->failed = true;
            return;
        }
        j->text = text;
        j->capacity = capacity;
    }
    memcpy(j->text + j->size, bytes, count);
    j->size += count;
    j->text[j->size] = '\0';
}

static void append_text(kd_json *j, const char *text)
{
    append(j, text, strlen(text));
}

static void new_line(kd_json *j)
{
    if (j->indent <= 0)
        return;
    append(j, "\n", 1);
    for (int i = 0; i < j->indent * j->depth; i++)
        append(j, " ", 1);
}

/* What stands before a value or a key: nothing behind a key, else a comma where the container has items
 * already. */
static void separate(kd_json *j)
{
    if (j->after_key) {
        j->after_key = false;
        return;
    }
    if (j->depth == 0)
        return;
    uint32_t bit = 1u << (j->depth - 1);
    if (j->filled & bit)
        append(j, ",", 1);
    j->filled |= bit;
    new_line(j);
}

static void begin(kd_json *j, const char *bracket)
{
    assert(j->depth < KD_JSON_MAX_DEPTH);
    separate(j);
    append_text(j, bracket);
    j->filled &= ~(1u << j->depth);
    j->depth++;
}

static void end(kd_json *j, const char *bracket)
{
    assert(j->depth > 0 && !j->after_key);
    j->depth--;
    if (j->filled & 1u << j->depth)
        new_line(j);
    append_text(j, bracket);
}

void kd_json_object_begin(kd_json *j)
{
    begin(j, "{");
}

void kd_json_object_end(kd_json *j)
{
    end(j, "}");
}

void kd_json_array_begin(kd_json *j)
{
    begin(j, "[");
}

void kd_json_array_end(kd_json *j)
{
    end(j, "]");
}

/* Length of the UTF-8 sequence at p, or 0 if it is malformed (overlong and surrogate forms included). */
static size_t utf8_length(const unsigned char *p)
{
    if (p[0] < 0x80)
        return 1;
    size_t length = p[0] >= 0xC2 && p[0] <= 0xDF   ? 2
                    : (p[0] & 0xF0) == 0xE0        ? 3
                    : p[0] >= 0xF0 && p[0] <= 0xF4 ? 4
                                                   : 0;
    for (size_t i = 1; i < length; i++)
        if ((p[i] & 0xC0) != 0x80)
            return 0;
    bool overlong = (p[0] == 0xE0 && p[1] < 0xA0) || (p[0] == 0xF0 && p[1] < 0x90);
    bool outside = (p[0] == 0xED && p[1] > 0x9F) || (p[0] == 0xF4 && p[1] > 0x8F);
    return overlong || outside ? 0 : length;
}

static void append_escaped(kd_json *j, const char *text)
{
    append(j, "\"", 1);
    for (const unsigned char *p = (const unsigned char *)text; *p;) {
        size_t length = utf8_length(p);
        char escape[8];
        if (length == 0) {
            append_text(j, "\\ufffd");
        } else if (*p == '"' || *p == '\\') {
            append(j, (char[]){'\\', (char)*p}, 2);
        } else if (*p == '\n' || *p == '\t' || *p == '\r') {
            append(j, (char[]){'\\', *p == '\n' ? 'n' : *p == '\t' ? 't' : 'r'}, 2);
        } else if (*p < 0x20) {
            snprintf(escape, sizeof escape, "\\u%04x", *p);
            append_text(j, escape);
        } else {
            append(j, (const char *)p, length);
        }
        p += length ? length : 1;
    }
    append(j, "\"", 1);
}

void kd_json_key(kd_json *j, const char *key)
{
    assert(j->depth > 0 && !j->after_key);
    separate(j);
    append_escaped(j, key);
    append_text(j, j->indent > 0 ? ": " : ":");
    j->after_key = true;
}

void kd_json_string(kd_json *j, const char *text)
{
    if (!text) {
        kd_json_null(j);
        return;
    }
    separate(j);
    append_escaped(j, text);
}

void kd_json_int(kd_json *j, int64_t value)
{
    char text[32];
    snprintf(text, sizeof text, "%" PRId64, value);
    separate(j);
    append_text(j, text);
}

void kd_json_uint(kd_json *j, uint64_t value)
{
    char text[32];
    snprintf(text, sizeof text, "%" PRIu64, value);
    separate(j);
    append_text(j, text);
}

void kd_json_double(kd_json *j, double value)
{
    if (!isfinite(value)) {
        kd_json_null(j);
        return;
    }
    char text[40];
    for (int digits = 6; digits <= 17; digits++) {
        snprintf(text, sizeof text, "%.*g", digits, value);
        if (strtod(text, NULL) == value)
            break;
    }
    char *comma = strchr(text, ','); /* an embedding program may have set a locale */
    if (comma)
        *comma = '.';
    separate(j);
    append_text(j, text);
}

void kd_json_bool(kd_json *j, bool value)
{
    separate(j);
    append_text(j, value ? "true" : "false");
}

void kd_json_null(kd_json *j)
{
    separate(j);
    append_text(j, "null");
}

const char *kd_json_text(const kd_json *j)
{
    return j->failed ? NULL : j->text ? j->text : "";
}

void kd_json_fini(kd_json *j)
{
    free(j->text);
    *j = (kd_json){.indent = j->indent};
}
