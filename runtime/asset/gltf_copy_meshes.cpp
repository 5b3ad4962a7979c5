/* Accessors, views of buffers and meshes, packed or not. */
#include "runtime/asset/gltf_copy.hpp"

#include <algorithm>
#include <climits>

namespace gltf_copy
{

void copy_accessor(gltf_accessor &out, const tinygltf::Accessor &from)
{
    out.view = from.bufferView;
    out.offset = from.byteOffset;
    out.count = from.count;
    out.component = from.componentType;
    out.width = tinygltf::GetNumComponentsInType(static_cast<uint32_t>(from.type));
    out.matrix = from.type >= TINYGLTF_TYPE_MAT2 && from.type <= TINYGLTF_TYPE_MAT4;
    out.normalized = from.normalized;
    out.sparse = from.sparse.isSparse;
    if (!out.sparse)
        return;
    out.sparse_count = from.sparse.count;
    out.sparse_index_view = from.sparse.indices.bufferView;
    out.sparse_index_offset = from.sparse.indices.byteOffset;
    out.sparse_index_component = from.sparse.indices.componentType;
    out.sparse_value_view = from.sparse.values.bufferView;
    out.sparse_value_offset = from.sparse.values.byteOffset;
}

gltf_attributes int_members(copier &to, const tinygltf::Value *object)
{
    std::map<std::string, int> found;
    if (object && object->IsObject())
        for (const auto &key : object->Keys())
            if (object->Get(key).IsInt())
                found[key] = object->Get(key).GetNumberAsInt();
    return to.attributes(found);
}

static uint64_t unsigned_member(const tinygltf::Value &object, const char *name, uint64_t missing)
{
    double value = number(object, name, static_cast<double>(missing));
    return value >= 0 && value < 9e15 ? static_cast<uint64_t>(value) : UINT64_MAX;
}

void copy_view(copier &to, gltf_view &out, const tinygltf::BufferView &from)
{
    out = {from.buffer, from.byteOffset, from.byteLength, from.byteStride, nullptr, nullptr};
    auto it = from.extensions.find("EXT_meshopt_compression");
    if (it == from.extensions.end())
        return;
    const tinygltf::Value &v = it->second;
    gltf_packed *packed = to.rows<gltf_packed>(1);
    const tinygltf::Value *mode = member(v, "mode"), *filter = member(v, "filter");
    *packed = {index(v, "buffer", INT_MAX),
               unsigned_member(v, "byteOffset", 0),
               unsigned_member(v, "byteLength", UINT64_MAX),
               unsigned_member(v, "byteStride", UINT64_MAX),
               unsigned_member(v, "count", UINT64_MAX),
               mode && mode->IsString() ? to.text(mode->Get<std::string>()) : "",
               filter && filter->IsString() ? to.text(filter->Get<std::string>()) : "NONE"};
    out.packed = packed;
}

/* Which material each variant gives to the primitive. Lists of variants that run over are left out. */
static const int *copy_variants(copier &to, const tinygltf::Primitive &from, size_t variants)
{
    auto it = from.extensions.find("KHR_materials_variants");
    const tinygltf::Value *mappings = it == from.extensions.end() ? nullptr : member(it->second, "mappings");
    if (!mappings || !mappings->IsArray() || !variants)
        return nullptr;
    int *materials = to.rows<int>(variants);
    std::fill(materials, materials + variants, -1);
    for (size_t m = 0; m < mappings->ArrayLen(); m++) {
        const tinygltf::Value &mapping = mappings->Get(m);
        const tinygltf::Value *list = member(mapping, "variants");
        for (size_t i = 0; list && list->IsArray() && i < list->ArrayLen(); i++) {
            int variant = list->Get(i).IsInt() ? list->Get(i).GetNumberAsInt() : -1;
            if (variant >= 0 && static_cast<size_t>(variant) < variants)
                materials[variant] = index(mapping, "material", -1);
        }
    }
    return materials;
}

static void copy_primitive(copier &to, gltf_primitive &out, const tinygltf::Primitive &from, size_t variants)
{
    auto draco = from.extensions.find("KHR_draco_mesh_compression");
    out.draco = -1;
    if (draco != from.extensions.end()) {
        out.draco = index(draco->second, "bufferView", INT_MAX);
        out.unique = int_members(to, member(draco->second, "attributes"));
    }
    out.variant_of = copy_variants(to, from, variants);
    out.attributes = to.attributes(from.attributes);
    gltf_attributes *targets = nullptr;
    out.target_count =
        to.each(targets, from.targets,
                [&](gltf_attributes &row, const std::map<std::string, int> &t) { row = to.attributes(t); });
    out.targets = targets;
    out.material = from.material;
    out.indices = from.indices;
    out.mode = from.mode;
}

void copy_mesh(copier &to, gltf_mesh &out, const tinygltf::Mesh &from, size_t variants)
{
    out.name = to.text(from.name);
    gltf_primitive *primitives = nullptr;
    out.primitive_count =
        to.each(primitives, from.primitives, [&](gltf_primitive &row, const tinygltf::Primitive &p) {
            copy_primitive(to, row, p, variants);
        });
    out.primitives = primitives;
    out.weights = to.reals(from.weights);
}

} /* namespace gltf_copy */
