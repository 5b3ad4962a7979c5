/* Functions that walk a text from end to end within one instruction: they are charged by its bytes. */
#include "runtime/script/internal.h"

#define TEXT_BYTES 32 /* of a text walked that cost as much as one instruction */

static int call_upvalue(lua_State *L)
{
    lua_pushvalue(L, lua_upvalueindex(1));
    lua_insert(L, 1);
    lua_call(L, lua_gettop(L) - 1, LUA_MULTRET);
    return lua_gettop(L);
}

/* Upvalue: the library's own function, which may walk every text it is given. */
static int call_charged(lua_State *L)
{
    int count = lua_gettop(L);
    size_t bytes = 0;
    for (int i = 1; i <= count; i++)
        bytes += lua_type(L, i) == LUA_TSTRING ? lua_rawlen(L, i) : 0;
    script_charge(L, 1 + (int64_t)(bytes / TEXT_BYTES));
    return call_upvalue(L);
}

/* Where an argument points into a text, from 1; below 0 it counts from the end. */
static lua_Integer place_at(lua_State *L, int argument, lua_Integer fallback, lua_Integer size)
{
    lua_Integer at = luaL_optinteger(L, argument, fallback);
    at = at < 0 ? size + 1 + at : at;
    return at < 0 ? 0 : at > size ? size : at;
}

/* Upvalues: utf8.len or utf8.codepoint, and whether no end means the text's. */
static int call_on_range(lua_State *L)
{
    size_t size;
    luaL_checklstring(L, 1, &size);
    lua_Integer length = (lua_Integer)size, first = place_at(L, 2, 1, length);
    lua_Integer last = place_at(L, 3, lua_toboolean(L, lua_upvalueindex(2)) ? length : first, length);
    script_charge(L, 1 + (last > first ? (last - first) / TEXT_BYTES : 0));
    return call_upvalue(L);
}

/* Upvalue: utf8.offset, which tells by its result how far it went. */
static int charged_offset(lua_State *L)
{
    size_t size;
    luaL_checklstring(L, 1, &size);
    lua_Integer n = luaL_checkinteger(L, 2), length = (lua_Integer)size;
    lua_Integer from = place_at(L, 3, n >= 0 ? 1 : length, length);
    int count = call_upvalue(L);
    lua_Integer to = lua_isinteger(L, 1) ? lua_tointeger(L, 1) : n > 0 ? length : 0;
    script_charge(L, 1 + (to > from ? to - from : from - to) / TEXT_BYTES);
    return count;
}

/* Upvalue: the iterator of utf8.codes, which skips bytes that go on a character. */
static int next_code(lua_State *L)
{
    size_t size;
    const char *text = luaL_checklstring(L, 1, &size);
    lua_Integer from = luaL_checkinteger(L, 2);
    size_t at = from > 0 && (lua_Unsigned)from < size ? (size_t)from : 0;
    while (at < size && ((unsigned char)text[at] & 0xC0) == 0x80)
        at++;
    script_charge(L, 1 + (from > 0 ? ((int64_t)at - from) / TEXT_BYTES : 0));
    lua_settop(L, 2);
    return call_upvalue(L);
}

/* Upvalue: utf8.codes. */
static int charged_codes(lua_State *L)
{
    lua_settop(L, 2);
    lua_pushvalue(L, lua_upvalueindex(1));
    lua_insert(L, 1);
    lua_call(L, 2, 3);
    lua_pushvalue(L, 1);
    lua_pushcclosure(L, next_code, 1);
    lua_replace(L, 1);
    return 3;
}

/* Replace functions of the table at the top. */
static void charge_functions(lua_State *L, const char *const *names)
{
    for (; *names; names++) {
        lua_getfield(L, -1, *names);
        lua_pushcclosure(L, call_charged, 1);
        lua_setfield(L, -2, *names);
    }
}

void script_sandbox_walks(lua_State *L)
{
    static const char *const base[] = {"tonumber", NULL};
    static const char *const text[] = {"lower", "reverse", "upper", NULL};
    static const char *const sums[] = {"__add", "__sub",  "__mul", "__mod", "__pow",
                                       "__div", "__idiv", "__unm", NULL}; /* texts that say numbers */
    lua_pushglobaltable(L);
    charge_functions(L, base);
    lua_getglobal(L, "utf8");
    lua_getfield(L, -1, "len");
    lua_pushboolean(L, true);
    lua_pushcclosure(L, call_on_range, 2);
    lua_setfield(L, -2, "len");
    lua_getfield(L, -1, "codepoint");
    lua_pushcclosure(L, call_on_range, 1);
    lua_setfield(L, -2, "codepoint");
    lua_getfield(L, -1, "offset");
    lua_pushcclosure(L, charged_offset, 1);
    lua_setfield(L, -2, "offset");
    lua_getfield(L, -1, "codes");
    lua_pushcclosure(L, charged_codes, 1);
    lua_setfield(L, -2, "codes");
    lua_getglobal(L, "string");
    charge_functions(L, text);
    lua_pushliteral(L, "");
    lua_getmetatable(L, -1);
    charge_functions(L, sums);
    lua_pop(L, 5);
}
