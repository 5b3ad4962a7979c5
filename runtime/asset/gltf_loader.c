#include "runtime/asset/gltf_loader.h"

#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>

#include "runtime/core/log.h"

kd_status gltf_fail(gltf_loader *l, kd_status status, const char *format, ...)
{
    char text[512];
    va_list args;
    va_start(args, format);
    vsnprintf(text, sizeof text, format, args);
    va_end(args);
    return kd_fail(status, "%s: %s", l->path, text);
}

void gltf_warn(gltf_loader *l, const char *format, ...)
{
    if (l->model->warning_count == GLTF_WARNINGS_MAX) {
        l->warnings_dropped++;
        return;
    }
    char text[512];
    va_list args;
    va_start(args, format);
    vsnprintf(text, sizeof text, format, args);
    va_end(args);
    const char *copy = kd_arena_printf(&l->kept, "%s", text);
    if (copy)
        l->warnings[l->model->warning_count++] = copy;
}

#define LEAST_BYTES 64 /* what an arena spends on the smallest piece */

kd_status gltf_alloc(gltf_loader *l, kd_arena *arena, size_t count, size_t size, void *out)
{
    void *memory = NULL;
    memcpy(out, &memory, sizeof memory); /* `out` is the address of a pointer of any type */
    uint64_t *spent = arena == &l->work ? &l->work_bytes : &l->bytes;
    bool fits = !size || count <= GLTF_BYTES_MAX / size;
    if (fits)
        *spent += (uint64_t)count * size + LEAST_BYTES;
    if (!fits || l->bytes + l->work_bytes > l->limit)
        return gltf_fail(l, KD_TOO_LARGE,
                         "the model unfolds to more than %llu MiB from %llu KiB of files; split it",
                         (unsigned long long)(l->limit >> 20), (unsigned long long)(l->source_bytes >> 10));
    memory = kd_arena_alloc(arena, count * size + 1);
    memcpy(out, &memory, sizeof memory);
    return memory ? KD_OK : gltf_fail(l, KD_NO_MEMORY, "out of memory for %zu bytes", count * size);
}

void gltf_reset_work(gltf_loader *l)
{
    /* Large blocks go back, or primitives of rising size would leave a trail of blocks too small for the
     * next. */
    if (l->work_bytes > ((uint64_t)16 << 20))
        kd_arena_fini(&l->work);
    else
        kd_arena_reset(&l->work);
    l->work_bytes = 0;
}

const char *gltf_name(gltf_loader *l, const char *name, const char *kind, size_t index)
{
    if (name && *name)
        return kd_arena_printf(&l->kept, "%s", name);
    return kd_arena_printf(&l->kept, "%s %zu", kind, index);
}

bool gltf_floats(const double *from, size_t count, float *to)
{
    for (size_t i = 0; i < count; i++) {
        to[i] = (float)from[i];
        if (!isfinite(to[i]))
            return false;
    }
    return true;
}
