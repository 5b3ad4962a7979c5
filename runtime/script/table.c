/* Tables that scenarios write: every key is known or an error that names the nearest one, every number has a
 * range. */
#include "runtime/script/internal.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "runtime/core/nearest.h"

_Noreturn void script_unknown(lua_State *L, const char *what, const char *word, const char *best)
{
    if (best)
        luaL_error(L, "%s: unknown key '%s'; did you mean '%s'?", what, word, best);
    luaL_error(L, "%s: unknown key '%s'; see the scenario reference for what it takes", what, word);
    for (;;)
        ; /* luaL_error never returns, but is not declared so */
}

void script_check_keys(lua_State *L, int table, const char *what, const char *const *keys)
{
    table = lua_absindex(L, table);
    for (lua_pushnil(L); lua_next(L, table); lua_pop(L, 1)) {
        if (lua_type(L, -2) != LUA_TSTRING)
            luaL_error(L, "%s: entries without a name are not allowed here; write key = value", what);
        const char *key = lua_tostring(L, -2);
        size_t i = 0;
        while (keys[i] && strcmp(keys[i], key) != 0)
            i++;
        if (!keys[i])
            script_unknown(L, what, key, kd_nearest_word(key, keys));
    }
}

void script_check_range(lua_State *L, const char *what, double value, double min, double max)
{
    char text[128];
    if (!isfinite((float)value))
        luaL_error(L, "%s is not a finite number; correct it", what);
    if (min == max || (value >= min && value <= max))
        return;
    snprintf(text, sizeof text, "%.6g, which is out of range; choose a value from %.6g to %.6g", value, min,
             max);
    luaL_error(L, "%s is %s", what, text);
}

static void wrong_type(lua_State *L, const char *what, const char *key, const char *wanted)
{
    luaL_error(L, "%s.%s must be %s, not a %s; correct it", what, key, wanted, luaL_typename(L, -1));
}

double script_get_number(lua_State *L, int table, const char *what, const char *key, double fallback,
                         double min, double max)
{
    double value = fallback;
    if (lua_getfield(L, table, key) != LUA_TNIL) {
        if (lua_type(L, -1) != LUA_TNUMBER)
            wrong_type(L, what, key, "a number");
        value = lua_tonumber(L, -1);
        script_check_range(L, lua_pushfstring(L, "%s.%s", what, key), value, min, max);
        lua_pop(L, 1);
    }
    lua_pop(L, 1);
    return value;
}

bool script_get_bool(lua_State *L, int table, const char *what, const char *key, bool fallback)
{
    bool value = fallback;
    if (lua_getfield(L, table, key) != LUA_TNIL) {
        if (!lua_isboolean(L, -1))
            wrong_type(L, what, key, "true or false");
        value = lua_toboolean(L, -1);
    }
    lua_pop(L, 1);
    return value;
}

const char *script_get_string(lua_State *L, int table, const char *what, const char *key)
{
    const char *value = NULL;
    if (lua_getfield(L, table, key) != LUA_TNIL) {
        size_t size;
        if (lua_type(L, -1) != LUA_TSTRING)
            wrong_type(L, what, key, "a string");
        value = lua_tolstring(L, -1, &size);
        if (strlen(value) != size)
            luaL_error(L, "%s.%s contains a zero byte; remove it", what, key);
    }
    lua_pop(L, 1); /* the table keeps it alive */
    return value;
}

void script_read_floats(lua_State *L, int index, const char *what, float *out, uint32_t count)
{
    index = lua_absindex(L, index);
    if (!lua_istable(L, index))
        luaL_error(L, "%s must be a list of %d numbers, not a %s; correct it", what, (int)count,
                   luaL_typename(L, index));
    if (lua_rawlen(L, index) != count)
        luaL_error(L, "%s must have %d numbers, not %d; correct it", what, (int)count,
                   (int)lua_rawlen(L, index));
    for (uint32_t i = 0; i < count; i++) {
        if (lua_rawgeti(L, index, (lua_Integer)i + 1) != LUA_TNUMBER)
            luaL_error(L, "%s[%d] must be a number, not a %s; correct it", what, (int)i + 1,
                       luaL_typename(L, -1));
        out[i] = (float)lua_tonumber(L, -1);
        if (!isfinite(out[i]))
            luaL_error(L, "%s[%d] is not finite; correct it", what, (int)i + 1);
        lua_pop(L, 1);
    }
}

bool script_get_floats(lua_State *L, int table, const char *what, const char *key, float *out, uint32_t count)
{
    bool there = lua_getfield(L, table, key) != LUA_TNIL;
    if (there) {
        const char *name = lua_pushfstring(L, "%s.%s", what, key);
        script_read_floats(L, -2, name, out, count);
        lua_pop(L, 1);
    }
    lua_pop(L, 1);
    return there;
}
