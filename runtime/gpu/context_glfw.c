/* GLFW: a window, visible or not, and what a frame loop asks of it. Threading: the main thread, as GLFW
 * demands. */

#include <stdio.h>
#include <stdlib.h>

#include "runtime/gpu/context.h"
#include "runtime/gpu/glfw_table.h"
#include "runtime/gpu/internal.h"

gpu_glfw_table gpu_glfw;

static const gpu_symbol glfw_symbols[] = {
#define GLFW_SYMBOL(member, symbol, result, arguments) {symbol, offsetof(gpu_glfw_table, member)},
    GLFW_LIST(GLFW_SYMBOL)
#undef GLFW_SYMBOL
};

static int glfw_users; /* windows open; GLFW ends with the last one */

static bool fail(gpu_reason *reason, const char *what)
{
    const char *text = NULL;
    gpu_glfw.get_error(&text);
    const char *display = getenv("DISPLAY"), *wayland = getenv("WAYLAND_DISPLAY");
    bool headless = !(display && *display) && !(wayland && *wayland);
    snprintf(reason->text, sizeof reason->text, "%s (%s)%s", what, text ? text : "no reason given",
             headless ? "; DISPLAY is not set" : "");
    return false;
}

static void release(void)
{
    if (--glfw_users == 0)
        gpu_glfw.terminate();
}

static bool make_current_glfw(gpu_context *context, bool on)
{
    gpu_glfw.make_current(on ? context->handle : NULL);
    return gpu_glfw.get_error(NULL) == 0;
}

static void close_glfw(gpu_context *context)
{
    gpu_glfw.make_current(NULL);
    gpu_glfw_events_end(context->handle);
    gpu_glfw.destroy(context->handle);
    release();
}

static void (*lookup_glfw(const char *name))(void)
{
    return gpu_glfw.get_proc(name);
}

static GLFWwindow *create_window(const kd_gpu_desc *desc)
{
    gpu_glfw.hint(GLFW_CLIENT_API, GLFW_OPENGL_API);
    gpu_glfw.hint(GLFW_CONTEXT_VERSION_MAJOR, 4);
    gpu_glfw.hint(GLFW_CONTEXT_VERSION_MINOR, 5);
    gpu_glfw.hint(GLFW_OPENGL_PROFILE, GLFW_OPENGL_CORE_PROFILE);
    gpu_glfw.hint(GLFW_OPENGL_DEBUG_CONTEXT, desc->debug ? GLFW_TRUE : GLFW_FALSE);
    gpu_glfw.hint(GLFW_VISIBLE, desc->window ? GLFW_TRUE : GLFW_FALSE);
    gpu_glfw.hint(GLFW_DEPTH_BITS, 0);
    gpu_glfw.hint(GLFW_STENCIL_BITS, 0);
    return gpu_glfw.create(desc->width ? (int)desc->width : 1280, desc->height ? (int)desc->height : 720,
                           desc->title ? desc->title : "Kandil", NULL, NULL);
}

bool gpu_context_open_glfw(const kd_gpu_desc *desc, gpu_context *out, gpu_reason *reason)
{
    static const char *const names[] = {"libglfw.so.3", "libglfw.so", NULL};
    void *library = gpu_library_open(names, reason);
    if (!library || !gpu_library_load(library, glfw_symbols, sizeof glfw_symbols / sizeof glfw_symbols[0],
                                      &gpu_glfw, reason))
        return false;
    if (!glfw_users && !gpu_glfw.init())
        return fail(reason, "GLFW cannot start");
    glfw_users++;
    GLFWwindow *window = create_window(desc);
    if (!window) {
        fail(reason, "no window with OpenGL 4.5 core");
        release();
        return false;
    }
    if (!gpu_glfw_events_begin(window)) {
        snprintf(reason->text, sizeof reason->text, "out of memory");
        gpu_glfw.destroy(window);
        release();
        return false;
    }
    gpu_glfw.make_current(window);
    gpu_glfw.swap_interval(desc->window ? 1 : 0);
    *out = (gpu_context){.api = KD_CONTEXT_GLFW,
                         .lookup = lookup_glfw,
                         .make_current = make_current_glfw,
                         .close = close_glfw,
                         .handle = window};
    return true;
}

void *kd_gpu_window_native(kd_gpu *gpu)
{
    return gpu->context.api == KD_CONTEXT_GLFW ? gpu->context.handle : NULL;
}
