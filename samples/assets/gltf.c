#include "samples/assets/gltf.h"

#include <errno.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const char *const section_names[GLTF_SECTION_COUNT] = {
    "scenes", "nodes", "meshes", "materials", "skins", "animations", "accessors", "bufferViews"};

static void reserve(bytes *b, size_t more)
{
    if (b->size + more <= b->capacity)
        return;
    b->capacity = (b->size + more) * 2;
    b->data = realloc(b->data, b->capacity);
    if (!b->data) {
        fputs("kandil-assets: out of memory\n", stderr);
        exit(1);
    }
}

void bytes_add(bytes *b, const void *data, size_t size)
{
    reserve(b, size);
    memcpy(b->data + b->size, data, size);
    b->size += size;
}

static void print_list(bytes *b, const char *format, va_list list)
{
    va_list again;
    va_copy(again, list);
    int size = vsnprintf(NULL, 0, format, again);
    va_end(again);
    reserve(b, (size_t)size + 1);
    vsnprintf(b->data + b->size, (size_t)size + 1, format, list);
    b->size += (size_t)size;
}

void bytes_print(bytes *b, const char *format, ...)
{
    va_list list;
    va_start(list, format);
    print_list(b, format, list);
    va_end(list);
}

void bytes_free(bytes *b)
{
    free(b->data);
    *b = (bytes){0};
}

int gltf_add(gltf *g, gltf_section section, const char *format, ...)
{
    va_list list;
    if (g->counts[section])
        bytes_print(&g->sections[section], ",\n");
    bytes_print(&g->sections[section], "    ");
    va_start(list, format);
    print_list(&g->sections[section], format, list);
    va_end(list);
    return g->counts[section]++;
}

static const char *type_name(int width)
{
    return width == 1 ? "SCALAR" : width == 3 ? "VEC3" : width == 4 ? "VEC4" : "MAT4";
}

static size_t type_size(gltf_type type)
{
    return type == GLTF_U8 ? 1 : type == GLTF_U16 ? 2 : 4;
}

/* `,"min":[…],"max":[…]` over the elements of a float array, nine digits: the exact values. */
static void print_bounds(bytes *out, const gltf_array *a)
{
    const float *values = a->data;
    for (int side = 0; side < 2; side++) {
        bytes_print(out, ",\"%s\":[", side ? "max" : "min");
        for (int c = 0; c < a->width; c++) {
            float best = values[c];
            for (int i = 1; i < a->count; i++) {
                float v = values[i * a->width + c];
                if (side ? v > best : v < best)
                    best = v;
            }
            bytes_print(out, "%s%.9g", c ? "," : "", (double)best);
        }
        bytes_print(out, "]");
    }
}

int gltf_add_array(gltf *g, const gltf_array *a)
{
    size_t size = (size_t)a->count * (size_t)a->width * type_size(a->type);
    bytes target = {0}, bounds = {0};
    if (a->target)
        bytes_print(&target, ",\"target\":%d", (int)a->target);
    if (a->normalized)
        bytes_print(&bounds, ",\"normalized\":true");
    if (a->bounds)
        print_bounds(&bounds, a);
    int view = gltf_add(g, GLTF_VIEWS, "{\"buffer\":0,\"byteOffset\":%zu,\"byteLength\":%zu%.*s}",
                        g->bin.size, size, (int)target.size, target.size ? target.data : "");
    bytes_add(&g->bin, a->data, size);
    while (g->bin.size % 4)
        bytes_add(&g->bin, "", 1);
    int index = gltf_add(
        g, GLTF_ACCESSORS, "{\"bufferView\":%d,\"componentType\":%d,\"count\":%d,\"type\":\"%s\"%.*s}", view,
        (int)a->type, a->count, type_name(a->width), (int)bounds.size, bounds.size ? bounds.data : "");
    bytes_free(&target);
    bytes_free(&bounds);
    return index;
}

static bool write_file(const char *folder, const char *name, const char *end, const bytes *content)
{
    bytes path = {0};
    bytes_print(&path, "%s/%s.%s", folder, name, end);
    FILE *file = fopen(path.data, "wb");
    bool ok = file && fwrite(content->data, 1, content->size, file) == content->size;
    if (file && fclose(file))
        ok = false;
    if (!ok)
        fprintf(stderr, "kandil-assets: %s: cannot be written (%s); choose a folder that exists\n", path.data,
                strerror(errno));
    bytes_free(&path);
    return ok;
}

bool gltf_save(const gltf *g, const char *folder, const char *name)
{
    bytes json = {0};
    bytes_print(
        &json,
        "{\n  \"asset\":{\"version\":\"2.0\",\"generator\":\"kandil samples/assets\"},\n  \"scene\":0,\n");
    for (int s = 0; s < GLTF_SECTION_COUNT; s++)
        if (g->counts[s])
            bytes_print(&json, "  \"%s\":[\n%.*s\n  ],\n", section_names[s], (int)g->sections[s].size,
                        g->sections[s].data);
    bytes_print(&json, "  \"buffers\":[{\"uri\":\"%s.bin\",\"byteLength\":%zu}]\n}\n", name, g->bin.size);
    bool ok = write_file(folder, name, "gltf", &json) && write_file(folder, name, "bin", &g->bin);
    bytes_free(&json);
    return ok;
}

void gltf_free(gltf *g)
{
    for (int s = 0; s < GLTF_SECTION_COUNT; s++)
        bytes_free(&g->sections[s]);
    bytes_free(&g->bin);
    *g = (gltf){0};
}
