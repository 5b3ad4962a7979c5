#include "tests/draco_encode.h"

#include <cstdlib>
#include <cstring>

#include <draco/compression/encode.h>
#include <draco/mesh/triangle_soup_mesh_builder.h>

extern "C" uint8_t *draco_encode(const kd_primitive_desc *p, size_t *size)
{
    draco::TriangleSoupMeshBuilder builder;
    builder.Start(static_cast<int>(p->index_count / 3));
    int position = builder.AddAttribute(draco::GeometryAttribute::POSITION, 3, draco::DT_FLOAT32);
    int normal = builder.AddAttribute(draco::GeometryAttribute::NORMAL, 3, draco::DT_FLOAT32);
    int uv = builder.AddAttribute(draco::GeometryAttribute::TEX_COORD, 2, draco::DT_FLOAT32);
    for (uint32_t f = 0; f < p->index_count / 3; f++) {
        const uint32_t *i = p->indices + 3 * f;
        draco::FaceIndex face(f);
        builder.SetAttributeValuesForFace(position, face, &p->positions[i[0]], &p->positions[i[1]],
                                          &p->positions[i[2]]);
        builder.SetAttributeValuesForFace(normal, face, &p->normals[i[0]], &p->normals[i[1]],
                                          &p->normals[i[2]]);
        builder.SetAttributeValuesForFace(uv, face, &p->uv0[i[0]], &p->uv0[i[1]], &p->uv0[i[2]]);
    }
    std::unique_ptr<draco::Mesh> mesh = builder.Finalize();
    draco::Encoder encoder;
    draco::EncoderBuffer buffer;
    encoder.SetAttributeQuantization(draco::GeometryAttribute::POSITION, 14);
    encoder.SetAttributeQuantization(draco::GeometryAttribute::NORMAL, 10);
    encoder.SetAttributeQuantization(draco::GeometryAttribute::TEX_COORD, 12);
    if (!mesh || !encoder.EncodeMeshToBuffer(*mesh, &buffer).ok())
        return nullptr;
    *size = buffer.size();
    uint8_t *bytes = static_cast<uint8_t *>(malloc(buffer.size()));
    memcpy(bytes, buffer.data(), buffer.size());
    return bytes;
}
