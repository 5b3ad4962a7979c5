/* Entity handles, and e.transform.position = {…}, which goes through a second small userdata that stands for
 * one component of one entity. A handle holds no pointer into the world: the entity may be gone at any time,
 * and then every use of it is an error that says so. One entity has one handle, so that handles are keys of
 * tables. */
#include "runtime/script/internal.h"

#include <string.h>

#include "runtime/core/nearest.h"

#define ENTITY_TYPE    "kandil.entity"
#define COMPONENT_TYPE "kandil.component"

/* Of longer strings Lua keeps several copies. */
enum { LONGEST_SHARED = 40 };

typedef struct component_handle {
    kd_entity entity;
    kd_component_id component;
} component_handle;

/* addresses that key the registry */
static const char handles_key;   /* number of an entity to its handle, which is not kept alive */
static const char entity_key;    /* metatable */
static const char component_key; /* metatable */
static const char ids_key;       /* names of components that were asked for */
static const char paths_key;     /* "transform.position" to known_path */

typedef struct known_path {
    kd_component_id id;
    const script_access *access;
} known_path;

/* ---- handles ---- */

void script_push_entity(lua_State *L, kd_entity e)
{
    if (e.generation == 0) {
        lua_pushnil(L);
        return;
    }
    luaL_checkstack(L, 4, "an entity");
    lua_Integer number = (lua_Integer)((uint64_t)e.generation << 32 | e.index);
    lua_rawgetp(L, LUA_REGISTRYINDEX, &handles_key);
    if (lua_rawgeti(L, -1, number) == LUA_TNIL) {
        lua_pop(L, 1);
        kd_entity *handle = lua_newuserdatauv(L, sizeof *handle, 1); /* the component last asked for */
        *handle = e;
        lua_rawgetp(L, LUA_REGISTRYINDEX, &entity_key);
        lua_setmetatable(L, -2);
        lua_pushvalue(L, -1);
        lua_rawseti(L, -3, number);
    }
    lua_remove(L, -2);
}

/* Get the userdata at `index` when its metatable is the one given, else NULL. */
static void *test_handle(lua_State *L, int index, const void *metatable)
{
    if (lua_type(L, index) != LUA_TUSERDATA || !lua_getmetatable(L, index))
        return NULL;
    bool same = lua_topointer(L, -1) == metatable;
    lua_pop(L, 1);
    return same ? lua_touserdata(L, index) : NULL;
}

bool script_is_entity(lua_State *L, int index)
{
    return test_handle(L, index, script_of(L)->entity_meta) != NULL;
}

kd_entity script_handle(lua_State *L, int index)
{
    kd_entity *e = test_handle(L, index, script_of(L)->entity_meta);
    return e ? *e : *(kd_entity *)luaL_checkudata(L, index, ENTITY_TYPE); /* which raises */
}

static _Noreturn void is_gone(lua_State *L)
{
    luaL_error(L, "this entity was destroyed; keep no handle to it, or ask e:alive() first");
    for (;;)
        ; /* luaL_error never returns, but is not declared so */
}

kd_entity script_check_entity(lua_State *L, int index)
{
    kd_entity e = script_handle(L, index);
    if (!kd_alive(script_of(L)->world, e))
        is_gone(L);
    return e;
}

bool script_handle_order(lua_State *L, int index, uint64_t *first, lua_Integer *second)
{
    const kd_script *script = script_of(L);
    const kd_entity *e = test_handle(L, index, script->entity_meta);
    const component_handle *c = e ? NULL : test_handle(L, index, script->component_meta);
    if (c)
        e = &c->entity;
    if (!e)
        return false;
    *first = (uint64_t)e->index << 32 | e->generation;
    *second = c ? (lua_Integer)c->component : 0;
    return true;
}

/* ---- components ---- */

static _Noreturn void no_component(lua_State *L, kd_entity e, const char *name)
{
    kd_world *w = script_of(L)->world;
    kd_nearest near = kd_nearest_to(name);
    for (kd_component_id i = 1; i <= kd_component_count(w); i++)
        if (kd_find_id(w, e, i))
            kd_nearest_offer(&near, kd_component_info(w, i)->name);
    const char *who = kd_get_name(w, e);
    if (near.best)
        luaL_error(L, "the entity '%s' has no '%s'; did you mean '%s'?", who, name, near.best);
    luaL_error(L, "the entity '%s' has no '%s'; give it one when it is spawned, or by e.%s = {}", who, name,
               name);
    for (;;)
        ; /* as above */
}

/* Id of the component that the string at `index` names; 0 when there is none. */
static kd_component_id component_at(lua_State *L, int index)
{
    const char *name = lua_tostring(L, index);
    script_known *known = script_known_at(L, &ids_key, name);
    if (known->owner == &ids_key && known->name == name)
        return (kd_component_id)(uintptr_t)known->meaning;
    kd_component_id id = kd_component_find(script_of(L)->world, name);
    if (!id)
        return 0;
    lua_pushvalue(L, index);
    lua_rawgetp(L, LUA_REGISTRYINDEX, &ids_key);
    lua_insert(L, -2);
    lua_pushboolean(L, true);
    lua_rawset(L, -3); /* keeps the name alive */
    lua_pop(L, 1);
    if (strlen(name) <= LONGEST_SHARED)
        *known = (script_known){&ids_key, name, (const void *)(uintptr_t)id};
    return id;
}

kd_component_id script_check_component(lua_State *L, kd_entity e, int index)
{
    kd_component_id id = component_at(L, index);
    if (!id || !kd_find_id(script_of(L)->world, e, id))
        no_component(L, e, lua_tostring(L, index));
    return id;
}

void script_write(lua_State *L, kd_entity e, kd_component_id id, const script_access *access, int index)
{
    kd_world *w = script_of(L)->world;
    char copy[4096];
    const kd_component_desc *desc = access->desc;
    if (access->kind == SCRIPT_PLAIN && kd_find_id(w, e, id)) {
        /* The field alone is read aside there, and nothing raises once the chunk is marked. */
        char *value = kd_find_mut_id(w, e, id);
        script_read_field(L, index, e, access, value);
        return;
    }
    if (desc->size > sizeof copy)
        luaL_error(L, "%s is too large to be set by a scenario", desc->name);
    memcpy(copy, kd_find_id(w, e, id), desc->size);
    script_read_field(L, index, e, access, copy);
    memcpy(kd_find_mut_id(w, e, id), copy, desc->size);
}

static int component_index(lua_State *L)
{
    const component_handle *h = test_handle(L, 1, script_of(L)->component_meta);
    kd_world *w = script_of(L)->world;
    const void *value = h ? kd_find_id(w, h->entity, h->component) : NULL;
    if (!value)
        is_gone(L);
    script_push_field(L, script_access_at(L, kd_component_info(w, h->component), 2), value);
    return 1;
}

static int component_newindex(lua_State *L)
{
    const component_handle *h = test_handle(L, 1, script_of(L)->component_meta);
    kd_world *w = script_of(L)->world;
    if (!h || !kd_find_id(w, h->entity, h->component))
        is_gone(L);
    script_write(L, h->entity, h->component, script_access_at(L, kd_component_info(w, h->component), 2), 3);
    return 0;
}

/* Push e.transform for the handle at index 1: scenarios write e.transform.position, so the handle keeps the
 * component that was asked for last. */
static void push_kept_component(lua_State *L, kd_entity e, kd_component_id id)
{
    lua_getiuservalue(L, 1, 1);
    const component_handle *kept = lua_touserdata(L, -1);
    if (kept && kept->component == id)
        return;
    lua_pop(L, 1);
    script_push_component(L, e, id);
    lua_pushvalue(L, -1);
    lua_setiuservalue(L, 1, 1);
}

void script_push_component(lua_State *L, kd_entity e, kd_component_id id)
{
    component_handle *h = lua_newuserdatauv(L, sizeof *h, 0);
    *h = (component_handle){e, id};
    lua_rawgetp(L, LUA_REGISTRYINDEX, &component_key);
    lua_setmetatable(L, -2);
}

/* A component with fields of the runtime's own cannot be made by a scenario: only the entities that have it
 * know them. */
static bool may_add(const kd_script_host *host, const kd_component_desc *desc)
{
    if (desc->on_remove)
        return false;
    for (uint32_t i = 0; host->may_write && i < desc->field_count; i++)
        if (!host->may_write(host->user, desc->name, desc->fields[i].name))
            return false;
    return true;
}

void script_set_component(lua_State *L, kd_entity e, kd_component_id id, int index)
{
    int top = lua_gettop(L);
    kd_world *w = script_of(L)->world;
    const kd_component_desc *desc = kd_component_info(w, id);
    index = lua_absindex(L, index);
    char small[256], *value = small;
    if (desc->size > sizeof small)
        value = lua_newuserdatauv(L, desc->size, 0);
    const void *start = kd_find_id(w, e, id);
    if (!start && !may_add(&script_of(L)->host, desc))
        luaL_error(L, "the entity '%s' has no '%s' itself; set it on the part that has, e:child(\"name\")",
                   kd_get_name(w, e), desc->name);
    if (!start)
        start = desc->default_value;
    if (start)
        memcpy(value, start, desc->size);
    else
        memset(value, 0, desc->size);
    script_read_component(L, index, e, desc, value);
    void *there = desc->on_remove ? kd_find_mut_id(w, e, id) : NULL;
    if (there) /* it keeps what it owns */
        memcpy(there, value, desc->size);
    else if (kd_set_value(w, e, (kd_value){desc, value}) != KD_OK)
        luaL_error(L, "out of memory");
    lua_settop(L, top);
}

static void remove_component(lua_State *L, kd_entity e, kd_component_id id)
{
    const kd_component_desc *desc = kd_component_info(script_of(L)->world, id);
    if (!may_add(&script_of(L)->host, desc) || strcmp(desc->name, "transform") == 0)
        luaL_error(L, "%s belongs to the entity; destroy the entity instead", desc->name);
    kd_remove_id(script_of(L)->world, e, id);
}

/* ---- paths: component.field ---- */

static const known_path *find_path(lua_State *L, kd_entity e, int index, const char *path)
{
    int top = lua_gettop(L);
    lua_pushvalue(L, index);
    lua_rawgetp(L, LUA_REGISTRYINDEX, &paths_key);
    lua_pushvalue(L, top + 1);
    if (lua_rawget(L, top + 2) == LUA_TNIL) {
        const char *dot = strchr(path, '.');
        if (!dot || dot == path || !dot[1])
            luaL_error(L, "'%s' names no field; write component.field, such as transform.position", path);
        known_path found;
        lua_pushlstring(L, path, (size_t)(dot - path));
        found.id = script_check_component(L, e, lua_gettop(L));
        found.access = script_access_named(L, kd_component_info(script_of(L)->world, found.id), dot + 1);
        lua_pushvalue(L, top + 1);
        *(known_path *)lua_newuserdatauv(L, sizeof found, 0) = found;
        lua_pushvalue(L, -1);
        lua_replace(L, top + 3);
        lua_rawset(L, top + 2);
    }
    const known_path *found = lua_touserdata(L, top + 3);
    lua_settop(L, top);
    return found;
}

void script_path_at(lua_State *L, kd_entity e, int index, kd_component_id *id, const script_access **access)
{
    const char *path = luaL_checkstring(L, index);
    script_known *known = script_known_at(L, &paths_key, path);
    bool is_known = known->owner == &paths_key && known->name == path;
    const known_path *found = is_known ? known->meaning : find_path(L, e, index, path);
    if (!is_known && strlen(path) <= LONGEST_SHARED)
        *known = (script_known){&paths_key, path, found};
    *id = found->id;
    *access = found->access;
    if (!kd_find_id(script_of(L)->world, e, found->id))
        no_component(L, e, found->access->desc->name);
}

/* ---- metamethods ---- */

static int entity_index(lua_State *L)
{
    lua_pushvalue(L, 2);
    if (lua_rawget(L, lua_upvalueindex(1)) != LUA_TNIL)
        return 1;
    kd_entity e = script_check_entity(L, 1);
    const char *key = luaL_checkstring(L, 2);
    if (strcmp(key, "name") == 0)
        lua_pushstring(L, kd_get_name(script_of(L)->world, e));
    else if (strcmp(key, "parent") == 0)
        script_push_entity(L, kd_get_parent(script_of(L)->world, e));
    else
        push_kept_component(L, e, script_check_component(L, e, 2));
    return 1;
}

void script_set_parent(lua_State *L, kd_entity e, int index)
{
    kd_entity parent = KD_NO_ENTITY;
    if (!lua_isnil(L, index)) {
        if (!script_is_entity(L, index))
            luaL_error(L, "parent must be an entity or nil, not a %s; correct it", luaL_typename(L, index));
        parent = script_check_entity(L, index);
    }
    kd_status status = kd_set_parent(script_of(L)->world, e, parent);
    if (status == KD_OUT_OF_RANGE)
        luaL_error(L, "an entity cannot hang below itself, nor more than 65535 deep; choose another parent");
    else if (status != KD_OK)
        luaL_error(L, "out of memory");
}

static int entity_newindex(lua_State *L)
{
    kd_entity e = script_check_entity(L, 1);
    const char *key = luaL_checkstring(L, 2);
    kd_component_id id = component_at(L, 2);
    if (strcmp(key, "name") == 0) {
        if (kd_set_name(script_of(L)->world, e, luaL_checkstring(L, 3)) != KD_OK)
            return luaL_error(L, "out of memory");
    } else if (strcmp(key, "parent") == 0) {
        script_set_parent(L, e, 3);
    } else if (!id) {
        no_component(L, e, key);
    } else if (lua_isnil(L, 3)) {
        remove_component(L, e, id);
    } else {
        script_set_component(L, e, id, 3);
    }
    return 0;
}

static int entity_equal(lua_State *L)
{
    const void *meta = script_of(L)->entity_meta;
    const kd_entity *a = test_handle(L, 1, meta), *b = test_handle(L, 2, meta);
    lua_pushboolean(L, a && b && kd_entity_equal(*a, *b));
    return 1;
}

static int entity_text(lua_State *L)
{
    kd_entity e = script_handle(L, 1);
    lua_pushfstring(L, "entity %d '%s'", (int)e.index, kd_get_name(script_of(L)->world, e));
    return 1;
}

/* Keep the metatable at the top under a key; nothing in a scenario may see it. */
static const void *keep_metatable(lua_State *L, const void *key)
{
    const void *metatable = lua_topointer(L, -1);
    lua_pushliteral(L, "protected");
    lua_setfield(L, -2, "__metatable");
    lua_rawsetp(L, LUA_REGISTRYINDEX, key);
    return metatable;
}

static void make_table(lua_State *L, const void *key, const char *mode)
{
    lua_newtable(L);
    if (mode) {
        lua_createtable(L, 0, 1);
        lua_pushstring(L, mode);
        lua_setfield(L, -2, "__mode");
        lua_setmetatable(L, -2);
    }
    lua_rawsetp(L, LUA_REGISTRYINDEX, key);
}

void script_entity_open(lua_State *L)
{
    static const luaL_Reg entity_meta[] = {
        {"__newindex", entity_newindex}, {"__eq", entity_equal}, {"__tostring", entity_text}, {NULL, NULL}};
    static const luaL_Reg component_meta[] = {
        {"__index", component_index}, {"__newindex", component_newindex}, {NULL, NULL}};
    kd_script *script = script_of(L);
    make_table(L, &handles_key, "v");
    make_table(L, &ids_key, NULL);
    make_table(L, &paths_key, NULL);
    luaL_newmetatable(L, ENTITY_TYPE);
    luaL_setfuncs(L, entity_meta, 0);
    script_push_functions(L, script_entity_methods);
    lua_pushcclosure(L, entity_index, 1);
    lua_setfield(L, -2, "__index");
    script->entity_meta = keep_metatable(L, &entity_key);
    luaL_newmetatable(L, COMPONENT_TYPE);
    luaL_setfuncs(L, component_meta, 0);
    script->component_meta = keep_metatable(L, &component_key);
}
