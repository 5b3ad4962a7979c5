#ifndef KD_SCRIPT_INTERNAL_H
#define KD_SCRIPT_INTERNAL_H

/* Shared by the files of the script layer. Functions that take a lua_State may raise a Lua error and hold
 * nothing that a long jump would leak. */

#include <lauxlib.h>
#include <lua.h>

#include "runtime/core/file.h"
#include "runtime/script/pool.h"
#include "runtime/script/script.h"

/* What one call into the scenario may still use. The hook and the allocator lower it. */
typedef struct script_budget {
    size_t memory_used, memory_limit;
    uint64_t allocations; /* ever made */
    int64_t instructions_left;
    int64_t unlooked;           /* charged since the last look at the clock */
    uint64_t deadline_ns;       /* before this moment it cannot be over its time */
    int64_t thread_deadline_ns; /* and it is when the thread has used so much of a processor */
    uint64_t loading_ns;        /* by which both were put off for what was read */
    bool exhausted;             /* instructions or time: stays set until the next call */
    bool over_memory;
    script_pool pool;
} script_budget;

typedef struct script_task script_task;

typedef struct script_event {
    double time_s;
    uint64_t order;
    script_task *task;
    bool next_step; /* a wait for the next step, which has no time of its own */
} script_event;

/* A file of Lua: its name in Lua's messages, and its path in ours. */
typedef struct script_chunk {
    char name[64]; /* short enough for Lua to leave it whole */
    char *path;
} script_chunk;

typedef struct script_param {
    char *text; /* NAME=value */
    bool asked; /* the scenario knows it */
} script_param;

/* What a name means to an owner, found before. Lua keeps one copy of a short string, and tables keep those
 * that are noted here alive: so the address stands for the name. */
typedef struct script_known {
    const void *owner;
    const char *name;
    const void *meaning;
} script_known;
enum { SCRIPT_KNOWN = 128 };

enum { SCRIPT_MAX_PARAM_NAMES = 256, SCRIPT_MAX_INPUTS = 256, SCRIPT_MAX_HELD = 16 };

struct kd_query;

struct kd_script {
    lua_State *L;
    kd_world *world;
    kd_script_host host;
    script_budget budget;
    uint64_t instruction_limit;
    uint64_t time_limit_ns;
    int callbacks[KD_SCRIPT_CALLBACK_COUNT];   /* registry references, LUA_NOREF */
    kd_script_input inputs[SCRIPT_MAX_INPUTS]; /* a ring */
    uint32_t input_first, input_count;
    const char *held[SCRIPT_MAX_HELD]; /* names of keys and buttons that are down, NULL: free */
    char path[KD_PATH_MAX];
    char (*roots)[KD_PATH_MAX]; /* the scenario's folder first */
    uint32_t root_count;
    script_chunk *chunks; /* the scenario first, then its modules */
    uint32_t chunk_count;
    const void *entity_meta, *component_meta; /* metatables */
    script_known known[SCRIPT_KNOWN];         /* by a hash of owner and name */

    script_event *events; /* a heap, see task.c */
    uint32_t event_count, event_capacity;
    uint64_t event_order;
    script_task **active; /* what runs every step, in order of starting */
    uint32_t active_count, active_capacity;
    script_task *running; /* the coroutine under way, or NULL */
    double step_s;        /* time of the step, below 0 before the first */
    double step_length_s; /* to the next step */
    double now_s;         /* time for which what runs now was asked */

    struct kd_query **queries;
    uint32_t query_count;
    script_param *params;
    uint32_t param_count;
    char (*param_names)[64]; /* [SCRIPT_MAX_PARAM_NAMES]: those asked for */
    uint32_t param_names_count;
};

/* A function of a scenario's table or handle, as the reference page shows it. */
typedef struct script_function {
    const char *name;
    lua_CFunction call;
    const char *usage, *doc;
} script_function;

/* Userdata that scenarios may hold, but for handles of entities and components, begin with a uint64_t: the
 * number by which pairs orders them. */

static inline kd_script *script_of(lua_State *L)
{
    return *(kd_script **)lua_getextraspace(L);
}

/* ---- sandbox.c, sandbox_string.c, sandbox_table.c, sandbox_walks.c: libraries and limits ---- */
lua_State *script_sandbox_make(kd_script *script); /* NULL when memory is out */
void script_sandbox_open(lua_State *L, uint64_t seed);
void script_sandbox_string(lua_State *L); /* replaces what could run for ever in the string library */
void script_sandbox_table(lua_State *L);  /* likewise in the table library */
void script_sandbox_walks(lua_State *L);  /* likewise in other functions of texts */
void script_budget_start(kd_script *script);
bool script_is_stopped(const kd_script *script);        /* by its host */
void script_charge(lua_State *L, int64_t instructions); /* raises when the budget is used up */
void script_look(lua_State *L); /* raises when the time is used up too, or the host has stopped */

uint64_t script_creation_number(const void *block); /* of what the sandbox's allocator gave */

/* ---- order.c: pairs and next, in the same order in every run ---- */
void script_order_open(lua_State *L);

/* ---- text.c: values as text, the same in every run ---- */
void script_text_open(lua_State *L);                   /* tostring, string.format */
const char *script_push_text(lua_State *L, int index); /* as luaL_tolstring */
/** Push the text at `index` as a terminal may show it: control characters are written out, and every line but
 * the first is indented, so that none passes for a message of the program. */
const char *script_push_shown(lua_State *L, int index);

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

/** Get where it is noted, or is to be noted, what a name means to an owner. */
static inline script_known *script_known_at(lua_State *L, const void *owner, const char *name)
{
    uintptr_t hash = ((uintptr_t)owner >> 4) * 31 + ((uintptr_t)name >> 4);
    return &script_of(L)->known[(hash ^ hash >> 7) % SCRIPT_KNOWN];
}

/* ---- access.c: fields by name ---- */
typedef enum script_access_kind {
    SCRIPT_PLAIN,
    SCRIPT_DEGREES,      /* an angle kept in radians, written NAME_deg */
    SCRIPT_ROTATION_DEG, /* a transform's rotation as three angles */
    SCRIPT_LOOK_AT,      /* a transform's rotation by the point or entity it looks at */
} script_access_kind;

typedef struct script_access {
    const kd_component_desc *desc;
    const char *name;  /* as the scenario says it */
    const char *owner; /* the component's field that it lies in */
    kd_field field;    /* where and how it is kept; of an angle in degrees the range is in degrees */
    script_access_kind kind;
    bool writable;
    uint32_t position_offset; /* of the transform's position */
} script_access;

void script_access_open(lua_State *L);
const kd_field *script_find_field(const kd_component_desc *desc, const char *name);
bool script_is_angle(const kd_field *field); /* one number in radians */
/** Find how to reach the field that the string at `index` names; raises when there is none. It lives as long
 * as the state. */
const script_access *script_access_at(lua_State *L, const kd_component_desc *desc, int index);
const script_access *script_access_named(lua_State *L, const kd_component_desc *desc, const char *name);
const char *script_access_name(lua_State *L, const script_access *access); /* pushes "light.intensity" */

/* ---- field.c: values of fields ---- */
void script_push_field(lua_State *L, const script_access *access, const void *component);
/** Set the field of the value of a component of the entity from the stack; unchanged when that raises. */
void script_read_field(lua_State *L, int index, kd_entity e, const script_access *access, void *component);
/** Set every field that the table at `index` names. */
void script_read_component(lua_State *L, int index, kd_entity e, const kd_component_desc *desc, void *value);

/* ---- pose.c: rotations that scenarios write ---- */
kd_quat script_rotation_from_deg(kd_vec3 deg); /* about x, then y, then z, fixed axes */
kd_vec3 script_rotation_to_deg(kd_quat q);
kd_quat script_look_at(kd_vec3 from,
                       kd_vec3 to); /* -Z towards the target, +Y up; equal points: no rotation */

/* ---- place.c ---- */
/** Find where the target stands, m, in the space of what hangs below `parent` (KD_NO_ENTITY: the world).
 * Returns false when there is no such place: something above is scaled to nothing. */
bool script_place_below(const kd_world *w, kd_entity target, kd_entity parent, kd_vec3 *out);

/* ---- entity.c, entity_methods.c: handles ---- */
void script_entity_open(lua_State *L);
void script_push_entity(lua_State *L, kd_entity e); /* nil for KD_NO_ENTITY */
bool script_is_entity(lua_State *L, int index);
kd_entity script_handle(lua_State *L, int index);       /* dead or alive */
kd_entity script_check_entity(lua_State *L, int index); /* raises when it is dead */
/** Tell whether it is a handle, and by which numbers handles are ordered. */
bool script_handle_order(lua_State *L, int index, uint64_t *first, lua_Integer *second);
void script_push_component(lua_State *L, kd_entity e, kd_component_id id);
/** Find the component that the string at `index` names; raises unless the entity has it. */
kd_component_id script_check_component(lua_State *L, kd_entity e, int index);
/** Find what the path at `index`, "transform.position", names; raises unless the entity has it. */
void script_path_at(lua_State *L, kd_entity e, int index, kd_component_id *id, const script_access **access);
void script_write(lua_State *L, kd_entity e, kd_component_id id, const script_access *access, int index);
/** Set the fields in the table at `index`; adds the component when it is missing and may be. */
void script_set_component(lua_State *L, kd_entity e, kd_component_id id, int index);
void script_set_parent(lua_State *L, kd_entity e, int index);
void script_push_functions(lua_State *L, const script_function *rows); /* a table of them */
extern const script_function script_entity_methods[];

/* ---- spawn.c ---- */
int script_spawn(lua_State *L);
/** Raise unless every key of the table is a component or what kandil.spawn understands besides. */
void script_check_spawn_keys(lua_State *L, int table, const char *what);
void script_set_components(lua_State *L, int table, kd_entity e);
void script_read_play(lua_State *L, int table, const char *what, kd_script_play *play);

/* ---- task.c, tween.c, clip.c: what happens later ---- */
void script_task_open(lua_State *L);
void script_tween_open(lua_State *L);
void script_run_due(lua_State *L, double time_s); /* everything that the step at this time asks for */
int script_at(lua_State *L);
int script_every(lua_State *L);
int script_run(lua_State *L);
int script_wait(lua_State *L);
int script_tween_start(lua_State *L);
int script_follow(lua_State *L);
int script_path(lua_State *L);
int script_ease_value(lua_State *L);
int script_on_clip(lua_State *L);
void script_play(lua_State *L, kd_entity e, const kd_script_play *play);
void script_clip_started(kd_script *script, kd_entity e); /* its watches begin anew */
extern const script_function script_task_methods[], script_path_methods[];

/* ---- input.c: what happens to the window ---- */
extern const script_function script_callbacks[]; /* by kd_script_callback; no function to call */
void script_run_inputs(lua_State *L);
int script_key(lua_State *L);

/* ---- query.c ---- */
int script_query(lua_State *L);
int script_find(lua_State *L);
int script_get_singleton(lua_State *L);

/* ---- module.c ---- */
void script_module_open(lua_State *L);
bool script_add_chunk(kd_script *script, const char *shown, const char *path);
/** Find the file in which a message of Lua, "NAME:LINE: …", says it arose. Returns NULL when it names none.
 */
const script_chunk *script_chunk_of(const kd_script *script, const char *message);
int script_param_get(lua_State *L);
kd_status script_check_params(const kd_script *script); /* fails for one that nobody asked for */

/* ---- kandil.c ---- */
void script_kandil_open(lua_State *L);
extern const script_function script_functions[];

/* ---- script.c ---- */
/** Put the line of the innermost Lua function before the error at the top, unless a place stands there. */
void script_explain(lua_State *L);

/** Raise what the host says when its work failed. */
void script_host_check(lua_State *L, kd_status status, const kd_script_error *error);
/** Charge for the entities that came since there were `before`. */
void script_charge_entities(lua_State *L, uint64_t before);

#endif
