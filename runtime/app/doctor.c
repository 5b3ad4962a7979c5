#include "runtime/app/doctor.h"

#include <dlfcn.h>
#include <stdio.h>
#include <unistd.h>

#include "runtime/app/app.h"
#include "runtime/app/child.h"
#include "runtime/core/file.h"
#include "runtime/core/log.h"
#include "runtime/gpu/gpu.h"

#define MAX_ROWS 16

static void print_contexts(const kd_gpu_probe_row *rows, uint32_t count)
{
    for (uint32_t i = 0; i < count; i++) {
        const kd_gpu_probe_row *row = &rows[i];
        printf("  %-16s %s", kd_context_api_name(row->api), row->works ? "works" : "not available");
        if (row->works)
            printf(": %s, OpenGL %s\n  %-16s storage blocks up to %lld MiB; timestamps of %d bits, timer "
                   "queries %s",
                   row->renderer, row->version, "", (long long)(row->max_ssbo_bytes >> 20),
                   row->timestamp_bits,
                   row->timer_works ? "plausible" : "not to be trusted (--profile-sync is the default)");
        if (row->note[0])
            printf("%s%s", row->works ? "\n                   " : ": ", row->note);
        printf("\n");
    }
}

static void print_program(const char *name, const char *purpose, const char *package)
{
    char path[KD_PATH_MAX];
    if (app_find_program(name, path, sizeof path))
        printf("  %-16s %s\n", name, path);
    else
        printf("  %-16s not found: needed for %s; install %s\n", name, purpose, package);
}

static void print_library(const char *file, const char *purpose, const char *package)
{
    void *library = dlopen(file, RTLD_LAZY | RTLD_LOCAL);
    if (library)
        printf("  %-16s found\n", file);
    else
        printf("  %-16s not found: needed for %s; install %s\n", file, purpose, package);
    if (library)
        dlclose(library);
}

kd_status app_doctor_print(void)
{
    kd_gpu_probe_row rows[MAX_ROWS];
    uint32_t count = kd_gpu_probe(rows, MAX_ROWS), working = 0;
    printf("Kandil %s\n\nprocessors: %ld\n\nways to OpenGL 4.5, in the order of --context auto:\n",
           KD_VERSION, sysconf(_SC_NPROCESSORS_ONLN));
    print_contexts(rows, count);
    for (uint32_t i = 0; i < count; i++)
        working += rows[i].works;
    printf("\nprograms and libraries:\n");
    print_program("ffmpeg", "--out film.mp4", "ffmpeg");
    print_program("dot", "--graph graph.svg", "graphviz");
    print_library("libEGL.so.1", "running without a window", "libegl1");
    print_library("libglfw.so.3", "--window", "libglfw3");
    print_library("libOSMesa.so.8", "--context osmesa", "libosmesa6");
    printf("\n%s\n",
           working ? "Ready to render." : "Nothing can render here: install libegl1 and libgl1-mesa-dri.");
    return working ? KD_OK
                   : kd_fail(KD_NO_CONTEXT,
                             "no way to an OpenGL 4.5 context; install libegl1 and libgl1-mesa-dri");
}
