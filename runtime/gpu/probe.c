/* Trying every way to a context. Each try is a child process that reports through a pipe, so that a driver
 * that crashes, hangs or spoils the process is a line in the report and nothing more. */

#include <errno.h>
#include <poll.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/wait.h>
#include <unistd.h>
#include <glob.h>

#include "runtime/gpu/internal.h"

enum { PATIENCE_MS = 30000, TIMED_FILL_BYTES = 32 << 20 };

static void ignore_message(void *user, kd_log_level level, const char *text)
{
    (void)user;
    (void)level;
    (void)text;
}

/* Time filling a buffer by the GPU's clock and by the CPU's, finishing before and after: a timer that works
 * counts up and says no more than what the CPU saw. */
static bool try_timer(kd_gpu *gpu)
{
    uint64_t ns[2] = {0, 0};
    kd_gpu_buffer buffer = kd_gpu_make_buffer(
        gpu, &(kd_gpu_buffer_desc){.size = TIMED_FILL_BYTES, .zeroed = true, .name = "probe"});
    kd_gpu_finish(gpu);
    uint64_t before = kd_clock_ns();
    kd_gpu_timestamp(gpu, 0);
    kd_gpu_fill_buffer(gpu, buffer, 0, TIMED_FILL_BYTES, 1);
    kd_gpu_timestamp(gpu, 1);
    kd_gpu_finish(gpu);
    uint64_t spent = kd_clock_ns() - before;
    kd_gpu_end_frame(gpu);
    kd_gpu_finish(gpu);
    bool read = kd_gpu_read_timestamps(gpu, ns, 2) != UINT64_MAX;
    kd_gpu_destroy_buffer(gpu, buffer);
    return read && ns[1] > ns[0] && ns[1] - ns[0] <= spent;
}

static void copy_text(char *out, size_t capacity, const char *text)
{
    snprintf(out, capacity, "%.*s", (int)capacity - 1, text);
}

static void add_note(kd_gpu_probe_row *row, const char *note)
{
    size_t used = strlen(row->note);
    snprintf(row->note + used, sizeof row->note - used, "%s%s", used ? "; " : "", note);
}

static void try_way(kd_gpu_probe_row *row)
{
    gpu_reason reason = {""};
    kd_gpu *gpu = NULL;
    kd_log_set_sink(ignore_message, NULL);
    if (gpu_open_one(&(kd_gpu_desc){.api = row->api, .width = 64, .height = 64}, row->api, &gpu, &reason) !=
        KD_OK) {
        add_note(row, reason.text);
        return;
    }
    const kd_gpu_info *info = kd_gpu_get_info(gpu);
    row->works = true;
    copy_text(row->renderer, sizeof row->renderer, info->renderer);
    copy_text(row->version, sizeof row->version, info->version);
    row->max_ssbo_bytes = info->max_ssbo_bytes;
    row->timestamp_bits = info->timestamp_bits;
    row->timer_works = info->timestamp_bits && try_timer(gpu);
    if (info->software)
        add_note(row, "a software renderer");
    kd_gpu_close(gpu);
}

/* Read a whole row. Returns false when the child ends or hangs before it is there. */
static bool receive(int from, kd_gpu_probe_row *row, bool *timed_out)
{
    size_t used = 0;
    uint64_t end = kd_clock_ns() + (uint64_t)PATIENCE_MS * 1000000u;
    while (used < sizeof *row) {
        uint64_t now = kd_clock_ns();
        struct pollfd wait = {.fd = from, .events = POLLIN};
        int ready = now < end ? poll(&wait, 1, (int)((end - now) / 1000000u) + 1) : 0;
        if (ready < 0 && errno == EINTR)
            continue;
        if (ready <= 0) {
            *timed_out = true;
            return false;
        }
        ssize_t got = read(from, (char *)row + used, sizeof *row - used);
        if (got <= 0)
            return false;
        used += (size_t)got;
    }
    return true;
}

static void run_child(int to, kd_gpu_probe_row *row)
{
    try_way(row);
    const char *bytes = (const char *)row;
    size_t sent = 0;
    while (sent < sizeof *row) {
        ssize_t written = write(to, bytes + sent, sizeof *row - sent);
        if (written <= 0)
            break;
        sent += (size_t)written;
    }
    _exit(0); /* the exit handlers are the parent's */
}

static void probe_way(kd_gpu_probe_row *row)
{
    int ends[2];
    bool timed_out = false;
    kd_gpu_probe_row answer = *row;
    if (pipe(ends) != 0) {
        add_note(row, "no pipe for a trial");
        return;
    }
    pid_t child = fork();
    if (child == 0) {
        close(ends[0]);
        run_child(ends[1], row);
    }
    close(ends[1]);
    if (child > 0 && receive(ends[0], &answer, &timed_out))
        *row = answer;
    else if (child > 0)
        kill(child, SIGKILL);
    close(ends[0]);
    int status = 0;
    if (child < 0)
        add_note(row, "no process for a trial");
    while (child > 0 && waitpid(child, &status, 0) < 0 && errno == EINTR) {
    }
    if (timed_out)
        add_note(row, "the driver hung");
    else if (child > 0 && WIFSIGNALED(status))
        add_note(row, "the driver crashed");
}

/* ---- what to know about the machine ---- */

static size_t count_paths(const char *pattern, bool *unreadable)
{
    glob_t found = {0};
    size_t count = glob(pattern, 0, NULL, &found) == 0 ? found.gl_pathc : 0;
    for (size_t i = 0; unreadable && i < count; i++)
        *unreadable |= access(found.gl_pathv[i], R_OK | W_OK) != 0;
    globfree(&found);
    return count;
}

static void add_egl_notes(kd_gpu_probe_row *row)
{
    bool unreadable = false;
    size_t vendors = count_paths("/usr/share/glvnd/egl_vendor.d/*.json", NULL) +
                     count_paths("/etc/glvnd/egl_vendor.d/*.json", NULL);
    if (!vendors && !getenv("__EGL_VENDOR_LIBRARY_FILENAMES") && !getenv("__EGL_VENDOR_LIBRARY_DIRS"))
        add_note(row, "no EGL vendor library is registered with glvnd (libegl-mesa0 brings one)");
    if (row->api != KD_CONTEXT_EGL_DEVICE)
        return;
    size_t nodes = count_paths("/dev/dri/renderD*", &unreadable);
    bool nvidia = access("/dev/nvidiactl", F_OK) == 0;
    if (!nodes && !nvidia)
        add_note(row, "no /dev/dri/renderD*: the machine shows no GPU");
    if (unreadable)
        add_note(row, "no permission on /dev/dri/renderD* (join the group render)");
    if (nvidia && !count_paths("/usr/share/glvnd/egl_vendor.d/*nvidia*.json", NULL) &&
        !count_paths("/etc/glvnd/egl_vendor.d/*nvidia*.json", NULL))
        add_note(row, "an NVIDIA device is there without its EGL vendor library");
}

static void add_machine_notes(kd_gpu_probe_row *row)
{
    const char *display = getenv("DISPLAY"), *wayland = getenv("WAYLAND_DISPLAY");
    if (row->works)
        return;
    if (row->api == KD_CONTEXT_GLFW && !(display && *display) && !(wayland && *wayland) &&
        !strstr(row->note, "DISPLAY"))
        add_note(row, "DISPLAY is not set");
    if (row->api == KD_CONTEXT_EGL_DEVICE || row->api == KD_CONTEXT_EGL_SURFACELESS ||
        row->api == KD_CONTEXT_EGL_SOFTWARE)
        add_egl_notes(row);
}

uint32_t kd_gpu_probe(kd_gpu_probe_row *rows, uint32_t capacity)
{
    static const kd_context_api ways[] = {KD_CONTEXT_EGL_DEVICE, KD_CONTEXT_EGL_SURFACELESS,
                                          KD_CONTEXT_EGL_SOFTWARE, KD_CONTEXT_OSMESA, KD_CONTEXT_GLFW};
    uint32_t count = 0;
    fflush(NULL);
    for (; count < sizeof ways / sizeof ways[0] && count < capacity; count++) {
        rows[count] = (kd_gpu_probe_row){.api = ways[count]};
        probe_way(&rows[count]);
        add_machine_notes(&rows[count]);
    }
    return count;
}
