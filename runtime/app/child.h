#ifndef KD_APP_CHILD_H
#define KD_APP_CHILD_H

/* A program run beside this one, fed through a pipe. */

#include <stdbool.h>
#include <stddef.h>
#include <sys/types.h>

#include "runtime/core/status.h"

typedef struct app_child {
    pid_t pid;  /* 0: none */
    int input;  /* write end of its standard input; -1: none */
    int errors; /* an unlinked file that takes its standard error */
} app_child;

/** Find a program in PATH. Returns false when there is none that may be run. */
bool app_find_program(const char *name, char *out, size_t out_size);

/** Start a program, argv[0] looked up in PATH. It gets a process group of its own, so that Ctrl+C reaches
 * only us. Errors IO with a message */
kd_status app_child_start(app_child *child, const char *const *argv);

/** Write everything to its input. Returns false when the child closed it or died. */
bool app_child_write(app_child *child, const void *data, size_t size);

/** Close its input, wait for it, and copy the last line of its standard error to `line`.
 *  Returns its exit code, 128 + the signal that ended it, or -1 */
int app_child_finish(app_child *child, char *line, size_t line_size);

/** Kill all that run. Threading: any, and from signal handlers; this process is to end too */
void app_children_kill(void);

#endif
