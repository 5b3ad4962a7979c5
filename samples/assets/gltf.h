#ifndef SAMPLES_ASSETS_GLTF_H
#define SAMPLES_ASSETS_GLTF_H

/* A small glTF 2.0 writer: JSON elements are collected section by section as text, binary data in one buffer,
 * and both are written as NAME.gltf and NAME.bin. Running out of memory ends the program: nothing is left to
 * save. */

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

typedef struct bytes {
    char *data;
    size_t size, capacity;
} bytes;

/** Append `size` bytes; the buffer grows as needed. */
void bytes_add(bytes *b, const void *data, size_t size);
/** Append text as printf does. */
void bytes_print(bytes *b, const char *format, ...) __attribute__((format(printf, 2, 3)));
void bytes_free(bytes *b);

typedef enum gltf_section {
    GLTF_SCENES,
    GLTF_NODES,
    GLTF_MESHES,
    GLTF_MATERIALS,
    GLTF_SKINS,
    GLTF_ANIMATIONS,
    GLTF_ACCESSORS,
    GLTF_VIEWS,
    GLTF_SECTION_COUNT
} gltf_section;

typedef struct gltf {
    bytes sections[GLTF_SECTION_COUNT];
    int counts[GLTF_SECTION_COUNT];
    bytes bin;
} gltf;

typedef enum gltf_type { GLTF_U8 = 5121, GLTF_U16 = 5123, GLTF_F32 = 5126 } gltf_type;
typedef enum gltf_target { GLTF_PLAIN = 0, GLTF_VERTICES = 34962, GLTF_INDICES = 34963 } gltf_target;

typedef struct gltf_array {
    const void *data; /* count * width values, tightly packed; a vertex's is a multiple of 4 bytes */
    int count, width; /* width: 1 SCALAR, 3 VEC3, 4 VEC4, 16 MAT4 */
    gltf_type type;
    gltf_target target;
    bool normalized; /* integers stand for 0..1 */
    bool bounds;     /* write min and max; F32 only */
} gltf_array;

/** Append one JSON element to a section, as printf does. Returns its index. */
int gltf_add(gltf *g, gltf_section section, const char *format, ...) __attribute__((format(printf, 3, 4)));
/** Append an accessor with its own buffer view. Returns the accessor's index. */
int gltf_add_array(gltf *g, const gltf_array *array);
/** Write FOLDER/NAME.gltf and FOLDER/NAME.bin. Returns false after a message on standard error. */
bool gltf_save(const gltf *g, const char *folder, const char *name);
void gltf_free(gltf *g);

#endif
