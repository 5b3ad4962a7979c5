#ifndef KD_GPU_SOURCE_H
#define KD_GPU_SOURCE_H

/* GLSL source as the compiler gets it: the files put into one text, each under a number, and the way back
 * from that number to its path in what the compiler says. */

#include <stdbool.h>
#include <stddef.h>

enum { GPU_MAX_SOURCE_FILES = 64 };

typedef struct gpu_source {
    char *text; /* NUL-terminated */
    size_t size, capacity;
    char *paths[GPU_MAX_SOURCE_FILES]; /* by number */
    unsigned path_count;
    char error[256];                       /* why expanding failed: FILE: what is wrong */
    const struct kd_embedded_shader *more; /* files beside those of the build, ended by an empty row; NULL */
} gpu_source;

/** Put `#version`, the defines and the file with all it includes together. Returns false with source->error
 * set.
 *
 *  Includes are written `#include "shaders/…"` and resolved once a file; one that cannot be resolved becomes
 * #error, so that it does no harm where conditions skip it (headers shared with C). Owns  the caller frees
 * with gpu_source_fini, after failure too
 */
bool gpu_source_expand(gpu_source *source, const char *path, const char *const *defines);
void gpu_source_fini(gpu_source *source);

/** Rewrite one line of a compiler's log from NUMBER:LINE(…) or NUMBER(LINE) to FILE:LINE. Others are copied.
 */
void gpu_source_translate(const gpu_source *source, const char *line, size_t length, char *out,
                          size_t capacity);

#endif
