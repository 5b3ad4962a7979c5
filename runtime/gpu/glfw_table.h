#ifndef KD_GPU_GLFW_TABLE_H
#define KD_GPU_GLFW_TABLE_H

/* GLFW's functions, looked up when a window is asked for, and the window that the files of this module share.
 */

#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>

#include "runtime/gpu/window.h"

/* X(member, symbol, result, arguments) */
#define GLFW_LIST(X)                                                                                         \
    X(init, "glfwInit", int, (void))                                                                         \
    X(terminate, "glfwTerminate", void, (void))                                                              \
    X(get_error, "glfwGetError", int, (const char **description))                                            \
    X(hint, "glfwWindowHint", void, (int hint, int value))                                                   \
    X(create, "glfwCreateWindow", GLFWwindow *,                                                              \
      (int width, int height, const char *title, GLFWmonitor *monitor, GLFWwindow *share))                   \
    X(destroy, "glfwDestroyWindow", void, (GLFWwindow * window))                                             \
    X(make_current, "glfwMakeContextCurrent", void, (GLFWwindow * window))                                   \
    X(get_proc, "glfwGetProcAddress", GLFWglproc, (const char *name))                                        \
    X(swap_interval, "glfwSwapInterval", void, (int interval))                                               \
    X(swap, "glfwSwapBuffers", void, (GLFWwindow * window))                                                  \
    X(poll, "glfwPollEvents", void, (void))                                                                  \
    X(wait, "glfwWaitEventsTimeout", void, (double seconds))                                                 \
    X(should_close, "glfwWindowShouldClose", int, (GLFWwindow * window))                                     \
    X(set_should_close, "glfwSetWindowShouldClose", void, (GLFWwindow * window, int value))                  \
    X(framebuffer_size, "glfwGetFramebufferSize", void, (GLFWwindow * window, int *width, int *height))      \
    X(window_size, "glfwGetWindowSize", void, (GLFWwindow * window, int *width, int *height))                \
    X(set_window_size, "glfwSetWindowSize", void, (GLFWwindow * window, int width, int height))              \
    X(content_scale, "glfwGetWindowContentScale", void, (GLFWwindow * window, float *x, float *y))           \
    X(attribute, "glfwGetWindowAttrib", int, (GLFWwindow * window, int attribute))                           \
    X(set_title, "glfwSetWindowTitle", void, (GLFWwindow * window, const char *title))                       \
    X(cursor_position, "glfwGetCursorPos", void, (GLFWwindow * window, double *x, double *y))                \
    X(set_user, "glfwSetWindowUserPointer", void, (GLFWwindow * window, void *user))                         \
    X(user, "glfwGetWindowUserPointer", void *, (GLFWwindow * window))                                       \
    X(on_key, "glfwSetKeyCallback", GLFWkeyfun, (GLFWwindow * window, GLFWkeyfun f))                         \
    X(on_text, "glfwSetCharCallback", GLFWcharfun, (GLFWwindow * window, GLFWcharfun f))                     \
    X(on_button, "glfwSetMouseButtonCallback", GLFWmousebuttonfun,                                           \
      (GLFWwindow * window, GLFWmousebuttonfun f))                                                           \
    X(on_pointer, "glfwSetCursorPosCallback", GLFWcursorposfun, (GLFWwindow * window, GLFWcursorposfun f))   \
    X(on_enter, "glfwSetCursorEnterCallback", GLFWcursorenterfun,                                            \
      (GLFWwindow * window, GLFWcursorenterfun f))                                                           \
    X(on_scroll, "glfwSetScrollCallback", GLFWscrollfun, (GLFWwindow * window, GLFWscrollfun f))             \
    X(on_focus, "glfwSetWindowFocusCallback", GLFWwindowfocusfun,                                            \
      (GLFWwindow * window, GLFWwindowfocusfun f))                                                           \
    X(on_refresh, "glfwSetWindowRefreshCallback", GLFWwindowrefreshfun,                                      \
      (GLFWwindow * window, GLFWwindowrefreshfun f))                                                         \
    X(on_size, "glfwSetFramebufferSizeCallback", GLFWframebuffersizefun,                                     \
      (GLFWwindow * window, GLFWframebuffersizefun f))                                                       \
    X(on_scale, "glfwSetWindowContentScaleCallback", GLFWwindowcontentscalefun,                              \
      (GLFWwindow * window, GLFWwindowcontentscalefun f))

typedef struct gpu_glfw_table {
#define GLFW_MEMBER(member, symbol, result, arguments) result(*member) arguments;
    GLFW_LIST(GLFW_MEMBER)
#undef GLFW_MEMBER
} gpu_glfw_table;

/* Filled before the first window is made. */
extern gpu_glfw_table gpu_glfw;

/** Gather the events of a window from now on. Returns false when memory is out. */
bool gpu_glfw_events_begin(GLFWwindow *window);
void gpu_glfw_events_end(GLFWwindow *window);

#endif
