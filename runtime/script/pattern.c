/* Lua's own matcher backtracks inside one C call that no hook can stop: "(.-)(.-)(.-)(.-)b" on a long text
 * runs for years. This one follows the same pattern language and can be stopped at every step. */
#include "runtime/script/pattern.h"

#include <ctype.h>
#include <string.h>

#define MAX_DEPTH     200 /* of recursion, as Lua's own */
#define STEPS_CHARGED 256 /* steps between two charges */

static const char *match_here(matcher *m, const char *s, const char *p);

void pattern_step(matcher *m)
{
    if (++m->steps == STEPS_CHARGED) {
        m->steps = 0;
        script_charge(m->L, STEPS_CHARGED);
    }
}

/* ---- single characters ---- */

/* Point behind the class that starts at p. */
static const char *class_end(matcher *m, const char *p)
{
    if (*p == '%') {
        if (p + 1 == m->pattern_end)
            luaL_error(m->L, "malformed pattern (ends with '%%'); write %%%% for a percent sign");
        return p + 2;
    }
    if (*p != '[')
        return p + 1;
    p++;
    if (p < m->pattern_end && *p == '^')
        p++;
    for (bool first = true; first || p >= m->pattern_end || *p != ']'; first = false) {
        if (p >= m->pattern_end)
            luaL_error(m->L, "malformed pattern (missing ']'); close the set");
        p += *p == '%' && p + 1 < m->pattern_end ? 2 : 1;
    }
    return p + 1;
}

static bool is_in_class(int c, int class)
{
    bool in;
    switch (tolower(class)) {
    case 'a': in = isalpha(c); break;
    case 'c': in = iscntrl(c); break;
    case 'd': in = isdigit(c); break;
    case 'g': in = isgraph(c); break;
    case 'l': in = islower(c); break;
    case 'p': in = ispunct(c); break;
    case 's': in = isspace(c); break;
    case 'u': in = isupper(c); break;
    case 'w': in = isalnum(c); break;
    case 'x': in = isxdigit(c); break;
    default: return class == c;
    }
    return isupper(class) ? !in : in;
}

/* Whether c is in the set from '[' at p to ']' just before `end`. */
static bool is_in_set(int c, const char *p, const char *end)
{
    bool wanted = true;
    const char *last = end - 1;
    if (*++p == '^') {
        wanted = false;
        p++;
    }
    while (p < last) {
        if (*p == '%' && p + 1 < last) {
            if (is_in_class(c, (unsigned char)p[1]))
                return wanted;
            p += 2;
        } else if (p + 2 < last && p[1] == '-') {
            if ((unsigned char)p[0] <= c && c <= (unsigned char)p[2])
                return wanted;
            p += 3;
        } else {
            if ((unsigned char)*p == c)
                return wanted;
            p++;
        }
    }
    return !wanted;
}

static bool is_single(matcher *m, const char *s, const char *p, const char *end)
{
    pattern_step(m);
    if (s >= m->text_end)
        return false;
    int c = (unsigned char)*s;
    switch (*p) {
    case '.': return true;
    case '%': return is_in_class(c, (unsigned char)p[1]);
    case '[': return is_in_set(c, p, end);
    default: return (unsigned char)*p == c;
    }
}

/* ---- items ---- */

static const char *match_repeat(matcher *m, const char *s, const char *p, const char *end, bool at_least_one)
{
    ptrdiff_t n = 0;
    while (is_single(m, s + n, p, end))
        n++;
    for (; n >= (at_least_one ? 1 : 0); n--) {
        const char *found = match_here(m, s + n, end + 1);
        if (found)
            return found;
        pattern_step(m);
    }
    return NULL;
}

static const char *match_shortest(matcher *m, const char *s, const char *p, const char *end)
{
    for (;; s++) {
        const char *found = match_here(m, s, end + 1);
        if (found)
            return found;
        if (!is_single(m, s, p, end))
            return NULL;
    }
}

static const char *match_balanced(matcher *m, const char *s, const char *p)
{
    if (p + 1 >= m->pattern_end)
        luaL_error(m->L, "malformed pattern (missing arguments to '%%b'); write %%b()");
    if (s >= m->text_end || *s != *p)
        return NULL;
    int depth = 1;
    while (++s < m->text_end) {
        pattern_step(m);
        if (*s == p[1]) {
            if (--depth == 0)
                return s + 1;
        } else if (*s == p[0]) {
            depth++;
        }
    }
    return NULL;
}

static const char *match_frontier(matcher *m, const char *s, const char *p)
{
    if (p >= m->pattern_end || *p != '[')
        luaL_error(m->L, "missing '[' after '%%f' in pattern; write %%f[set]");
    const char *end = class_end(m, p);
    int before = s == m->text ? 0 : (unsigned char)s[-1], here = s < m->text_end ? (unsigned char)*s : 0;
    pattern_step(m);
    return !is_in_set(before, p, end) && is_in_set(here, p, end) ? match_here(m, s, end) : NULL;
}

static const char *open_capture(matcher *m, const char *s, const char *p, ptrdiff_t length)
{
    if (m->count == PATTERN_CAPTURES)
        luaL_error(m->L, "too many captures; use at most %d", PATTERN_CAPTURES);
    m->captures[m->count].start = s;
    m->captures[m->count].length = length;
    m->count++;
    const char *found = match_here(m, s, p);
    if (!found)
        m->count--;
    return found;
}

static const char *close_capture(matcher *m, const char *s, const char *p)
{
    int i = m->count - 1;
    while (i >= 0 && m->captures[i].length != CAPTURE_OPEN)
        i--;
    if (i < 0)
        luaL_error(m->L, "invalid pattern capture; a ')' has no '('");
    m->captures[i].length = s - m->captures[i].start;
    const char *found = match_here(m, s, p);
    if (!found)
        m->captures[i].length = CAPTURE_OPEN;
    return found;
}

static const char *match_back_reference(matcher *m, const char *s, int digit)
{
    int i = digit - '1';
    if (i < 0 || i >= m->count || m->captures[i].length < 0)
        luaL_error(m->L, "invalid capture index %%%d in pattern; there is no such capture yet", i + 1);
    size_t length = (size_t)m->captures[i].length;
    script_charge(m->L, 1 + (int64_t)length / 16);
    if ((size_t)(m->text_end - s) < length || memcmp(m->captures[i].start, s, length) != 0)
        return NULL;
    return s + length;
}

/* A class with what may follow it: * + - ? or nothing. Sets *next to go on with in the caller's loop. */
static const char *match_class(matcher *m, const char *s, const char *p, const char **next)
{
    const char *end = class_end(m, p);
    char suffix = end < m->pattern_end ? *end : '\0';
    *next = NULL;
    switch (suffix) {
    case '*': return match_repeat(m, s, p, end, false);
    case '+': return match_repeat(m, s, p, end, true);
    case '-': return match_shortest(m, s, p, end);
    case '?': {
        const char *found = is_single(m, s, p, end) ? match_here(m, s + 1, end + 1) : NULL;
        *next = found ? NULL : end + 1;
        return found ? found : s;
    }
    default:
        if (!is_single(m, s, p, end))
            return NULL;
        *next = end;
        return s + 1;
    }
}

/* One item at p: sets *next when the loop goes on there with the returned place; else the result is final. */
static const char *match_item(matcher *m, const char *s, const char *p, const char **next)
{
    *next = NULL;
    if (*p == '(')
        return p + 1 < m->pattern_end && p[1] == ')' ? open_capture(m, s, p + 2, CAPTURE_POSITION)
                                                     : open_capture(m, s, p + 1, CAPTURE_OPEN);
    if (*p == ')')
        return close_capture(m, s, p + 1);
    if (*p == '$' && p + 1 == m->pattern_end)
        return s == m->text_end ? s : NULL;
    if (*p == '%' && p + 1 < m->pattern_end && p[1] == 'b') {
        s = match_balanced(m, s, p + 2);
        *next = s ? p + 4 : NULL;
        return s;
    }
    if (*p == '%' && p + 1 < m->pattern_end && p[1] == 'f')
        return match_frontier(m, s, p + 2);
    if (*p == '%' && p + 1 < m->pattern_end && isdigit((unsigned char)p[1])) {
        s = match_back_reference(m, s, p[1]);
        *next = s ? p + 2 : NULL;
        return s;
    }
    return match_class(m, s, p, next);
}

static const char *match_here(matcher *m, const char *s, const char *p)
{
    if (++m->depth > MAX_DEPTH)
        luaL_error(m->L, "pattern too complex; split it");
    while (p && p < m->pattern_end && s) {
        const char *next;
        pattern_step(m);
        s = match_item(m, s, p, &next);
        if (!next)
            break;
        p = next;
    }
    m->depth--;
    return s;
}

/* ---- what a match has found ---- */

void pattern_push_capture(matcher *m, int i, const char *s, const char *end)
{
    if (i >= m->count) {
        if (i != 0)
            luaL_error(m->L, "invalid capture index %%%d; the pattern has fewer captures", i + 1);
        lua_pushlstring(m->L, s, (size_t)(end - s));
    } else if (m->captures[i].length == CAPTURE_POSITION) {
        lua_pushinteger(m->L, m->captures[i].start - m->text + 1);
    } else if (m->captures[i].length == CAPTURE_OPEN) {
        luaL_error(m->L, "unfinished capture; close it with ')'");
    } else {
        lua_pushlstring(m->L, m->captures[i].start, (size_t)m->captures[i].length);
    }
}

int pattern_push_captures(matcher *m, const char *s, const char *end)
{
    int count = m->count == 0 && s ? 1 : m->count;
    luaL_checkstack(m->L, count, "too many captures");
    for (int i = 0; i < count; i++)
        pattern_push_capture(m, i, s, end);
    return count;
}

matcher pattern_begin(lua_State *L, const char *text, size_t text_size, const char *pattern,
                      size_t pattern_size)
{
    return (matcher){
        .L = L, .text = text, .text_end = text + text_size, .pattern_end = pattern + pattern_size};
}

const char *pattern_try(matcher *m, const char *s, const char *p)
{
    m->count = 0;
    m->depth = 0;
    return match_here(m, s, p);
}
