/* Runs the kandil program of this build as a user does: a process of its own with a time limit, its standard
 * error kept. */
#ifndef KD_TESTS_PROGRAM_FIXTURE_H
#define KD_TESTS_PROGRAM_FIXTURE_H

#include <fcntl.h>
#include <signal.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

#define PROGRAM_PATH KD_BINARY_DIR "/kandil"

/* A limit for programs that hang, no measure: a first picture compiles shaders for 5 s on an idle machine, and
 * machines are shared. */
#define PROGRAM_LIMIT_S 45.0

typedef struct program {
    pid_t pid;       /* 0: none runs here */
    double deadline; /* on the monotonic clock [s] */
    bool timed_out;
    int code; /* exit code, or 1000 + the signal that ended it */
    char said_path[128];
    char said[8192]; /* standard error, cut at the buffer's end */
} program;

static inline double program_clock_s(void)
{
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

/* Start `kandil` with argv[1…]; standard error goes to said_path, standard output nowhere. */
static inline bool program_start(program *p, const char *said_path, const char *const *argv, double limit_s)
{
    *p = (program){.deadline = program_clock_s() + limit_s};
    snprintf(p->said_path, sizeof p->said_path, "%s", said_path);
    p->pid = fork();
    if (p->pid == 0) {
        int errors = open(said_path, O_CREAT | O_TRUNC | O_WRONLY, 0600), nowhere = open("/dev/null", O_RDWR);
        if (errors < 0 || nowhere < 0)
            _exit(126);
        dup2(nowhere, STDIN_FILENO);
        dup2(nowhere, STDOUT_FILENO);
        dup2(errors, STDERR_FILENO);
        close(errors);
        close(nowhere);
        execv(PROGRAM_PATH, (char *const *)(uintptr_t)argv);
        _exit(127);
    }
    return p->pid > 0;
}

/* True once it has ended; one beyond its limit is killed. */
static inline bool program_poll(program *p)
{
    int state = 0;
    pid_t done = waitpid(p->pid, &state, WNOHANG);
    if (done == 0 && program_clock_s() > p->deadline) {
        p->timed_out = true;
        kill(p->pid, SIGKILL);
        done = waitpid(p->pid, &state, 0);
    }
    if (done == 0)
        return false;
    p->code = WIFEXITED(state) ? WEXITSTATUS(state) : 1000 + WTERMSIG(state);
    p->pid = 0;
    FILE *file = fopen(p->said_path, "rb");
    size_t size = file ? fread(p->said, 1, sizeof p->said - 1, file) : 0;
    p->said[size] = '\0';
    if (file)
        fclose(file);
    unlink(p->said_path);
    return true;
}

static inline void program_wait(program *p)
{
    while (!program_poll(p))
        nanosleep(&(struct timespec){.tv_nsec = 5000000}, NULL);
}

/* One line that starts with the program's name and mentions `about`. */
static inline bool program_said_one_line(const program *p, const char *about)
{
    const char *newline = strchr(p->said, '\n');
    return strncmp(p->said, "kandil: ", 8) == 0 && newline && !newline[1] && strstr(p->said, about);
}

/* Nothing but warnings of ours: `kandil: warning: …`, a line each. */
static inline bool program_said_only_warnings(const program *p)
{
    const char *line = p->said;
    while (*line) {
        const char *newline = strchr(line, '\n');
        if (strncmp(line, "kandil: warning: ", 17) != 0 || !newline)
            return false;
        line = newline + 1;
    }
    return true;
}

#endif
