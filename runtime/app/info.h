#ifndef KD_APP_INFO_H
#define KD_APP_INFO_H

#include "runtime/core/status.h"

/** Print what a model file holds. Errors with a message */
kd_status app_info_print(const char *path);

#endif
