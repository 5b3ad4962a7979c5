#ifndef KD_PROFILE_JSON_READ_H
#define KD_PROFILE_JSON_READ_H

/* Reading of JSON from front to back, without building a tree: what is not wanted is skipped, however deep. A
 * mistake in the text sets `failed`; every call then says that there is nothing more.
 *
 *     for (json_begin(&r, '{'); json_next_key(&r, key, sizeof key);)
 *         if (strcmp(key, "frames") == 0) n = json_number(&r); else json_skip(&r); */

#include <stdbool.h>
#include <stddef.h>

typedef struct json_reader {
    const char *at, *end;
    bool failed;
} json_reader;

void json_begin(json_reader *r, char bracket); /* '{' or '[' */
/** Go to the next key of the object, or past its end. Long ones are cut. */
bool json_next_key(json_reader *r, char *key, size_t size);
bool json_next_item(json_reader *r); /* of the array */
double json_number(json_reader *r);
void json_string(json_reader *r, char *out, size_t size);
void json_skip(json_reader *r); /* any value */

#endif
