#ifndef KD_APP_CONSOLE_H
#define KD_APP_CONSOLE_H

/* The terminal: messages and the progress bar share it, so one file owns it. Threading: any, except open and
 * close. */

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

void app_console_open(void);            /* takes over the log's sink */
void app_console_set_quiet(bool quiet); /* errors only */
void app_console_close(void);

/** Draw the bar when standard error is a terminal. `frame_ms` is the time of the last frame. */
void app_console_progress(uint64_t done, uint64_t total, double frame_ms);
/** Draw the bar for some other work when standard error is a terminal, and nothing otherwise. */
void app_console_bar(uint64_t done, uint64_t total, const char *what);
/** Show how much of some work is done: the bar on a terminal, else a line at each tenth. `what` names its
 * parts. */
void app_console_work(uint64_t done, uint64_t total, const char *what);
void app_console_clear(void);

/** Catch errors in `text` instead of printing them: the last one stays. NULL ends that. */
void app_console_capture(char *text, size_t size);

/** Hand every warning and error to somebody else too. NULL ends that. Threading: called by any thread, one at
 * a time; it must not log. */
void app_console_listen(void (*listener)(void *user, bool error, const char *text), void *user);
/** An error is over and the program goes on: the next one is printed again. */
void app_console_recover(void);

/** Tell whether an error was printed. */
bool app_console_said_error(void);

/** Get the warnings so far, oldest first; at most 64 are kept. Valid until the next warning. */
const char *const *app_console_warnings(uint32_t *count);

#endif
