#ifndef KD_APP_OPTIONS_READ_H
#define KD_APP_OPTIONS_READ_H

/* Values of options, checked. Each failure writes one message that names the option; USAGE. */

#include <stdint.h>

#include "runtime/app/options.h"

/** Read a whole number from min to max. */
kd_status app_read_integer(const char *option, const char *text, int64_t min, int64_t max, int64_t *out);
/** Read a number from min to max. */
kd_status app_read_real(const char *option, const char *text, double min, double max, double *out);
/** Read one of a NULL-terminated list of words as its index. */
kd_status app_read_word(const char *option, const char *text, const char *const *words, int *out);
/** Read a path, which is kept as it is. */
kd_status app_read_path(const char *option, const char *text, const char **out);

/* ---- readers of what the path tracer is asked for ---- */
kd_status app_read_frame(app_options *o, const char *text);
kd_status app_read_spp(app_options *o, const char *text);
kd_status app_read_bounces(app_options *o, const char *text);
kd_status app_read_gathers(app_options *o, const char *text);
kd_status app_read_terms(app_options *o, const char *text);
kd_status app_read_lambert(app_options *o, const char *text);
kd_status app_read_temporal(app_options *o, const char *text);
kd_status app_read_pixel(app_options *o, const char *text);
kd_status app_read_time_budget(app_options *o, const char *text);
kd_status app_read_techniques(app_options *o, const char *text);
kd_status app_read_html(app_options *o, const char *text);
kd_status app_read_report(app_options *o, const char *text);
kd_status app_read_noise(app_options *o, const char *text);

#endif
