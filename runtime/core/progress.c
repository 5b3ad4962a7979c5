#include "runtime/core/progress.h"

#include <stddef.h>

static struct {
    kd_progress_sink *sink;
    void *user;
} progress;

void kd_progress_set_sink(kd_progress_sink *sink, void *user)
{
    progress.sink = sink;
    progress.user = user;
}

bool kd_progress(uint64_t done, uint64_t total, const char *what)
{
    return !progress.sink || progress.sink(progress.user, done, total, what);
}
