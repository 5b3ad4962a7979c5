/* pairs and next in an order that is the same in every run.
 *
 * Lua's own order follows hashes: of strings with a seed that differs between runs, of objects by their
 * address. Here keys are ordered by kind, then value: numbers, strings byte by byte, booleans, entities and
 * their components by handle, other objects by when they were made. Both calls look at a table's keys as they
 * were when the traversal began: a key that is removed meanwhile is left out, one that is added is not seen.
 */
#include "runtime/script/internal.h"

#include <stdlib.h>
#include <string.h>

static const char
    walks_key; /* its address keys the registry's table: table under way with next, to its keys */

typedef enum key_rank {
    RANK_NUMBER,
    RANK_STRING,
    RANK_BOOLEAN,
    RANK_HANDLE,
    RANK_OBJECT,
    RANK_CODE
} key_rank;

typedef struct sort_key {
    uint8_t rank;
    uint8_t is_float;
    uint32_t slot; /* in the list of keys as Lua gave them */
    union {
        double number;
        const char *text;
        uint64_t order;
    } first;
    union {
        lua_Integer integer;
        size_t length;
    } second;
} sort_key;

/* ---- comparing ---- */

/* Describe the key at `index`; text points into the key. Light C functions lie in one program image or
 * library each, whose inner order is fixed: their address serves. */
static sort_key describe(lua_State *L, int index)
{
    sort_key key = {.rank = RANK_OBJECT};
    switch (lua_type(L, index)) {
    case LUA_TNUMBER:
        key.rank = RANK_NUMBER;
        key.is_float = !lua_isinteger(L, index);
        key.first.number = (double)lua_tonumber(L, index);
        key.second.integer = key.is_float ? 0 : lua_tointeger(L, index);
        return key;
    case LUA_TSTRING:
        key.rank = RANK_STRING;
        key.first.text = lua_tolstring(L, index, &key.second.length);
        return key;
    case LUA_TBOOLEAN:
        key.rank = RANK_BOOLEAN;
        key.first.order = (uint64_t)lua_toboolean(L, index);
        return key;
    case LUA_TUSERDATA:
        if (script_handle_order(L, index, &key.first.order, &key.second.integer)) {
            key.rank = RANK_HANDLE;
            return key;
        }
        key.first.order = *(const uint64_t *)lua_touserdata(L, index);
        return key;
    case LUA_TFUNCTION:
        if (lua_iscfunction(L, index) && !lua_getupvalue(L, index, 1)) {
            key.rank = RANK_CODE;
            key.first.order = (uint64_t)(uintptr_t)lua_tocfunction(L, index);
            return key;
        }
        if (lua_iscfunction(L, index))
            lua_pop(L, 1);
        break;
    case LUA_TTHREAD: /* Lua keeps room for its host before the thread's own block */
        key.first.order = script_creation_number((const char *)lua_topointer(L, index) - LUA_EXTRASPACE);
        return key;
    default: break;
    }
    key.first.order = script_creation_number(lua_topointer(L, index));
    return key;
}

static int compare_text(const sort_key *a, const sort_key *b)
{
    size_t n = a->second.length, m = b->second.length;
    int order = memcmp(a->first.text, b->first.text, n < m ? n : m);
    return order ? order : (n > m) - (n < m);
}

/* Whole numbers may round to one double: then they decide themselves, before a float of that value. */
static int compare_numbers(const sort_key *a, const sort_key *b)
{
    if (a->first.number != b->first.number)
        return a->first.number < b->first.number ? -1 : 1;
    if (a->is_float != b->is_float)
        return a->is_float ? 1 : -1;
    return (a->second.integer > b->second.integer) - (a->second.integer < b->second.integer);
}

static int compare_keys(const void *left, const void *right)
{
    const sort_key *a = left, *b = right;
    if (a->rank != b->rank)
        return a->rank < b->rank ? -1 : 1;
    if (a->rank == RANK_NUMBER)
        return compare_numbers(a, b);
    if (a->rank == RANK_STRING)
        return compare_text(a, b);
    if (a->first.order != b->first.order)
        return a->first.order < b->first.order ? -1 : 1;
    return (a->second.integer > b->second.integer) - (a->second.integer < b->second.integer);
}

/* ---- sorted keys ---- */

/* Push a list of the table's keys in Lua's order. */
static uint32_t push_raw_keys(lua_State *L, int table)
{
    uint32_t count = 0;
    lua_newtable(L);
    int list = lua_gettop(L);
    for (lua_pushnil(L); lua_next(L, table); lua_pop(L, 1)) {
        lua_pushvalue(L, -2);
        lua_rawseti(L, list, (lua_Integer)++count);
    }
    return count;
}

static int log2_of(uint32_t n)
{
    int bits = 0;
    for (; n > 1; n >>= 1)
        bits++;
    return bits;
}

/* Push a list of the table's keys in our order. */
static void push_sorted_keys(lua_State *L, int table)
{
    luaL_checkstack(L, 8, "the keys of a table");
    uint32_t count = push_raw_keys(L, table);
    int raw = lua_gettop(L);
    script_charge(L, (int64_t)count * (1 + log2_of(count) / 4));
    sort_key *keys = lua_newuserdatauv(L, (count + 1) * sizeof *keys, 0);
    for (uint32_t i = 0; i < count; i++) {
        lua_rawgeti(L, raw, (lua_Integer)i + 1);
        keys[i] = describe(L, lua_gettop(L)); /* texts stay: the list holds the keys */
        keys[i].slot = i + 1;
        lua_settop(L, raw + 1);
    }
    qsort(keys, count, sizeof *keys, compare_keys);
    lua_createtable(L, (int)count, 0);
    for (uint32_t i = 0; i < count; i++) {
        lua_rawgeti(L, raw, (lua_Integer)keys[i].slot);
        lua_rawseti(L, -2, (lua_Integer)i + 1);
    }
    lua_replace(L, raw);
    lua_settop(L, raw);
}

/* ---- pairs ---- */

/* Tell whether the keys are 1 to n alone, the most common case, which needs no list. */
static bool is_sequence(lua_State *L, int table, lua_Unsigned n)
{
    lua_Unsigned count = 0;
    for (lua_pushnil(L); lua_next(L, table); lua_pop(L, 1)) {
        if (++count > n || !lua_isinteger(L, -2) || (lua_Unsigned)lua_tointeger(L, -2) - 1 >= n) {
            lua_pop(L, 2);
            return false;
        }
    }
    script_charge(L, (int64_t)(count / 4));
    return count == n;
}

/* Upvalue: the length when the traversal began. */
static int next_of_sequence(lua_State *L)
{
    lua_Integer n = lua_tointeger(L, lua_upvalueindex(1)), i = lua_tointeger(L, 2);
    luaL_checktype(L, 1, LUA_TTABLE);
    while (i < n) {
        lua_pushinteger(L, ++i);
        if (lua_rawgeti(L, 1, i) != LUA_TNIL)
            return 2;
        lua_pop(L, 2); /* removed meanwhile */
    }
    lua_pushnil(L);
    return 1;
}

/* Upvalues: the table, its sorted keys, the number of the last one given out. */
static int next_sorted(lua_State *L)
{
    lua_Integer i = lua_tointeger(L, lua_upvalueindex(3));
    for (;;) {
        lua_settop(L, 0);
        if (lua_rawgeti(L, lua_upvalueindex(2), ++i) == LUA_TNIL)
            return 1;
        lua_pushvalue(L, 1);
        if (lua_rawget(L, lua_upvalueindex(1)) != LUA_TNIL)
            break; /* else removed meanwhile */
    }
    lua_pushinteger(L, i);
    lua_replace(L, lua_upvalueindex(3));
    return 2;
}

static int ordered_pairs(lua_State *L)
{
    luaL_checkany(L, 1);
    if (luaL_getmetafield(L, 1, "__pairs") != LUA_TNIL) {
        lua_pushvalue(L, 1);
        lua_call(L, 1, 3);
        return 3;
    }
    luaL_checktype(L, 1, LUA_TTABLE);
    lua_settop(L, 1);
    lua_Unsigned n = lua_rawlen(L, 1);
    if (is_sequence(L, 1, n)) {
        lua_pushinteger(L, (lua_Integer)n);
        lua_pushcclosure(L, next_of_sequence, 1);
    } else {
        lua_pushvalue(L, 1);
        push_sorted_keys(L, 1);
        lua_pushinteger(L, 0);
        lua_pushcclosure(L, next_sorted, 3);
    }
    lua_pushvalue(L, 1);
    lua_pushnil(L);
    return 3;
}

/* ---- next ---- */

/* Push the smallest key; false when the table is empty. */
static bool push_first_key(lua_State *L, int table)
{
    sort_key best = {0};
    int64_t count = 0;
    lua_pushnil(L); /* the best so far */
    int at = lua_gettop(L);
    for (lua_pushnil(L); lua_next(L, table); lua_settop(L, at + 1)) {
        sort_key key = describe(L, at + 1);
        if (count++ == 0 || compare_keys(&key, &best) < 0) {
            best = key;
            lua_pushvalue(L, at + 1);
            lua_replace(L, at);
        }
    }
    script_charge(L, count / 2);
    return count > 0;
}

/* Push the list of keys by which the table at 1 is being walked, making it when there is none. */
static void push_walk(lua_State *L)
{
    lua_rawgetp(L, LUA_REGISTRYINDEX, &walks_key);
    lua_pushvalue(L, 1);
    if (lua_rawget(L, -2) == LUA_TNIL) {
        lua_pop(L, 1);
        push_sorted_keys(L, 1);
        lua_pushvalue(L, 1);
        lua_pushvalue(L, -2);
        lua_rawset(L, -4);
    }
    lua_remove(L, -2);
}

static void forget_walk(lua_State *L)
{
    lua_rawgetp(L, LUA_REGISTRYINDEX, &walks_key);
    lua_pushvalue(L, 1);
    lua_pushnil(L);
    lua_rawset(L, -3);
    lua_pop(L, 1);
}

/* Number of the first key in the list at `list` that comes after the key at 2. */
static lua_Integer after(lua_State *L, int list)
{
    sort_key key = describe(L, 2);
    lua_Integer low = 1, high = (lua_Integer)lua_rawlen(L, list) + 1;
    while (low < high) {
        lua_Integer middle = low + (high - low) / 2;
        lua_rawgeti(L, list, middle);
        sort_key other = describe(L, lua_gettop(L));
        lua_pop(L, 1);
        if (compare_keys(&other, &key) <= 0)
            low = middle + 1;
        else
            high = middle;
    }
    return low;
}

/* The key that comes after another, whether that one is still there or not. */
static int ordered_next(lua_State *L)
{
    luaL_checktype(L, 1, LUA_TTABLE);
    lua_settop(L, 2);
    if (lua_isnil(L, 2)) {
        forget_walk(L);
        if (!push_first_key(L, 1))
            return 1;
        lua_pushvalue(L, -1);
        lua_rawget(L, 1);
        return 2;
    }
    push_walk(L);
    for (lua_Integer i = after(L, 3);; i++) {
        lua_settop(L, 3);
        if (lua_rawgeti(L, 3, i) == LUA_TNIL)
            break;
        lua_pushvalue(L, 4);
        if (lua_rawget(L, 1) != LUA_TNIL)
            return 2;
    }
    forget_walk(L);
    lua_pushnil(L);
    return 1;
}

void script_order_open(lua_State *L)
{
    lua_newtable(L);
    lua_createtable(L, 0, 1);
    lua_pushliteral(L, "k"); /* the keys of a table do not keep it alive */
    lua_setfield(L, -2, "__mode");
    lua_setmetatable(L, -2);
    lua_rawsetp(L, LUA_REGISTRYINDEX, &walks_key);
    lua_register(L, "pairs", ordered_pairs);
    lua_register(L, "next", ordered_next);
}
