/* Values as text. Lua shows tables, functions and the like by their address, which differs from run to run
 * and would let a scenario depend on it. Here each gets a number when it is first shown. */
#include "runtime/script/internal.h"

#include <string.h>

static const char numbers_key; /* its address keys the registry's table: object to number, keys weak */

/* Push the number of the object at `index`. */
static void push_number(lua_State *L, int index)
{
    lua_rawgetp(L, LUA_REGISTRYINDEX, &numbers_key);
    lua_pushvalue(L, index);
    if (lua_rawget(L, -2) == LUA_TNIL) {
        lua_pop(L, 1);
        lua_getfield(L, -1, "last"); /* no string is ever an object */
        lua_Integer number = lua_tointeger(L, -1) + 1;
        lua_pop(L, 1);
        lua_pushinteger(L, number);
        lua_setfield(L, -2, "last");
        lua_pushvalue(L, index);
        lua_pushinteger(L, number);
        lua_rawset(L, -3);
        lua_pushinteger(L, number);
    }
    lua_remove(L, -2);
}

const char *script_push_text(lua_State *L, int index)
{
    index = lua_absindex(L, index);
    luaL_checkstack(L, 6, "a value's text");
    if (lua_type(L, index) < LUA_TTABLE && lua_type(L, index) != LUA_TLIGHTUSERDATA)
        return luaL_tolstring(L, index, NULL);
    if (luaL_getmetafield(L, index, "__tostring") != LUA_TNIL) {
        lua_pop(L, 1);
        return luaL_tolstring(L, index, NULL);
    }
    int kind = luaL_getmetafield(L, index, "__name"); /* pushes nothing when there is none */
    const char *name = kind == LUA_TSTRING ? lua_tostring(L, -1) : luaL_typename(L, index);
    push_number(L, index);
    lua_pushfstring(L, "%s: %I", name, (LUAI_UACINT)lua_tointeger(L, -1));
    lua_replace(L, kind == LUA_TNIL ? -2 : -3);
    if (kind != LUA_TNIL)
        lua_pop(L, 1);
    return lua_tostring(L, -1);
}

/* Tell whether a byte is a control, or one of the two by which UTF-8 writes one. A tab and the end of a line
 * are none here. */
static bool is_control(const unsigned char *text, size_t i, size_t size)
{
    unsigned char c = text[i], next = i + 1 < size ? text[i + 1] : 0, before = i ? text[i - 1] : 0;
    return (c < 32 && c != '\t' && c != '\n') || c == 127 || (c == 0xC2 && next >= 0x80 && next < 0xA0) ||
           (before == 0xC2 && c >= 0x80 && c < 0xA0);
}

const char *script_push_shown(lua_State *L, int index)
{
    static const char digits[] = "0123456789abcdef";
    luaL_Buffer out;
    size_t size;
    const unsigned char *text = (const unsigned char *)lua_tolstring(L, index, &size);
    luaL_buffinit(L, &out);
    for (size_t i = 0; i < size; i++) {
        if (is_control(text, i, size)) {
            const char shown[4] = {'\\', 'x', digits[text[i] >> 4], digits[text[i] & 15]};
            luaL_addlstring(&out, shown, sizeof shown);
        } else {
            luaL_addchar(&out, (char)text[i]);
        }
        if (text[i] == '\n')
            luaL_addstring(&out, "    ");
    }
    luaL_pushresult(&out);
    return lua_tostring(L, -1);
}

static int to_string(lua_State *L)
{
    luaL_checkany(L, 1);
    script_push_text(L, 1);
    return 1;
}

/* Upvalue: string.format. What %s would show by its address is put into words first. */
static int string_format(lua_State *L)
{
    size_t size;
    const char *at = luaL_checklstring(L, 1, &size), *end = at + size;
    int argument = 1, count = lua_gettop(L);
    while (at < end) {
        if (*at++ != '%')
            continue;
        bool percent = at < end && *at == '%';
        while (at < end && *at && strchr("-+ #.0123456789", *at))
            at++;
        argument += !percent;
        if (at < end && *at == 'p')
            return luaL_error(L, "%%p is not available, since addresses differ from run to run; use %%s");
        if (at < end && *at == 's' && argument <= count) {
            script_push_text(L, argument);
            lua_replace(L, argument);
        }
        at += at < end;
    }
    lua_pushvalue(L, lua_upvalueindex(1));
    lua_insert(L, 1);
    lua_call(L, count, 1);
    return 1;
}

void script_text_open(lua_State *L)
{
    lua_newtable(L);
    lua_createtable(L, 0, 1);
    lua_pushliteral(L, "k");
    lua_setfield(L, -2, "__mode");
    lua_setmetatable(L, -2);
    lua_rawsetp(L, LUA_REGISTRYINDEX, &numbers_key);
    lua_register(L, "tostring", to_string);
    lua_getglobal(L, "string");
    lua_getfield(L, -1, "format");
    lua_pushcclosure(L, string_format, 1);
    lua_setfield(L, -2, "format");
    lua_pop(L, 1);
}
