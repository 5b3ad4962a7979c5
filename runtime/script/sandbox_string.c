/* string.find, match, gmatch, gsub and rep with a bound. */
#include "runtime/script/pattern.h"

#include <ctype.h>
#include <string.h>

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
    matcher m = pattern_begin(L, text, size, pattern, pattern_size);
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
        const char *end = pattern_try(&m, s, pattern + (anchored ? 1 : 0));
        if (end && !find)
            return pattern_push_captures(&m, s, end);
        if (end) {
            lua_pushinteger(L, s - text + 1);
            lua_pushinteger(L, end - text);
            return pattern_push_captures(&m, NULL, NULL) + 2;
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
    matcher m = pattern_begin(L, text, size, pattern, pattern_size);
    for (const char *s = text + lua_tointeger(L, lua_upvalueindex(3)); s <= m.text_end; s++) {
        const char *end = pattern_try(&m, s, pattern);
        if (end && end - text != last) {
            lua_pushinteger(L, end - text);
            lua_copy(L, -1, lua_upvalueindex(3));
            lua_replace(L, lua_upvalueindex(4));
            return pattern_push_captures(&m, s, end);
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
            pattern_push_capture(m, c - '1', s, end);
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
        pattern_push_capture(m, 0, s, end);
        lua_gettable(L, 3);
    } else {
        lua_pushvalue(L, 3);
        lua_call(L, pattern_push_captures(m, s, end), 1);
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
    matcher m = pattern_begin(L, text, size, pattern, pattern_size);
    const char *s = text, *last = NULL;
    luaL_Buffer out;
    lua_settop(L, 3);
    luaL_buffinit(L, &out);
    while (count < limit) {
        const char *end = pattern_try(&m, s, pattern + (anchored ? 1 : 0));
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
