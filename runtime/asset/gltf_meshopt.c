/* EXT_meshopt_compression: views whose bytes meshoptimizer has packed. Source: the extension's text; the
 * decoders take any bytes. */

#include <stdio.h>
#include <string.h>

#include <meshoptimizer.h>

#include "runtime/asset/gltf_loader.h"

static kd_status view_fail(gltf_loader *l, size_t view, const char *what)
{
    return gltf_fail(l, KD_BAD_FORMAT,
                     "%s (bufferViews[%zu].extensions.EXT_meshopt_compression); export the model again", what,
                     view);
}

/* Check what the decoders only assert. */
static const char *find_fault(const gltf_loader *l, const gltf_view *v)
{
    const gltf_packed *p = v->packed;
    const gltf_buffer *buffer =
        p->buffer >= 0 && (size_t)p->buffer < l->doc.buffer_count ? &l->doc.buffers[p->buffer] : NULL;
    bool attributes = strcmp(p->mode, "ATTRIBUTES") == 0, triangles = strcmp(p->mode, "TRIANGLES") == 0;
    if (!buffer || !buffer->bytes)
        return "its buffer is not there";
    if (p->offset > buffer->byte_length || p->length > buffer->byte_length - p->offset)
        return "the packed bytes reach beyond their buffer";
    if (!attributes && !triangles && strcmp(p->mode, "INDICES") != 0)
        return "the mode is none of ATTRIBUTES, TRIANGLES and INDICES";
    if (attributes ? p->stride < 4 || p->stride > 256 || p->stride % 4 : p->stride != 2 && p->stride != 4)
        return "the stride does not fit the mode";
    if (p->count > v->length / p->stride || p->count * p->stride != v->length)
        return "count times stride is not the view's length";
    return triangles && p->count % 3 ? "the count is no multiple of three" : NULL;
}

/* Undo the filter. Returns what is wrong with it, or NULL. */
static const char *unfilter(const gltf_packed *p, uint8_t *bytes)
{
    size_t count = (size_t)p->count, stride = (size_t)p->stride;
    if (strcmp(p->filter, "NONE") == 0)
        return NULL;
    if (strcmp(p->mode, "ATTRIBUTES") != 0)
        return "indices have a filter";
    if (strcmp(p->filter, "OCTAHEDRAL") == 0) {
        if (stride != 4 && stride != 8)
            return "the stride does not fit the filter";
        meshopt_decodeFilterOct(bytes, count, stride);
    } else if (strcmp(p->filter, "QUATERNION") == 0) {
        if (stride != 8)
            return "the stride does not fit the filter";
        meshopt_decodeFilterQuat(bytes, count, stride);
    } else if (strcmp(p->filter, "EXPONENTIAL") == 0) {
        meshopt_decodeFilterExp(bytes, count, stride);
    } else {
        return "the filter is none of OCTAHEDRAL, QUATERNION and EXPONENTIAL";
    }
    return NULL;
}

static kd_status unpack(gltf_loader *l, size_t index)
{
    gltf_view *v = &l->doc.views[index];
    const gltf_packed *p = v->packed;
    const char *fault = find_fault(l, v);
    if (fault)
        return view_fail(l, index, fault);
    uint8_t *out;
    kd_status status = gltf_alloc(l, &l->scratch, (size_t)v->length, 1, &out);
    if (status)
        return status;
    const uint8_t *packed = l->doc.buffers[p->buffer].bytes + p->offset;
    size_t count = (size_t)p->count, stride = (size_t)p->stride, size = (size_t)p->length;
    int code = p->mode[0] == 'A'   ? meshopt_decodeVertexBuffer(out, count, stride, packed, size)
               : p->mode[0] == 'T' ? meshopt_decodeIndexBuffer(out, count, stride, packed, size)
                                   : meshopt_decodeIndexSequence(out, count, stride, packed, size);
    fault = code ? "the packed bytes are broken" : unfilter(p, out);
    v->unpacked = out;
    return fault ? view_fail(l, index, fault) : KD_OK;
}

kd_status gltf_unpack_views(gltf_loader *l)
{
    kd_status status = KD_OK;
    for (size_t i = 0; !status && i < l->doc.view_count; i++)
        if (l->doc.views[i].packed)
            status = unpack(l, i);
    return status;
}
