#ifndef KD_APP_DOCTOR_H
#define KD_APP_DOCTOR_H

#include "runtime/core/status.h"

/** Print every way to a GL context with its driver and limits, the programs found, and advice. Errors
 * NO_CONTEXT when no way works, after everything was printed */
kd_status app_doctor_print(void);

#endif
