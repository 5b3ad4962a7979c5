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
static const char damaged[] = "its pixels are damaged, or stored in a way that is not supported";
static const char no_memory[] = "there is no memory to decode it";

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
            *error = damaged;
        *width = static_cast<uint32_t>(w);
        *height = static_cast<uint32_t>(h);
        return rgb;
    } catch (const std::exception &) {
        *error = no_memory;
        return nullptr;
    }
}

static const float *find_plane(const EXRHeader &header, const EXRImage &image, const char *name)
{
    for (int c = 0; c < image.num_channels; c++)
        if (std::strcmp(header.channels[c].name, name) == 0)
            return reinterpret_cast<const float *>(image.images[c]);
    return nullptr;
}

static float *copy_planes(const EXRHeader &header, const EXRImage &image, const char *const *names,
                          uint32_t count, const char **missing)
{
    const size_t texels = static_cast<size_t>(image.width) * static_cast<size_t>(image.height);
    std::vector<const float *> planes(count);
    for (uint32_t i = 0; i < count; i++) {
        planes[i] = image.images ? find_plane(header, image, names[i]) : nullptr; // tiled files have none
        if (!planes[i]) {
            *missing = names[i];
            return nullptr;
        }
    }
    float *out = static_cast<float *>(std::malloc(texels * count * sizeof *out));
    for (uint32_t i = 0; out && i < count; i++)
        std::memcpy(out + i * texels, planes[i], texels * sizeof *out);
    return out;
}

static float *decode_planes(const unsigned char *data, size_t size, const char *const *names, uint32_t count,
                            uint32_t *width, uint32_t *height, const char **missing)
{
    EXRVersion version;
    EXRHeader header;
    EXRImage image;
    float *out = nullptr;
    const char *error = nullptr;
    InitEXRHeader(&header);
    InitEXRImage(&image);
    int code = ParseEXRVersionFromMemory(&version, data, size);
    if (code == TINYEXR_SUCCESS)
        code = ParseEXRHeaderFromMemory(&header, &version, data, size, &error);
    for (int c = 0; code == TINYEXR_SUCCESS && c < header.num_channels; c++)
        header.requested_pixel_types[c] = TINYEXR_PIXELTYPE_FLOAT;
    if (code == TINYEXR_SUCCESS &&
        LoadEXRImageFromMemory(&image, &header, data, size, &error) == TINYEXR_SUCCESS) {
        out = copy_planes(header, image, names, count, missing);
        *width = static_cast<uint32_t>(image.width);
        *height = static_cast<uint32_t>(image.height);
        FreeEXRImage(&image);
    }
    if (error)
        FreeEXRErrorMessage(error);
    FreeEXRHeader(&header);
    return out;
}

float *exr_shim_planes(const void *data, size_t size, const char *const *names, uint32_t count,
                       uint32_t *width, uint32_t *height, const char **error, const char **missing)
{
    const unsigned char *bytes = static_cast<const unsigned char *>(data);
    *missing = nullptr;
    try {
        *error = check_header(bytes, size);
        float *out = *error ? nullptr : decode_planes(bytes, size, names, count, width, height, missing);
        if (!out && !*error)
            *error = *missing ? "it has not all channels" : damaged;
        return out;
    } catch (const std::exception &) {
        *error = no_memory;
        return nullptr;
    }
}
