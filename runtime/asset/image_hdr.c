#include "runtime/asset/image_hdr.h"

#include <string.h>

#define STB_IMAGE_IMPLEMENTATION
#define STB_IMAGE_STATIC
#define STBI_ONLY_HDR
#define STBI_NO_STDIO
#define STBI_NO_FAILURE_STRINGS
#define STBI_MAX_DIMENSIONS 16384
/* Declarations of what is left out stay without a body. */
#pragma GCC diagnostic ignored "-Wunused-function"
#include <stb/stb_image.h>

bool image_hdr_measure(const uint8_t *bytes, int size, int *width, int *height)
{
    int channels;
    return stbi_is_hdr_from_memory(bytes, size) &&
           stbi_info_from_memory(bytes, size, width, height, &channels);
}

/* Reads from memory and notes when there was less than asked for: stb takes zeros for it and does not say so.
 * It fills a buffer of 128 bytes, which may be cut by the end, and asks for less only when it needs all of
 * it. */
typedef struct source {
    const uint8_t *bytes;
    int size, at;
    bool missing;
} source;

enum { STB_BUFFER = 128 };

static int take(void *user, char *data, int size)
{
    source *s = user;
    int left = s->size - s->at, n = size < left ? size : left;
    memcpy(data, s->bytes + s->at, (size_t)n);
    s->at += n;
    s->missing |= n == 0 || (n < size && size < STB_BUFFER);
    return n;
}

static void skip(void *user, int n)
{
    source *s = user;
    int left = s->size - s->at;
    s->at += n < left ? n : left;
}

static int is_end(void *user)
{
    const source *s = user;
    return s->at >= s->size;
}

float *image_hdr_decode(const uint8_t *bytes, int size, int *width, int *height)
{
    static const stbi_io_callbacks callbacks = {take, skip, is_end};
    source s = {.bytes = bytes, .size = size};
    int channels;
    float *rgb = stbi_loadf_from_callbacks(&callbacks, &s, width, height, &channels, 3);
    if (rgb != NULL && !s.missing)
        return rgb;
    stbi_image_free(rgb);
    return NULL;
}
