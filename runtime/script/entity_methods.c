/* What entity handles can do: e:set, e:play, e:clone … */
#include "runtime/ecs/instance.h"
#include "runtime/script/internal.h"

#include <math.h>
#include <string.h>

/* ---- values ---- */

static int entity_set(lua_State *L)
{
    kd_component_id id;
    const script_access *access;
    kd_entity e = script_check_entity(L, 1);
    luaL_checkany(L, 3);
    script_path_at(L, e, 2, &id, &access);
    script_write(L, e, id, access, 3);
    lua_settop(L, 1);
    return 1; /* so that calls can be chained */
}

static int entity_get(lua_State *L)
{
    kd_component_id id;
    const script_access *access;
    kd_entity e = script_check_entity(L, 1);
    script_path_at(L, e, 2, &id, &access);
    script_push_field(L, access, kd_find_id(script_of(L)->world, e, id));
    return 1;
}

static int entity_has(lua_State *L)
{
    kd_entity e = script_check_entity(L, 1);
    kd_world *w = script_of(L)->world;
    kd_component_id id = kd_component_find(w, luaL_checkstring(L, 2));
    lua_pushboolean(L, id && kd_find_id(w, e, id));
    return 1;
}

static int entity_components(lua_State *L)
{
    kd_entity e = script_check_entity(L, 1);
    kd_world *w = script_of(L)->world;
    lua_Integer count = 0;
    lua_newtable(L);
    for (kd_component_id id = 1; id <= kd_component_count(w); id++) {
        if (!kd_find_id(w, e, id))
            continue;
        lua_pushstring(L, kd_component_info(w, id)->name);
        lua_rawseti(L, -2, ++count);
    }
    return 1;
}

static int entity_enable(lua_State *L)
{
    kd_entity e = script_check_entity(L, 1);
    kd_component_id id = script_check_component(L, e, 2);
    const kd_component_desc *desc = kd_component_info(script_of(L)->world, id);
    if (!(desc->flags & KD_COMPONENT_TOGGLE))
        return luaL_error(L, "%s cannot be switched off; set one of its fields", desc->name);
    if (kd_enable_id(script_of(L)->world, e, id, lua_isnone(L, 3) || lua_toboolean(L, 3)) != KD_OK)
        return luaL_error(L, "out of memory");
    lua_settop(L, 1);
    return 1;
}

/* e:look_at(point) or e:look_at(entity): a point is below the same parent as e, an entity anywhere. */
static int entity_look_at(lua_State *L)
{
    kd_entity e = script_check_entity(L, 1);
    kd_component_id id;
    const script_access *access;
    lua_settop(L, 2);
    lua_pushliteral(L, "transform.look_at");
    script_path_at(L, e, 3, &id, &access);
    script_write(L, e, id, access, 2);
    lua_settop(L, 1);
    return 1;
}

/* ---- animation ---- */

static int entity_play(lua_State *L)
{
    kd_entity e = script_check_entity(L, 1);
    kd_script *script = script_of(L);
    kd_script_play play = {.clip = luaL_optstring(L, 2, NULL), .loop = true, .speed = 1, .weight = 1};
    if (!lua_isnoneornil(L, 3)) {
        luaL_checktype(L, 3, LUA_TTABLE);
        script_read_play(L, 3, "play", &play);
    }
    script_play(L, e, &play);
    if (!play.layer)
        script_clip_started(script, e);
    lua_settop(L, 1);
    return 1;
}

/* e:stop(layer, seconds): fade a layer out. */
static int entity_stop(lua_State *L)
{
    kd_entity e = script_check_entity(L, 1);
    lua_Integer layer = luaL_checkinteger(L, 2);
    double blend_s = luaL_optnumber(L, 3, 0);
    if (layer < 1 || layer > 3)
        return luaL_error(L,
                          "layer %I does not exist; choose 1, 2 or 3, or pause by e.animation.paused = true",
                          (LUAI_UACINT)layer);
    script_check_range(L, "the time of e:stop", blend_s, 0, 3600);
    script_play(L, e, &(kd_script_play){.layer = (uint32_t)layer, .stop = true, .blend_s = (float)blend_s});
    lua_settop(L, 1);
    return 1;
}

/* ---- life ---- */

static int entity_destroy(lua_State *L)
{
    kd_destroy(script_of(L)->world, script_check_entity(L, 1));
    return 0;
}

static int entity_alive(lua_State *L)
{
    lua_pushboolean(L, kd_alive(script_of(L)->world, script_handle(L, 1)));
    return 1;
}

/* e:clone{name = …, parent = …, transform = {…}, …}: a copy of it and of what hangs below it. */
static int entity_clone(lua_State *L)
{
    kd_script *script = script_of(L);
    kd_entity e = script_check_entity(L, 1), copy = KD_NO_ENTITY, parent = kd_get_parent(script->world, e);
    kd_script_error error = {""};
    lua_settop(L, 2);
    if (lua_isnil(L, 2)) {
        lua_newtable(L);
        lua_replace(L, 2);
    }
    luaL_checktype(L, 2, LUA_TTABLE);
    script_charge(L, 500); /* as kandil.spawn */
    script_check_spawn_keys(L, 2, "clone");
    if (lua_getfield(L, 2, "parent") != LUA_TNIL)
        parent = script_check_entity(L, 3);
    lua_settop(L, 2);
    for (kd_entity up = parent; up.generation; up = kd_get_parent(script->world, up))
        if (kd_entity_equal(up, e))
            return luaL_error(L, "a copy cannot hang below what is copied; choose another parent");
    const char *name = script_get_string(L, 2, "clone", "name");
    uint64_t before = kd_entity_count(script->world);
    script_look(L);
    kd_status status = script->host.clone ? script->host.clone(script->host.user, e, parent, &copy, &error)
                                          : kd_instantiate(script->world, e, parent, 1, &copy);
    script_host_check(L, status, &error);
    script_charge_entities(L, before);
    if (kd_set_name(script->world, copy, name ? name : kd_get_name(script->world, e)) != KD_OK)
        return luaL_error(L, "out of memory");
    script_set_components(L, 2, copy);
    script_push_entity(L, copy);
    return 1;
}

/* ---- hierarchy ---- */

/* Find a descendant by name, parents before children, without recursion. */
static kd_entity find_below(const kd_world *w, kd_entity root, const char *name)
{
    kd_entity e = kd_first_child(w, root);
    while (e.generation) {
        if (strcmp(kd_get_name(w, e), name) == 0)
            return e;
        kd_entity next = kd_first_child(w, e);
        while (!next.generation && !kd_entity_equal(e, root)) {
            next = kd_next_sibling(w, e);
            if (!next.generation)
                e = kd_get_parent(w, e);
        }
        e = next;
    }
    return KD_NO_ENTITY;
}

static int entity_child(lua_State *L)
{
    kd_entity e = script_check_entity(L, 1);
    const char *name = luaL_checkstring(L, 2);
    kd_entity child = find_below(script_of(L)->world, e, name);
    if (!child.generation)
        return luaL_error(L, "the entity '%s' has no child '%s'; `kandil info` lists a model's nodes",
                          kd_get_name(script_of(L)->world, e), name);
    script_push_entity(L, child);
    return 1;
}

static int entity_children(lua_State *L)
{
    kd_world *w = script_of(L)->world;
    kd_entity e = script_check_entity(L, 1);
    lua_Integer count = 0;
    lua_newtable(L);
    for (kd_entity c = kd_first_child(w, e); c.generation; c = kd_next_sibling(w, c)) {
        script_push_entity(L, c);
        lua_rawseti(L, -2, ++count);
    }
    script_charge(L, count);
    return 1;
}

const script_function script_entity_methods[] = {
    {"set", entity_set, "e:set(\"component.field\", value)",
     "set a field; returns e, so that calls can be chained"},
    {"get", entity_get, "e:get(\"component.field\")", "read a field; a list is a copy"},
    {"has", entity_has, "e:has(\"component\")", "tell whether it has a component"},
    {"components", entity_components, "e:components()", "list the names of its components"},
    {"enable", entity_enable, "e:enable(\"component\", on)",
     "show a component to systems or hide it, where it allows that"},
    {"look_at", entity_look_at, "e:look_at(point or entity)",
     "turn it so that its -z points there; a point is relative to e's parent, an entity may hang anywhere"},
    {"play", entity_play, "e:play(\"clip\", { loop, speed, blend, layer, weight, from })",
     "play a clip of its model from the start; with layer = 1 to 3 lay it over the pose, below node `from` "
     "alone"},
    {"stop", entity_stop, "e:stop(layer, seconds)", "fade a layer out"},
    {"on_clip", script_on_clip, "e:on_clip(\"clip\", time, f)",
     "call f(e) whenever its animation passes that time of the clip; returns a task"},
    {"clone", entity_clone, "e:clone { name, parent, component = {…} }", "copy it and what hangs below it"},
    {"child", entity_child, "e:child(\"name\")",
     "find what hangs below it: a node of its model, or another descendant"},
    {"children", entity_children, "e:children()", "list what hangs directly below it"},
    {"destroy", entity_destroy, "e:destroy()", "remove it and what hangs below it"},
    {"alive", entity_alive, "e:alive()", "tell whether it is still there"},
    {NULL, NULL, NULL, NULL},
};

void script_push_functions(lua_State *L, const script_function *rows)
{
    lua_newtable(L);
    for (; rows->name; rows++) {
        lua_pushcfunction(L, rows->call);
        lua_setfield(L, -2, rows->name);
    }
}
