#ifndef KD_APP_WINDOW_RELOAD_H
#define KD_APP_WINDOW_RELOAD_H

/* Files that what is shown was made of: tells when one was written anew. Folders are watched, since editors
 * put another file in the place of the old one. */

#include <stdbool.h>
#include <stdint.h>

#include "runtime/core/status.h"

typedef struct window_watch window_watch;

typedef enum window_change {
    WINDOW_CHANGED_SCENARIO = 1, /* the scenario or one of its modules */
    WINDOW_CHANGED_SHADERS = 2,
    WINDOW_CHANGED_MODEL = 4, /* or a file that it names */
} window_change;

/** Returns NULL, after a warning, when the system tells nothing about files. */
window_watch *window_watch_make(void);
void window_watch_destroy(window_watch *w); /* NULL does nothing */
/** Forget every file. */
void window_watch_clear(window_watch *w);
/** Watch one file. */
void window_watch_file(window_watch *w, const char *path, window_change change);
/** Watch all files of a folder and of those below it. */
void window_watch_tree(window_watch *w, const char *folder, window_change change);
/** Tell what has changed and been still since for a moment: window_change bits, each told once. Cost: none */
uint32_t window_watch_poll(window_watch *w, double now_s);

#endif
