#include "runtime/app/interrupt.h"

#include <signal.h>
#include <stddef.h>

static volatile sig_atomic_t interrupted;

static void note(int number)
{
    (void)number;
    interrupted = 1;
}

void app_interrupt_install(void)
{
    static const int numbers[] = {SIGINT, SIGTERM, SIGHUP};
    struct sigaction action = {.sa_handler = note};
    interrupted = 0;
    sigemptyset(&action.sa_mask);
    action.sa_flags =
        (int)(SA_RESTART | SA_RESETHAND); /* reset: the second signal of a kind does what it always does */
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
