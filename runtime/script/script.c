/* Loads, steps and closes a scenario; turns every Lua error into one message `FILE:LINE: what is wrong; what
 * to do`. */
#include "runtime/script/script.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "runtime/core/log.h"
#include "runtime/ecs/query.h"
#include "runtime/script/internal.h"

#define MAX_SOURCE_BYTES ((size_t)16 << 20)

/* ---- messages ---- */

/* Copy in one line and at most `size` bytes; cut characters stay whole. */
static void copy_line(char *out, size_t size, const char *text)
{
    size_t n = 0;
    for (; text[n] && n + 1 < size; n++)
        out[n] = (unsigned char)text[n] < 32 || text[n] == 127 ? ' ' : text[n];
    if (text[n])
        while (n > 0 && ((unsigned char)text[n] & 0xC0) == 0x80)
            n--;
    out[n] = '\0';
}

/* Tell whether a message says already what to do. */
static bool has_advice(const char *text)
{
    return strstr(text, "; ") != NULL;
}

static kd_status report(kd_script *script, int result)
{
    char line[768];
    lua_State *L = script->L;
    const script_budget *budget = &script->budget;
    if (script_is_stopped(script)) {
        lua_pop(L, 1);
        return KD_INTERRUPTED;
    }
    if (result == LUA_ERRMEM) {
        if (budget->over_memory)
            return kd_fail(KD_SCRIPT,
                           "%s: needs more than %zu MiB of memory; keep less in its tables and strings",
                           script->path, budget->memory_limit >> 20);
        return kd_fail(KD_NO_MEMORY, "%s: out of memory", script->path);
    }
    const char *text = lua_tostring(L, -1);
    copy_line(line, sizeof line,
              text ? text : "stopped with an error that is no text; give error() a string");
    lua_pop(L, 1);
    const script_chunk *chunk = script_chunk_of(script, line);
    return kd_fail(KD_SCRIPT, "%s%s%s%s", chunk ? chunk->path : script->path, chunk ? "" : ": ",
                   chunk ? line + strlen(chunk->name) : line,
                   has_advice(line) ? "" : "; correct the scenario there");
}

void script_explain(lua_State *L)
{
    lua_Debug activation;
    if (lua_type(L, -1) != LUA_TSTRING && luaL_getmetafield(L, -1, "__tostring") != LUA_TNIL) {
        lua_pop(L, 1);
        luaL_tolstring(L, -1, NULL);
        lua_remove(L, -2);
    }
    const char *text = lua_tostring(L, -1);
    if (!text || script_chunk_of(script_of(L), text))
        return;
    for (int level = 0; lua_getstack(L, level, &activation); level++) {
        if (lua_getinfo(L, "Sl", &activation) && activation.currentline > 0) {
            lua_pushfstring(L, "%s:%d: ", activation.short_src, activation.currentline);
            lua_insert(L, -2);
            lua_concat(L, 2);
            return;
        }
    }
}

/* Runs inside the protected call, before the stack is unwound. An error value with __tostring speaks through
 * it. */
static int message_handler(lua_State *L)
{
    script_explain(L);
    return 1;
}

/* Call the function below its `count` arguments, with a fresh budget. */
static kd_status call(kd_script *script, int count)
{
    lua_State *L = script->L;
    int handler = lua_gettop(L) - count;
    lua_pushcfunction(L, message_handler);
    lua_insert(L, handler);
    script_budget_start(script);
    int result = lua_pcall(L, count, 0, handler);
    lua_remove(L, handler);
    return result == LUA_OK ? KD_OK : report(script, result);
}

/* ---- loading ---- */

static kd_status add_roots(kd_script *script, const kd_script_desc *desc)
{
    script->roots = calloc(desc->root_count + 1, sizeof *script->roots);
    if (!script->roots)
        return kd_fail(KD_NO_MEMORY, "%s: out of memory", desc->path);
    kd_status status = kd_path_folder(script->roots[0], KD_PATH_MAX, desc->path);
    script->root_count = 1;
    for (uint32_t i = 0; i < desc->root_count && status == KD_OK; i++)
        status = kd_path_join(script->roots[script->root_count++], KD_PATH_MAX, ".", desc->roots[i]);
    return status;
}

static int open_all(lua_State *L)
{
    const uint64_t *seed = lua_touserdata(L, 1);
    script_sandbox_open(L, *seed);
    script_access_open(L);
    script_module_open(L);
    script_entity_open(L);
    script_task_open(L);
    script_tween_open(L);
    script_kandil_open(L);
    return 0;
}

/* Make the Lua state with everything that a scenario sees. */
static kd_status open_state(kd_script *script, const kd_script_desc *desc)
{
    uint64_t seed = desc->seed;
    script->L = script_sandbox_make(script);
    if (!script->L)
        return kd_fail(KD_NO_MEMORY, "%s: out of memory", desc->path);
    script_budget_start(script);
    lua_pushcfunction(script->L, open_all);
    lua_pushlightuserdata(script->L, &seed);
    int result = lua_pcall(script->L, 1, 0, 0);
    return result == LUA_OK ? KD_OK : report(script, result);
}

static kd_status run_file(kd_script *script)
{
    void *data;
    size_t size;
    char name[sizeof script->chunks->name + 2];
    kd_status status = kd_file_read(script->path, MAX_SOURCE_BYTES, &data, &size);
    if (status != KD_OK)
        return status;
    snprintf(name, sizeof name, "@%s", script->chunks[0].name);
    script_budget_start(script);
    int result = luaL_loadbufferx(script->L, data, size, name, "t");
    free(data);
    return result == LUA_OK ? call(script, 0) : report(script, result);
}

static kd_script *make(const kd_script_desc *desc)
{
    kd_script *script = calloc(1, sizeof *script);
    if (!script)
        return NULL;
    script->world = desc->world;
    script->host = desc->host;
    for (int i = 0; i < KD_SCRIPT_CALLBACK_COUNT; i++)
        script->callbacks[i] = LUA_NOREF;
    script->budget.memory_limit = desc->memory_limit ? desc->memory_limit : (size_t)256 << 20;
    script->instruction_limit = desc->instruction_limit ? desc->instruction_limit : 50000000;
    script->time_limit_ns = (uint64_t)((desc->time_limit_s > 0 ? desc->time_limit_s : 5) * 1e9);
    snprintf(script->path, sizeof script->path, "%s", desc->path);
    script->step_s = -1;
    return script;
}

static kd_status add_params(kd_script *script, const kd_script_desc *desc)
{
    script->params = calloc(desc->param_count + 1, sizeof *script->params);
    script->param_names = calloc(SCRIPT_MAX_PARAM_NAMES, sizeof *script->param_names);
    bool ok = script->params && script->param_names;
    for (uint32_t i = 0; i < desc->param_count && ok; i++) {
        script->params[i].text = strdup(desc->params[i]);
        ok = script->params[i].text != NULL;
        script->param_count += ok;
    }
    ok = ok && script_add_chunk(script, kd_path_name(desc->path), desc->path);
    return ok ? KD_OK : kd_fail(KD_NO_MEMORY, "%s: out of memory", desc->path);
}

kd_status kd_script_load(const kd_script_desc *desc, kd_script **out)
{
    *out = NULL;
    kd_script *script = make(desc);
    if (!script)
        return kd_fail(KD_NO_MEMORY, "%s: out of memory", desc->path);
    kd_status status = add_roots(script, desc);
    if (status == KD_OK)
        status = add_params(script, desc);
    if (status == KD_OK)
        status = open_state(script, desc);
    if (status == KD_OK)
        status = run_file(script);
    if (status == KD_OK)
        status = script_check_params(script);
    if (status == KD_OK)
        *out = script;
    else
        kd_script_destroy(script);
    return status;
}

/* ---- stepping ---- */

/* Time and length of the step are on the stack. */
static int run_step(lua_State *L)
{
    script_run_inputs(L);
    script_run_due(L, lua_tonumber(L, 1));
    if (!kd_script_listens(script_of(L), KD_SCRIPT_UPDATE))
        return 0;
    lua_rawgeti(L, LUA_REGISTRYINDEX, script_of(L)->callbacks[KD_SCRIPT_UPDATE]);
    lua_insert(L, 1);
    lua_call(L, 2, 0);
    return 0;
}

kd_status kd_script_step(kd_script *script, double time_s, double dt_s)
{
    script->step_length_s = dt_s;
    lua_pushcfunction(script->L, run_step);
    lua_pushnumber(script->L, time_s);
    lua_pushnumber(script->L, dt_s);
    return call(script, 2);
}

uint32_t kd_script_file_count(const kd_script *script)
{
    return script->chunk_count;
}

const char *kd_script_file(const kd_script *script, uint32_t index)
{
    return script->chunks[index].path;
}

size_t kd_script_bytes(const kd_script *script)
{
    return script->budget.memory_used;
}

void kd_script_destroy(kd_script *script)
{
    if (!script)
        return;
    if (script->L)
        lua_close(script->L);
    script_pool_fini(&script->budget.pool);
    for (uint32_t i = 0; i < script->query_count; i++)
        kd_query_destroy(script->queries[i]);
    for (uint32_t i = 0; i < script->chunk_count; i++)
        free(script->chunks[i].path);
    for (uint32_t i = 0; i < script->param_count; i++)
        free(script->params[i].text);
    free(script->queries);
    free(script->chunks);
    free(script->params);
    free(script->param_names);
    free(script->events);
    free(script->active);
    free(script->roots);
    free(script);
}
