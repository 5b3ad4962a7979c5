#include "runtime/app/console.h"

#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "runtime/core/log.h"

#define MAX_WARNINGS 64
#define BAR_WIDTH    32

static struct {
    pthread_mutex_t lock;
    bool quiet, terminal, bar_shown, said_error;
    char *capture;
    size_t capture_size;
    char *warnings[MAX_WARNINGS];
    uint32_t warning_count;
    void (*listener)(void *user, bool error, const char *text);
    void *listener_user;
} console = {.lock = PTHREAD_MUTEX_INITIALIZER};

static void hide_bar(void)
{
    if (console.bar_shown)
        fputs("\r\033[K", stderr);
    console.bar_shown = false;
}

static void keep_warning(const char *text)
{
    if (console.warning_count == MAX_WARNINGS)
        return;
    char *copy = strdup(text);
    if (copy)
        console.warnings[console.warning_count++] = copy;
}

static void print(kd_log_level level, const char *text)
{
    hide_bar();
    fprintf(stderr, "kandil: %s%s\n", level == KD_LOG_WARNING ? "warning: " : "", text);
}

static void sink(void *user, kd_log_level level, const char *text)
{
    (void)user;
    pthread_mutex_lock(&console.lock);
    if (level == KD_LOG_WARNING)
        keep_warning(text);
    if (level == KD_LOG_ERROR && console.capture) {
        snprintf(console.capture, console.capture_size, "%s", text);
    } else if (level == KD_LOG_ERROR || (level > KD_LOG_DEBUG && !console.quiet)) {
        /* What fails after the first failure follows from it. */
        bool said = level != KD_LOG_ERROR || !console.said_error;
        if (said)
            print(level, text);
        if (said && console.listener && level >= KD_LOG_WARNING)
            console.listener(console.listener_user, level == KD_LOG_ERROR, text);
        console.said_error = console.said_error || level == KD_LOG_ERROR;
    }
    pthread_mutex_unlock(&console.lock);
}

void app_console_open(void)
{
    console.terminal = isatty(STDERR_FILENO) != 0;
    kd_log_set_sink(sink, NULL);
}

void app_console_set_quiet(bool quiet)
{
    console.quiet = quiet;
}

void app_console_close(void)
{
    app_console_clear();
    kd_log_set_sink(NULL, NULL);
    for (uint32_t i = 0; i < console.warning_count; i++)
        free(console.warnings[i]);
    console.warning_count = 0;
    console.said_error = false;
    console.quiet = false;
}

static void draw_bar(uint64_t done, uint64_t total, const char *text)
{
    char bar[BAR_WIDTH + 1];
    uint64_t filled = done * BAR_WIDTH / total;
    for (uint64_t i = 0; i < BAR_WIDTH; i++)
        bar[i] = i < filled ? '#' : '.';
    bar[BAR_WIDTH] = '\0';
    pthread_mutex_lock(&console.lock);
    fprintf(stderr, "\r[%s] %llu/%llu  %s\033[K", bar, (unsigned long long)done, (unsigned long long)total,
            text);
    fflush(stderr);
    console.bar_shown = true;
    pthread_mutex_unlock(&console.lock);
}

void app_console_bar(uint64_t done, uint64_t total, const char *what)
{
    if (console.terminal && !console.quiet && total > 0)
        draw_bar(done, total, what);
}

void app_console_progress(uint64_t done, uint64_t total, double frame_ms)
{
    char text[32];
    snprintf(text, sizeof text, "%.0f ms a frame", frame_ms);
    app_console_bar(done, total, text);
}

void app_console_work(uint64_t done, uint64_t total, const char *what)
{
    if (console.quiet || total == 0)
        return;
    if (console.terminal)
        draw_bar(done, total, what);
    else if (done == total || done * 10 / total != (done - 1) * 10 / total)
        kd_log(KD_LOG_INFO, "%llu of %llu %s", (unsigned long long)done, (unsigned long long)total, what);
}

void app_console_clear(void)
{
    pthread_mutex_lock(&console.lock);
    hide_bar();
    pthread_mutex_unlock(&console.lock);
}

void app_console_capture(char *text, size_t size)
{
    pthread_mutex_lock(&console.lock);
    console.capture = text;
    console.capture_size = size;
    if (text && size > 0)
        text[0] = '\0';
    pthread_mutex_unlock(&console.lock);
}

void app_console_listen(void (*listener)(void *user, bool error, const char *text), void *user)
{
    pthread_mutex_lock(&console.lock);
    console.listener = listener;
    console.listener_user = user;
    pthread_mutex_unlock(&console.lock);
}

void app_console_recover(void)
{
    pthread_mutex_lock(&console.lock);
    console.said_error = false;
    pthread_mutex_unlock(&console.lock);
}

bool app_console_said_error(void)
{
    return console.said_error;
}

const char *const *app_console_warnings(uint32_t *count)
{
    *count = console.warning_count;
    return (const char *const *)console.warnings;
}
