#include "runtime/asset/draco_shim.h"

#include <cstdio>
#include <exception>
#include <memory>
#include <new>

#include <draco/compression/decode.h>
#include <draco/mesh/mesh.h>

struct draco_shim {
    std::unique_ptr<draco::Mesh> mesh;
};

namespace
{

template <typename T>
bool read(const draco::Mesh &mesh, const draco::PointAttribute &from, int width, void *out)
{
    T *row = static_cast<T *>(out);
    for (uint32_t i = 0; i < mesh.num_points(); i++, row += width)
        if (!from.ConvertValue<T>(from.mapped_index(draco::PointIndex(i)), static_cast<int8_t>(width), row))
            return false;
    return true;
}

} /* namespace */

extern "C" kd_status draco_shim_open(const uint8_t *bytes, size_t size, draco_shim **out, char *error,
                                     size_t error_size)
{
    *out = nullptr;
    try {
        draco::DecoderBuffer buffer;
        draco::Decoder decoder;
        buffer.Init(reinterpret_cast<const char *>(bytes), size);
        auto decoded = decoder.DecodeMeshFromBuffer(&buffer);
        if (!decoded.ok()) {
            snprintf(error, error_size, "%.100s", decoded.status().error_msg());
            return KD_BAD_FORMAT;
        }
        *out = new draco_shim{std::move(decoded).value()};
        return KD_OK;
    } catch (const std::bad_alloc &) {
        snprintf(error, error_size, "out of memory");
        return KD_NO_MEMORY;
    } catch (const std::exception &e) {
        snprintf(error, error_size, "%.100s", e.what());
        return KD_BAD_FORMAT;
    }
}

extern "C" void draco_shim_close(draco_shim *mesh)
{
    delete mesh;
}

extern "C" uint32_t draco_shim_points(const draco_shim *mesh)
{
    return mesh->mesh->num_points();
}

extern "C" uint32_t draco_shim_triangles(const draco_shim *mesh)
{
    return mesh->mesh->num_faces();
}

extern "C" void draco_shim_indices(const draco_shim *mesh, uint32_t *out)
{
    for (uint32_t f = 0; f < mesh->mesh->num_faces(); f++)
        for (int corner = 0; corner < 3; corner++)
            *out++ = mesh->mesh->face(draco::FaceIndex(f))[corner].value();
}

extern "C" bool draco_shim_attribute(const draco_shim *mesh, int id, int component, int width, void *out)
{
    const draco::PointAttribute *from =
        id < 0 ? nullptr : mesh->mesh->GetAttributeByUniqueId(static_cast<uint32_t>(id));
    if (!from || from->num_components() != width)
        return false;
    switch (component) {
    case 5120: return read<int8_t>(*mesh->mesh, *from, width, out);
    case 5121: return read<uint8_t>(*mesh->mesh, *from, width, out);
    case 5122: return read<int16_t>(*mesh->mesh, *from, width, out);
    case 5123: return read<uint16_t>(*mesh->mesh, *from, width, out);
    case 5125: return read<uint32_t>(*mesh->mesh, *from, width, out);
    case 5126: return read<float>(*mesh->mesh, *from, width, out);
    default: return false;
    }
}
