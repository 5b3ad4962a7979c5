#ifndef KD_SCRIPT_TASK_H
#define KD_SCRIPT_TASK_H

/* What happens later: functions at a time, coroutines that wait, movements that last.
 *
 * A task is a userdata. It is held (kept from the collector) as long as the queue or the list of what runs
 * every step points to it; a coroutine that waits for other tasks is kept by their lists of waiters. Its
 * first user value is the function or the thread, its second the list of coroutines that wait for its end. */

#include "runtime/script/internal.h"

typedef enum script_task_kind {
    SCRIPT_TASK_AT,
    SCRIPT_TASK_EVERY,
    SCRIPT_TASK_RUN,
    SCRIPT_TASK_TWEEN, /* a script_tween */
    SCRIPT_TASK_CLIP,  /* a script_clip_watch */
} script_task_kind;

struct script_task {
    uint64_t order; /* of making: a scenario's objects begin with it, see internal.h */
    script_task_kind kind;
    bool done;        /* or cancelled */
    bool waits;       /* a coroutine that yielded by kandil.wait */
    uint32_t pending; /* tasks that the coroutine waits for */
    uint32_t holds;
    int anchor; /* registry reference while it is held */
    double start_s, period_s;
    uint64_t fired; /* times that "every" has fired */
    lua_State *thread;
};

enum { TASK_FUNCTION = 1, TASK_WAITERS = 2, TASK_VALUES = 2 };

/** Push a new task of `size` bytes, zero after the head, with the value at `function` as its first user
 * value. */
script_task *script_task_push(lua_State *L, script_task_kind kind, size_t size, int function);
/** Hold the task at `index` of the stack once more; let go of it once. */
void script_task_hold(lua_State *L, script_task *task, int index);
void script_task_release(lua_State *L, script_task *task);
void script_task_push_held(lua_State *L, const script_task *task); /* pushes it again */

/** Queue the task at `index` for a time. */
void script_task_queue(lua_State *L, script_task *task, int index, double time_s, bool next_step);
/** Let it run every step from now on; stop that. */
void script_task_activate(lua_State *L, script_task *task, int index);
/** End the task at `index`: it runs no more, and who waits for it goes on. */
void script_task_finish(lua_State *L, script_task *task, int index);

/* ---- one step of each kind ---- */
void script_tween_step(lua_State *L, script_task *task, double time_s);
void script_clip_step(lua_State *L, script_task *task);

#endif
