/* An X server of the test's own, so that no screen is needed and none is disturbed. */
#ifndef KD_TESTS_XVFB_FIXTURE_H
#define KD_TESTS_XVFB_FIXTURE_H

#include <errno.h>
#include <poll.h>
#include <signal.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/types.h>
#include <sys/wait.h>
#include <unistd.h>

static pid_t xvfb_server;

/* Start Xvfb on a free display and point DISPLAY at it. Returns false when there is no Xvfb. */
static inline bool xvfb_start(const char *screen)
{
    int ends[2];
    char text[32] = ":", fd_text[16];
    if (pipe(ends) != 0)
        return false;
    xvfb_server = fork();
    if (xvfb_server == 0) {
        close(ends[0]);
        if (!freopen("/dev/null", "w", stderr))
            _exit(127);
        snprintf(fd_text, sizeof fd_text, "%d", ends[1]);
        /* Without -noreset the server starts anew when its last client leaves, and refuses the next
         * meanwhile. */
        execlp("Xvfb", "Xvfb", "-displayfd", fd_text, "-screen", "0", screen, "-nolisten", "tcp", "-noreset",
               (char *)NULL);
        _exit(127);
    }
    close(ends[1]);
    size_t used = 1;
    ssize_t got = 0;
    struct pollfd wait = {.fd = ends[0], .events = POLLIN};
    while (used < sizeof text - 1 && !strchr(text, '\n') && poll(&wait, 1, 20000) > 0 &&
           (got = read(ends[0], text + used, sizeof text - 1 - used)) > 0)
        used += (size_t)got;
    close(ends[0]);
    text[strcspn(text, "\n")] = '\0';
    return used > 1 && setenv("DISPLAY", text, 1) == 0 && unsetenv("WAYLAND_DISPLAY") == 0;
}

static inline void xvfb_stop(void)
{
    kill(xvfb_server, SIGTERM);
    while (waitpid(xvfb_server, NULL, 0) < 0 && errno == EINTR) {
    }
}

#endif
