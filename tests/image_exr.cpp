// tinyexr behind a C function, for tests that read what the program wrote.
#include "tests/image_exr.h"

#include <cstdlib>
#include <exception>

#include <tinyexr.h>

static float *decode(const void *data, size_t size, uint32_t *width, uint32_t *height)
{
    float *rgba = nullptr;
    int w = 0, h = 0;
    const char *error = nullptr;
    int code = LoadEXRFromMemory(&rgba, &w, &h, static_cast<const unsigned char *>(data), size, &error);
    if (error)
        FreeEXRErrorMessage(error);
    if (code != TINYEXR_SUCCESS)
        return nullptr;
    const size_t count = static_cast<size_t>(w) * static_cast<size_t>(h);
    for (size_t i = 0; i < count; i++) // in place: opacity goes
        for (size_t c = 0; c < 3; c++)
            rgba[i * 3 + c] = rgba[i * 4 + c];
    *width = static_cast<uint32_t>(w);
    *height = static_cast<uint32_t>(h);
    return rgba;
}

float *image_exr_decode(const void *data, size_t size, uint32_t *width, uint32_t *height)
{
    try {
        return decode(data, size, width, height);
    } catch (const std::exception &) {
        return nullptr;
    }
}
