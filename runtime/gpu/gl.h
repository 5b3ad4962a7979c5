#ifndef KD_GPU_GL_H
#define KD_GPU_GL_H

/* The GL functions as a table that belongs to one context, so that contexts of different libraries can live
 * in one process and nothing links against libGL. */

#include <GL/glcorearb.h>

#include "runtime/gpu/gl_list.h"

typedef struct gl_table {
#define KD_GL_MEMBER(name, NAME) PFNGL##NAME##PROC name;
    KD_GL_LIST(KD_GL_MEMBER)
#undef KD_GL_MEMBER
} gl_table;

typedef void (*gl_function)(void);
typedef gl_function gl_lookup(const char *name);

/** Fill the table. Returns NULL, or the name of the first function that the context lacks. */
const char *gl_load(gl_table *table, gl_lookup *lookup);

/** Name an error code of glGetError. */
const char *gl_error_name(GLenum error);

#endif
