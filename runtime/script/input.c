/* Functions of a scenario that the runtime calls: every step, and for what happens to a window. Input that
 * came between two steps is told at the beginning of the next, so that a step is a function of what it was
 * told. */
#include "runtime/script/internal.h"

#include <string.h>

const script_function script_callbacks[] = {
    [KD_SCRIPT_UPDATE] = {"update", NULL, "function kandil.update(t, dt)",
                          "every step: time and length of the step, seconds"},
    [KD_SCRIPT_ON_KEY] =
        {"on_key", NULL, "function kandil.on_key(key, down)",
         "a key was pressed or let go: `\"a\"`, `\"space\"`, `\"left\"`, `\"f3\"`, `\"kp_5\"`"},
    [KD_SCRIPT_ON_MOUSE] =
        {"on_mouse", NULL, "function kandil.on_mouse(button, down, x, y)",
         "a button of the mouse: `\"left\"`, `\"middle\"`, `\"right\"`; x and y from 0, 0 at the "
         "picture's upper left to 1, 1"},
    [KD_SCRIPT_ON_MOUSE_MOVE] = {"on_mouse_move", NULL, "function kandil.on_mouse_move(x, y)",
                                 "the pointer has moved"},
    [KD_SCRIPT_ON_SCROLL] = {"on_scroll", NULL, "function kandil.on_scroll(x, y)",
                             "notches of the wheel; y > 0 away from the hand"},
    [KD_SCRIPT_CALLBACK_COUNT] = {NULL, NULL, NULL, NULL},
};

bool kd_script_listens(const kd_script *script, kd_script_callback callback)
{
    return script->callbacks[callback] != LUA_NOREF;
}

void kd_script_push_input(kd_script *script, const kd_script_input *input)
{
    if (script->input_count == SCRIPT_MAX_INPUTS) {
        script->input_first = (script->input_first + 1) % SCRIPT_MAX_INPUTS;
        script->input_count--;
    }
    script->inputs[(script->input_first + script->input_count++) % SCRIPT_MAX_INPUTS] = *input;
}

/* ---- what is held ---- */

static void hold(kd_script *script, const char *name, bool down)
{
    int place = -1;
    for (int i = 0; i < SCRIPT_MAX_HELD; i++) {
        bool same = script->held[i] && strcmp(script->held[i], name) == 0;
        place = same || (place < 0 && !script->held[i]) ? i : place;
        if (same)
            break;
    }
    if (place >= 0 && (down || script->held[place]))
        script->held[place] = down ? name : NULL;
}

/* kandil.key("space"): whether it is held. */
int script_key(lua_State *L)
{
    const kd_script *script = script_of(L);
    const char *name = luaL_checkstring(L, 1);
    bool down = false;
    for (int i = 0; i < SCRIPT_MAX_HELD; i++)
        down = down || (script->held[i] && strcmp(script->held[i], name) == 0);
    lua_pushboolean(L, down);
    return 1;
}

/* ---- telling ---- */

static int push_arguments(lua_State *L, const kd_script_input *input)
{
    bool named = input->kind == KD_SCRIPT_ON_KEY || input->kind == KD_SCRIPT_ON_MOUSE;
    if (named) {
        lua_pushstring(L, input->name);
        lua_pushboolean(L, input->down);
    }
    if (input->kind == KD_SCRIPT_ON_KEY)
        return 2;
    lua_pushnumber(L, (lua_Number)input->x);
    lua_pushnumber(L, (lua_Number)input->y);
    return named ? 4 : 2;
}

void script_run_inputs(lua_State *L)
{
    kd_script *script = script_of(L);
    while (script->input_count > 0) {
        kd_script_input input = script->inputs[script->input_first];
        script->input_first = (script->input_first + 1) % SCRIPT_MAX_INPUTS;
        script->input_count--;
        if (input.kind == KD_SCRIPT_ON_KEY || input.kind == KD_SCRIPT_ON_MOUSE)
            hold(script, input.name, input.down);
        if (!kd_script_listens(script, input.kind))
            continue;
        lua_rawgeti(L, LUA_REGISTRYINDEX, script->callbacks[input.kind]);
        lua_call(L, push_arguments(L, &input), 0);
    }
}
