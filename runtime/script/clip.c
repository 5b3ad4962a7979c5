/* e:on_clip("walk", 0.5, f): calls f whenever the animation passes a time of a clip, however often it loops.
 * The watch reads the component "animation" before each step's pose is made: its time is that of the pose to
 * come. */
#include <math.h>
#include <string.h>

#include "runtime/script/task.h"

typedef struct script_clip_watch {
    script_task task; /* first user value: the function */
    kd_entity entity;
    kd_component_id component;
    uint32_t clip_offset, time_offset, speed_offset, loop_offset;
    uint32_t clip;
    float at_s, length_s, last_s;
    bool armed; /* the clip was playing at last_s one step ago */
} script_clip_watch;

void script_play(lua_State *L, kd_entity e, const kd_script_play *play)
{
    kd_script *script = script_of(L);
    kd_script_error error = {""};
    if (!script->host.play)
        luaL_error(L, "clips cannot be played here");
    script_host_check(L, script->host.play(script->host.user, e, play, &error), &error);
}

void script_clip_started(kd_script *script, kd_entity e)
{
    for (uint32_t i = 0; i < script->active_count; i++) {
        script_clip_watch *watch = (script_clip_watch *)script->active[i];
        if (watch->task.kind == SCRIPT_TASK_CLIP && kd_entity_equal(watch->entity, e))
            watch->armed = false;
    }
}

static uint32_t offset_of(lua_State *L, const kd_component_desc *desc, const char *field)
{
    return script_access_named(L, desc, field)->field.offset;
}

int script_on_clip(lua_State *L)
{
    kd_script *script = script_of(L);
    kd_script_error error = {""};
    uint32_t clip = 0;
    float length_s = 0;
    kd_entity e = script_check_entity(L, 1);
    const char *name = luaL_checkstring(L, 2);
    double at_s = luaL_checknumber(L, 3);
    luaL_checktype(L, 4, LUA_TFUNCTION);
    if (!script->host.find_clip)
        return luaL_error(L, "clips cannot be played here");
    script_host_check(L, script->host.find_clip(script->host.user, e, name, &clip, &length_s, &error),
                      &error);
    if (!(at_s >= 0 && at_s <= (double)length_s))
        return luaL_error(L, "clip '%s' is %f s long; choose a time in it instead of %f", name,
                          (double)length_s, at_s);
    lua_settop(L, 4);
    lua_pushliteral(L, "animation");
    kd_component_id id = script_check_component(L, e, 5);
    const kd_component_desc *desc = kd_component_info(script->world, id);
    script_clip_watch *watch = (script_clip_watch *)script_task_push(L, SCRIPT_TASK_CLIP, sizeof *watch, 4);
    watch->entity = e;
    watch->component = id;
    watch->clip_offset = offset_of(L, desc, "clip");
    watch->time_offset = offset_of(L, desc, "time_s");
    watch->speed_offset = offset_of(L, desc, "speed");
    watch->loop_offset = offset_of(L, desc, "loop");
    watch->clip = clip;
    watch->at_s = (float)at_s;
    watch->length_s = length_s;
    script_task_activate(L, &watch->task, lua_gettop(L));
    return 1;
}

/* A clip's time is a sum of rounded steps and may fall short of the event by a little in the step that
 * reaches it. How far the event is moved towards where the clip comes from: it depends on the step's length
 * alone, so that a change of speed never brings an event twice. */
#define EARLY_STEPS (1.0f / 32)
#define EARLY_CLIP  (1.0f / 64) /* and no more than this share of the clip */

static float early_by(const kd_script *script, const script_clip_watch *watch)
{
    return fminf((float)script->step_length_s * EARLY_STEPS, watch->length_s * EARLY_CLIP);
}

static float moved_event(const script_clip_watch *watch, float early_s, bool backwards, bool loops)
{
    float event = backwards ? watch->at_s + early_s : watch->at_s - early_s;
    if (loops && event < 0)
        return event + watch->length_s;
    return loops && event >= watch->length_s ? event - watch->length_s : event;
}

/* Tell whether the way from `from` to `to` leads past the event; a clip that loops jumps over its end. */
static bool passes(float from, float to, float event, bool backwards)
{
    if (backwards)
        return to <= from ? event < from && event >= to : event < from || event >= to;
    return to >= from ? event > from && event <= to : event > from || event <= to;
}

void script_clip_step(lua_State *L, script_task *task)
{
    script_clip_watch *watch = (script_clip_watch *)task;
    const char *value = kd_find_id(script_of(L)->world, watch->entity, watch->component);
    uint32_t clip;
    float time_s, speed, early_s = early_by(script_of(L), watch);
    uint8_t loops;
    int top = lua_gettop(L);
    if (!value) {
        script_task_push_held(L, task);
        script_task_finish(L, task, top + 1);
        lua_settop(L, top);
        return;
    }
    memcpy(&clip, value + watch->clip_offset, sizeof clip);
    memcpy(&time_s, value + watch->time_offset, sizeof time_s);
    memcpy(&speed, value + watch->speed_offset, sizeof speed);
    memcpy(&loops, value + watch->loop_offset, sizeof loops);
    bool was_armed = watch->armed;
    float last_s = watch->last_s;
    watch->armed = clip == watch->clip;
    watch->last_s = time_s;
    bool starts_there = !was_armed && fabsf(time_s - watch->at_s) <= early_s;
    float event = moved_event(watch, early_s, speed < 0, loops);
    if (!watch->armed || (was_armed && time_s == last_s) ||
        !(starts_there || (was_armed && passes(last_s, time_s, event, speed < 0))))
        return;
    script_task_push_held(L, task);
    lua_getiuservalue(L, -1, TASK_FUNCTION);
    script_push_entity(L, watch->entity);
    lua_call(L, 1, 0);
    lua_settop(L, top);
}
