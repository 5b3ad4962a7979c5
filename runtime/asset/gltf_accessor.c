/* Accessors: a count, a type and a place in a buffer, each of which may lie. An accessor is checked when
 * first used, once, with arithmetic that cannot overflow; a sparse one becomes a dense copy. After that
 * reading needs no checks. */

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "runtime/asset/gltf_loader.h"

/* What an accessor without a view holds; no element is wider than 64 bytes. */
static const uint8_t zero_element[64];

static uint32_t component_bytes(int component)
{
    switch (component) {
    case GLTF_BYTE:
    case GLTF_UBYTE: return 1;
    case GLTF_SHORT:
    case GLTF_USHORT: return 2;
    case GLTF_UINT:
    case GLTF_FLOAT: return 4;
    default: return 0;
    }
}

uint32_t gltf_element_bytes(const gltf_accessor *a)
{
    return component_bytes(a->component) * (uint32_t)a->width;
}

static kd_status accessor_fail(gltf_loader *l, const char *where, int accessor, const char *what)
{
    return gltf_fail(l, KD_BAD_FORMAT, "%s (%s, accessor %d); export the model again", what, where, accessor);
}

/* Find `count` elements of `size` bytes in a view. */
static kd_status locate(gltf_loader *l, int accessor, const char *where, int view, uint64_t offset,
                        uint64_t count, uint32_t size, gltf_span *out)
{
    if (view < 0 || (size_t)view >= l->doc.view_count)
        return accessor_fail(l, where, accessor, "the buffer view does not exist");
    const gltf_view *v = &l->doc.views[view];
    const uint8_t *bytes = gltf_view_bytes(l, v);
    if (!bytes)
        return accessor_fail(l, where, accessor, "its buffer has neither a URI nor a binary chunk");
    uint64_t stride = v->stride ? v->stride : size;
    if (stride < size)
        return accessor_fail(l, where, accessor, "the stride is smaller than an element");
    if (offset > v->length ||
        (count && (v->length - offset < size || count - 1 > (v->length - offset - size) / stride)))
        return accessor_fail(l, where, accessor, "the elements reach beyond the buffer view");
    out->base = bytes + offset;
    out->stride = (size_t)stride;
    return KD_OK;
}

static uint32_t read_index(const uint8_t *p, int component)
{
    uint16_t u16;
    uint32_t u32;
    switch (component) {
    case GLTF_UBYTE: return *p;
    case GLTF_USHORT: memcpy(&u16, p, sizeof u16); return u16;
    default: memcpy(&u32, p, sizeof u32); return u32;
    }
}

uint32_t gltf_read_uint(const gltf_span *span, uint32_t element, int component)
{
    const uint8_t *p = span->base + (size_t)element * span->stride;
    return read_index(p + (size_t)component * component_bytes(span->component), span->component);
}

/* Replace the span by a dense copy with the sparse values put in. */
static kd_status make_dense(gltf_loader *l, int accessor, const char *where, gltf_span *span)
{
    const gltf_accessor *a = &l->doc.accessors[accessor];
    uint32_t size = gltf_element_bytes(a), index_size = component_bytes(a->sparse_index_component);
    if (a->sparse_count < 1 || (uint64_t)a->sparse_count > a->count)
        return accessor_fail(l, where, accessor,
                             "the sparse count is not between 1 and the accessor's count");
    if (a->sparse_index_offset < 0 || a->sparse_value_offset < 0)
        return accessor_fail(l, where, accessor, "a sparse offset is negative");
    if (a->sparse_index_component == GLTF_FLOAT || a->sparse_index_component == GLTF_BYTE ||
        a->sparse_index_component == GLTF_SHORT || !index_size)
        return accessor_fail(l, where, accessor, "the sparse indices are not unsigned integers");
    gltf_span indices = {0}, values = {0};
    uint64_t n = (uint64_t)a->sparse_count;
    kd_status status = locate(l, accessor, where, a->sparse_index_view, (uint64_t)a->sparse_index_offset, n,
                              index_size, &indices);
    if (!status)
        status = locate(l, accessor, where, a->sparse_value_view, (uint64_t)a->sparse_value_offset, n, size,
                        &values);
    uint8_t *dense;
    if (!status)
        status = gltf_alloc(l, &l->scratch, span->count, size, &dense);
    if (status)
        return status;
    for (size_t i = 0; i < span->count; i++)
        memcpy(dense + i * size, span->base + i * span->stride, size);
    uint32_t before = 0;
    for (size_t i = 0; i < n; i++) {
        uint32_t index = read_index(indices.base + i * indices.stride, a->sparse_index_component);
        if (index >= span->count || (i && index <= before))
            return accessor_fail(l, where, accessor, "the sparse indices do not rise or run past the count");
        memcpy(dense + (size_t)index * size, values.base + i * values.stride, size);
        before = index;
    }
    span->base = dense;
    span->stride = size;
    return KD_OK;
}

static kd_status check_accessor(gltf_loader *l, int accessor, const char *where, gltf_span *span)
{
    const gltf_accessor *a = &l->doc.accessors[accessor];
    if (!component_bytes(a->component) || a->width < 1 || a->width > 16)
        return accessor_fail(l, where, accessor, "the component type is not one of glTF 2.0's");
    if (a->matrix && a->component != GLTF_FLOAT)
        return accessor_fail(l, where, accessor, "a matrix is not of floats");
    if (a->count < 1)
        return accessor_fail(l, where, accessor, "the count is zero");
    if (a->count > GLTF_VERTICES_MAX)
        return gltf_fail(l, KD_TOO_LARGE,
                         "%llu elements are more than the limit of %u (%s, accessor %d); split the mesh",
                         (unsigned long long)a->count, GLTF_VERTICES_MAX, where, accessor);
    *span = (gltf_span){.base = zero_element,
                        .count = (uint32_t)a->count,
                        .component = a->component,
                        .width = a->width,
                        .normalized = a->normalized};
    kd_status status = KD_OK;
    if (a->view != -1)
        status = locate(l, accessor, where, a->view, a->offset, a->count, gltf_element_bytes(a), span);
    if (!status && a->sparse)
        status = make_dense(l, accessor, where, span);
    return status;
}

kd_status gltf_span_of(gltf_loader *l, int accessor, const char *where, gltf_span *out)
{
    if (accessor < 0 || (size_t)accessor >= l->doc.accessor_count)
        return gltf_fail(l, KD_BAD_FORMAT, "there is no accessor %d (%s); export the model again", accessor,
                         where);
    gltf_span *span = &l->spans[accessor];
    if (!span->base) {
        kd_status status = check_accessor(l, accessor, where, span);
        if (status) {
            span->base = NULL;
            return status;
        }
    }
    *out = *span;
    return KD_OK;
}

/* glTF 2.0, section 3.6.2.2: signed normalised values clamp at -1. */
static float read_component(const uint8_t *p, int component, bool normalized)
{
    int16_t s16;
    uint16_t u16;
    uint32_t u32;
    float f32;
    switch (component) {
    case GLTF_BYTE: return normalized ? fmaxf((float)(int8_t)*p / 127.0f, -1) : (float)(int8_t)*p;
    case GLTF_UBYTE: return normalized ? (float)*p / 255.0f : (float)*p;
    case GLTF_SHORT:
        memcpy(&s16, p, sizeof s16);
        return normalized ? fmaxf((float)s16 / 32767.0f, -1) : (float)s16;
    case GLTF_USHORT: memcpy(&u16, p, sizeof u16); return normalized ? (float)u16 / 65535.0f : (float)u16;
    case GLTF_UINT: memcpy(&u32, p, sizeof u32); return (float)u32;
    default: memcpy(&f32, p, sizeof f32); return f32;
    }
}

kd_status gltf_read_floats(gltf_loader *l, const gltf_span *span, const uint32_t *select, uint32_t count,
                           float *out, uint32_t row_floats, const char *where)
{
    uint32_t width = (uint32_t)span->width < row_floats ? (uint32_t)span->width : row_floats;
    uint32_t bytes = component_bytes(span->component);
    for (uint32_t i = 0; i < count; i++) {
        uint32_t element = select ? select[i] : i;
        const uint8_t *p = span->base + (size_t)element * span->stride;
        float *row = out + (size_t)i * row_floats;
        if (span->component == GLTF_FLOAT)
            memcpy(row, p, width * sizeof *row);
        else
            for (uint32_t c = 0; c < width; c++)
                row[c] = read_component(p + (size_t)c * bytes, span->component, span->normalized);
        for (uint32_t c = 0; c < width; c++)
            if (!isfinite(row[c]))
                return gltf_fail(l, KD_BAD_FORMAT,
                                 "a value is not finite (%s, element %u); export the model again", where,
                                 element);
    }
    return KD_OK;
}
