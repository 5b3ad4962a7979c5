#include "runtime/app/child.h"

#include <errno.h>
#include <fcntl.h>
#include <signal.h>
#include <spawn.h>
#include <stdatomic.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include "runtime/core/log.h"

extern char **environ;

/* Who runs, for a signal handler; 0: nobody. */
enum { MAX_CHILDREN = 16 };
static atomic_int running[MAX_CHILDREN];

static void exchange(int from, int to)
{
    for (int i = 0; i < MAX_CHILDREN; i++) {
        int expected = from;
        if (atomic_compare_exchange_strong(&running[i], &expected, to))
            return;
    }
}

void app_children_kill(void)
{
    for (int i = 0; i < MAX_CHILDREN; i++)
        if (atomic_load(&running[i]) > 0)
            kill(atomic_load(&running[i]), SIGKILL);
}

bool app_find_program(const char *name, char *out, size_t out_size)
{
    const char *path = getenv("PATH");
    for (const char *p = path ? path : ""; *p;) {
        size_t length = strcspn(p, ":");
        struct stat info;
        int written = snprintf(out, out_size, "%.*s/%s", (int)length, p, name);
        if (length > 0 && written > 0 && (size_t)written < out_size && access(out, X_OK) == 0 &&
            stat(out, &info) == 0 && S_ISREG(info.st_mode))
            return true;
        p += length + (p[length] == ':');
    }
    return false;
}

static int temporary_file(void)
{
    char path[] = "/tmp/kandil-XXXXXX";
    int file = mkstemp(path);
    if (file >= 0) {
        unlink(path);
        fcntl(file, F_SETFD, FD_CLOEXEC);
    }
    return file;
}

/* Start it with the read end of the pipe as standard input. Returns an errno value. */
static int spawn(app_child *child, int read_end, const char *const *argv)
{
    posix_spawn_file_actions_t files;
    posix_spawnattr_t attributes;
    sigset_t defaults;
    sigemptyset(&defaults);
    sigaddset(&defaults, SIGPIPE);
    posix_spawn_file_actions_init(&files);
    posix_spawnattr_init(&attributes);
    posix_spawn_file_actions_adddup2(&files, read_end, STDIN_FILENO);
    posix_spawn_file_actions_addopen(&files, STDOUT_FILENO, "/dev/null", O_WRONLY, 0);
    if (child->errors >= 0)
        posix_spawn_file_actions_adddup2(&files, child->errors, STDERR_FILENO);
    posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETPGROUP | POSIX_SPAWN_SETSIGDEF);
    posix_spawnattr_setpgroup(&attributes, 0);
    posix_spawnattr_setsigdefault(&attributes, &defaults);
    int error =
        posix_spawnp(&child->pid, argv[0], &files, &attributes, (char *const *)(uintptr_t)argv, environ);
    posix_spawn_file_actions_destroy(&files);
    posix_spawnattr_destroy(&attributes);
    return error;
}

kd_status app_child_start(app_child *child, const char *const *argv)
{
    int ends[2];
    *child = (app_child){.input = -1, .errors = -1};
    if (pipe(ends) != 0)
        return kd_fail(KD_IO, "%s: no pipe could be made (%s); close other programs", argv[0],
                       strerror(errno));
    fcntl(ends[0], F_SETFD, FD_CLOEXEC);
    fcntl(ends[1], F_SETFD, FD_CLOEXEC);
    child->input = ends[1];
    child->errors = temporary_file();
    int error = spawn(child, ends[0], argv);
    close(ends[0]);
    if (error == 0) {
        exchange(0, (int)child->pid);
        return KD_OK;
    }
    child->pid = 0;
    app_child_finish(child, NULL, 0);
    return kd_fail(KD_IO, "%s: could not be started (%s); check its installation", argv[0], strerror(error));
}

bool app_child_write(app_child *child, const void *data, size_t size)
{
    const char *at = data;
    while (size > 0) {
        ssize_t written = write(child->input, at, size);
        if (written < 0 && errno == EINTR)
            continue;
        if (written <= 0)
            return false;
        at += written;
        size -= (size_t)written;
    }
    return true;
}

static void last_line(int file, char *line, size_t line_size)
{
    char text[2048];
    off_t end = lseek(file, 0, SEEK_END),
          start = end > (off_t)sizeof text - 1 ? end - (off_t)sizeof text + 1 : 0;
    ssize_t count = pread(file, text, sizeof text - 1, start);
    line[0] = '\0';
    if (count <= 0)
        return;
    while (count > 0 && (text[count - 1] == '\n' || text[count - 1] == '\r'))
        count--;
    text[count] = '\0';
    char *newline = strrchr(text, '\n');
    snprintf(line, line_size, "%s", newline ? newline + 1 : text);
}

int app_child_finish(app_child *child, char *line, size_t line_size)
{
    int state = 0, code = -1;
    if (child->input >= 0)
        close(child->input);
    child->input = -1;
    if (child->pid > 0) {
        pid_t done;
        while ((done = waitpid(child->pid, &state, 0)) < 0 && errno == EINTR)
            ;
        exchange((int)child->pid, 0);
        if (done == child->pid)
            code = WIFEXITED(state) ? WEXITSTATUS(state) : 128 + WTERMSIG(state);
    }
    child->pid = 0;
    if (line && line_size > 0) {
        line[0] = '\0';
        if (child->errors >= 0)
            last_line(child->errors, line, line_size);
    }
    if (child->errors >= 0)
        close(child->errors);
    child->errors = -1;
    return code;
}
