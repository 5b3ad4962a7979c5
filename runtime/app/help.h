#ifndef KD_APP_HELP_H
#define KD_APP_HELP_H

#include "runtime/core/status.h"

/** Print help on the program (topic NULL), a command, or "settings", to standard output. Errors USAGE for an
 * unknown topic */
kd_status app_help_print(const char *topic);

#endif
