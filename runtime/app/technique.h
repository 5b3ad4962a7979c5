#ifndef KD_APP_TECHNIQUE_H
#define KD_APP_TECHNIQUE_H

#include "runtime/app/options.h"

/** `kandil compare SCENE`: path trace a frame, render it by each technique, and report how they differ.
 * Errors with one message */
kd_status app_compare_techniques(const app_options *options);

#endif
