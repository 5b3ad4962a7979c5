#include "runtime/app/graph.h"

#include <errno.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

#include "runtime/app/child.h"
#include "runtime/core/file.h"
#include "runtime/core/log.h"

kd_status app_graph_check(const char *path)
{
    kd_file_out probe;
    char program[KD_PATH_MAX];
    kd_status status = kd_file_out_open(&probe, path);
    if (status != KD_OK)
        return status;
    kd_file_out_cancel(&probe);
    if (kd_path_has_extension(path, ".svg") && !app_find_program("dot", program, sizeof program))
        return kd_fail(KD_NOT_FOUND,
                       "%s: Graphviz's dot was not found in PATH; install it, or write a .dot file", path);
    return KD_OK;
}

kd_status app_graph_write(const kd_schedule *s, const char *path)
{
    char dot[KD_PATH_MAX], svg[KD_PATH_MAX], option[KD_PATH_MAX + 2], line[256];
    app_child child;
    if (!kd_path_has_extension(path, ".svg"))
        return kd_schedule_write_dot(s, path);
    int a = snprintf(dot, sizeof dot, "%s.part%ld.dot", path, (long)getpid());
    int b = snprintf(svg, sizeof svg, "%s.part%ld.svg", path, (long)getpid());
    if (a >= (int)sizeof dot || b >= (int)sizeof svg)
        return kd_fail(KD_OUT_OF_RANGE, "%.64s…: the path is too long; shorten it", path);
    snprintf(option, sizeof option, "-o%s", svg);
    const char *const argv[] = {"dot", "-Tsvg", option, dot, NULL};
    kd_status status = kd_schedule_write_dot(s, dot);
    if (status == KD_OK)
        status = app_child_start(&child, argv);
    if (status == KD_OK && app_child_finish(&child, line, sizeof line) != 0)
        status = kd_fail(KD_IO, "%s: dot failed (%s); write a .dot file and look at it", path, line);
    if (status == KD_OK && rename(svg, path) != 0)
        status =
            kd_fail(KD_IO, "%s: could not be put in place (%s); check the folder", path, strerror(errno));
    unlink(dot);
    if (status != KD_OK)
        unlink(svg);
    return status;
}
