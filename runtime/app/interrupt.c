#include "runtime/app/interrupt.h"

#include <signal.h>
#include <stddef.h>

#include "runtime/app/child.h"
#include "runtime/core/temp_files.h"

static volatile sig_atomic_t interrupted;

/* The first is noted, and the frame under way is finished. Who asks again wants the end at once: nothing half
 * written stays, and the signal then does what it always does. */
static void note(int number)
{
    if (interrupted) {
        app_children_kill();
        kd_temp_files_remove();
        signal(number, SIG_DFL);
        raise(number);
    }
    interrupted = 1;
}

void app_interrupt_install(void)
{
    static const int numbers[] = {SIGINT, SIGTERM, SIGHUP};
    struct sigaction action = {.sa_handler = note};
    interrupted = 0;
    sigemptyset(&action.sa_mask);
    action.sa_flags = SA_RESTART;
    for (size_t i = 0; i < sizeof numbers / sizeof *numbers; i++)
        sigaction(numbers[i], &action, NULL);
    struct sigaction ignore = {.sa_handler = SIG_IGN};
    sigaction(SIGPIPE, &ignore, NULL);
    sigaction(SIGXFSZ, &ignore, NULL); /* writing then fails, and says so */
}

bool app_interrupted(void)
{
    return interrupted != 0;
}
