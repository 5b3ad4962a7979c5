#ifndef KD_GPU_CONTEXT_H
#define KD_GPU_CONTEXT_H

/* One way to a GL context: the library it came from, what closes it, and how its functions are found. Free of
 * GL types, because OSMesa's header brings a set of its own. */

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "runtime/gpu/gpu.h"

typedef struct gpu_context {
    kd_context_api api; /* the way that was taken, never AUTO or EGL */
    void (*(*lookup)(const char *name))(void);
    /* Make it current on this thread, or (on false) let it go from it. Returns false when the library
     * refuses. */
    bool (*make_current)(struct gpu_context *context, bool on);
    void (*close)(struct gpu_context *context); /* which is current on this thread, or on none */
    void *display;                              /* EGLDisplay */
    void *handle;                               /* EGLContext, OSMesaContext or GLFWwindow * */
    bool hardware_only; /* the way promises a GPU: a software renderer is no success */
} gpu_context;

/* Why a way failed, for the message that lists them all. */
typedef struct gpu_reason {
    char text[256];
} gpu_reason;

/* Each opens its way and makes the context current, or says why not; nothing stays open then. */
bool gpu_context_open_egl(const kd_gpu_desc *desc, kd_context_api api, gpu_context *out, gpu_reason *reason);
bool gpu_context_open_osmesa(const kd_gpu_desc *desc, gpu_context *out, gpu_reason *reason);
bool gpu_context_open_glfw(const kd_gpu_desc *desc, gpu_context *out, gpu_reason *reason);

/** Load the first library of a NULL-terminated list. Returns NULL when none is there. */
void *gpu_library_open(const char *const *names, gpu_reason *reason);

typedef struct gpu_symbol {
    const char *name;
    size_t offset; /* of the function pointer inside the table */
} gpu_symbol;

/** Fill a table of function pointers. Returns false and names the symbol that is missing. */
bool gpu_library_load(void *library, const gpu_symbol *symbols, size_t count, void *table,
                      gpu_reason *reason);

#endif
