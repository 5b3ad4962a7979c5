#ifndef KD_SCRIPT_INTERNAL_H
#define KD_SCRIPT_INTERNAL_H

/* Shared by the files of the script layer. Functions that take a lua_State may raise a Lua error and hold
 * nothing that a long jump would leak. */

#include <lauxlib.h>
#include <lua.h>

#include "runtime/core/file.h"
#include "runtime/script/script.h"

/* What one call into the scenario may still use. The hook and the allocator lower it. */
typedef struct script_budget {
    size_t memory_used, memory_limit;
    int64_t instructions_left;
    uint64_t deadline_ns;
    bool exhausted; /* instructions or time: stays set until the next call */
    bool over_memory;
} script_budget;

typedef struct script_event {
    double time_s;
    int function; /* registry reference */
} script_event;

struct kd_script {
    lua_State *L;
    kd_world *world;
    kd_script_host host;
    script_budget budget;
    uint64_t instruction_limit;
    uint64_t time_limit_ns;
    int update;           /* registry reference, LUA_NOREF */
    script_event *events; /* latest first, so that the next one is the last */
    uint32_t event_count, event_capacity;
    bool scene_said;
    char path[KD_PATH_MAX];
    char chunk[64];             /* its name inside Lua, which cuts longer ones */
    char (*roots)[KD_PATH_MAX]; /* the scenario's folder first */
    uint32_t root_count;
};

static inline kd_script *script_of(lua_State *L) {
    return *(kd_script **)lua_getextraspace(L);
}

/* ---- sandbox.c, sandbox_string.c: libraries and limits ---- */
lua_State *script_sandbox_make(kd_script *script); /* NULL when memory is out */
void script_sandbox_open(lua_State *L, uint64_t seed);
void script_sandbox_string(lua_State *L); /* replaces what could run for ever in the string library */
void script_budget_start(kd_script *script);
void script_charge(lua_State *L, int64_t instructions); /* raises when the budget is used up */

/* ---- text.c: values as text, the same in every run ---- */
void script_text_open(lua_State *L);                       /* tostring, string.format */
const char *script_push_text(lua_State *L, int index);     /* as luaL_tolstring */

/* ---- path.c ---- */
/** Find the file that a scenario names; raises unless it lies in a root. Returns `out`. */
const char *script_resolve(lua_State *L, const char *name, char out[KD_PATH_MAX]);

/* ---- table.c: tables with known keys ---- */
void script_check_keys(lua_State *L, int table, const char *what, const char *const *keys);
_Noreturn void script_unknown(lua_State *L, const char *what, const char *word, const char *best);
/** Raise unless the value is finite and, when min and max differ, lies between them. */
void script_check_range(lua_State *L, const char *what, double value, double min, double max);
double script_get_number(lua_State *L, int table, const char *what, const char *key, double fallback,
                         double min, double max);
bool script_get_bool(lua_State *L, int table, const char *what, const char *key, bool fallback);
const char *script_get_string(lua_State *L, int table, const char *what,
                              const char *key); /* NULL when absent */
/** Read `count` numbers from the list at `index` (of the stack). */
void script_read_floats(lua_State *L, int index, const char *what, float *out, uint32_t count);
bool script_get_floats(lua_State *L, int table, const char *what, const char *key, float *out,
                       uint32_t count);

/* ---- field.c: component values through reflection ---- */
const kd_field *script_find_field(const kd_component_desc *desc, const char *name);
void script_push_field(lua_State *L, const kd_component_desc *desc, const char *name, const void *value);
/** Set field `name` of the value from the stack; understands NAME_deg, rotation_deg and look_at. */
void script_read_field(lua_State *L, int index, const kd_component_desc *desc, const char *name, void *value);
/** Set every field that the table at `index` names. */
void script_read_component(lua_State *L, int index, const kd_component_desc *desc, void *value);

/* ---- pose.c: rotations that scenarios write ---- */
kd_quat script_rotation_from_deg(kd_vec3 deg); /* about x, then y, then z, fixed axes */
kd_vec3 script_rotation_to_deg(kd_quat q);
kd_quat script_look_at(kd_vec3 from,
                       kd_vec3 to); /* -Z towards the target, +Y up; equal points: no rotation */

/* ---- entity.c: entity handles ---- */
void script_entity_open(lua_State *L);
void script_push_entity(lua_State *L, kd_entity e);
kd_entity script_check_entity(lua_State *L, int index);

/* ---- spawn.c, kandil.c ---- */
int script_spawn(lua_State *L);
void script_read_play(lua_State *L, int table, const char *what, kd_script_play *play);
void script_kandil_open(lua_State *L);

/** Start and end work of the host, whose time is not the scenario's. Raises what it says when it failed. */
uint64_t script_host_begin(lua_State *L);
void script_host_end(lua_State *L, uint64_t began_ns, kd_status status, const kd_script_error *error);

#endif
