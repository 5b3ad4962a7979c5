#include "runtime/asset/gltf_scan.h"

#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* The stack of open containers is fixed: the deepest glTF property sits at about 8 levels, extensions add a
 * few. */
#define DEPTH_MAX 64
/* A parsed container costs up to about 600 bytes, so that hostile text of `{},{},…` stays below 2.5 GiB. */
#define CONTAINERS_MAX (4u << 20)
/* What is left after blanking describes structure only; 20 MB of it is a scene of 100,000 nodes. */
#define STRUCTURE_BYTES_MAX ((size_t)64 << 20)
/* Rows of a top-level array (nodes, accessors, …). Costly ones have a smaller limit: the parser spends 2.5 KB
 * on a material, a buffer or an image may each open a file. */
#define ROWS_MAX        (1u << 20)
#define COSTLY_ROWS_MAX 65536u

typedef struct open_container {
    bool object, blanked; /* blanked: this member is taken out of the text */
    bool rows, costly;    /* a top-level array */
    size_t first;         /* byte at which it opened */
    size_t items;         /* containers that it has opened so far */
    bool meshes;          /* the top-level list of that name, or a mesh's primitives */
    gltf_range *keep;     /* where its range goes when it closes, or NULL */
} open_container;

typedef struct scanner {
    char *text;
    size_t at, size;
    open_container open[DEPTH_MAX];
    int depth;
    size_t containers, rows, blanked;
    int blanking; /* open containers that will be blanked: only the outermost is */
    bool expect_key;
    gltf_range key; /* last key's text between the quotes */
    bool key_escaped;
    gltf_range buffers, images, required;
    gltf_scan *scan;
    char *error;
    size_t error_size;
} scanner;

static kd_status scan_fail(scanner *s, kd_status status, const char *what)
{
    snprintf(s->error, s->error_size, "%s (byte %zu of the JSON)", what, s->at);
    return status;
}

static bool key_is(const scanner *s, const char *name)
{
    return s->key.size == strlen(name) && memcmp(s->text + s->key.first, name, s->key.size) == 0;
}

/* Pass a string; s->at stands on its opening quote. */
static kd_status pass_string(scanner *s, gltf_range *range, bool *escaped)
{
    size_t first = s->at + 1, i = first;
    *escaped = false;
    while (i < s->size && s->text[i] != '"') {
        if (s->text[i] == '\\') {
            *escaped = true;
            i++;
        }
        i++;
    }
    if (i >= s->size)
        return scan_fail(s, KD_BAD_FORMAT, "a string does not end");
    *range = (gltf_range){first, i - first};
    s->at = i + 1;
    return KD_OK;
}

static kd_status pass_key(scanner *s)
{
    kd_status status = pass_string(s, &s->key, &s->key_escaped);
    s->expect_key = false;
    /* An escaped spelling of a top-level name would slip past the blanking; no writer produces one. */
    if (status == KD_OK && s->depth == 1 && s->key_escaped)
        return scan_fail(s, KD_BAD_FORMAT, "a top-level name is spelt with escapes");
    return status;
}

static kd_status open_one(scanner *s, bool object)
{
    if (s->depth == DEPTH_MAX)
        return scan_fail(s, KD_TOO_LARGE, "containers are nested deeper than 64 levels");
    if (++s->containers > CONTAINERS_MAX)
        return scan_fail(s, KD_TOO_LARGE, "more than 4 million objects and arrays");
    const open_container *parent = s->depth ? &s->open[s->depth - 1] : NULL;
    bool member = parent && parent->object;
    open_container c = {.object = object, .first = s->at};
    c.blanked = member && key_is(s, "extras");
    c.meshes =
        member && !object &&
        (s->depth == 1 ? key_is(s, "meshes") : s->depth == 3 && s->open[1].meshes && key_is(s, "primitives"));
    if (parent)
        s->open[s->depth - 1].items++;
    if (s->depth == 1 && member) {
        c.rows = !object;
        c.keep = key_is(s, "buffers") ? &s->buffers : key_is(s, "images") ? &s->images : NULL;
        c.blanked = c.blanked || c.keep;
        c.costly = c.keep || key_is(s, "materials");
        if (key_is(s, "extensionsRequired"))
            c.keep = &s->required;
        s->rows = 0;
    }
    if (parent && parent->rows && ++s->rows > (parent->costly ? COSTLY_ROWS_MAX : ROWS_MAX))
        return scan_fail(s, KD_TOO_LARGE, "too many entries in one list");
    s->blanking += c.blanked;
    s->open[s->depth++] = c;
    s->expect_key = object;
    s->at++;
    return KD_OK;
}

/* Blank what a closed container held: spaces, with an empty container left in front. */
static void blank(scanner *s, size_t first, size_t end, bool object)
{
    memset(s->text + first, ' ', end - first);
    memcpy(s->text + first, object ? "{}" : "[]", 2);
    s->blanked += end - first - 2;
}

/* Note the `extras` that have just closed where they are a mesh's or a primitive's. */
static kd_status keep_extras(scanner *s, size_t first)
{
    gltf_scan *scan = s->scan;
    bool of_mesh = s->depth == 3 && s->open[1].meshes && s->open[2].object;
    bool of_primitive = s->depth == 5 && s->open[1].meshes && s->open[3].meshes && s->open[4].object;
    if (!of_mesh && !of_primitive)
        return KD_OK;
    if (scan->extras_count == scan->extras_capacity) {
        size_t capacity = scan->extras_capacity * 2 + 16;
        gltf_extras *grown = realloc(scan->extras, capacity * sizeof *grown);
        if (!grown)
            return scan_fail(s, KD_NO_MEMORY, "out of memory");
        scan->extras = grown;
        scan->extras_capacity = capacity;
    }
    scan->extras[scan->extras_count++] = (gltf_extras){
        s->open[1].items - 1, of_mesh ? GLTF_WHOLE_MESH : s->open[3].items - 1, {first, s->at - first}};
    return KD_OK;
}

static kd_status close_one(scanner *s, bool object)
{
    if (s->depth == 0 || s->open[s->depth - 1].object != object)
        return scan_fail(s, KD_BAD_FORMAT, "brackets do not match");
    open_container c = s->open[--s->depth];
    s->at++;
    s->expect_key = false;
    if (c.keep)
        *c.keep = (gltf_range){c.first, s->at - c.first};
    if (!c.blanked || --s->blanking)
        return KD_OK;
    blank(s, c.first, s->at, object);
    return object ? keep_extras(s, c.first) : KD_OK;
}

void gltf_scan_fini(gltf_scan *scan)
{
    free(scan->copy);
    free(scan->extras);
    *scan = (gltf_scan){0};
}

static kd_status step(scanner *s)
{
    char c = s->text[s->at];
    gltf_range unused;
    bool escaped;
    switch (c) {
    case '{':
    case '[': return open_one(s, c == '{');
    case '}':
    case ']': return close_one(s, c == '}');
    case '"': return s->expect_key ? pass_key(s) : pass_string(s, &unused, &escaped);
    case ',': s->expect_key = s->depth > 0 && s->open[s->depth - 1].object; break;
    default: break;
    }
    s->at++;
    return KD_OK;
}

kd_status gltf_scan_json(char *text, size_t size, gltf_scan *scan, char *error, size_t error_size)
{
    *scan = (gltf_scan){0};
    scan->copy = malloc(size + 1);
    if (!scan->copy) {
        snprintf(error, error_size, "no memory for a second copy of the text");
        return KD_NO_MEMORY;
    }
    memcpy(scan->copy, text, size);
    scanner *s = calloc(1, sizeof *s);
    if (!s)
        return KD_NO_MEMORY;
    *s = (scanner){.text = text, .size = size, .scan = scan, .error = error, .error_size = error_size};
    kd_status status = KD_OK;
    while (status == KD_OK && s->at < size)
        status = step(s);
    if (status == KD_OK && s->depth)
        status = scan_fail(s, KD_BAD_FORMAT, "the text ends inside an object");
    if (status == KD_OK && size - s->blanked > STRUCTURE_BYTES_MAX)
        status = scan_fail(s, KD_TOO_LARGE, "more than 64 MiB of structure");
    if (s->buffers.size)
        scan->buffers = scan->copy + s->buffers.first;
    if (s->images.size)
        scan->images = scan->copy + s->images.first;
    if (s->required.size)
        scan->required = scan->copy + s->required.first;
    scan->required_size = s->required.size;
    scan->buffers_size = s->buffers.size;
    scan->images_size = s->images.size;
    free(s);
    return status;
}

static uint32_t read_u32(const uint8_t *p)
{
    return (uint32_t)p[0] | (uint32_t)p[1] << 8 | (uint32_t)p[2] << 16 | (uint32_t)p[3] << 24;
}

#define GLB_HEADER_BYTES 12
#define GLB_CHUNK_BYTES  8
#define GLB_JSON         0x4E4F534Au
#define GLB_BIN          0x004E4942u

static kd_status split_fail(char *error, size_t error_size, const char *what)
{
    snprintf(error, error_size, "%s", what);
    return KD_BAD_FORMAT;
}

kd_status gltf_split(uint8_t *bytes, size_t size, gltf_chunks *out, char *error, size_t error_size)
{
    static const char pointer[] = "version https://git-lfs";
    *out = (gltf_chunks){.json = (char *)bytes, .json_size = size};
    if (size >= sizeof pointer - 1 && memcmp(bytes, pointer, sizeof pointer - 1) == 0)
        return split_fail(error, error_size,
                          "the file is only a pointer of Git LFS; fetch its content with `git lfs pull`");
    if (size < 4 || memcmp(bytes, "glTF", 4) != 0)
        return KD_OK;
    if (size < GLB_HEADER_BYTES + GLB_CHUNK_BYTES)
        return split_fail(error, error_size, "the GLB header is cut off");
    if (read_u32(bytes + 4) != 2)
        return split_fail(error, error_size, "the GLB container is not version 2");
    size_t length = read_u32(bytes + 8);
    if (length > size || length < GLB_HEADER_BYTES + GLB_CHUNK_BYTES)
        return split_fail(error, error_size,
                          "the GLB header's length does not fit the file, which may be cut off");
    size_t json_size = read_u32(bytes + 12);
    if (read_u32(bytes + 16) != GLB_JSON)
        return split_fail(error, error_size, "the GLB's first chunk is not JSON");
    size_t at = GLB_HEADER_BYTES + GLB_CHUNK_BYTES;
    if (json_size > length - at)
        return split_fail(error, error_size, "the GLB's JSON chunk runs over the end");
    out->json = (char *)bytes + at;
    out->json_size = json_size;
    at += json_size;
    while (length - at >= GLB_CHUNK_BYTES) { /* the first BIN chunk counts, unknown kinds are passed over */
        size_t chunk = read_u32(bytes + at), kind = read_u32(bytes + at + 4);
        at += GLB_CHUNK_BYTES;
        if (chunk > length - at)
            return split_fail(error, error_size, "a GLB chunk runs over the end");
        if (kind == GLB_BIN && !out->binary) {
            out->binary = bytes + at;
            out->binary_size = chunk;
        }
        at += chunk;
    }
    if (at != length)
        return split_fail(error, error_size, "bytes are left over after the GLB's last chunk");
    return KD_OK;
}
