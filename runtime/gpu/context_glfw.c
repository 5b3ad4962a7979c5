/* GLFW: a window, visible or not, and what a frame loop asks of it. Threading: the main thread, as GLFW
 * demands. */

#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>
#include <stdio.h>
#include <stdlib.h>

#include "runtime/gpu/context.h"
#include "runtime/gpu/internal.h"

static struct glfw_table {
    int (*init)(void);
    void (*terminate)(void);
    int (*get_error)(const char **description);
    void (*hint)(int hint, int value);
    GLFWwindow *(*create)(int width, int height, const char *title, GLFWmonitor *monitor, GLFWwindow *share);
    void (*destroy)(GLFWwindow *window);
    void (*make_current)(GLFWwindow *window);
    GLFWglproc (*get_proc)(const char *name);
    void (*swap_interval)(int interval);
    void (*swap)(GLFWwindow *window);
    void (*poll)(void);
    int (*should_close)(GLFWwindow *window);
    void (*framebuffer_size)(GLFWwindow *window, int *width, int *height);
} glfw;

static const gpu_symbol glfw_symbols[] = {
    {"glfwInit", offsetof(struct glfw_table, init)},
    {"glfwTerminate", offsetof(struct glfw_table, terminate)},
    {"glfwGetError", offsetof(struct glfw_table, get_error)},
    {"glfwWindowHint", offsetof(struct glfw_table, hint)},
    {"glfwCreateWindow", offsetof(struct glfw_table, create)},
    {"glfwDestroyWindow", offsetof(struct glfw_table, destroy)},
    {"glfwMakeContextCurrent", offsetof(struct glfw_table, make_current)},
    {"glfwGetProcAddress", offsetof(struct glfw_table, get_proc)},
    {"glfwSwapInterval", offsetof(struct glfw_table, swap_interval)},
    {"glfwSwapBuffers", offsetof(struct glfw_table, swap)},
    {"glfwPollEvents", offsetof(struct glfw_table, poll)},
    {"glfwWindowShouldClose", offsetof(struct glfw_table, should_close)},
    {"glfwGetFramebufferSize", offsetof(struct glfw_table, framebuffer_size)},
};

static int glfw_users; /* windows open; GLFW ends with the last one */

static bool fail(gpu_reason *reason, const char *what)
{
    const char *text = NULL;
    glfw.get_error(&text);
    const char *display = getenv("DISPLAY"), *wayland = getenv("WAYLAND_DISPLAY");
    bool headless = !(display && *display) && !(wayland && *wayland);
    snprintf(reason->text, sizeof reason->text, "%s (%s)%s", what, text ? text : "no reason given",
             headless ? "; DISPLAY is not set" : "");
    return false;
}

static void release(void)
{
    if (--glfw_users == 0)
        glfw.terminate();
}

static bool make_current_glfw(gpu_context *context, bool on)
{
    glfw.make_current(on ? context->handle : NULL);
    return glfw.get_error(NULL) == 0;
}

static void close_glfw(gpu_context *context)
{
    glfw.make_current(NULL);
    glfw.destroy(context->handle);
    release();
}

static void (*lookup_glfw(const char *name))(void)
{
    return glfw.get_proc(name);
}

static GLFWwindow *create_window(const kd_gpu_desc *desc)
{
    glfw.hint(GLFW_CLIENT_API, GLFW_OPENGL_API);
    glfw.hint(GLFW_CONTEXT_VERSION_MAJOR, 4);
    glfw.hint(GLFW_CONTEXT_VERSION_MINOR, 5);
    glfw.hint(GLFW_OPENGL_PROFILE, GLFW_OPENGL_CORE_PROFILE);
    glfw.hint(GLFW_OPENGL_DEBUG_CONTEXT, desc->debug ? GLFW_TRUE : GLFW_FALSE);
    glfw.hint(GLFW_VISIBLE, desc->window ? GLFW_TRUE : GLFW_FALSE);
    glfw.hint(GLFW_DEPTH_BITS, 0);
    glfw.hint(GLFW_STENCIL_BITS, 0);
    return glfw.create(desc->width ? (int)desc->width : 1280, desc->height ? (int)desc->height : 720,
                       desc->title ? desc->title : "Kandil", NULL, NULL);
}

bool gpu_context_open_glfw(const kd_gpu_desc *desc, gpu_context *out, gpu_reason *reason)
{
    static const char *const names[] = {"libglfw.so.3", "libglfw.so", NULL};
    void *library = gpu_library_open(names, reason);
    if (!library ||
        !gpu_library_load(library, glfw_symbols, sizeof glfw_symbols / sizeof glfw_symbols[0], &glfw, reason))
        return false;
    if (!glfw_users && !glfw.init())
        return fail(reason, "GLFW cannot start");
    glfw_users++;
    GLFWwindow *window = create_window(desc);
    if (!window) {
        fail(reason, "no window with OpenGL 4.5 core");
        release();
        return false;
    }
    glfw.make_current(window);
    glfw.swap_interval(desc->window ? 1 : 0);
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

bool kd_gpu_window_should_close(kd_gpu *gpu)
{
    GLFWwindow *window = kd_gpu_window_native(gpu);
    if (!window)
        return false;
    glfw.poll();
    return glfw.should_close(window) != 0;
}

void kd_gpu_window_size(kd_gpu *gpu, uint32_t *width, uint32_t *height)
{
    GLFWwindow *window = kd_gpu_window_native(gpu);
    int w = 0, h = 0;
    if (window)
        glfw.framebuffer_size(window, &w, &h);
    *width = (uint32_t)w;
    *height = (uint32_t)h;
}

void kd_gpu_window_present(kd_gpu *gpu)
{
    GLFWwindow *window = kd_gpu_window_native(gpu);
    if (window)
        glfw.swap(window);
}
