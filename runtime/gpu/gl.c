#include "runtime/gpu/gl.h"

#include <stddef.h>
#include <string.h>

static const struct gl_row {
    const char *name;
    size_t offset;
} gl_rows[] = {
#define KD_GL_ROW(name, NAME) {"gl" #name, offsetof(gl_table, name)},
    KD_GL_LIST(KD_GL_ROW)
#undef KD_GL_ROW
};

const char *gl_load(gl_table *table, gl_lookup *lookup)
{
    for (size_t i = 0; i < sizeof gl_rows / sizeof gl_rows[0]; i++) {
        gl_function function = lookup(gl_rows[i].name);
        if (!function)
            return gl_rows[i].name;
        memcpy((char *)table + gl_rows[i].offset, &function, sizeof function);
    }
    return NULL;
}

const char *gl_error_name(GLenum error)
{
    switch (error) {
    case GL_NO_ERROR: return "no error";
    case GL_INVALID_ENUM: return "invalid enum";
    case GL_INVALID_VALUE: return "invalid value";
    case GL_INVALID_OPERATION: return "invalid operation";
    case GL_INVALID_FRAMEBUFFER_OPERATION: return "invalid framebuffer operation";
    case GL_OUT_OF_MEMORY: return "out of memory";
    case GL_CONTEXT_LOST: return "context lost";
    default: return "unknown error";
    }
}
