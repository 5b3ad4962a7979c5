#include "runtime/script/task.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define TASK_TYPE       "kandil.task"
#define MAX_TASKS       1000000
#define MAX_DUE         100000 /* in one step */
#define DUE_TOLERANCE_S 1e-9   /* times are multiples of 1/fps, which has no exact value */

static const char meta_key; /* its address keys the registry's metatable */

/* ---- tasks ---- */

script_task *script_task_push(lua_State *L, script_task_kind kind, size_t size, int function)
{
    function = lua_absindex(L, function);
    script_task *task = lua_newuserdatauv(L, size, TASK_VALUES);
    memset(task, 0, size);
    task->order = ++script_of(L)->budget.allocations;
    task->kind = kind;
    lua_rawgetp(L, LUA_REGISTRYINDEX, &meta_key);
    lua_setmetatable(L, -2);
    lua_pushvalue(L, function);
    lua_setiuservalue(L, -2, TASK_FUNCTION);
    return task;
}

void script_task_hold(lua_State *L, script_task *task, int index)
{
    if (task->holds++)
        return;
    lua_pushvalue(L, index);
    task->anchor = luaL_ref(L, LUA_REGISTRYINDEX);
}

void script_task_release(lua_State *L, script_task *task)
{
    if (--task->holds == 0)
        luaL_unref(L, LUA_REGISTRYINDEX, task->anchor);
}

void script_task_push_held(lua_State *L, const script_task *task)
{
    lua_rawgeti(L, LUA_REGISTRYINDEX, task->anchor);
}

/* ---- the queue: a heap, earliest first, among equals what was queued first ---- */

static bool comes_before(const script_event *a, const script_event *b)
{
    return a->time_s < b->time_s || (a->time_s == b->time_s && a->order < b->order);
}

static void sift_up(script_event *heap, uint32_t at)
{
    while (at > 0 && comes_before(&heap[at], &heap[(at - 1) / 2])) {
        script_event moved = heap[at];
        heap[at] = heap[(at - 1) / 2];
        heap[(at - 1) / 2] = moved;
        at = (at - 1) / 2;
    }
}

static void sift_down(script_event *heap, uint32_t count)
{
    for (uint32_t at = 0, child; (child = 2 * at + 1) < count; at = child) {
        if (child + 1 < count && comes_before(&heap[child + 1], &heap[child]))
            child++;
        if (comes_before(&heap[at], &heap[child]))
            return;
        script_event moved = heap[at];
        heap[at] = heap[child];
        heap[child] = moved;
    }
}

static void *grown(lua_State *L, void *items, uint32_t *capacity, size_t size)
{
    uint32_t wanted = *capacity ? *capacity * 2 : 64;
    void *more = realloc(items, wanted * size);
    if (!more)
        luaL_error(L, "out of memory");
    *capacity = wanted;
    return more;
}

void script_task_queue(lua_State *L, script_task *task, int index, double time_s, bool next_step)
{
    kd_script *script = script_of(L);
    if (script->event_count == MAX_TASKS)
        luaL_error(L, "more than %d tasks wait; use kandil.update", MAX_TASKS);
    if (script->event_count == script->event_capacity)
        script->events = grown(L, script->events, &script->event_capacity, sizeof *script->events);
    script_charge(L, 8);
    script_task_hold(L, task, index);
    script->events[script->event_count] = (script_event){time_s, ++script->event_order, task, next_step};
    sift_up(script->events, script->event_count++);
}

static script_event take_first(kd_script *script)
{
    script_event first = script->events[0];
    script->events[0] = script->events[--script->event_count];
    sift_down(script->events, script->event_count);
    return first;
}

/* ---- what runs every step ---- */

void script_task_activate(lua_State *L, script_task *task, int index)
{
    kd_script *script = script_of(L);
    if (script->active_count == MAX_TASKS)
        luaL_error(L, "more than %d movements run at once; use kandil.update", MAX_TASKS);
    if (script->active_count == script->active_capacity)
        script->active = grown(L, script->active, &script->active_capacity, sizeof(script_task *));
    script_charge(L, 8);
    script_task_hold(L, task, index);
    script->active[script->active_count++] = task;
}

/* Step each that runs, those started meanwhile too; let go of those that have ended. */
static void step_active(lua_State *L, double time_s)
{
    kd_script *script = script_of(L);
    uint32_t kept = 0;
    for (uint32_t i = 0; i < script->active_count; i++) {
        script_task *task = script->active[i];
        if (!task->done && task->kind == SCRIPT_TASK_TWEEN)
            script_tween_step(L, task, time_s);
        else if (!task->done)
            script_clip_step(L, task);
        script_charge(L, 1);
    }
    for (uint32_t i = 0; i < script->active_count; i++) {
        if (script->active[i]->done)
            script_task_release(L, script->active[i]);
        else
            script->active[kept++] = script->active[i];
    }
    script->active_count = kept;
}

/* ---- coroutines ---- */

/* Run the coroutine of the task at `index` until it waits or ends; `count` arguments lie on its own stack.
 * Returns false with what to raise at the top. */
static bool resume(lua_State *L, script_task *task, int index, int count)
{
    kd_script *script = script_of(L);
    script_task *outer = script->running;
    int results;
    index = lua_absindex(L, index);
    task->waits = false;
    script->running = task;
    int status = lua_resume(task->thread, L, count, &results);
    script->running = outer;
    if (status == LUA_YIELD && task->waits) {
        lua_pop(task->thread, results);
        return true;
    }
    if (status == LUA_YIELD) {
        luaL_where(task->thread, 1);
        lua_xmove(task->thread, L, 1);
        lua_pushliteral(L, "a function of kandil.run yielded; pause it by kandil.wait");
        lua_concat(L, 2);
    } else if (status != LUA_OK) {
        script_explain(task->thread);
        lua_xmove(task->thread, L, 1);
    } else {
        lua_settop(task->thread, 0);
    }
    script_task_finish(L, task, index);
    return status == LUA_OK;
}

static script_task *check_task(lua_State *L, int index)
{
    return luaL_checkudata(L, index, TASK_TYPE);
}

/* Push the list of who waits for the task at `index`. */
static void push_waiters(lua_State *L, int index)
{
    index = lua_absindex(L, index);
    if (lua_getiuservalue(L, index, TASK_WAITERS) == LUA_TTABLE)
        return;
    lua_pop(L, 1);
    lua_newtable(L);
    lua_pushvalue(L, -1);
    lua_setiuservalue(L, index, TASK_WAITERS);
}

/* The end of what it waited for wakes a coroutine at that very time. */
static void wake(lua_State *L, int index)
{
    script_task *waiter = lua_touserdata(L, index);
    if (--waiter->pending == 0 && !waiter->done)
        script_task_queue(L, waiter, index, script_of(L)->now_s, false);
}

void script_task_finish(lua_State *L, script_task *task, int index)
{
    if (task->done)
        return;
    index = lua_absindex(L, index);
    task->done = true;
    luaL_checkstack(L, 6, "a task");
    if (lua_getiuservalue(L, index, TASK_WAITERS) == LUA_TTABLE) {
        lua_Integer count = (lua_Integer)lua_rawlen(L, -1);
        for (lua_Integer i = 1; i <= count; i++) {
            lua_rawgeti(L, -1, i);
            wake(L, lua_gettop(L));
            lua_pop(L, 1);
        }
        lua_pushnil(L);
        lua_setiuservalue(L, index, TASK_WAITERS);
    }
    lua_pop(L, 1);
}

/* ---- what is due ---- */

static void fire(lua_State *L, script_task *task, int index, double due_s)
{
    const kd_script *script = script_of(L);
    if (task->kind == SCRIPT_TASK_RUN) {
        if (!resume(L, task, index, 0))
            lua_error(L);
        return;
    }
    if (task->kind == SCRIPT_TASK_TWEEN) {
        script_tween_step(L, task, due_s);
        script_task_finish(L, task, index);
        return;
    }
    if (task->kind == SCRIPT_TASK_AT)
        script_task_finish(L, task, index);
    lua_getiuservalue(L, index, TASK_FUNCTION);
    lua_pushnumber(L, script->step_s);
    lua_call(L, 1, 1);
    bool stopped = lua_isboolean(L, -1) && !lua_toboolean(L, -1);
    lua_pop(L, 1);
    if (task->kind != SCRIPT_TASK_EVERY || task->done)
        return;
    if (stopped)
        script_task_finish(L, task, index);
    else
        script_task_queue(L, task, index, task->start_s + (double)(++task->fired + 1) * task->period_s,
                          false);
}

void script_run_due(lua_State *L, double time_s)
{
    kd_script *script = script_of(L);
    uint32_t count = 0;
    script->step_s = time_s;
    while (script->event_count > 0 && script->events[0].time_s <= time_s + DUE_TOLERANCE_S) {
        if (++count > MAX_DUE)
            luaL_error(L, "more than %d tasks fell due in one step; spread them", MAX_DUE);
        script_event event = take_first(script);
        script->now_s = event.next_step ? time_s : event.time_s;
        int top = lua_gettop(L);
        script_task_push_held(L, event.task);
        script_task_release(L, event.task);
        if (!event.task->done) {
            script_task_hold(L, event.task, top + 1); /* while it runs it can be waited for */
            fire(L, event.task, top + 1, event.time_s);
            script_task_release(L, event.task);
        }
        lua_settop(L, top);
    }
    script->now_s = time_s;
    step_active(L, time_s);
}

/* ---- functions of kandil ---- */

static double check_time(lua_State *L, int index, const char *what)
{
    double time_s = luaL_checknumber(L, index);
    if (!isfinite(time_s) || time_s < 0)
        luaL_error(L, "%s: the time is %f; give seconds from 0 on", what, time_s);
    return time_s;
}

int script_at(lua_State *L)
{
    double time_s = check_time(L, 1, "kandil.at");
    luaL_checktype(L, 2, LUA_TFUNCTION);
    script_task *task = script_task_push(L, SCRIPT_TASK_AT, sizeof *task, 2);
    script_task_queue(L, task, lua_gettop(L), time_s, false);
    return 1;
}

int script_every(lua_State *L)
{
    double period_s = check_time(L, 1, "kandil.every");
    luaL_checktype(L, 2, LUA_TFUNCTION);
    if (period_s < 1e-6)
        return luaL_error(L, "kandil.every: a period of %f s is too short; give a microsecond at least",
                          period_s);
    script_task *task = script_task_push(L, SCRIPT_TASK_EVERY, sizeof *task, 2);
    task->start_s = script_of(L)->now_s;
    task->period_s = period_s;
    script_task_queue(L, task, lua_gettop(L), task->start_s + period_s, false);
    return 1;
}

/* kandil.run(f, …): starts at once, up to its first wait. */
int script_run(lua_State *L)
{
    int count = lua_gettop(L) - 1;
    luaL_checktype(L, 1, LUA_TFUNCTION);
    lua_State *thread = lua_newthread(L);
    lua_insert(L, 1);
    if (!lua_checkstack(thread, count + 1))
        return luaL_error(L, "kandil.run: too many arguments; pass a table");
    lua_xmove(L, thread, count + 1);
    script_task *task = script_task_push(L, SCRIPT_TASK_RUN, sizeof *task, 1);
    task->thread = thread;
    script_task_hold(L, task, 2);
    bool ok = resume(L, task, 2, count);
    script_task_release(L, task);
    if (!ok)
        return lua_error(L);
    lua_settop(L, 2);
    return 1;
}

static bool wait_for_task(lua_State *L, script_task *self, int index)
{
    const script_task *other = check_task(L, index);
    if (other == self)
        luaL_error(L, "kandil.wait: a coroutine cannot wait for itself; wait for another task");
    if (other->done)
        return false;
    push_waiters(L, index);
    script_task_push_held(L, self);
    lua_rawseti(L, -2, (lua_Integer)lua_rawlen(L, -2) + 1);
    lua_pop(L, 1);
    self->pending++;
    return true;
}

/* kandil.wait(seconds), kandil.wait(task, …), kandil.wait(): until the next step. Seconds count from when the
 * coroutine was to go on, not from the step in which it did: waits add up exactly. */
int script_wait(lua_State *L)
{
    kd_script *script = script_of(L);
    script_task *self = script->running;
    if (!self || self->thread != L)
        return luaL_error(L, "kandil.wait works in a function that was given to kandil.run; start one");
    if (lua_type(L, 1) == LUA_TUSERDATA) {
        int count = lua_gettop(L);
        for (int i = 1; i <= count; i++)
            wait_for_task(L, self, i);
        if (!self->pending)
            return 0;
    } else {
        double wait_s = lua_isnoneornil(L, 1) ? 0 : check_time(L, 1, "kandil.wait");
        bool next = wait_s <= 0;
        script_task_push_held(L, self);
        script_task_queue(L, self, lua_gettop(L),
                          next ? script->step_s + 2 * DUE_TOLERANCE_S : script->now_s + wait_s, next);
    }
    self->waits = true;
    return lua_yield(L, 0);
}

static int task_cancel(lua_State *L)
{
    script_task *task = check_task(L, 1);
    if (task == script_of(L)->running)
        return luaL_error(L, "a coroutine cannot cancel itself; return from it");
    script_task_finish(L, task, 1);
    return 0;
}

static int task_done(lua_State *L)
{
    lua_pushboolean(L, check_task(L, 1)->done);
    return 1;
}

const script_function script_task_methods[] = {
    {"cancel", task_cancel, "task:cancel()", "end it where it stands; who waits for it goes on"},
    {"done", task_done, "task:done()", "tell whether it has ended"},
    {NULL, NULL, NULL, NULL},
};

void script_task_open(lua_State *L)
{
    luaL_newmetatable(L, TASK_TYPE);
    script_push_functions(L, script_task_methods);
    lua_setfield(L, -2, "__index");
    lua_pushliteral(L, "protected");
    lua_setfield(L, -2, "__metatable");
    lua_rawsetp(L, LUA_REGISTRYINDEX, &meta_key);
}
