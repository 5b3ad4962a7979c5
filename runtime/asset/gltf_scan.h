#ifndef KD_ASSET_GLTF_SCAN_H
#define KD_ASSET_GLTF_SCAN_H

/* One pass over the JSON text before a parser sees it. It refuses what would cost a parser its stack or its
 * memory, and takes out what we load ourselves: buffers and images (a parser would read files, decode base64
 * slowly and trust byte offsets) and `extras`, of which those of meshes and primitives are kept aside: they
 * may hold cages. */

#include <stddef.h>
#include <stdint.h>

#include "runtime/core/status.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct gltf_range {
    size_t first, size;
} gltf_range;

/* The `extras` of meshes[mesh], or of a primitive of it. */
typedef struct gltf_extras {
    size_t mesh, primitive; /* primitive GLTF_WHOLE_MESH: the mesh's own */
    gltf_range text;        /* in the copy */
} gltf_extras;
#define GLTF_WHOLE_MESH SIZE_MAX

typedef struct gltf_scan {
    char *buffers, *images; /* JSON text of these two members, NULL when missing; parts of the copy below */
    size_t buffers_size, images_size;
    char *required; /* `extensionsRequired`, likewise, which stays in the text */
    size_t required_size;
    gltf_extras *extras; /* in order of the file */
    size_t extras_count, extras_capacity;
    char *copy;
} gltf_scan;

/** Free what a scan holds. */
void gltf_scan_fini(gltf_scan *scan);

/** Scan and blank the text in place.
 *
 *  Errors  KD_BAD_FORMAT, KD_TOO_LARGE, KD_NO_MEMORY: `error` says why, no message is logged
 *  Owns    the caller ends the scan with gltf_scan_fini, also after an error
 */
kd_status gltf_scan_json(char *text, size_t size, gltf_scan *scan, char *error, size_t error_size);

typedef struct gltf_chunks {
    char *json;
    size_t json_size;
    const uint8_t *binary; /* NULL when there is none */
    size_t binary_size;
} gltf_chunks;

/** Split a file into its JSON and its binary chunk; a file without the GLB magic is all JSON. Errors as
 * above. */
kd_status gltf_split(uint8_t *bytes, size_t size, gltf_chunks *out, char *error, size_t error_size);

#ifdef __cplusplus
}
#endif

#endif
