/* Movements that last: a field from its value to another, an entity along a path, a function of the share.
 * All are set once a step, and exactly at their end. */
#include <float.h>
#include <math.h>
#include <string.h>

#include "runtime/core/nearest.h"
#include "runtime/ecs/reflect.h"
#include "runtime/script/curve.h"
#include "runtime/script/ease.h"
#include "runtime/script/task.h"

#define MAX_NUMBERS 16
#define PATH_TYPE   "kandil.path"
#define DEG_PER_RAD 57.295779513082323

typedef enum tween_target { TWEEN_FUNCTION, TWEEN_FIELD, TWEEN_PATH } tween_target;
typedef enum tween_look { LOOK_AS_BEFORE, LOOK_ALONG, LOOK_AT_POINT, LOOK_AT_ENTITY } tween_look;

typedef struct script_tween {
    script_task task; /* first user value: the function or the path */
    tween_target target;
    double start_s, length_s;
    int curve;
    bool loop;
    kd_entity entity;
    kd_component_id component;
    const script_access *access, *rotation; /* of the field, of the path's transform */
    uint32_t count;
    float from[MAX_NUMBERS], to[MAX_NUMBERS];
    tween_look look;
    kd_vec3 look_point;
    kd_entity look_entity;
} script_tween;

/* ---- reading what is asked for ---- */

static int check_curve(lua_State *L, int index)
{
    const char *name = luaL_optstring(L, index, "ease_in_out");
    int curve = script_ease_find(name);
    if (curve >= 0)
        return curve;
    luaL_Buffer families;
    luaL_buffinit(L, &families);
    for (int i = 0; script_ease_families[i]; i++) {
        luaL_addstring(&families, i ? ", " : "");
        luaL_addstring(&families, script_ease_families[i]);
    }
    luaL_pushresult(&families);
    return luaL_error(L, "there is no easing '%s'; choose linear, or one of %s with _in, _out or _inout",
                      name, lua_tostring(L, -1));
}

static double check_length(lua_State *L, int index, const char *what)
{
    double length_s = luaL_checknumber(L, index);
    if (!isfinite(length_s) || length_s < 0)
        luaL_error(L, "%s: a length of %f s makes no sense; give seconds from 0 on", what, length_s);
    return length_s;
}

static bool is_rotation(const script_access *access)
{
    return access->kind == SCRIPT_LOOK_AT || (access->kind == SCRIPT_PLAIN && access->field.type == KD_QUAT);
}

static kd_quat quat_of(const float *v)
{
    return (kd_quat){v[0], v[1], v[2], v[3]};
}

/* Read the field's numbers from the component's value; angles of a rotation in degrees. */
static void read_numbers(const script_tween *tween, const char *value, float *out)
{
    memcpy(out, value + tween->access->field.offset, tween->count * sizeof *out);
    if (tween->access->kind == SCRIPT_ROTATION_DEG) {
        float q[4];
        memcpy(q, value + tween->access->field.offset, sizeof q);
        kd_vec3 deg = script_rotation_to_deg(quat_of(q));
        memcpy(out, &deg, sizeof deg);
    }
}

static void read_field(lua_State *L, script_tween *tween)
{
    kd_world *w = script_of(L)->world;
    const kd_component_desc *desc = tween->access->desc;
    const kd_field *field = &tween->access->field;
    bool degrees = tween->access->kind == SCRIPT_ROTATION_DEG;
    uint32_t bytes = field->count > 1 ? 0 : field->size;
    bool floats = field->type == KD_F32 || (field->type >= KD_VEC2 && field->type <= KD_COLOR);
    if (!floats || !bytes || bytes > sizeof tween->from)
        luaL_error(L, "%s does not change by degrees; set it at a time by kandil.at",
                   script_access_name(L, tween->access));
    tween->count = degrees ? 3 : bytes / (uint32_t)sizeof(float);
    char *value = lua_newuserdatauv(L, desc->size, 0);
    memcpy(value, kd_find_id(w, tween->entity, tween->component), desc->size);
    read_numbers(tween, value, tween->from);
    script_read_field(L, 3, tween->entity, tween->access, value);
    if (degrees)
        script_read_floats(L, 3, "transform.rotation_deg", tween->to, 3);
    else
        read_numbers(tween, value, tween->to);
    lua_pop(L, 1);
}

/* Let the task at the top run from now on, and end when its time has come. */
static int start(lua_State *L, script_tween *tween)
{
    int index = lua_gettop(L);
    tween->start_s = script_of(L)->now_s;
    script_task_activate(L, &tween->task, index);
    if (!tween->loop)
        script_task_queue(L, &tween->task, index, tween->start_s + tween->length_s, false);
    return 1;
}

static script_tween *push_tween(lua_State *L, tween_target target, int function)
{
    script_tween *tween = (script_tween *)script_task_push(L, SCRIPT_TASK_TWEEN, sizeof *tween, function);
    tween->target = target;
    return tween;
}

/* kandil.tween(entity, "component.field", value, seconds, easing), kandil.tween(f, seconds, easing) */
int script_tween_start(lua_State *L)
{
    if (lua_isfunction(L, 1)) {
        double length_s = check_length(L, 2, "kandil.tween");
        int curve = check_curve(L, 3);
        script_tween *tween = push_tween(L, TWEEN_FUNCTION, 1);
        tween->length_s = length_s;
        tween->curve = curve;
        return start(L, tween);
    }
    kd_entity e = script_check_entity(L, 1);
    luaL_checkany(L, 3);
    double length_s = check_length(L, 4, "kandil.tween");
    int curve = check_curve(L, 5);
    script_tween *tween = push_tween(L, TWEEN_FIELD, 2);
    tween->entity = e;
    tween->length_s = length_s;
    tween->curve = curve;
    script_path_at(L, e, 2, &tween->component, &tween->access);
    read_field(L, tween);
    return start(L, tween);
}

int script_ease_value(lua_State *L)
{
    double share = luaL_checknumber(L, 2);
    lua_settop(L, 2);
    lua_insert(L, 1);
    lua_pushnumber(L, script_ease(check_curve(L, 2), share));
    return 1;
}

/* ---- each step ---- */

/* Curves that swing out must not leave the field's range. */
static float in_range(const kd_field *field, float value)
{
    if (field->min == field->max)
        return value;
    return value < (float)field->min   ? (float)field->min
           : value > (float)field->max ? (float)field->max
                                       : value;
}

static void store(kd_world *w, kd_entity e, kd_component_id id, const kd_field *field, const void *value,
                  size_t size)
{
    char *component = kd_find_mut_id(w, e, id);
    if (component)
        memcpy(component + field->offset, value, size);
}

static void step_field(kd_world *w, const script_tween *tween, double share)
{
    float now[MAX_NUMBERS], s = (float)share;
    const kd_field *field = &tween->access->field;
    kd_field in_radians = *field;
    if (tween->access->kind == SCRIPT_DEGREES) {
        in_radians.min /= DEG_PER_RAD;
        in_radians.max /= DEG_PER_RAD;
    }
    for (uint32_t i = 0; i < tween->count; i++)
        now[i] = share == 1 ? tween->to[i]
                            : in_range(&in_radians, tween->from[i] + (tween->to[i] - tween->from[i]) * s);
    if (tween->access->kind == SCRIPT_ROTATION_DEG) {
        kd_quat q = script_rotation_from_deg((kd_vec3){now[0], now[1], now[2]});
        store(w, tween->entity, tween->component, field, &q, sizeof q);
    } else if (is_rotation(tween->access)) {
        kd_quat q = kd_quat_slerp(quat_of(tween->from), quat_of(tween->to), s);
        store(w, tween->entity, tween->component, field, &q, sizeof q);
    } else {
        store(w, tween->entity, tween->component, field, now, tween->count * sizeof *now);
    }
}

static bool look_target(kd_world *w, const script_tween *tween, kd_vec3 position, kd_vec3 direction,
                        kd_vec3 *out)
{
    switch (tween->look) {
    case LOOK_ALONG: *out = kd_vec3_add(position, direction); return true;
    case LOOK_AT_POINT: *out = tween->look_point; return true;
    case LOOK_AT_ENTITY:
        return kd_find_id(w, tween->look_entity, tween->component) &&
               script_place_below(w, tween->look_entity, kd_get_parent(w, tween->entity), out);
    default: return false;
    }
}

static void step_path(lua_State *L, const script_tween *tween, double share)
{
    kd_world *w = script_of(L)->world;
    kd_vec3 direction, target;
    script_task_push_held(L, &tween->task);
    lua_getiuservalue(L, -1, TASK_FUNCTION);
    kd_vec3 position = script_curve_at(lua_touserdata(L, -1), share, &direction);
    lua_pop(L, 2);
    store(w, tween->entity, tween->component, &tween->access->field, &position, sizeof position);
    if (look_target(w, tween, position, direction, &target)) {
        kd_quat q = script_look_at(position, target);
        store(w, tween->entity, tween->component, &tween->rotation->field, &q, sizeof q);
    }
}

static void step_function(lua_State *L, const script_tween *tween, double share)
{
    script_task_push_held(L, &tween->task);
    lua_getiuservalue(L, -1, TASK_FUNCTION);
    lua_pushnumber(L, share);
    lua_call(L, 1, 0);
    lua_pop(L, 1);
}

void script_tween_step(lua_State *L, script_task *task, double time_s)
{
    script_tween *tween = (script_tween *)task;
    kd_world *w = script_of(L)->world;
    double elapsed_s = time_s - tween->start_s;
    double share = tween->length_s > 0 ? elapsed_s / tween->length_s : 1;
    if (share > 1 - 1e-9)
        share = tween->loop ? share - floor(share) : 1;
    if (tween->target != TWEEN_FUNCTION && !kd_find_id(w, tween->entity, tween->component)) {
        script_task_push_held(L, task); /* its entity is gone, and the movement with it */
        script_task_finish(L, task, lua_gettop(L));
        lua_pop(L, 1);
        return;
    }
    share = script_ease(tween->curve, share);
    if (tween->target == TWEEN_FUNCTION)
        step_function(L, tween, share);
    else if (tween->target == TWEEN_FIELD)
        step_field(w, tween, share);
    else
        step_path(L, tween, share);
}

/* ---- paths ---- */

/* kandil.path{ {x, y, z}, …, closed = true } */
int script_path(lua_State *L)
{
    luaL_checktype(L, 1, LUA_TTABLE);
    lua_settop(L, 1);
    lua_Unsigned count = lua_rawlen(L, 1);
    if (count < 2 || count > 100000)
        return luaL_error(L, "kandil.path needs from 2 to 100000 points, not %d; list them", (int)count);
    bool closed = script_get_bool(L, 1, "kandil.path", "closed", false);
    size_t lengths = ((size_t)count * SCRIPT_CURVE_STEPS + 1) * sizeof(float);
    script_curve *curve = lua_newuserdatauv(L, sizeof *curve + (size_t)count * sizeof(kd_vec3) + lengths, 0);
    *curve = (script_curve){.order = ++script_of(L)->budget.allocations,
                            .point_count = (uint32_t)count,
                            .closed = closed,
                            .points = (kd_vec3 *)(curve + 1)};
    curve->lengths_m = (float *)(curve->points + count);
    for (uint32_t i = 0; i < curve->point_count; i++) {
        lua_rawgeti(L, 1, (lua_Integer)i + 1);
        script_read_floats(L, -1, "a point of kandil.path", &curve->points[i].x, 3);
        lua_pop(L, 1);
    }
    script_charge(L, (int64_t)count * SCRIPT_CURVE_STEPS);
    script_curve_measure(curve);
    luaL_setmetatable(L, PATH_TYPE);
    return 1;
}

static void push_vec3(lua_State *L, kd_vec3 v)
{
    const float values[3] = {v.x, v.y, v.z};
    lua_createtable(L, 3, 0);
    for (int i = 0; i < 3; i++) {
        lua_pushnumber(L, (lua_Number)values[i]);
        lua_rawseti(L, -2, i + 1);
    }
}

static double check_share(lua_State *L, int index)
{
    double share = luaL_checknumber(L, index);
    if (!isfinite(share))
        luaL_error(L, "the share of a path is %f; give a number from 0 to 1", share);
    return share;
}

static int path_at(lua_State *L)
{
    kd_vec3 direction;
    const script_curve *curve = luaL_checkudata(L, 1, PATH_TYPE);
    push_vec3(L, script_curve_at(curve, check_share(L, 2), &direction));
    push_vec3(L, direction);
    return 2;
}

static int path_length(lua_State *L)
{
    const script_curve *curve = luaL_checkudata(L, 1, PATH_TYPE);
    lua_pushnumber(L, (lua_Number)curve->length_m);
    return 1;
}

const script_function script_path_methods[] = {
    {"at", path_at, "path:at(share)", "the point and the unit direction at a share of its length, 0 to 1"},
    {"length", path_length, "path:length()", "its length in metres"},
    {NULL, NULL, NULL, NULL},
};

static void read_look(lua_State *L, int table, script_tween *tween)
{
    int type = lua_getfield(L, table, "look_at");
    if (type == LUA_TSTRING && strcmp(lua_tostring(L, -1), "path") == 0) {
        tween->look = LOOK_ALONG;
    } else if (type == LUA_TTABLE) {
        tween->look = LOOK_AT_POINT;
        script_read_floats(L, -1, "look_at", &tween->look_point.x, 3);
    } else if (script_is_entity(L, -1)) {
        tween->look = LOOK_AT_ENTITY;
        tween->look_entity = script_check_entity(L, -1);
    } else if (type != LUA_TNIL) {
        luaL_error(L, "look_at must be a point, an entity or \"path\", not a %s; correct it",
                   luaL_typename(L, -1));
    }
    lua_pop(L, 1);
}

/* kandil.follow(entity, path, seconds, { easing, loop, look_at }) */
int script_follow(lua_State *L)
{
    static const char *const keys[] = {"easing", "loop", "look_at", NULL};
    kd_entity e = script_check_entity(L, 1);
    luaL_checkudata(L, 2, PATH_TYPE);
    double length_s = check_length(L, 3, "kandil.follow");
    lua_settop(L, 4);
    if (lua_isnil(L, 4)) {
        lua_newtable(L);
        lua_replace(L, 4);
    }
    luaL_checktype(L, 4, LUA_TTABLE);
    script_check_keys(L, 4, "kandil.follow", keys);
    lua_getfield(L, 4, "easing");
    int curve = lua_isnil(L, -1) ? script_ease_find("linear") : check_curve(L, lua_gettop(L));
    lua_settop(L, 4);
    lua_pushliteral(L, "transform.position");
    script_tween *tween = push_tween(L, TWEEN_PATH, 2);
    tween->entity = e;
    tween->length_s = length_s;
    tween->curve = curve;
    tween->loop = script_get_bool(L, 4, "kandil.follow", "loop", false) && length_s > 0;
    read_look(L, 4, tween);
    script_path_at(L, e, 5, &tween->component, &tween->access);
    tween->rotation = script_access_named(L, tween->access->desc, "rotation");
    return start(L, tween);
}

void script_tween_open(lua_State *L)
{
    luaL_newmetatable(L, PATH_TYPE);
    script_push_functions(L, script_path_methods);
    lua_setfield(L, -2, "__index");
    lua_pushliteral(L, "protected");
    lua_setfield(L, -2, "__metatable");
    lua_pop(L, 1);
}
