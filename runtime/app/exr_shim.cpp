// tinyexr behind a C function. Its exceptions and its error texts, which it allocates, stay here.
#include "runtime/app/exr_shim.h"

#include <cstring>
#include <exception>

#include <tinyexr.h>

static size_t encode(uint32_t width, uint32_t height, const uint16_t *planes, unsigned char **data) {
    static const char *const names[3] = {"B", "G", "R"}; // readers expect the order of the alphabet
    EXRHeader header;
    EXRImage image;
    EXRChannelInfo channels[3];
    int types[3] = {TINYEXR_PIXELTYPE_HALF, TINYEXR_PIXELTYPE_HALF, TINYEXR_PIXELTYPE_HALF};
    unsigned char *pixels[3];
    const size_t count = static_cast<size_t>(width) * height;
    InitEXRHeader(&header);
    InitEXRImage(&image);
    std::memset(channels, 0, sizeof channels);
    for (size_t i = 0; i < 3; i++) {
        std::strcpy(channels[i].name, names[i]);
        pixels[i] = reinterpret_cast<unsigned char *>(const_cast<uint16_t *>(planes + i * count));
    }
    header.num_channels = image.num_channels = 3;
    header.channels = channels;
    header.pixel_types = header.requested_pixel_types = types;
    header.compression_type = TINYEXR_COMPRESSIONTYPE_ZIP;
    image.images = pixels;
    image.width = static_cast<int>(width);
    image.height = static_cast<int>(height);
    const char *error = nullptr;
    size_t size = SaveEXRImageToMemory(&image, &header, data, &error);
    if (error)
        FreeEXRErrorMessage(error);
    return size;
}

size_t exr_shim_encode(uint32_t width, uint32_t height, const uint16_t *planes, unsigned char **data) {
    *data = nullptr;
    try {
        return encode(width, height, planes, data);
    } catch (const std::exception &) {
        *data = nullptr;
        return 0;
    }
}
