#ifndef KD_GPU_EMBEDDED_H
#define KD_GPU_EMBEDDED_H

#include <stddef.h>

/** One shader file as the build put it into the program; path is written from the root
 * ("shaders/svo/filter.comp"). */
typedef struct kd_embedded_shader {
    const char *path;
    const char *text; /* NUL-terminated */
    size_t size;      /* bytes without the NUL */
} kd_embedded_shader;

/** A row of a table of one's own: KD_SHADER("shaders/mine/glow.comp", "layout(…) in; …"). */
#define KD_SHADER(path, text)                                                                                \
    {                                                                                                        \
        (path), (text), sizeof(text) - 1                                                                     \
    }

/** Every file below shaders/, ended by a row whose path is NULL. */
extern const kd_embedded_shader kd_embedded_shaders[];

#endif
