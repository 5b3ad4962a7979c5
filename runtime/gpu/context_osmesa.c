/* OSMesa: Mesa's software renderer without any window system. It wants a colour buffer of its own, which
 * nothing here draws to, so that it is tiny. Mesa dropped the library in 25.1. */

#include <GL/osmesa.h>
#include <stdio.h>
#include <stdlib.h>

#include "runtime/gpu/context.h"

enum { BUFFER_SIDE = 16 };

static struct osmesa_table {
    OSMesaContext (*create)(const int *attributes, OSMesaContext share);
    void (*destroy)(OSMesaContext context);
    GLboolean (*make_current)(OSMesaContext context, void *buffer, GLenum type, GLsizei width,
                              GLsizei height);
    OSMESAproc (*get_proc)(const char *name);
} osmesa;

static const gpu_symbol osmesa_symbols[] = {
    {"OSMesaCreateContextAttribs", offsetof(struct osmesa_table, create)},
    {"OSMesaDestroyContext", offsetof(struct osmesa_table, destroy)},
    {"OSMesaMakeCurrent", offsetof(struct osmesa_table, make_current)},
    {"OSMesaGetProcAddress", offsetof(struct osmesa_table, get_proc)},
};

static bool make_current_osmesa(gpu_context *context, bool on)
{
    if (!on)
        return osmesa.make_current(NULL, NULL, 0, 0, 0) == GL_TRUE;
    return osmesa.make_current(context->handle, context->display, GL_UNSIGNED_BYTE, BUFFER_SIDE,
                               BUFFER_SIDE) == GL_TRUE;
}

static void close_osmesa(gpu_context *context)
{
    make_current_osmesa(context, false);
    osmesa.destroy(context->handle);
    free(context->display);
}

static void (*lookup_osmesa(const char *name))(void)
{
    return osmesa.get_proc(name);
}

bool gpu_context_open_osmesa(const kd_gpu_desc *desc, gpu_context *out, gpu_reason *reason)
{
    static const char *const names[] = {"libOSMesa.so.8", "libOSMesa.so.6", "libOSMesa.so", NULL};
    static const int attributes[] = {OSMESA_FORMAT,
                                     OSMESA_RGBA,
                                     OSMESA_DEPTH_BITS,
                                     0,
                                     OSMESA_PROFILE,
                                     OSMESA_CORE_PROFILE,
                                     OSMESA_CONTEXT_MAJOR_VERSION,
                                     4,
                                     OSMESA_CONTEXT_MINOR_VERSION,
                                     5,
                                     0};
    (void)desc;
    void *library = gpu_library_open(names, reason);
    if (!library || !gpu_library_load(library, osmesa_symbols,
                                      sizeof osmesa_symbols / sizeof osmesa_symbols[0], &osmesa, reason))
        return false;
    OSMesaContext context = osmesa.create(attributes, NULL);
    if (!context) {
        snprintf(reason->text, sizeof reason->text, "no OpenGL 4.5 core context");
        return false;
    }
    void *pixels = calloc((size_t)BUFFER_SIDE * BUFFER_SIDE, 4);
    if (!pixels || !osmesa.make_current(context, pixels, GL_UNSIGNED_BYTE, BUFFER_SIDE, BUFFER_SIDE)) {
        snprintf(reason->text, sizeof reason->text, "the context cannot be made current");
        osmesa.destroy(context);
        free(pixels);
        return false;
    }
    *out = (gpu_context){.api = KD_CONTEXT_OSMESA,
                         .lookup = lookup_osmesa,
                         .make_current = make_current_osmesa,
                         .close = close_osmesa,
                         .display = pixels,
                         .handle = context};
    return true;
}
