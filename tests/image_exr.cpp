// tinyexr behind a C function, for tests that read what the program wrote.
#include "tests/image_exr.h"

#include <cstdlib>
#include <cstring>
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

static float *find(const EXRHeader &header, const EXRImage &image, const char *name)
{
    for (int c = 0; c < image.num_channels; c++) {
        if (std::strcmp(header.channels[c].name, name) != 0)
            continue;
        size_t bytes = static_cast<size_t>(image.width) * static_cast<size_t>(image.height) * sizeof(float);
        float *out = static_cast<float *>(std::malloc(bytes));
        if (out)
            std::memcpy(out, image.images[c], bytes);
        return out;
    }
    return nullptr;
}

static float *channel(const unsigned char *data, size_t size, const char *name, uint32_t *width,
                      uint32_t *height)
{
    EXRVersion version;
    EXRHeader header;
    EXRImage image;
    float *out = nullptr;
    const char *error = nullptr;
    InitEXRHeader(&header);
    InitEXRImage(&image);
    if (ParseEXRVersionFromMemory(&version, data, size) != TINYEXR_SUCCESS ||
        ParseEXRHeaderFromMemory(&header, &version, data, size, &error) != TINYEXR_SUCCESS)
        return nullptr;
    for (int c = 0; c < header.num_channels; c++)
        header.requested_pixel_types[c] = TINYEXR_PIXELTYPE_FLOAT;
    if (LoadEXRImageFromMemory(&image, &header, data, size, &error) == TINYEXR_SUCCESS) {
        out = find(header, image, name);
        *width = static_cast<uint32_t>(image.width);
        *height = static_cast<uint32_t>(image.height);
        FreeEXRImage(&image);
    }
    FreeEXRHeader(&header);
    return out;
}

float *image_exr_channel(const void *data, size_t size, const char *name, uint32_t *width, uint32_t *height)
{
    try {
        return channel(static_cast<const unsigned char *>(data), size, name, width, height);
    } catch (const std::exception &) {
        return nullptr;
    }
}
