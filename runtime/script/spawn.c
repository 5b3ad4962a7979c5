/* kandil.spawn: one table to one entity. Models, meshes and materials go to the host; every other key that
 * names a component gives its values through reflection. */
#include "runtime/script/internal.h"

#include <float.h>
#include <math.h>
#include <string.h>

#include "runtime/core/clock.h"
#include "runtime/core/nearest.h"

#define WHAT "kandil.spawn"

static const char *const own_keys[] = {"name",      "model",  "mesh",      "material", "transform",
                                       "animation", "parent", "light",     "camera",   "scene",
                                       "variant",   "sky",    "sky_image", NULL};
/* keys that are no component here, or that the host fills */
static const char *const host_keys[] = {"name",   "model", "mesh",    "material",  "animation",
                                        "parent", "scene", "variant", "sky_image", NULL};

#define ENTITY_COST 100 /* instructions for each entity of a model or copy after the first */

/* By how much reading a file may put off the end of a step: one file, and all of them. */
#define LOAD_MAX_NS  120000000000u
#define LOADS_MAX_NS 600000000000u

static const char loads_key = 0; /* of the registry's table of what was read */

void script_charge_entities(lua_State *L, uint64_t before)
{
    uint64_t count = kd_entity_count(script_of(L)->world);
    script_charge(L, count > before + 1 ? (int64_t)(count - before - 1) * ENTITY_COST : 0);
    script_look(L);
}

/* Tell whether this is the first time that these files were read, and note it. */
static bool is_first_load(lua_State *L, const kd_script_spawn *spawn)
{
    if (!spawn->model && !spawn->sky_image)
        return false;
    if (lua_rawgetp(L, LUA_REGISTRYINDEX, &loads_key) == LUA_TNIL) {
        lua_newtable(L);
        lua_pushvalue(L, -1);
        lua_rawsetp(L, LUA_REGISTRYINDEX, &loads_key);
        lua_replace(L, -2);
    }
    lua_pushfstring(L, "%s\n%s\n%s\n%s", spawn->model ? spawn->model : "",
                    spawn->model_scene ? spawn->model_scene : "", spawn->variant ? spawn->variant : "",
                    spawn->sky_image ? spawn->sky_image : "");
    lua_pushvalue(L, -1);
    bool first = lua_rawget(L, -3) == LUA_TNIL;
    lua_pop(L, 1);
    lua_pushboolean(L, 1);
    lua_rawset(L, -3);
    lua_pop(L, 1);
    return first;
}

/* Reading a file that was not read before is none of the script's time; all else is. */
static void put_off_deadline(lua_State *L, const kd_script_spawn *spawn, uint64_t took_ns)
{
    script_budget *budget = &script_of(L)->budget;
    uint64_t room_ns = LOADS_MAX_NS - budget->loading_ns;
    if (!is_first_load(L, spawn))
        return;
    took_ns = took_ns < LOAD_MAX_NS ? took_ns : LOAD_MAX_NS;
    took_ns = took_ns < room_ns ? took_ns : room_ns;
    budget->loading_ns += took_ns;
    budget->deadline_ns += took_ns;
    budget->thread_deadline_ns += (int64_t)took_ns;
}

/* Waiting for a file uses no processor, but is the script's time all the same. */
static void count_waiting(lua_State *L, const kd_script_spawn *spawn, uint64_t took_ns, uint64_t worked_ns)
{
    if ((spawn->model || spawn->sky_image) && took_ns > worked_ns)
        script_of(L)->budget.thread_deadline_ns -= (int64_t)(took_ns - worked_ns);
}

void script_host_check(lua_State *L, kd_status status, const kd_script_error *error)
{
    if (status == KD_OUT_OF_RANGE && !error->text[0])
        luaL_error(L, "the entity would hang more than 65535 deep; choose a parent further up");
    if (status != KD_OK)
        luaL_error(L, "%s", error->text[0] ? error->text : kd_status_text(status));
}

static bool is_one_of(const char *const *words, const char *word)
{
    for (; *words; words++)
        if (strcmp(*words, word) == 0)
            return true;
    return false;
}

void script_check_spawn_keys(lua_State *L, int table, const char *what)
{
    for (lua_pushnil(L); lua_next(L, table); lua_pop(L, 1)) {
        if (lua_type(L, -2) != LUA_TSTRING)
            luaL_error(L, "%s: entries without a name are not allowed; write key = value", what);
        const char *key = lua_tostring(L, -2);
        if (!is_one_of(own_keys, key) && !kd_component_find(script_of(L)->world, key))
            script_unknown(L, what, key, kd_nearest_word(key, own_keys));
    }
}

static void read_mesh(lua_State *L, kd_script_mesh *mesh)
{
    static const char *const keys[] = {"shape", "size", "segments", NULL};
    static const char *const shapes[] = {"box", "sphere", "plane", "cylinder", "torus", NULL};
    if (lua_getfield(L, 1, "mesh") != LUA_TNIL) {
        if (!lua_istable(L, -1))
            luaL_error(L, WHAT ".mesh must be a table such as { shape = \"box\" }, not a %s",
                       luaL_typename(L, -1));
        int table = lua_gettop(L);
        script_check_keys(L, table, "mesh", keys);
        mesh->shape = script_get_string(L, table, "mesh", "shape");
        if (!mesh->shape || !is_one_of(shapes, mesh->shape))
            luaL_error(L, "mesh.shape must be box, sphere, plane, cylinder or torus, not '%s'; choose one",
                       mesh->shape ? mesh->shape : "nothing");
        bool torus = strcmp(mesh->shape, "torus") == 0; /* size.y is its tube: a quarter unless it is given */
        mesh->size = (kd_vec3){1, torus ? 0.25f : 1, 1};
        if (lua_getfield(L, table, "size") == LUA_TNUMBER) {
            float edge = (float)lua_tonumber(L, -1);
            mesh->size = (kd_vec3){edge, torus ? edge / 4 : edge, edge};
        } else {
            script_get_floats(L, table, "mesh", "size", &mesh->size.x, 3);
        }
        lua_pop(L, 1);
        if (!(mesh->size.x > 0 && mesh->size.y >= 0 && mesh->size.z >= 0 && mesh->size.x < 1e6f &&
              mesh->size.y < 1e6f && mesh->size.z < 1e6f))
            luaL_error(L, "mesh.size must be positive and below a million metres; correct it");
        mesh->segments = (uint32_t)script_get_number(L, table, "mesh", "segments", 0, 0, 1024);
    }
    lua_pop(L, 1);
}

static void read_lobes(lua_State *L, int table, kd_script_material *material)
{
    material->ior = (float)script_get_number(L, table, "material", "ior", 1.5, 1, 1000);
    material->specular = (float)script_get_number(L, table, "material", "specular", 1, 0, 1);
    material->clearcoat = (float)script_get_number(L, table, "material", "clearcoat", 0, 0, 1);
    material->clearcoat_roughness =
        (float)script_get_number(L, table, "material", "clearcoat_roughness", 0, 0, 1);
    material->transmission = (float)script_get_number(L, table, "material", "transmission", 0, 0, 1);
}

static void read_material(lua_State *L, kd_script_material *material)
{
    static const char *const keys[] = {
        "base_color",   "metallic", "roughness", "emissive",  "double_sided",
        "unlit",        "ior",      "specular",  "clearcoat", "clearcoat_roughness",
        "transmission", NULL};
    *material = (kd_script_material){.base_color = {1, 1, 1, 1}, .roughness = 1, .ior = 1.5f, .specular = 1};
    if (lua_getfield(L, 1, "material") != LUA_TNIL) {
        if (!lua_istable(L, -1))
            luaL_error(L, WHAT ".material must be a table such as { base_color = {1, 0, 0} }, not a %s",
                       luaL_typename(L, -1));
        int table = lua_gettop(L);
        script_check_keys(L, table, "material", keys);
        material->given = true;
        if (lua_getfield(L, table, "base_color") == LUA_TTABLE)
            script_read_floats(L, -1, "material.base_color", &material->base_color.x,
                               lua_rawlen(L, -1) == 4 ? 4 : 3);
        else if (!lua_isnil(L, -1))
            luaL_error(L, "material.base_color must be a list of 3 or 4 numbers, not a %s; correct it",
                       luaL_typename(L, -1));
        lua_pop(L, 1);
        material->metallic = (float)script_get_number(L, table, "material", "metallic", 0, 0, 1);
        material->roughness = (float)script_get_number(L, table, "material", "roughness", 1, 0, 1);
        script_get_floats(L, table, "material", "emissive", &material->emissive.x, 3);
        material->double_sided = script_get_bool(L, table, "material", "double_sided", false);
        material->unlit = script_get_bool(L, table, "material", "unlit", false);
        read_lobes(L, table, material);
        const float *c = &material->base_color.x, *e = &material->emissive.x;
        for (int i = 0; i < 4; i++)
            if (c[i] < 0 || c[i] > 1)
                luaL_error(L,
                           "material.base_color[%d] is %f, which is out of range; choose a value from 0 to 1",
                           i + 1, (double)c[i]);
        for (int i = 0; i < 3; i++)
            if (e[i] < 0)
                luaL_error(L, "material.emissive[%d] is negative; choose 0 or more", i + 1);
    }
    lua_pop(L, 1);
}

static kd_entity read_parent(lua_State *L)
{
    kd_entity parent = KD_NO_ENTITY;
    if (lua_getfield(L, 1, "parent") != LUA_TNIL) {
        if (!script_is_entity(L, -1))
            luaL_error(L, WHAT ".parent must be an entity that kandil.spawn returned, not a %s",
                       luaL_typename(L, -1));
        parent = script_check_entity(L, -1);
    }
    lua_pop(L, 1);
    return parent;
}

/* Set the components of the table on the entity, in order of registration. */
void script_set_components(lua_State *L, int table, kd_entity e)
{
    int top = lua_gettop(L);
    kd_world *w = script_of(L)->world;
    table = lua_absindex(L, table);
    for (kd_component_id id = 1; id <= kd_component_count(w); id++) {
        const kd_component_desc *desc = kd_component_info(w, id);
        if (!is_one_of(host_keys, desc->name) && lua_getfield(L, table, desc->name) != LUA_TNIL)
            script_set_component(L, e, id, lua_gettop(L));
        lua_settop(L, top);
    }
}

void script_read_play(lua_State *L, int table, const char *what, kd_script_play *play)
{
    static const char *const keys[] = {"clip", "loop", "speed", "blend", "layer", "weight", "from", NULL};
    script_check_keys(L, table, what, keys);
    play->loop = script_get_bool(L, table, what, "loop", true);
    play->speed = (float)script_get_number(L, table, what, "speed", 1, -1000, 1000);
    play->blend_s = (float)script_get_number(L, table, what, "blend", 0, 0, 3600);
    double layer = script_get_number(L, table, what, "layer", 0, 0, 3);
    if (layer != floor(layer))
        luaL_error(L, "%s.layer is %f; choose 0, 1, 2 or 3", what, layer);
    play->layer = (uint32_t)layer;
    play->weight = (float)script_get_number(L, table, what, "weight", 1, 0, 1);
    play->from = script_get_string(L, table, what, "from");
    if (!play->layer && (play->from || play->weight < 1))
        luaL_error(L, "%s: weight and from are for layers; add layer = 1", what);
}

static void start_animation(lua_State *L, kd_entity e)
{
    if (lua_getfield(L, 1, "animation") != LUA_TNIL) {
        if (!lua_istable(L, -1))
            luaL_error(L, WHAT ".animation must be a table such as { clip = \"walk\" }, not a %s",
                       luaL_typename(L, -1));
        int table = lua_gettop(L);
        kd_script_play play = {.clip = script_get_string(L, table, "animation", "clip")};
        script_read_play(L, table, "animation", &play);
        script_play(L, e, &play);
    }
    lua_settop(L, 1);
}

int script_spawn(lua_State *L)
{
    char path[KD_PATH_MAX], sky_path[KD_PATH_MAX];
    kd_script *script = script_of(L);
    kd_script_spawn spawn = {0};
    kd_script_error error = {""};
    kd_entity e = KD_NO_ENTITY;
    luaL_checktype(L, 1, LUA_TTABLE);
    lua_settop(L, 1);
    script_check_spawn_keys(L, 1, WHAT);
    spawn.name = script_get_string(L, 1, WHAT, "name");
    spawn.model = script_get_string(L, 1, WHAT, "model");
    spawn.model_scene = script_get_string(L, 1, WHAT, "scene");
    spawn.variant = script_get_string(L, 1, WHAT, "variant");
    spawn.sky_image = script_get_string(L, 1, WHAT, "sky_image");
    read_mesh(L, &spawn.mesh);
    read_material(L, &spawn.material);
    spawn.parent = read_parent(L);
    if (spawn.model && spawn.mesh.shape)
        return luaL_error(L, WHAT ": model and mesh exclude each other; spawn two entities");
    if ((spawn.model_scene || spawn.variant) && !spawn.model)
        return luaL_error(L, WHAT ": a scene or a variant is one of a model; name the model");
    if (spawn.material.given && !spawn.model && !spawn.mesh.shape)
        return luaL_error(L, WHAT ": a material needs a model or a mesh to cover; add one");
    if (spawn.model)
        spawn.model = script_resolve(L, spawn.model, path);
    if (spawn.sky_image)
        spawn.sky_image = script_resolve(L, spawn.sky_image, sky_path);
    spawn.roots = (const char(*)[KD_PATH_MAX])script->roots;
    spawn.root_count = script->root_count;
    uint64_t before = kd_entity_count(script->world), began_ns = kd_clock_ns();
    uint64_t worked_ns = kd_clock_thread_ns();
    script_look(L);
    kd_status status = script->host.spawn(script->host.user, &spawn, &e, &error);
    uint64_t took_ns = kd_clock_ns() - began_ns;
    count_waiting(L, &spawn, took_ns, kd_clock_thread_ns() - worked_ns);
    script_host_check(L, status, &error);
    put_off_deadline(L, &spawn, took_ns);
    script_charge_entities(L, before);
    script_set_components(L, 1, e);
    start_animation(L, e);
    script_push_entity(L, e);
    return 1;
}
