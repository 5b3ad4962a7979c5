/* The table library. Its functions walk as many entries as they are told, and every one of them may ask
 * metamethods, all without an instruction: each entry is charged, and the limits are looked at on the way. */
#include "runtime/script/internal.h"

#include <limits.h>

#define MAX_LIST     4194304 /* entries of a list that one call may walk */
#define LOOK_ENTRIES 256     /* walked between two looks at the clock */
#define TEXT_BYTES   32      /* of a text compared that cost as much as one instruction */

static lua_Integer length_of_list(lua_State *L)
{
    luaL_checktype(L, 1, LUA_TTABLE);
    lua_Integer length = luaL_len(L, 1);
    if (length > MAX_LIST)
        luaL_error(L, "a list of %I entries is too long; keep it below %d", (LUAI_UACINT)length, MAX_LIST);
    return length;
}

static lua_Integer index_at(lua_State *L, int argument, lua_Integer fallback)
{
    lua_Integer n = luaL_optinteger(L, argument, fallback);
    if (n > MAX_LIST || n < -MAX_LIST)
        luaL_error(L, "an index of %I is out of range; keep it below %d", (LUAI_UACINT)n, MAX_LIST);
    return n;
}

static void look_after(lua_State *L, lua_Integer walked)
{
    if (walked % LOOK_ENTRIES == 0)
        script_look(L);
}

/* Charge for the entries from first to last, and count them. */
static lua_Integer charge_range(lua_State *L, lua_Integer first, lua_Integer last)
{
    lua_Integer count = last >= first ? last - first + 1 : 0;
    script_charge(L, 1 + count);
    return count;
}

/* Copy the entries `first` to `last` of the table at `from` to `at` and on in the table at `to`. */
static void copy_entries(lua_State *L, int from, lua_Integer first, lua_Integer last, int to, lua_Integer at,
                         bool last_first)
{
    lua_Integer count = charge_range(L, first, last);
    for (lua_Integer i = 0; i < count; i++) {
        lua_Integer k = last_first ? count - 1 - i : i;
        lua_geti(L, from, first + k);
        lua_seti(L, to, at + k);
        look_after(L, i + 1);
    }
}

static int table_insert(lua_State *L)
{
    lua_Integer end = length_of_list(L) + 1, at = end;
    int count = lua_gettop(L);
    if (count != 2 && count != 3)
        return luaL_error(L, "wrong number of arguments to 'insert'; give it a list, a place and a value");
    if (count == 3) {
        at = luaL_checkinteger(L, 2);
        luaL_argcheck(L, at >= 1 && at <= end, 2, "position out of bounds");
        copy_entries(L, 1, at, end - 1, 1, at + 1, true);
        lua_settop(L, 3);
    }
    lua_seti(L, 1, at);
    return 0;
}

static int table_remove(lua_State *L)
{
    lua_Integer length = length_of_list(L), at = luaL_optinteger(L, 2, length);
    luaL_argcheck(L, at == length || (at >= 1 && at <= length + 1), 2, "position out of bounds");
    lua_settop(L, 1);
    lua_geti(L, 1, at);
    copy_entries(L, 1, at + 1, length, 1, at, false);
    lua_pushnil(L);
    lua_seti(L, 1, at > length ? at : length);
    return 1;
}

static int table_concat(lua_State *L)
{
    size_t size;
    lua_Integer length = length_of_list(L);
    const char *separator = luaL_optlstring(L, 2, "", &size);
    lua_Integer first = index_at(L, 3, 1), last = index_at(L, 4, length);
    lua_Integer count = charge_range(L, first, last);
    luaL_Buffer out;
    luaL_buffinit(L, &out);
    for (lua_Integer i = 0; i < count; i++) {
        if (i > 0)
            luaL_addlstring(&out, separator, size);
        lua_geti(L, 1, first + i);
        if (!lua_isstring(L, -1))
            return luaL_error(L,
                              "invalid value (at index %I) in table for 'concat'; give it texts or numbers",
                              (LUAI_UACINT)(first + i));
        luaL_addvalue(&out);
        look_after(L, i + 1);
    }
    luaL_pushresult(&out);
    return 1;
}

static int table_unpack(lua_State *L)
{
    lua_Integer first = index_at(L, 2, 1);
    lua_Integer last = lua_isnoneornil(L, 3) ? length_of_list(L) : index_at(L, 3, 0);
    lua_Integer count = charge_range(L, first, last);
    if (count >= INT_MAX || !lua_checkstack(L, (int)count))
        return luaL_error(L, "too many results to unpack; take fewer at a time");
    for (lua_Integer i = 0; i < count; i++) {
        lua_geti(L, 1, first + i);
        look_after(L, i + 1);
    }
    return (int)count;
}

static int table_move(lua_State *L)
{
    int to = lua_isnoneornil(L, 5) ? 1 : 5;
    luaL_checktype(L, 1, LUA_TTABLE);
    luaL_checktype(L, to, LUA_TTABLE);
    for (int i = 2; i <= 4; i++)
        luaL_checkinteger(L, i);
    lua_Integer first = index_at(L, 2, 1), last = index_at(L, 3, 1), at = index_at(L, 4, 1);
    copy_entries(L, 1, first, last, to, at, at > first && at <= last && lua_rawequal(L, 1, to));
    lua_pushvalue(L, to);
    return 1;
}

/* Upvalue: what the scenario compares by, or nil. */
static int compare_charged(lua_State *L)
{
    int64_t cost = 1;
    lua_settop(L, 2);
    if (lua_isnil(L, lua_upvalueindex(1))) {
        if (lua_type(L, 1) == LUA_TSTRING && lua_type(L, 2) == LUA_TSTRING) {
            size_t a = lua_rawlen(L, 1), b = lua_rawlen(L, 2);
            cost += (int64_t)((a < b ? a : b) / TEXT_BYTES);
        }
        script_charge(L, cost);
        lua_pushboolean(L, lua_compare(L, 1, 2, LUA_OPLT));
        return 1;
    }
    script_charge(L, cost);
    lua_pushvalue(L, lua_upvalueindex(1));
    lua_insert(L, 1);
    lua_call(L, 2, 1);
    return 1;
}

/* Upvalue: table.sort. */
static int table_sort(lua_State *L)
{
    script_charge(L, 1 + length_of_list(L));
    if (!lua_isnoneornil(L, 2))
        luaL_checktype(L, 2, LUA_TFUNCTION);
    lua_settop(L, 2);
    lua_pushcclosure(L, compare_charged, 1);
    lua_pushvalue(L, lua_upvalueindex(1));
    lua_insert(L, 1);
    lua_call(L, 2, 0);
    return 0;
}

void script_sandbox_table(lua_State *L)
{
    static const luaL_Reg functions[] = {
        {"insert", table_insert}, {"remove", table_remove}, {"concat", table_concat},
        {"unpack", table_unpack}, {"move", table_move},     {NULL, NULL},
    };
    lua_getglobal(L, "table");
    luaL_setfuncs(L, functions, 0);
    lua_getfield(L, -1, "sort");
    lua_pushcclosure(L, table_sort, 1);
    lua_setfield(L, -2, "sort");
    lua_pop(L, 1);
}
