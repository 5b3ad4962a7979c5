/* kandil.query("light", "!camera", "?animation"): walks what has these components. The entities are listed
 * when the walk begins, so that it may spawn, destroy and change whatever it meets. */
#include <string.h>

#include <stdlib.h>

#include "runtime/core/nearest.h"
#include "runtime/ecs/query.h"
#include "runtime/script/internal.h"

#define MAX_SHOWN 16

typedef struct walk {
    uint32_t count, next, shown;
    kd_component_id ids[MAX_SHOWN]; /* of which handles are given out */
    bool optional[MAX_SHOWN];
    kd_entity entities[];
} walk;

static _Noreturn void unknown_component(lua_State *L, const char *name)
{
    const kd_world *w = script_of(L)->world;
    kd_nearest near = kd_nearest_to(name);
    for (kd_component_id id = 1; id <= kd_component_count(w); id++)
        kd_nearest_offer(&near, kd_component_info(w, id)->name);
    if (near.best)
        luaL_error(L, "there is no component '%s'; did you mean '%s'?", name, near.best);
    luaL_error(L, "there is no component '%s'; see the scenario reference for what there is", name);
    for (;;)
        ; /* luaL_error never returns, but is not declared so */
}

/* Read the terms from the arguments. */
static void read_terms(lua_State *L, kd_query_desc *desc, walk *head)
{
    kd_world *w = script_of(L)->world;
    int count = lua_gettop(L);
    if (count < 1 || count > KD_MAX_TERMS)
        luaL_error(L, "kandil.query needs from 1 to %d components; name them", KD_MAX_TERMS);
    for (int i = 1; i <= count; i++) {
        const char *word = luaL_checkstring(L, i), *name = word + (*word == '!' || *word == '?');
        kd_component_id id = kd_component_find(w, name);
        if (!id)
            unknown_component(L, name);
        desc->terms[i - 1] = (kd_term){.kind = *word == '!'   ? KD_TERM_WITHOUT
                                               : *word == '?' ? KD_TERM_OPTIONAL
                                                              : KD_TERM_READ,
                                       .desc = kd_component_info(w, id)};
        if (!desc->terms[i - 1].desc->size && desc->terms[i - 1].kind != KD_TERM_WITHOUT)
            desc->terms[i - 1].kind = *word == '?' ? KD_TERM_OPTIONAL : KD_TERM_WITH;
        if (*word == '!')
            continue;
        head->ids[head->shown] = id;
        head->optional[head->shown++] = *word == '?';
    }
}

/* Make the query, or find it among those made before: they live as long as the scenario. */
static kd_query *ensure_query(lua_State *L, const kd_query_desc *desc)
{
    kd_script *script = script_of(L);
    kd_query *query = kd_query_make(script->world, desc);
    if (!query)
        luaL_error(L, "out of memory");
    for (uint32_t i = 0; i < script->query_count; i++) {
        if (script->queries[i] == query) {
            kd_query_destroy(query); /* counted twice now */
            return query;
        }
    }
    kd_query **grown = realloc(script->queries, (script->query_count + 1) * sizeof *grown);
    if (!grown || script->query_count == 1000) {
        script->queries = grown ? grown : script->queries;
        kd_query_destroy(query);
        luaL_error(L, "kandil.query: more than 1000 different queries; name fewer components");
    }
    script->queries = grown;
    script->queries[script->query_count++] = query;
    return query;
}

/* Upvalue: the walk. */
static int next_match(lua_State *L)
{
    walk *list = lua_touserdata(L, lua_upvalueindex(1));
    kd_world *w = script_of(L)->world;
    while (list->next < list->count) {
        kd_entity e = list->entities[list->next++];
        bool matches = kd_alive(w, e);
        for (uint32_t i = 0; i < list->shown && matches; i++)
            matches = list->optional[i] || kd_find_id(w, e, list->ids[i]);
        if (!matches)
            continue; /* changed meanwhile */
        luaL_checkstack(L, (int)list->shown + 6, "a query");
        script_push_entity(L, e);
        for (uint32_t i = 0; i < list->shown; i++) {
            if (kd_find_id(w, e, list->ids[i]))
                script_push_component(L, e, list->ids[i]);
            else
                lua_pushnil(L);
        }
        return (int)list->shown + 1;
    }
    lua_pushnil(L);
    return 1;
}

int script_query(lua_State *L)
{
    kd_query_desc desc = {.name = "scenario"};
    walk head = {0};
    read_terms(L, &desc, &head);
    kd_query *query = ensure_query(L, &desc);
    uint32_t count = kd_query_count(query);
    script_charge(L, count / 4);
    walk *list = lua_newuserdatauv(L, sizeof *list + count * sizeof(kd_entity), 0);
    memcpy(list, &head, sizeof *list);
    for (kd_iter it = kd_query_iter(query); kd_iter_next(&it);) {
        memcpy(list->entities + list->count, it.entities, it.count * sizeof(kd_entity));
        list->count += it.count;
    }
    lua_pushcclosure(L, next_match, 1);
    return 1;
}

int script_find(lua_State *L)
{
    script_push_entity(L, kd_find_named(script_of(L)->world, luaL_checkstring(L, 1)));
    return 1;
}

/* kandil.get("frame.dt_s"): a field of what there is one of in the world. */
int script_get_singleton(lua_State *L)
{
    kd_world *w = script_of(L)->world;
    const char *path = luaL_checkstring(L, 1), *dot = strchr(path, '.');
    if (!dot || dot == path || !dot[1])
        return luaL_error(L, "'%s' names no field; write component.field, such as frame.dt_s", path);
    lua_pushlstring(L, path, (size_t)(dot - path));
    kd_component_id id = kd_component_find(w, lua_tostring(L, -1));
    if (!id)
        unknown_component(L, lua_tostring(L, -1));
    const void *value = kd_singleton_find(w, id);
    if (!value)
        return luaL_error(L, "the world keeps no %s of its own; ask an entity that has one",
                          lua_tostring(L, -1));
    script_push_field(L, script_access_named(L, kd_component_info(w, id), dot + 1), value);
    return 1;
}
