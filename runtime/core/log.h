#ifndef KD_CORE_LOG_H
#define KD_CORE_LOG_H

#include "runtime/core/status.h"

typedef enum kd_log_level { KD_LOG_DEBUG, KD_LOG_INFO, KD_LOG_WARNING, KD_LOG_ERROR } kd_log_level;

/** Receive one message without newline; `text` is borrowed for the call. Threading: any thread, one call at a
 * time. */
typedef void kd_log_sink(void *user, kd_log_level level, const char *text);

/** Hand in the sink for all messages; NULL restores the default, which writes `kandil: TEXT` to standard
 * error. */
void kd_log_set_sink(kd_log_sink *sink, void *user);

/** Write one message. Threading: any. */
void kd_log(kd_log_level level, const char *format, ...) __attribute__((format(printf, 2, 3)));

/** Write one error message and return `status`, so that a failing call can end in `return kd_fail(…)`. */
kd_status kd_fail(kd_status status, const char *format, ...) __attribute__((format(printf, 2, 3)));

/** Count warnings and errors written since the program started. */
int kd_log_count(kd_log_level level);

#endif
