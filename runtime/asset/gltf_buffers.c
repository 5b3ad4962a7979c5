/* Bytes from outside the JSON: data URIs, files beside the model, the GLB's binary chunk. */

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "runtime/asset/gltf_loader.h"
#include "runtime/core/file.h"

#define URI_SHOWN 80 /* characters of a URI in a message: a data URI may have millions */

static int base64_value(char c)
{
    if (c >= 'A' && c <= 'Z')
        return c - 'A';
    if (c >= 'a' && c <= 'z')
        return c - 'a' + 26;
    if (c >= '0' && c <= '9')
        return c - '0' + 52;
    return c == '+' ? 62 : c == '/' ? 63 : -1;
}

/* Decode until the padding. Returns the bytes written, or SIZE_MAX for a character that does not belong
 * there. */
static size_t base64_decode(const char *text, size_t length, uint8_t *out)
{
    size_t written = 0;
    uint32_t bits = 0;
    int have = 0;
    while (length && text[length - 1] == '=')
        length--;
    for (size_t i = 0; i < length; i++) {
        int value = base64_value(text[i]);
        if (value < 0)
            return SIZE_MAX;
        bits = bits << 6 | (uint32_t)value;
        have += 6;
        if (have >= 8) {
            have -= 8;
            out[written++] = (uint8_t)(bits >> have);
        }
    }
    return written;
}

static int hex_value(char c)
{
    return c >= '0' && c <= '9'   ? c - '0'
           : c >= 'a' && c <= 'f' ? c - 'a' + 10
           : c >= 'A' && c <= 'F' ? c - 'A' + 10
                                  : -1;
}

/* Undo %20 and the like (RFC 3986, section 2.1). Returns the bytes written, no more than the text has. */
static size_t percent_decode(const char *text, uint8_t *out)
{
    size_t n = 0;
    for (; *text; text++) {
        char c = *text;
        if (c == '%' && hex_value(text[1]) >= 0 && hex_value(text[2]) >= 0) {
            c = (char)(hex_value(text[1]) << 4 | hex_value(text[2]));
            text += 2;
        }
        out[n++] = (uint8_t)c;
    }
    return n;
}

static kd_status load_data_uri(gltf_loader *l, const char *uri, const char *where, const uint8_t **bytes,
                               size_t *size)
{
    const char *comma = strchr(uri, ',');
    if (!comma)
        return gltf_fail(l, KD_BAD_FORMAT, "a data URI holds no data (%s); export it again", where);
    bool base64 = comma - uri >= 7 && memcmp(comma - 7, ";base64", 7) == 0;
    size_t length = strlen(comma + 1);
    uint8_t *out;
    kd_status status = gltf_alloc(l, &l->scratch, length + 1, 1, &out);
    if (status)
        return status;
    *bytes = out;
    *size = base64 ? base64_decode(comma + 1, length, out) : percent_decode(comma + 1, out);
    if (*size == SIZE_MAX)
        return gltf_fail(l, KD_BAD_FORMAT,
                         "a data URI holds a character that is not base64 (%s); export it again", where);
    return KD_OK;
}

/* Returns false for a name that is too long, empty or holds a zero byte. */
static bool decode_name(const char *uri, char *out, size_t size)
{
    if (strlen(uri) >= size)
        return false;
    size_t length = percent_decode(uri, (uint8_t *)out);
    out[length] = 0;
    return length && strlen(out) == length;
}

/* A name with a scheme ("http:") or an absolute path is no file beside the model. */
static bool is_relative(const char *uri)
{
    size_t name = strcspn(uri, "/:?#");
    return uri[0] != '/' && uri[name] != ':';
}

/* Buffers and pictures are read once each. */
static kd_status note_file(gltf_loader *l, const char *path)
{
    const char **files = (const char **)l->model->files; /* made by the first of them, const for readers */
    size_t most = l->doc.buffer_count + l->doc.image_count;
    kd_status status = files ? KD_OK : gltf_alloc(l, &l->kept, most, sizeof *files, &files);
    if (status || l->model->file_count == most)
        return status;
    l->model->files = files;
    files[l->model->file_count] = kd_arena_printf(&l->kept, "%s", path);
    if (!files[l->model->file_count])
        return gltf_fail(l, KD_NO_MEMORY, "out of memory for names");
    l->model->file_count++;
    return KD_OK;
}

static bool lies_in_roots(const kd_model_options *options, const char *path)
{
    for (uint32_t i = 0; i < options->root_count; i++)
        if (kd_path_is_below(options->roots[i], path))
            return true;
    return options->root_count == 0;
}

static kd_status load_file(gltf_loader *l, const char *uri, const char *where, const uint8_t **bytes,
                           size_t *size)
{
    char name[KD_PATH_MAX], folder[KD_PATH_MAX], path[KD_PATH_MAX];
    if (!is_relative(uri))
        return gltf_fail(l, KD_UNSUPPORTED, "'%.*s' is not a file beside the model (%s); use a relative path",
                         URI_SHOWN, uri, where);
    if (!decode_name(uri, name, sizeof name) || name[0] == '/' ||
        kd_path_folder(folder, sizeof folder, l->path) || kd_path_join(path, sizeof path, folder, name))
        return gltf_fail(l, KD_BAD_FORMAT, "'%.*s' is no usable file name (%s)", URI_SHOWN, uri, where);
    if (!lies_in_roots(&l->options, path))
        return gltf_fail(l, KD_UNSUPPORTED,
                         "'%.*s' lies outside the scenario's folder (%s); give its folder with --asset-root",
                         URI_SHOWN, name, where);
    if (!kd_file_exists(path))
        return gltf_fail(l, KD_NOT_FOUND,
                         "the file '%.*s' is missing or cannot be read (%s); put it beside the model",
                         URI_SHOWN, name, where);
    void *data;
    kd_status status = kd_file_read(path, (size_t)(GLTF_BYTES_MAX - l->bytes), &data, size);
    if (status)
        return status;
    uint8_t *copy;
    status = gltf_alloc(l, &l->scratch, *size + 1, 1, &copy);
    if (!status)
        memcpy(copy, data, *size);
    free(data);
    *bytes = copy;
    l->source_bytes += *size;
    return status ? status : note_file(l, path);
}

kd_status gltf_load_uri(gltf_loader *l, const char *uri, const char *where, const uint8_t **bytes,
                        size_t *size)
{
    if (strncmp(uri, "data:", 5) == 0)
        return load_data_uri(l, uri, where, bytes, size);
    return load_file(l, uri, where, bytes, size);
}

static kd_status load_buffer(gltf_loader *l, size_t index)
{
    gltf_buffer *buffer = &l->doc.buffers[index];
    char where[48];
    snprintf(where, sizeof where, "buffers[%zu]", index);
    size_t size = l->chunks.binary_size;
    buffer->bytes = l->chunks.binary;
    kd_status status = KD_OK;
    if (buffer->uri)
        status = gltf_load_uri(l, buffer->uri, where, &buffer->bytes, &size);
    else if (index || !l->chunks.binary)
        return KD_OK; /* a placeholder: refused when something reads it */
    if (!status && size < buffer->byte_length)
        status =
            gltf_fail(l, KD_BAD_FORMAT,
                      "%llu bytes are announced, %zu are there (%s); the file is cut off or not the model's",
                      (unsigned long long)buffer->byte_length, size, where);
    return status;
}

static kd_status check_view(gltf_loader *l, size_t index)
{
    const gltf_view *v = &l->doc.views[index];
    if (v->buffer < 0 || (size_t)v->buffer >= l->doc.buffer_count)
        return gltf_fail(l, KD_BAD_FORMAT, "there is no buffer %d (bufferViews[%zu]); export the model again",
                         v->buffer, index);
    uint64_t length = l->doc.buffers[v->buffer].byte_length;
    if (v->offset > length || v->length > length - v->offset)
        return gltf_fail(
            l, KD_BAD_FORMAT,
            "the view reaches beyond its buffer of %llu bytes (bufferViews[%zu]); export the model again",
            (unsigned long long)length, index);
    return KD_OK;
}

const uint8_t *gltf_view_bytes(const gltf_loader *l, const gltf_view *view)
{
    const uint8_t *bytes = l->doc.buffers[view->buffer].bytes;
    return view->packed ? view->unpacked : bytes ? bytes + view->offset : NULL;
}

kd_status gltf_load_buffers(gltf_loader *l)
{
    kd_status status = KD_OK;
    for (size_t i = 0; !status && i < l->doc.buffer_count; i++)
        status = load_buffer(l, i);
    for (size_t i = 0; !status && i < l->doc.view_count; i++)
        status = check_view(l, i);
    return status;
}
