// tinyexr behind a C function. Its exceptions and its error texts, which it allocates, stay here.
#include "runtime/asset/exr_shim.h"

#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <exception>
#include <vector>

#include <tinyexr.h>

static size_t encode(uint32_t width, uint32_t height, const exr_plane *planes, uint32_t count,
                     unsigned char **data)
{
    EXRHeader header;
    EXRImage image;
    std::vector<EXRChannelInfo> channels(count);
    std::vector<int> types(count);
    std::vector<unsigned char *> pixels(count);
    InitEXRHeader(&header);
    InitEXRImage(&image);
    for (size_t i = 0; i < count; i++) {
        std::memset(&channels[i], 0, sizeof channels[i]);
        std::snprintf(channels[i].name, sizeof channels[i].name, "%s", planes[i].name);
        types[i] = planes[i].floats ? TINYEXR_PIXELTYPE_FLOAT : TINYEXR_PIXELTYPE_HALF;
        pixels[i] = static_cast<unsigned char *>(const_cast<void *>(planes[i].texels));
    }
    header.num_channels = image.num_channels = static_cast<int>(count);
    header.channels = channels.data();
    header.pixel_types = header.requested_pixel_types = types.data();
    header.compression_type = TINYEXR_COMPRESSIONTYPE_ZIP;
    image.images = pixels.data();
    image.width = static_cast<int>(width);
    image.height = static_cast<int>(height);
    const char *error = nullptr;
    size_t size = SaveEXRImageToMemory(&image, &header, data, &error);
    if (error)
        FreeEXRErrorMessage(error);
    return size;
}

size_t exr_shim_encode(uint32_t width, uint32_t height, const exr_plane *planes, uint32_t count,
                       unsigned char **data)
{
    *data = nullptr;
    try {
        return encode(width, height, planes, count, data);
    } catch (const std::exception &) {
        *data = nullptr;
        return 0;
    }
}

static const int side_max = 16384;

// The size is known before anything of that size is made.
static const char *check_header(const unsigned char *data, size_t size)
{
    EXRVersion version;
    EXRHeader header;
    const char *error = nullptr;
    if (ParseEXRVersionFromMemory(&version, data, size) != TINYEXR_SUCCESS)
        return "it is no OpenEXR file";
    if (version.multipart || version.non_image)
        return "files of several parts or with deep data are not supported";
    InitEXRHeader(&header);
    int code = ParseEXRHeaderFromMemory(&header, &version, data, size, &error);
    if (error)
        FreeEXRErrorMessage(error);
    if (code != TINYEXR_SUCCESS) {
        FreeEXRHeader(&header); // what was read before the damage
        return "its header is damaged";
    }
    const long long width = static_cast<long long>(header.data_window.max_x) - header.data_window.min_x + 1;
    const long long height = static_cast<long long>(header.data_window.max_y) - header.data_window.min_y + 1;
    FreeEXRHeader(&header);
    return width < 1 || height < 1 || width > side_max || height > side_max ? "its size is out of range"
                                                                            : nullptr;
}

static float *decode_rgb(const unsigned char *data, size_t size, int *width, int *height)
{
    float *rgba = nullptr;
    const char *error = nullptr;
    int code = LoadEXRFromMemory(&rgba, width, height, data, size, &error);
    if (error)
        FreeEXRErrorMessage(error);
    if (code != TINYEXR_SUCCESS)
        return nullptr;
    const size_t count = static_cast<size_t>(*width) * static_cast<size_t>(*height);
    for (size_t i = 0; i < count; i++) // in place: opacity goes
        for (size_t c = 0; c < 3; c++)
            rgba[i * 3 + c] = rgba[i * 4 + c];
    return rgba;
}

float *exr_shim_decode(const void *data, size_t size, uint32_t *width, uint32_t *height, const char **error)
{
    const unsigned char *bytes = static_cast<const unsigned char *>(data);
    int w = 0, h = 0;
    try {
        *error = check_header(bytes, size);
        float *rgb = *error ? nullptr : decode_rgb(bytes, size, &w, &h);
        if (!rgb && !*error)
            *error = "its pixels are damaged, or stored in a way that is not supported";
        *width = static_cast<uint32_t>(w);
        *height = static_cast<uint32_t>(h);
        return rgb;
    } catch (const std::exception &) {
        *error = "there is no memory to decode it";
        return nullptr;
    }
}
