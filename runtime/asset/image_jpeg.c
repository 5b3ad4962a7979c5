#include "runtime/asset/image_jpeg.h"

#include <string.h>

#define STB_IMAGE_IMPLEMENTATION
#define STB_IMAGE_STATIC
#define STBI_ONLY_JPEG
#define STBI_NO_STDIO
#define STBI_NO_LINEAR
#define STBI_NO_HDR
#define STBI_NO_FAILURE_STRINGS
#define STBI_MAX_DIMENSIONS 16384
/* Declarations of what is left out stay without a body. */
#pragma GCC diagnostic ignored "-Wunused-function"
#include <stb/stb_image.h>

bool image_jpeg_measure(const uint8_t *bytes, int size, int *width, int *height)
{
    int channels;
    return stbi_info_from_memory(bytes, size, width, height, &channels) != 0;
}

bool image_jpeg_decode(const uint8_t *bytes, int size, size_t rgba_bytes, uint8_t *rgba)
{
    int width, height, channels;
    stbi_uc *pixels = stbi_load_from_memory(bytes, size, &width, &height, &channels, 4);
    bool right = pixels && (size_t)width * (size_t)height * 4 == rgba_bytes;
    if (right)
        memcpy(rgba, pixels, rgba_bytes);
    stbi_image_free(pixels);
    return right;
}
