/* require and kandil.param: what a scenario takes from files beside it and from the command line. */
#include <stdlib.h>
#include <string.h>

#include "runtime/core/log.h"
#include "runtime/core/nearest.h"
#include "runtime/script/internal.h"

#define MAX_SOURCE_BYTES ((size_t)16 << 20)
#define MAX_MODULES      1000

static const char loaded_key; /* its address keys the registry's table: path to value; true while it loads */

/* ---- require ---- */

bool script_add_chunk(kd_script *script, const char *shown, const char *path)
{
    if (script->chunk_count == MAX_MODULES)
        return false;
    script_chunk *grown = realloc(script->chunks, (script->chunk_count + 1) * sizeof *grown);
    if (!grown)
        return false;
    script->chunks = grown;
    script_chunk *chunk = &grown[script->chunk_count];
    size_t length = strlen(shown), room = sizeof chunk->name - 8; /* Lua cuts names of more than 59 */
    snprintf(chunk->name, sizeof chunk->name, "%s", length > room ? shown + length - room : shown);
    chunk->path = strdup(path);
    script->chunk_count += chunk->path != NULL;
    return chunk->path != NULL;
}

const script_chunk *script_chunk_of(const kd_script *script, const char *message)
{
    for (uint32_t i = 0; i < script->chunk_count; i++) {
        size_t length = strlen(script->chunks[i].name);
        if (strncmp(message, script->chunks[i].name, length) == 0 && message[length] == ':')
            return &script->chunks[i];
    }
    return NULL;
}

/* "parts.walls" stands for parts/walls.lua; a name with a slash or .lua stands for itself. */
static void file_name(lua_State *L, const char *name, char out[KD_PATH_MAX])
{
    size_t length = strlen(name);
    bool is_path = strchr(name, '/') || kd_path_has_extension(name, ".lua");
    if (length > 512)
        luaL_error(L, "require: a name of %d characters is too long; shorten it", (int)length);
    if (!*name)
        luaL_error(L, "require: '%s' is no module name; give a file beside the scenario", name);
    memcpy(out, name, length + 1);
    if (is_path)
        return;
    for (size_t i = 0; i < length; i++)
        out[i] = name[i] == '.' ? '/' : name[i];
    memcpy(out + length, ".lua", 5);
}

/* Push the module's function. */
static void load_module(lua_State *L, const char *shown, const char *path)
{
    kd_script *script = script_of(L);
    void *data;
    size_t size;
    if (!script_add_chunk(script, shown, path))
        luaL_error(L, "require: no room for '%s'; load fewer modules", shown);
    kd_status status = kd_file_read(path, MAX_SOURCE_BYTES, &data, &size);
    if (status != KD_OK)
        luaL_error(L, "require: '%s' cannot be read; check the file", shown);
    char name[sizeof script->chunks->name + 2];
    snprintf(name, sizeof name, "@%s", script->chunks[script->chunk_count - 1].name);
    script->budget.instructions_left -= (int64_t)size;
    int result = luaL_loadbufferx(L, data, size, name, "t");
    free(data);
    if (result != LUA_OK)
        lua_error(L);
}

static int require(lua_State *L)
{
    char name[KD_PATH_MAX], path[KD_PATH_MAX];
    lua_settop(L, 1);
    file_name(L, luaL_checkstring(L, 1), name);
    script_resolve(L, name, path);
    lua_rawgetp(L, LUA_REGISTRYINDEX, &loaded_key);
    if (lua_getfield(L, 2, path) != LUA_TNIL) {
        if (lua_rawequal(L, 3, 2))
            return luaL_error(L, "require: '%s' needs itself, or has failed before; break the circle", name);
        return 1;
    }
    lua_settop(L, 2);
    lua_pushvalue(L, 2); /* the list itself stands for what is under way */
    lua_setfield(L, 2, path);
    load_module(L, name, path);
    lua_pushvalue(L, 1);
    lua_call(L, 1, 1);
    if (lua_isnil(L, 3)) {
        lua_pushboolean(L, 1);
        lua_replace(L, 3);
    }
    lua_pushvalue(L, 3);
    lua_setfield(L, 2, path);
    return 1;
}

void script_module_open(lua_State *L)
{
    lua_newtable(L);
    lua_rawsetp(L, LUA_REGISTRYINDEX, &loaded_key);
    lua_register(L, "require", require);
}

/* ---- parameters ---- */

/* Find NAME=value of the command line; marks it as asked for. */
static const char *find_param(kd_script *script, const char *name)
{
    const char *found = NULL;
    size_t length = strlen(name);
    for (uint32_t i = 0; i < script->param_count; i++) {
        script_param *p = &script->params[i];
        if (strncmp(p->text, name, length) != 0 || p->text[length] != '=')
            continue;
        p->asked = true;
        found = p->text + length + 1; /* the last one said counts */
    }
    return found;
}

static void push_param(lua_State *L, const char *name, const char *text)
{
    switch (lua_type(L, 2)) {
    case LUA_TNUMBER:
        if (!lua_stringtonumber(L, text))
            luaL_error(L, "--set param.%s=%s: it must be a number; correct it", name, text);
        if (lua_isinteger(L, 2) && !lua_isinteger(L, -1))
            luaL_error(L, "--set param.%s=%s: it must be a whole number; correct it", name, text);
        return;
    case LUA_TBOOLEAN: {
        static const char *const words[] = {"off", "on", "false", "true", "0", "1", NULL};
        for (int i = 0; words[i]; i++) {
            if (strcmp(words[i], text) == 0) {
                lua_pushboolean(L, i % 2);
                return;
            }
        }
        luaL_error(L, "--set param.%s=%s: it must be on or off; correct it", name, text);
        return;
    }
    default: lua_pushstring(L, text); return;
    }
}

/* kandil.param("name", default): what `--set param.name=value` says, read as the default's kind. */
int script_param_get(lua_State *L)
{
    kd_script *script = script_of(L);
    const char *name = luaL_checkstring(L, 1);
    lua_settop(L, 2);
    if (lua_type(L, 2) != LUA_TNUMBER && lua_type(L, 2) != LUA_TBOOLEAN && lua_type(L, 2) != LUA_TSTRING)
        return luaL_error(
            L, "kandil.param: the default must be a number, a string, true or false, not a %s; give one",
            luaL_typename(L, 2));
    if (strcspn(name, "=") != strlen(name) || !*name)
        return luaL_error(L, "kandil.param: '%s' is no name; use letters, digits and _", name);
    const char *text = find_param(script, name);
    if (script->param_names_count < SCRIPT_MAX_PARAM_NAMES) /* for the message about what nobody asked for */
        snprintf(script->param_names[script->param_names_count++], sizeof *script->param_names, "%s", name);
    if (text)
        push_param(L, name, text);
    return 1;
}

kd_status script_check_params(const kd_script *script)
{
    for (uint32_t i = 0; i < script->param_count; i++) {
        char name[64];
        if (script->params[i].asked)
            continue;
        snprintf(name, sizeof name, "%.*s", (int)strcspn(script->params[i].text, "="),
                 script->params[i].text);
        kd_nearest near = kd_nearest_to(name);
        for (uint32_t k = 0; k < script->param_names_count; k++)
            kd_nearest_offer(&near, script->param_names[k]);
        if (near.best)
            return kd_fail(KD_USAGE, "--set param.%s: %s has no such parameter; did you mean '%s'?", name,
                           script->path, near.best);
        return kd_fail(KD_USAGE, "--set param.%s: %s asks for no such parameter while it loads; leave it out",
                       name, script->path);
    }
    return KD_OK;
}
