/* string.find, match, gmatch, gsub and rep with a bound.
 *
 * Lua's own matcher backtracks inside one C call that no hook can stop: "(.-)(.-)(.-)(.-)b" on a long text
 * runs for years. This one follows the same pattern language (Lua 5.4 manual, section 6.4.1) and charges the
 * scenario's budget for every step. */
#include "runtime/script/internal.h"

#include <ctype.h>
#include <string.h>

#define MAX_CAPTURES  32
#define MAX_DEPTH     200 /* of recursion, as Lua's own */
#define STEPS_CHARGED 256 /* steps between two charges */

#define CAPTURE_OPEN     ((ptrdiff_t)-1)
#define CAPTURE_POSITION ((ptrdiff_t)-2)

typedef struct matcher {
    lua_State *L;
    const char *text, *text_end, *pattern_end;
    int steps, depth, count;
    struct {
        const char *start;
        ptrdiff_t length; /* or CAPTURE_* */
    } captures[MAX_CAPTURES];
} matcher;

static const char *match_here(matcher *m, const char *s, const char *p);

static void step(matcher *m)
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
    step(m);
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
        step(m);
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
        step(m);
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
    step(m);
    return !is_in_set(before, p, end) && is_in_set(here, p, end) ? match_here(m, s, end) : NULL;
}

static const char *open_capture(matcher *m, const char *s, const char *p, ptrdiff_t length)
{
    if (m->count == MAX_CAPTURES)
        luaL_error(m->L, "too many captures; use at most %d", MAX_CAPTURES);
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
        step(m);
        s = match_item(m, s, p, &next);
        if (!next)
            break;
        p = next;
    }
    m->depth--;
    return s;
}

/* ---- the library's functions ---- */

static void push_capture(matcher *m, int i, const char *s, const char *end)
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

static int push_captures(matcher *m, const char *s, const char *end)
{
    int count = m->count == 0 && s ? 1 : m->count;
    luaL_checkstack(m->L, count, "too many captures");
    for (int i = 0; i < count; i++)
        push_capture(m, i, s, end);
    return count;
}

static matcher begin_match(lua_State *L, const char *text, size_t text_size, const char *pattern,
                           size_t pattern_size)
{
    return (matcher){
        .L = L, .text = text, .text_end = text + text_size, .pattern_end = pattern + pattern_size};
}

/* Try at s alone, forgetting what was captured before. */
static const char *try_match(matcher *m, const char *s, const char *p)
{
    m->count = 0;
    m->depth = 0;
    return match_here(m, s, p);
}

static size_t start_index(lua_Integer init, size_t size)
{
    if (init > 0)
        return (size_t)init - 1;
    if (init == 0 || init < -(lua_Integer)size)
        return 0;
    return size - (size_t)-init;
}

/* Search bytes as they are; NULL when not there. */
static const char *find_plain(matcher *m, const char *s, const char *word, size_t size)
{
    for (; (size_t)(m->text_end - s) >= size; s++) {
        size_t same = 0;
        while (same < size && s[same] == word[same])
            same++;
        if (same == size)
            return s;
        script_charge(m->L, 1 + (int64_t)same / 16);
    }
    return NULL;
}

static int find_or_match(lua_State *L, bool find)
{
    size_t size, pattern_size;
    const char *text = luaL_checklstring(L, 1, &size), *pattern = luaL_checklstring(L, 2, &pattern_size);
    size_t init = start_index(luaL_optinteger(L, 3, 1), size);
    matcher m = begin_match(L, text, size, pattern, pattern_size);
    if (init > size) {
        luaL_pushfail(L);
        return 1;
    }
    if (find && lua_toboolean(L, 4)) {
        const char *at = find_plain(&m, text + init, pattern, pattern_size);
        if (!at)
            goto fail;
        lua_pushinteger(L, at - text + 1);
        lua_pushinteger(L, at - text + (lua_Integer)pattern_size);
        return 2;
    }
    bool anchored = pattern_size > 0 && *pattern == '^';
    for (const char *s = text + init; s <= m.text_end; s++) {
        const char *end = try_match(&m, s, pattern + (anchored ? 1 : 0));
        if (end && !find)
            return push_captures(&m, s, end);
        if (end) {
            lua_pushinteger(L, s - text + 1);
            lua_pushinteger(L, end - text);
            return push_captures(&m, NULL, NULL) + 2;
        }
        if (anchored)
            break;
    }
fail:
    luaL_pushfail(L);
    return 1;
}

static int string_find(lua_State *L)
{
    return find_or_match(L, true);
}

static int string_match(lua_State *L)
{
    return find_or_match(L, false);
}

/* Upvalues: text, pattern, where to go on, where the last match ended (-1: nowhere). */
static int gmatch_next(lua_State *L)
{
    size_t size, pattern_size;
    const char *text = lua_tolstring(L, lua_upvalueindex(1), &size),
               *pattern = lua_tolstring(L, lua_upvalueindex(2), &pattern_size);
    lua_Integer last = lua_tointeger(L, lua_upvalueindex(4));
    matcher m = begin_match(L, text, size, pattern, pattern_size);
    for (const char *s = text + lua_tointeger(L, lua_upvalueindex(3)); s <= m.text_end; s++) {
        const char *end = try_match(&m, s, pattern);
        if (end && end - text != last) {
            lua_pushinteger(L, end - text);
            lua_copy(L, -1, lua_upvalueindex(3));
            lua_replace(L, lua_upvalueindex(4));
            return push_captures(&m, s, end);
        }
    }
    return 0;
}

static int string_gmatch(lua_State *L)
{
    size_t size;
    luaL_checklstring(L, 1, &size);
    luaL_checkstring(L, 2);
    size_t init = start_index(luaL_optinteger(L, 3, 1), size);
    lua_settop(L, 2);
    lua_pushinteger(L, (lua_Integer)(init > size ? size + 1 : init));
    lua_pushinteger(L, -1);
    lua_pushcclosure(L, gmatch_next, 4);
    return 1;
}

/* Add the replacement string with its %0 … %9. */
static void add_template(matcher *m, luaL_Buffer *out, const char *s, const char *end)
{
    size_t size;
    const char *template = lua_tolstring(m->L, 3, &size);
    for (size_t i = 0; i < size; i++) {
        if (template[i] != '%') {
            luaL_addchar(out, template[i]);
            continue;
        }
        char c = i + 1 < size ? template[i + 1] : '\0';
        i++;
        if (c == '%') {
            luaL_addchar(out, c);
        } else if (c == '0') {
            luaL_addlstring(out, s, (size_t)(end - s));
        } else if (isdigit((unsigned char)c)) {
            push_capture(m, c - '1', s, end);
            luaL_tolstring(m->L, -1, NULL);
            lua_remove(m->L, -2);
            luaL_addvalue(out);
        } else {
            luaL_error(m->L, "invalid use of '%%' in replacement string; write %%%% for a percent sign");
        }
    }
}

static void add_replacement(matcher *m, luaL_Buffer *out, const char *s, const char *end, int type)
{
    lua_State *L = m->L;
    if (type == LUA_TSTRING || type == LUA_TNUMBER) {
        add_template(m, out, s, end);
        return;
    }
    if (type == LUA_TTABLE) {
        push_capture(m, 0, s, end);
        lua_gettable(L, 3);
    } else {
        lua_pushvalue(L, 3);
        lua_call(L, push_captures(m, s, end), 1);
    }
    if (!lua_toboolean(L, -1)) {
        lua_pop(L, 1);
        luaL_addlstring(out, s, (size_t)(end - s));
    } else if (lua_isstring(L, -1)) {
        luaL_addvalue(out);
    } else {
        luaL_error(L, "invalid replacement value (a %s); return a string, or nil to keep the text",
                   luaL_typename(L, -1));
    }
}

static int string_gsub(lua_State *L)
{
    size_t size, pattern_size;
    const char *text = luaL_checklstring(L, 1, &size), *pattern = luaL_checklstring(L, 2, &pattern_size);
    int type = lua_type(L, 3);
    luaL_argexpected(
        L, type == LUA_TSTRING || type == LUA_TNUMBER || type == LUA_TTABLE || type == LUA_TFUNCTION, 3,
        "string/function/table");
    lua_Integer limit = luaL_optinteger(L, 4, (lua_Integer)size + 1), count = 0;
    bool anchored = pattern_size > 0 && *pattern == '^';
    matcher m = begin_match(L, text, size, pattern, pattern_size);
    const char *s = text, *last = NULL;
    luaL_Buffer out;
    lua_settop(L, 3);
    luaL_buffinit(L, &out);
    while (count < limit) {
        const char *end = try_match(&m, s, pattern + (anchored ? 1 : 0));
        if (end && end != last) {
            count++;
            add_replacement(&m, &out, s, end, type);
            s = last = end;
        } else if (s < m.text_end) {
            luaL_addchar(&out, *s++);
        } else {
            break;
        }
        if (anchored)
            break;
    }
    luaL_addlstring(&out, s, (size_t)(m.text_end - s));
    luaL_pushresult(&out);
    lua_pushinteger(L, count);
    return 2;
}

/* Upvalue: string.rep, which walks its count even when there is nothing to repeat. */
static int string_rep(lua_State *L)
{
    size_t size, separator = 0;
    luaL_checklstring(L, 1, &size);
    lua_Integer n = luaL_checkinteger(L, 2);
    if (!lua_isnoneornil(L, 3))
        luaL_checklstring(L, 3, &separator);
    if (size + separator == 0)
        n = n > 0 ? 1 : 0;
    lua_settop(L, 3);
    if (n > 0)
        script_charge(L, n / 256);
    lua_pushvalue(L, lua_upvalueindex(1));
    lua_pushvalue(L, 1);
    lua_pushinteger(L, n);
    lua_pushvalue(L, 3);
    lua_call(L, 3, 1);
    return 1;
}

void script_sandbox_string(lua_State *L)
{
    static const luaL_Reg functions[] = {
        {"find", string_find}, {"match", string_match}, {"gmatch", string_gmatch}, {"gsub", string_gsub},
        {NULL, NULL},
    };
    lua_getglobal(L, "string");
    luaL_setfuncs(L, functions, 0);
    lua_getfield(L, -1, "rep");
    lua_pushcclosure(L, string_rep, 1);
    lua_setfield(L, -2, "rep");
    lua_pushnil(L);
    lua_setfield(L, -2, "dump");
    lua_pop(L, 1);
    /* strings' own metatable must not be changed under the feet of the host */
    lua_pushliteral(L, "");
    if (lua_getmetatable(L, -1)) {
        lua_pushliteral(L, "protected");
        lua_setfield(L, -2, "__metatable");
        lua_pop(L, 1);
    }
    lua_pop(L, 1);
}
