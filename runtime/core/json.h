#ifndef KD_CORE_JSON_H
#define KD_CORE_JSON_H

/* A streaming JSON writer into one growing buffer. Commas and indentation come by themselves; begin and end
 * must match.
 *
 *     kd_json j = {.indent = 2};
 *     kd_json_object_begin(&j);
 *     kd_json_key(&j, "frames");
 *     kd_json_int(&j, 8);
 *     kd_json_object_end(&j);
 *     … kd_json_text(&j) … kd_json_fini(&j);
 *
 * When memory runs out the text becomes NULL and further calls do nothing: check once, at the end. */

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#define KD_JSON_MAX_DEPTH 32

typedef struct kd_json {
    char *text;
    size_t size, capacity;
    int indent; /* blanks a level; 0 writes everything in one line */
    int depth;
    uint32_t filled; /* bit d: the container at depth d has an item already */
    bool after_key, failed;
} kd_json;

void kd_json_object_begin(kd_json *j);
void kd_json_object_end(kd_json *j);
void kd_json_array_begin(kd_json *j);
void kd_json_array_end(kd_json *j);
void kd_json_key(kd_json *j, const char *key);

/** Write a string; NULL gives null, bytes that are no UTF-8 become U+FFFD. */
void kd_json_string(kd_json *j, const char *text);
void kd_json_int(kd_json *j, int64_t value);
void kd_json_uint(kd_json *j, uint64_t value);
/** Write the shortest text that reads back equal; NaN and infinity give null. */
void kd_json_double(kd_json *j, double value);
void kd_json_bool(kd_json *j, bool value);
void kd_json_null(kd_json *j);

/** Get the text, NUL-terminated, without a newline at its end. Returns NULL when memory ran out; "" before
 * any item. */
const char *kd_json_text(const kd_json *j);
void kd_json_fini(kd_json *j);

#endif
