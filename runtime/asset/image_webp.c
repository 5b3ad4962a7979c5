#include "runtime/asset/image_webp.h"

#include <string.h>

#include <webp/decode.h>

bool image_is_webp(const uint8_t *bytes, size_t size)
{
    return size > 12 && memcmp(bytes, "RIFF", 4) == 0 && memcmp(bytes + 8, "WEBP", 4) == 0;
}

bool image_webp_measure(const uint8_t *bytes, size_t size, int *width, int *height)
{
    return WebPGetInfo(bytes, size, width, height) != 0;
}

bool image_webp_decode(const uint8_t *bytes, size_t size, uint32_t width, uint32_t height, uint8_t *rgba)
{
    size_t row = (size_t)width * 4;
    int now_width, now_height;
    return WebPGetInfo(bytes, size, &now_width, &now_height) && now_width == (int)width &&
           now_height == (int)height && WebPDecodeRGBAInto(bytes, size, rgba, row * height, (int)row) != NULL;
}
