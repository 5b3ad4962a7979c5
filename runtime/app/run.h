#ifndef KD_APP_RUN_H
#define KD_APP_RUN_H

#include "runtime/app/options.h"

/** Do `kandil run`. Errors with a message; INTERRUPTED after Ctrl+C, with everything finished so far written
 */
kd_status app_run(const app_options *options);

#endif
