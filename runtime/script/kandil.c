/* The table `kandil` of a scenario. Its functions cannot be replaced; those that the runtime calls
 * (script_callbacks) are the scenario's to set. */
#include "runtime/script/internal.h"

#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "runtime/core/log.h"
#include "runtime/core/nearest.h"

/* ---- kandil.scene ---- */

static void set_setting(lua_State *L, const char *key, int value)
{
    kd_script *script = script_of(L);
    kd_script_error error = {""};
    if (lua_isboolean(L, value))
        lua_pushfstring(L, "%s=%s", key, lua_toboolean(L, value) ? "on" : "off");
    else if (lua_isnumber(L, value) || lua_isstring(L, value))
        lua_pushfstring(L, "%s=%s", key, luaL_tolstring(L, value, NULL));
    else
        luaL_error(L, "settings.%s must be a number, a word, true or false, not a %s; correct it", key,
                   luaL_typename(L, value));
    kd_status status =
        script->host.set ? script->host.set(script->host.user, lua_tostring(L, -1), &error) : KD_UNSUPPORTED;
    if (status != KD_OK)
        luaL_error(L, "settings: %s", error.text);
}

/* Set what the table at `table` says: { ["voxels.span"] = 0.05 } or { voxels = { span = 0.05 } }. */
static void read_settings(lua_State *L, int table, const char *group)
{
    luaL_checkstack(L, 8, "settings");
    for (lua_pushnil(L); lua_next(L, table);) {
        int top = lua_gettop(L);
        if (lua_type(L, top - 1) != LUA_TSTRING)
            luaL_error(L, "settings: entries without a name are not allowed; write [\"voxels.span\"] = 0.05");
        const char *key = lua_tostring(L, top - 1);
        if (group)
            key = lua_pushfstring(L, "%s.%s", group, key);
        if (!group && lua_istable(L, top))
            read_settings(L, top, key);
        else
            set_setting(L, key, top);
        lua_settop(L, top - 1);
    }
}

static void read_size(lua_State *L, kd_script_scene *scene)
{
    float size[2];
    if (!script_get_floats(L, 1, "kandil.scene", "size", size, 2))
        return;
    for (int i = 0; i < 2; i++)
        if (size[i] < 1 || size[i] > 16384 || size[i] != floorf(size[i]))
            luaL_error(L, "kandil.scene.size[%d] must be a whole number from 1 to 16384, not %f; correct it",
                       i + 1, (double)size[i]);
    scene->width = (uint32_t)size[0];
    scene->height = (uint32_t)size[1];
}

static int kandil_scene(lua_State *L)
{
    static const char *const keys[] = {"size",     "fps",         "seconds", "gi", "view",
                                       "settings", "exposure_ev", "ambient", NULL};
    static const char *const shortcuts[][2] = {{"exposure_ev", "view.exposure_ev"},
                                               {"ambient", "light.ambient"}};
    kd_script *script = script_of(L);
    kd_script_scene scene = {0};
    kd_script_error error = {""};
    luaL_checktype(L, 1, LUA_TTABLE);
    lua_settop(L, 1);
    script_check_keys(L, 1, "kandil.scene", keys);
    read_size(L, &scene);
    scene.fps = script_get_number(L, 1, "kandil.scene", "fps", 0, 0.001, 10000);
    scene.seconds = script_get_number(L, 1, "kandil.scene", "seconds", 0, 0, 1e6);
    scene.gi = script_get_string(L, 1, "kandil.scene", "gi");
    scene.view = script_get_string(L, 1, "kandil.scene", "view");
    for (size_t i = 0; i < sizeof shortcuts / sizeof *shortcuts; i++) {
        if (lua_getfield(L, 1, shortcuts[i][0]) != LUA_TNIL)
            set_setting(L, shortcuts[i][1], 2);
        lua_settop(L, 1);
    }
    if (lua_getfield(L, 1, "settings") == LUA_TTABLE)
        read_settings(L, 2, NULL);
    else if (!lua_isnil(L, 2))
        return luaL_error(L, "kandil.scene.settings must be a table, not a %s; correct it",
                          luaL_typename(L, 2));
    if (script->host.scene && script->host.scene(script->host.user, &scene, &error) != KD_OK)
        return luaL_error(L, "kandil.scene: %s", error.text);
    return 0;
}

/* ---- the rest ---- */

static int kandil_log(lua_State *L)
{
    luaL_checkany(L, 1);
    lua_getglobal(L, "print");
    lua_insert(L, 1);
    lua_call(L, lua_gettop(L) - 1, 0);
    return 0;
}

static int kandil_spawn(lua_State *L)
{
    script_charge(L, 500); /* it costs far more than an instruction: 100000 in one call are enough */
    return script_spawn(L);
}

/* kandil.set("voxels.span", 0.05): a setting, from the next step on. */
static int kandil_set(lua_State *L)
{
    const char *key = luaL_checkstring(L, 1);
    luaL_checkany(L, 2);
    lua_settop(L, 2);
    set_setting(L, key, 2);
    return 0;
}

static int kandil_time(lua_State *L)
{
    double time_s = script_of(L)->step_s;
    lua_pushnumber(L, time_s < 0 ? 0 : time_s);
    return 1;
}

const script_function script_functions[] = {
    {"scene", kandil_scene, "kandil.scene { size, fps, seconds, gi, view, settings }",
     "what is to be rendered, said while the scenario loads"},
    {"spawn", kandil_spawn,
     "kandil.spawn { name, model, mesh, material, animation, parent, component = {…} }",
     "make an entity; returns its handle"},
    {"find", script_find, "kandil.find(\"name\")", "the entity named so first, or nil"},
    {"query", script_query, "for e, light in kandil.query(\"light\", \"!camera\", \"?animation\") do",
     "walk the entities that have these components, lack those with `!`, and give nil for those with `?` "
     "that are missing"},
    {"get", script_get_singleton, "kandil.get(\"frame.dt_s\")",
     "read, in a step, a field of a component that the world has one of"},
    {"set", kandil_set, "kandil.set(\"view.exposure_ev\", 1)", "change a setting from the next step on"},
    {"param", script_param_get, "kandil.param(\"name\", default)",
     "what `--set param.name=value` says, of the default's kind, else the default"},
    {"time", kandil_time, "kandil.time()", "time of the step, seconds; 0 while the scenario loads"},
    {"at", script_at, "kandil.at(time, f)",
     "call f(t) once, in the first step at or after that time; returns a task"},
    {"every", script_every, "kandil.every(period, f)",
     "call f(t) again and again, first after one period, until it returns false; returns a task"},
    {"run", script_run, "kandil.run(f, …)", "run f(…) as a coroutine that may wait; returns a task"},
    {"wait", script_wait, "kandil.wait(seconds), kandil.wait(task, …), kandil.wait()",
     "in a coroutine: go on that much later, when all these tasks have ended, in the next step"},
    {"tween", script_tween_start,
     "kandil.tween(e, \"component.field\", value, seconds, \"easing\"), kandil.tween(f, seconds, \"easing\")",
     "move a field to a value, or call f(share) every step; returns a task"},
    {"ease", script_ease_value, "kandil.ease(\"easing\", share)", "value of an easing curve"},
    {"path", script_path, "kandil.path { {x, y, z}, …, closed = false }", "a smooth curve through points"},
    {"follow", script_follow, "kandil.follow(e, path, seconds, { easing, loop, look_at })",
     "move an entity along a path at constant speed, or by an easing; returns a task"},
    {"key", script_key, "kandil.key(\"space\")",
     "whether a key or button of the mouse is held; never without a window"},
    {"log", kandil_log, "kandil.log(…)", "write a line; as print"},
    {NULL, NULL, NULL, NULL},
};

static _Noreturn void unknown_member(lua_State *L, const char *key)
{
    kd_nearest near = kd_nearest_to(key);
    for (const script_function *f = script_functions; f->name; f++)
        kd_nearest_offer(&near, f->name);
    for (const script_function *f = script_callbacks; f->name; f++)
        kd_nearest_offer(&near, f->name);
    if (near.best)
        luaL_error(L, "kandil.%s does not exist; did you mean kandil.%s?", key, near.best);
    luaL_error(L, "kandil.%s does not exist; `kandil help scenario` lists what does", key);
    for (;;)
        ; /* luaL_error never returns, but is not declared so */
}

/* Number of a function that the scenario may set; raises for any other name. */
static int callback_at(lua_State *L, int index)
{
    const char *key = luaL_checkstring(L, index);
    for (int i = 0; i < KD_SCRIPT_CALLBACK_COUNT; i++)
        if (strcmp(key, script_callbacks[i].name) == 0)
            return i;
    unknown_member(L, key);
}

static int kandil_index(lua_State *L)
{
    lua_rawgeti(L, LUA_REGISTRYINDEX, script_of(L)->callbacks[callback_at(L, 2)]);
    return 1;
}

static int kandil_newindex(lua_State *L)
{
    kd_script *script = script_of(L);
    int which = callback_at(L, 2);
    if (!lua_isnil(L, 3) && !lua_isfunction(L, 3))
        return luaL_error(L, "kandil.%s must be a function, not a %s; write %s … end",
                          script_callbacks[which].name, luaL_typename(L, 3), script_callbacks[which].usage);
    luaL_unref(L, LUA_REGISTRYINDEX, script->callbacks[which]);
    script->callbacks[which] = LUA_NOREF;
    lua_settop(L, 3);
    if (!lua_isnil(L, 3))
        script->callbacks[which] = luaL_ref(L, LUA_REGISTRYINDEX);
    return 0;
}

void script_kandil_open(lua_State *L)
{
    script_push_functions(L, script_functions);
    lua_newtable(L);
    lua_pushcfunction(L, kandil_index);
    lua_setfield(L, -2, "__index");
    lua_pushcfunction(L, kandil_newindex);
    lua_setfield(L, -2, "__newindex");
    lua_pushliteral(L, "protected");
    lua_setfield(L, -2, "__metatable");
    lua_setmetatable(L, -2);
    lua_setglobal(L, "kandil");
}
