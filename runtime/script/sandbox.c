/* The sandbox: which libraries a scenario sees, and the limits of one call into it.
 *
 * Instructions are counted by a hook that every coroutine inherits. Once the budget is used up the hook
 * raises at every instruction, so that no pcall can hold the error back for ever, and the allocator refuses
 * to grow. What could loop inside one library call, without an instruction, is replaced here and in
 * sandbox_string.c, sandbox_table.c and sandbox_walks.c, or charges the budget. Lua code that would run with
 * hooks switched off is kept out: finalizers, the handler of xpcall while a hook raises, and the to-be-closed
 * variables of a coroutine in which a hook has raised. */
#include "runtime/script/internal.h"

#include <lualib.h>
#include <stdlib.h>
#include <string.h>

#include "runtime/core/clock.h"
#include "runtime/core/log.h"

/* What a line of the log costs in instructions: a step writes some megabytes at most. */
#define LINE_COST      2000
#define LINE_COST_BYTE 16
#define HOOK_PERIOD    200  /* instructions between two looks at the clock: below 1 % of the run time */
#define BYTES_CHARGED  256  /* allocated bytes that cost as much as one instruction */
#define LOOK_AFTER     4096 /* charged instructions after which the clock is looked at too */
#define TEXT_BYTES     32   /* of a text walked that cost as much as one instruction */
#define GC_PAUSE       400 /* per cent of what lives before Lua looks for garbage: half the work of its 200 */

/* Before every block stands the number of the allocation, by which objects have an order of their own
 * (order.c): addresses differ from run to run, numbers of two objects compare alike in all. */
typedef struct block_head {
    uint64_t number;
} block_head;

static void release(script_budget *budget, void *block, size_t size)
{
    if (!block)
        return;
    script_pool_free(&budget->pool, (block_head *)block - 1, size + sizeof(block_head));
    budget->memory_used -= size + sizeof(block_head);
}

static void *allocate(void *user, void *block, size_t old_size, size_t new_size)
{
    script_budget *budget = user;
    if (new_size == 0) {
        release(budget, block, old_size);
        return NULL;
    }
    size_t had = block ? old_size + sizeof(block_head) : 0; /* without a block old_size is a type */
    size_t wanted = new_size + sizeof(block_head);
    if (wanted > had) {
        size_t more = wanted - had;
        budget->instructions_left -= (int64_t)(more / BYTES_CHARGED);
        if (wanted < new_size || more > budget->memory_limit - budget->memory_used) {
            budget->over_memory = true;
            return NULL;
        }
    }
    block_head *grown =
        script_pool_resize(&budget->pool, block ? (block_head *)block - 1 : NULL, had, wanted);
    if (!grown)
        return NULL;
    if (!block)
        grown->number = ++budget->allocations;
    budget->memory_used = budget->memory_used - had + wanted;
    return grown + 1;
}

uint64_t script_creation_number(const void *block)
{
    return ((const block_head *)block - 1)->number;
}

/* Raise at what runs on stack level `level`: in a hook the interrupted function is level 0, in a call its
 * caller is 1. */
static void raise_exhausted(lua_State *L, int level)
{
    luaL_where(L, level);
    lua_pushliteral(
        L, "ran for too long in one call; return from it sooner, or spread the work over several steps");
    lua_concat(L, 2);
    lua_error(L);
}

/* A busy machine may give the script no processor for a while: that is none of its time. Processor time costs
 * a system call to read, and cannot have run out before that of the wall has. */
static bool is_over_time(const script_budget *budget)
{
    return kd_clock_ns() >= budget->deadline_ns &&
           (int64_t)kd_clock_thread_ns() >= budget->thread_deadline_ns;
}

static void count_hook(lua_State *L, lua_Debug *activation)
{
    (void)activation;
    script_budget *budget = &script_of(L)->budget;
    budget->instructions_left -= HOOK_PERIOD;
    budget->exhausted = budget->exhausted || script_is_stopped(script_of(L));
    if (!budget->exhausted && budget->instructions_left > 0 && !is_over_time(budget))
        return;
    budget->exhausted = true;
    lua_sethook(L, count_hook, LUA_MASKCOUNT, 1);
    raise_exhausted(L, 0);
}

/* Many calls that each do much fit between two looks of the hook: they look themselves. */
void script_look(lua_State *L)
{
    script_budget *budget = &script_of(L)->budget;
    budget->unlooked = 0;
    budget->exhausted = budget->exhausted || script_is_stopped(script_of(L)) ||
                        budget->instructions_left <= 0 || is_over_time(budget);
    if (budget->exhausted)
        raise_exhausted(L, 1);
}

void script_charge(lua_State *L, int64_t instructions)
{
    script_budget *budget = &script_of(L)->budget;
    budget->instructions_left -= instructions;
    budget->unlooked += instructions;
    if (budget->instructions_left <= 0 || budget->exhausted || budget->unlooked >= LOOK_AFTER)
        script_look(L);
}

bool script_is_stopped(const kd_script *script)
{
    return script->host.stopped && script->host.stopped(script->host.user);
}

void script_budget_start(kd_script *script)
{
    script_budget *budget = &script->budget;
    budget->instructions_left = (int64_t)script->instruction_limit;
    budget->deadline_ns = kd_clock_ns() + script->time_limit_ns;
    budget->thread_deadline_ns = (int64_t)(kd_clock_thread_ns() + script->time_limit_ns);
    budget->loading_ns = 0;
    budget->unlooked = 0;
    budget->exhausted = false;
    budget->over_memory = false;
    lua_sethook(script->L, count_hook, LUA_MASKCOUNT, HOOK_PERIOD);
}

/* ---- base library ---- */

static int safe_load(lua_State *L)
{
    size_t size;
    const char *text = luaL_checklstring(L, 1, &size); /* a function could feed the parser for ever */
    const char *name = luaL_optstring(L, 2, text);
    bool has_env = !lua_isnone(L, 4);
    script_charge(L, (int64_t)size);
    if (luaL_loadbufferx(L, text, size, name, "t") != LUA_OK) {
        luaL_pushfail(L);
        lua_insert(L, -2);
        return 2;
    }
    if (has_env) {
        lua_pushvalue(L, 4);
        lua_setupvalue(L, -2, 1);
    }
    return 1;
}

static int safe_setmetatable(lua_State *L)
{
    luaL_checktype(L, 1, LUA_TTABLE);
    luaL_argexpected(L, lua_isnil(L, 2) || lua_istable(L, 2), 2, "nil or table");
    if (luaL_getmetafield(L, 1, "__metatable") != LUA_TNIL)
        return luaL_error(L, "cannot change a protected metatable");
    if (lua_istable(L, 2)) {
        lua_pushliteral(L, "__gc");
        if (lua_rawget(L, 2) != LUA_TNIL)
            return luaL_error(L, "finalizers (__gc) are not available in scenarios; remove it");
        lua_pushliteral(L, "__mode");
        if (lua_rawget(L, 2) != LUA_TNIL)
            return luaL_error(L, "weak tables (__mode) would show when memory is collected; remove it");
    }
    lua_settop(L, 2);
    lua_setmetatable(L, 1);
    return 1;
}

static int finish_xpcall(lua_State *L, int status, lua_KContext unused)
{
    (void)unused;
    if (status == LUA_OK || status == LUA_YIELD)
        return lua_gettop(L) - 2;
    lua_pushvalue(L, 2);
    lua_insert(L, -2);
    lua_call(L, 1, LUA_MULTRET); /* above: function, handler, true */
    lua_pushboolean(L, 0);
    lua_replace(L, 3);
    return lua_gettop(L) - 2;
}

/* The handler runs once the stack is unwound: there is no traceback to be taken here that would need it
 * sooner. */
static int safe_xpcall(lua_State *L)
{
    int count = lua_gettop(L);
    luaL_checktype(L, 2, LUA_TFUNCTION);
    lua_pushboolean(L, 1);
    lua_pushvalue(L, 1);
    lua_rotate(L, 3, 2);
    return finish_xpcall(L, lua_pcallk(L, count - 2, LUA_MULTRET, 0, 0, finish_xpcall), 0);
}

/* Upvalue: a coroutine. Resumes it and raises what it raised; it is left as it is, not closed. */
static int call_wrapped(lua_State *L)
{
    lua_State *coroutine = lua_tothread(L, lua_upvalueindex(1));
    int count = lua_gettop(L), results;
    if (lua_status(coroutine) == LUA_OK && lua_gettop(coroutine) == 0)
        return luaL_error(L, "cannot resume dead coroutine");
    if (!lua_checkstack(coroutine, count))
        return luaL_error(L, "too many arguments to resume");
    lua_xmove(L, coroutine, count);
    int status = lua_resume(coroutine, L, count, &results);
    if (status != LUA_OK && status != LUA_YIELD) {
        lua_xmove(coroutine, L, 1);
        return lua_error(L);
    }
    luaL_checkstack(L, results, "too many results to resume");
    lua_xmove(coroutine, L, results);
    return results;
}

static int safe_wrap(lua_State *L)
{
    luaL_checktype(L, 1, LUA_TFUNCTION);
    lua_State *coroutine = lua_newthread(L);
    lua_pushvalue(L, 1);
    lua_xmove(L, coroutine, 1);
    lua_pushcclosure(L, call_wrapped, 1);
    return 1;
}

static int print_line(lua_State *L)
{
    int count = lua_gettop(L);
    luaL_Buffer line;
    luaL_buffinit(L, &line);
    for (int i = 1; i <= count; i++) {
        if (i > 1)
            luaL_addchar(&line, ' ');
        script_push_text(L, i);
        luaL_addvalue(&line);
    }
    luaL_pushresult(&line);
    script_charge(L, LINE_COST + LINE_COST_BYTE * (int64_t)lua_rawlen(L, -1));
    kd_log(KD_LOG_INFO, "%s: %s", script_of(L)->path, script_push_shown(L, lua_gettop(L)));
    return 0;
}

/* ---- maths library ---- */

/* Upvalue: math.randomseed, which without argument would take the time. */
static int seeded_randomseed(lua_State *L)
{
    luaL_checknumber(L, 1);
    int count = lua_gettop(L);
    lua_pushvalue(L, lua_upvalueindex(1));
    lua_insert(L, 1);
    lua_call(L, count, 0);
    return 0;
}

static void seed_math_library(lua_State *L, uint64_t seed)
{
    lua_getglobal(L, "math");
    lua_getfield(L, -1, "randomseed");
    lua_pushvalue(L, -1);
    lua_pushinteger(L, (lua_Integer)seed);
    lua_call(L, 1, 0);
    lua_pushcclosure(L, seeded_randomseed, 1);
    lua_setfield(L, -2, "randomseed");
    lua_pop(L, 1);
}

static void replace_base_library(lua_State *L)
{
    static const char *const removed[] = {"dofile", "loadfile", "collectgarbage", "warn", "require", NULL};
    for (size_t i = 0; removed[i]; i++) {
        lua_pushnil(L);
        lua_setglobal(L, removed[i]);
    }
    lua_register(L, "load", safe_load);
    lua_register(L, "setmetatable", safe_setmetatable);
    lua_register(L, "xpcall", safe_xpcall);
    lua_register(L, "print", print_line);
    lua_getglobal(L, "coroutine");
    lua_pushcfunction(L, safe_wrap);
    lua_setfield(L, -2, "wrap");
    lua_pushnil(L);
    lua_setfield(L, -2, "close");
    lua_pop(L, 1);
}

void script_sandbox_open(lua_State *L, uint64_t seed)
{
    static const luaL_Reg libraries[] = {
        {LUA_GNAME, luaopen_base},       {LUA_TABLIBNAME, luaopen_table}, {LUA_STRLIBNAME, luaopen_string},
        {LUA_MATHLIBNAME, luaopen_math}, {LUA_UTF8LIBNAME, luaopen_utf8}, {LUA_COLIBNAME, luaopen_coroutine},
    };
    for (size_t i = 0; i < sizeof libraries / sizeof *libraries; i++) {
        luaL_requiref(L, libraries[i].name, libraries[i].func, 1);
        lua_pop(L, 1);
    }
    lua_pushnil(L); /* requiref's list of loaded modules */
    lua_setfield(L, LUA_REGISTRYINDEX, LUA_LOADED_TABLE);
    replace_base_library(L);
    script_sandbox_table(L);
    script_sandbox_string(L);
    script_sandbox_walks(L);
    script_order_open(L);
    script_text_open(L);
    seed_math_library(L, seed);
}

lua_State *script_sandbox_make(kd_script *script)
{
    lua_State *L = lua_newstate(allocate, &script->budget);
    if (!L)
        return NULL;
    *(kd_script **)lua_getextraspace(L) = script;
    lua_gc(L, LUA_GCINC, GC_PAUSE, 0, 0);
    return L;
}
