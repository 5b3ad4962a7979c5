#ifndef KD_SCRIPT_PATTERN_H
#define KD_SCRIPT_PATTERN_H

#include "runtime/script/internal.h"

/* Lua's patterns (Lua 5.4 manual, section 6.4.1), with the scenario's budget charged for every step. */

#define PATTERN_CAPTURES 32

#define CAPTURE_OPEN     ((ptrdiff_t)-1)
#define CAPTURE_POSITION ((ptrdiff_t)-2)

typedef struct matcher {
    lua_State *L;
    const char *text, *text_end, *pattern_end;
    int steps, depth, count;
    struct {
        const char *start;
        ptrdiff_t length; /* or CAPTURE_* */
    } captures[PATTERN_CAPTURES];
} matcher;

matcher pattern_begin(lua_State *L, const char *text, size_t text_size, const char *pattern,
                      size_t pattern_size);

/** Charge for a step of a search. */
void pattern_step(matcher *m);

/** Try pattern p at s alone, forgetting what was captured before. Returns where the match ends, or NULL. */
const char *pattern_try(matcher *m, const char *s, const char *p);

/** Push capture i of a match from s to end; capture 0 of a pattern without any is the whole. */
void pattern_push_capture(matcher *m, int i, const char *s, const char *end);

/** Push all. Returns how many. */
int pattern_push_captures(matcher *m, const char *s, const char *end);

#endif
