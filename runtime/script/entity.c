/* Entity handles: e:play, e:set, e:get, e:destroy, e:child, e:alive, e.name, and e.transform.position = {…},
 * which goes through a second small userdata that stands for one component of one entity. A handle holds no
 * pointer into the world: the entity may be gone at any time, and then every use of it is an error that says
 * so. */
#include "runtime/script/internal.h"

#include <string.h>

#include "runtime/core/nearest.h"

#define ENTITY_TYPE    "kandil.entity"
#define COMPONENT_TYPE "kandil.component"

typedef struct component_handle {
    kd_entity entity;
    kd_component_id component;
} component_handle;

void script_push_entity(lua_State *L, kd_entity e) {
    if (e.generation == 0) {
        lua_pushnil(L);
        return;
    }
    kd_entity *handle = lua_newuserdatauv(L, sizeof *handle, 0);
    *handle = e;
    luaL_setmetatable(L, ENTITY_TYPE);
}

kd_entity script_check_entity(lua_State *L, int index) {
    kd_entity e = *(kd_entity *)luaL_checkudata(L, index, ENTITY_TYPE);
    if (!kd_alive(script_of(L)->world, e))
        luaL_error(L, "this entity was destroyed; keep no handle to it, or ask e:alive() first");
    return e;
}

/* ---- components ---- */

/* Find the component that an entity has by name; raises otherwise. */
static kd_component_id find_component(lua_State *L, kd_entity e, const char *name) {
    kd_world *w = script_of(L)->world;
    kd_component_id id = kd_component_find(w, name);
    if (id && kd_find_id(w, e, id))
        return id;
    kd_nearest near = kd_nearest_to(name);
    for (kd_component_id i = 1; i <= kd_component_count(w); i++)
        if (kd_find_id(w, e, i))
            kd_nearest_offer(&near, kd_component_info(w, i)->name);
    const char *who = kd_get_name(w, e);
    if (near.best)
        luaL_error(L, "the entity '%s' has no '%s'; did you mean '%s'?", who, name, near.best);
    luaL_error(L, "the entity '%s' has no '%s'; give it one when it is spawned", who, name);
    return 0;
}

static void set_field(lua_State *L, kd_entity e, kd_component_id id, const char *field, int index) {
    kd_world *w = script_of(L)->world;
    const kd_component_desc *desc = kd_component_info(w, id);
    char copy[1024]; /* changed aside, so that a value that is refused leaves nothing half written */
    if (desc->size > sizeof copy)
        luaL_error(L, "%s is too large to be set by a scenario", desc->name);
    memcpy(copy, kd_find_id(w, e, id), desc->size);
    script_read_field(L, index, desc, field, copy);
    memcpy(kd_find_mut_id(w, e, id), copy, desc->size);
}

static int component_index(lua_State *L) {
    component_handle *h = luaL_checkudata(L, 1, COMPONENT_TYPE);
    kd_world *w = script_of(L)->world;
    const void *value = kd_find_id(w, h->entity, h->component);
    if (!value)
        return luaL_error(L, "this entity was destroyed; keep no handle to it, or ask e:alive() first");
    script_push_field(L, kd_component_info(w, h->component), luaL_checkstring(L, 2), value);
    return 1;
}

static int component_newindex(lua_State *L) {
    component_handle *h = luaL_checkudata(L, 1, COMPONENT_TYPE);
    if (!kd_find_id(script_of(L)->world, h->entity, h->component))
        return luaL_error(L, "this entity was destroyed; keep no handle to it, or ask e:alive() first");
    set_field(L, h->entity, h->component, luaL_checkstring(L, 2), 3);
    return 0;
}

/* ---- methods ---- */

/* Split "component.field"; returns the field and pushes the component's name. */
static const char *split_path(lua_State *L, const char *path) {
    const char *dot = strchr(path, '.');
    if (!dot || dot == path || !dot[1])
        luaL_error(L, "'%s' names no field; write component.field, such as transform.position", path);
    lua_pushlstring(L, path, (size_t)(dot - path));
    return dot + 1;
}

static int entity_set(lua_State *L) {
    kd_entity e = script_check_entity(L, 1);
    luaL_checkany(L, 3);
    const char *field = split_path(L, luaL_checkstring(L, 2));
    set_field(L, e, find_component(L, e, lua_tostring(L, -1)), field, 3);
    lua_settop(L, 1);
    return 1; /* so that calls can be chained */
}

static int entity_get(lua_State *L) {
    kd_entity e = script_check_entity(L, 1);
    const char *field = split_path(L, luaL_checkstring(L, 2));
    kd_component_id id = find_component(L, e, lua_tostring(L, -1));
    kd_world *w = script_of(L)->world;
    script_push_field(L, kd_component_info(w, id), field, kd_find_id(w, e, id));
    return 1;
}

static int entity_play(lua_State *L) {
    kd_entity e = script_check_entity(L, 1);
    kd_script *script = script_of(L);
    kd_script_play play = {.clip = luaL_optstring(L, 2, NULL), .loop = true, .speed = 1};
    if (!lua_isnoneornil(L, 3)) {
        static const char *const keys[] = {"blend", "loop", "speed", NULL};
        luaL_checktype(L, 3, LUA_TTABLE);
        script_check_keys(L, 3, "play", keys);
        script_read_play(L, 3, "play", &play);
    }
    if (!script->host.play)
        return luaL_error(L, "clips cannot be played here");
    kd_script_error error = {""};
    uint64_t began = script_host_begin(L);
    script_host_end(L, began, script->host.play(script->host.user, e, &play, &error), &error);
    lua_settop(L, 1);
    return 1;
}

static int entity_destroy(lua_State *L) {
    kd_destroy(script_of(L)->world, script_check_entity(L, 1));
    return 0;
}

static int entity_alive(lua_State *L) {
    kd_entity *e = luaL_checkudata(L, 1, ENTITY_TYPE);
    lua_pushboolean(L, kd_alive(script_of(L)->world, *e));
    return 1;
}

/* Find a descendant by name, parents before children, without recursion. */
static kd_entity find_below(const kd_world *w, kd_entity root, const char *name) {
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

static int entity_child(lua_State *L) {
    kd_entity e = script_check_entity(L, 1);
    const char *name = luaL_checkstring(L, 2);
    kd_entity child = find_below(script_of(L)->world, e, name);
    if (!child.generation)
        return luaL_error(L, "the entity '%s' has no child '%s'; `kandil info` lists a model's nodes",
                          kd_get_name(script_of(L)->world, e), name);
    script_push_entity(L, child);
    return 1;
}

static const luaL_Reg methods[] = {
    {"play", entity_play},   {"set", entity_set},     {"get", entity_get}, {"destroy", entity_destroy},
    {"child", entity_child}, {"alive", entity_alive}, {NULL, NULL},
};

static int entity_index(lua_State *L) {
    const char *key = luaL_checkstring(L, 2);
    if (lua_getfield(L, lua_upvalueindex(1), key) != LUA_TNIL)
        return 1;
    kd_entity e = script_check_entity(L, 1);
    if (strcmp(key, "name") == 0) {
        lua_pushstring(L, kd_get_name(script_of(L)->world, e));
        return 1;
    }
    kd_component_id id = find_component(L, e, key);
    component_handle *h = lua_newuserdatauv(L, sizeof *h, 0);
    *h = (component_handle){e, id};
    luaL_setmetatable(L, COMPONENT_TYPE);
    return 1;
}

static int entity_newindex(lua_State *L) {
    kd_entity e = script_check_entity(L, 1);
    const char *key = luaL_checkstring(L, 2);
    kd_world *w = script_of(L)->world;
    if (strcmp(key, "name") == 0) {
        if (kd_set_name(w, e, luaL_checkstring(L, 3)) != KD_OK)
            return luaL_error(L, "out of memory");
        return 0;
    }
    return luaL_error(L, "'%s' cannot be set as a whole; set a field, such as e.%s.position", key, key);
}

static int entity_equal(lua_State *L) {
    kd_entity *a = luaL_testudata(L, 1, ENTITY_TYPE), *b = luaL_testudata(L, 2, ENTITY_TYPE);
    lua_pushboolean(L, a && b && kd_entity_equal(*a, *b));
    return 1;
}

static int entity_text(lua_State *L) {
    kd_entity *e = luaL_checkudata(L, 1, ENTITY_TYPE);
    lua_pushfstring(L, "entity %d '%s'", (int)e->index, kd_get_name(script_of(L)->world, *e));
    return 1;
}

static void protect(lua_State *L) {
    lua_pushliteral(L, "protected");
    lua_setfield(L, -2, "__metatable");
    lua_pop(L, 1);
}

void script_entity_open(lua_State *L) {
    static const luaL_Reg entity_meta[] = {
        {"__newindex", entity_newindex}, {"__eq", entity_equal}, {"__tostring", entity_text}, {NULL, NULL}};
    static const luaL_Reg component_meta[] = {
        {"__index", component_index}, {"__newindex", component_newindex}, {NULL, NULL}};
    luaL_newmetatable(L, ENTITY_TYPE);
    luaL_setfuncs(L, entity_meta, 0);
    luaL_newlib(L, methods);
    lua_pushcclosure(L, entity_index, 1);
    lua_setfield(L, -2, "__index");
    protect(L);
    luaL_newmetatable(L, COMPONENT_TYPE);
    luaL_setfuncs(L, component_meta, 0);
    protect(L);
}
