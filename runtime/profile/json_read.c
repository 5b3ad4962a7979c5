#include "runtime/profile/json_read.h"

#include <stdlib.h>
#include <string.h>

static char peek(json_reader *r)
{
    while (!r->failed && r->at < r->end &&
           (*r->at == ' ' || *r->at == '\n' || *r->at == '\r' || *r->at == '\t'))
        r->at++;
    return !r->failed && r->at < r->end ? *r->at : '\0';
}

static void expect(json_reader *r, char c)
{
    if (peek(r) == c)
        r->at++;
    else
        r->failed = true;
}

void json_begin(json_reader *r, char bracket)
{
    expect(r, bracket);
}

/* Past the comma before the next member, or past the end. */
static bool next(json_reader *r, char closing)
{
    if (peek(r) == closing) {
        r->at++;
        return false;
    }
    if (peek(r) == ',')
        r->at++;
    r->failed = r->failed || peek(r) == '\0';
    return !r->failed;
}

bool json_next_item(json_reader *r)
{
    return next(r, ']');
}

bool json_next_key(json_reader *r, char *key, size_t size)
{
    if (!next(r, '}'))
        return false;
    json_string(r, key, size);
    expect(r, ':');
    return !r->failed;
}

/* The character that \c stands for; what \u0041 stands for is left as it is, no name has one. */
static char unescape(char c)
{
    static const char from[] = "nrtbf", to[] = "\n\r\t\b\f";
    const char *at = strchr(from, c);
    return at && c ? to[at - from] : c;
}

void json_string(json_reader *r, char *out, size_t size)
{
    size_t length = 0;
    expect(r, '"');
    while (!r->failed && r->at < r->end && *r->at != '"') {
        bool escape = *r->at == '\\' && r->end - r->at > 1;
        r->at += escape;
        if (length + 1 < size)
            out[length++] = escape ? unescape(*r->at) : *r->at;
        r->at++;
    }
    out[length] = '\0';
    expect(r, '"');
}

/* The text ends with a zero byte, so that strtod stops there. */
double json_number(json_reader *r)
{
    char *end;
    double value = peek(r) ? strtod(r->at, &end) : 0;
    if (r->failed || r->at >= r->end || end == r->at)
        r->failed = true;
    else
        r->at = end;
    return r->failed ? 0 : value;
}

void json_skip(json_reader *r)
{
    size_t depth = 0;
    char text[1];
    do {
        char c = peek(r);
        if (c == '"') {
            json_string(r, text, sizeof text);
        } else if (c == '{' || c == '[') {
            depth++;
            r->at++;
        } else if (c == '}' || c == ']') {
            if (depth-- == 0)
                r->failed = true;
            r->at++;
        } else if (c == ',' || c == ':') {
            if (depth == 0)
                r->failed = true;
            r->at++;
        } else if (c) {
            r->at += strcspn(r->at, "\",:{}[] \t\r\n");
        } else {
            r->failed = true;
        }
    } while (!r->failed && depth > 0);
}
