/* One lock keeps messages whole and the sink's calls apart. A message is formatted before the lock is taken,
 * so that a slow format never holds up another thread. */
#include "runtime/core/log.h"

#include <pthread.h>
#include <stdarg.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>

static pthread_mutex_t log_lock = PTHREAD_MUTEX_INITIALIZER;
static kd_log_sink *log_sink;
static void *log_user;
static atomic_int log_counts[KD_LOG_ERROR + 1];

void kd_log_set_sink(kd_log_sink *sink, void *user)
{
    pthread_mutex_lock(&log_lock);
    log_sink = sink;
    log_user = user;
    pthread_mutex_unlock(&log_lock);
}

static void write_default(kd_log_level level, const char *text)
{
    if (level > KD_LOG_DEBUG)
        fprintf(stderr, "kandil: %s\n", text);
}

static void write_message(kd_log_level level, const char *text)
{
    atomic_fetch_add_explicit(&log_counts[level], 1, memory_order_relaxed);
    pthread_mutex_lock(&log_lock);
    if (log_sink)
        log_sink(log_user, level, text);
    else
        write_default(level, text);
    pthread_mutex_unlock(&log_lock);
}

static void format_message(kd_log_level level, const char *format, va_list args)
{
    char buffer[1024];
    va_list again;
    va_copy(again, args);
    int length = vsnprintf(buffer, sizeof buffer, format, args);
    char *longer = length >= (int)sizeof buffer ? malloc((size_t)length + 1) : NULL;
    if (longer)
        vsnprintf(longer, (size_t)length + 1, format, again);
    va_end(again);
    write_message(level, longer ? longer : length < 0 ? format : buffer);
    free(longer);
}

void kd_log(kd_log_level level, const char *format, ...)
{
    va_list args;
    va_start(args, format);
    format_message(level, format, args);
    va_end(args);
}

kd_status kd_fail(kd_status status, const char *format, ...)
{
    va_list args;
    va_start(args, format);
    format_message(KD_LOG_ERROR, format, args);
    va_end(args);
    return status;
}

int kd_log_count(kd_log_level level)
{
    return atomic_load_explicit(&log_counts[level], memory_order_relaxed);
}
