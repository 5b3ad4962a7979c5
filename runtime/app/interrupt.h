#ifndef KD_APP_INTERRUPT_H
#define KD_APP_INTERRUPT_H

#include <stdbool.h>

/** Note SIGINT, SIGTERM and SIGHUP instead of dying; a second one kills, once half written files are gone.
 * SIGPIPE becomes an ordinary write error. */
void app_interrupt_install(void);
bool app_interrupted(void);

#endif
