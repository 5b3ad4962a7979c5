#ifndef KD_APP_HELP_H
#define KD_APP_HELP_H

#include "runtime/core/status.h"

#include "runtime/app/extension.h"

/** Print help on the program (topic NULL), a command, "settings", "scenario" or "messages" to standard output, or the
 *  program's manual page ("man") or its completion for a shell ("bash", "zsh").
 *
 *  extension  whose components scenarios can use, too; NULL: none
 *  Errors     USAGE for an unknown topic
 */
kd_status app_help_print(const char *topic, const kd_extension *extension);

#endif
