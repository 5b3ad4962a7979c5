/* Materials, with the extensions that change their surface. */
#include "runtime/asset/gltf_copy.hpp"

namespace gltf_copy
{

static void pair(const tinygltf::Value &object, const char *name, double out[2])
{
    const tinygltf::Value *value = member(object, name);
    if (!value)
        return;
    if (!value->IsArray() || value->ArrayLen() != 2 || !value->Get(0).IsNumber() || !value->Get(1).IsNumber())
        throw malformed(std::string("KHR_texture_transform: '") + name + "' is not a pair of numbers");
    out[0] = value->Get(0).GetNumberAsDouble();
    out[1] = value->Get(1).GetNumberAsDouble();
}

static void transform_texture(const tinygltf::Value &transform, gltf_texture_use &use)
{
    pair(transform, "offset", use.offset);
    pair(transform, "scale", use.scale);
    use.rotation = number(transform, "rotation", 0);
    use.uv_set = index(transform, "texCoord", use.uv_set);
}

template <typename Info> static gltf_texture_use texture_use(const Info &from, double strength)
{
    gltf_texture_use use = {from.index, from.texCoord, strength, {0, 0}, {1, 1}, 0};
    auto it = from.extensions.find("KHR_texture_transform");
    if (it != from.extensions.end())
        transform_texture(it->second, use);
    return use;
}

/* The same inside an extension, where the parser leaves it as it is written. */
static gltf_texture_use texture_use(const tinygltf::Value &from)
{
    gltf_texture_use use = {index(from, "index", -2), index(from, "texCoord", 0), 1, {0, 0}, {1, 1}, 0};
    const tinygltf::Value *extensions = member(from, "extensions");
    const tinygltf::Value *transform =
        extensions && extensions->IsObject() ? member(*extensions, "KHR_texture_transform") : nullptr;
    if (transform && transform->IsObject())
        transform_texture(*transform, use);
    return use;
}

static const tinygltf::Value *extension(const tinygltf::Material &from, const char *name)
{
    auto it = from.extensions.find(name);
    return it == from.extensions.end() ? nullptr : &it->second;
}

static double factor(const tinygltf::Value *object, const char *name, double missing)
{
    return object ? number(*object, name, missing) : missing;
}

static int texture_index(const tinygltf::Value *object, const char *name)
{
    const tinygltf::Value *info = object ? member(*object, name) : nullptr;
    return info && info->IsObject() ? index(*info, "index", -2) : -1;
}

/* Numbers of a list that may be missing. */
static void numbers(const tinygltf::Value &object, const char *where, const char *name, double *out,
                    int count)
{
    const tinygltf::Value *list = member(object, name);
    if (!list)
        return;
    bool good = list->IsArray() && list->ArrayLen() == static_cast<size_t>(count);
    for (int i = 0; good && i < count; i++)
        good = list->Get(i).IsNumber();
    if (!good)
        throw malformed(std::string(where) + ": '" + name + "' is not a list of " + std::to_string(count) +
                        " numbers");
    for (int i = 0; i < count; i++)
        out[i] = list->Get(i).GetNumberAsDouble();
}

static void copy_lobes(gltf_material &out, const tinygltf::Material &from)
{
    const auto *ior = extension(from, "KHR_materials_ior");
    const auto *specular = extension(from, "KHR_materials_specular");
    const auto *coat = extension(from, "KHR_materials_clearcoat");
    const auto *transmission = extension(from, "KHR_materials_transmission");
    out.ior = factor(ior, "ior", 1.5);
    out.specular = factor(specular, "specularFactor", 1);
    for (int i = 0; i < 3; i++)
        out.specular_color[i] = 1;
    if (specular)
        numbers(*specular, "KHR_materials_specular", "specularColorFactor", out.specular_color, 3);
    out.specular_texture = texture_index(specular, "specularTexture");
    out.specular_color_texture = texture_index(specular, "specularColorTexture");
    out.clearcoat = factor(coat, "clearcoatFactor", 0);
    out.clearcoat_roughness = factor(coat, "clearcoatRoughnessFactor", 0);
    out.clearcoat_texture = texture_index(coat, "clearcoatTexture");
    out.clearcoat_roughness_texture = texture_index(coat, "clearcoatRoughnessTexture");
    out.clearcoat_normal_texture = texture_index(coat, "clearcoatNormalTexture");
    out.transmission = factor(transmission, "transmissionFactor", 0);
    out.transmission_texture = texture_index(transmission, "transmissionTexture");
}

/* Materials of the archived extension as dielectrics: its diffuse colour below a reflection of its specular
 * colour. Where the file says both, its metallic-roughness maps say more than a mean. */
static void copy_specular_glossiness(gltf_material &out, const tinygltf::Material &from)
{
    const auto *old = extension(from, "KHR_materials_pbrSpecularGlossiness");
    const auto &pbr = from.pbrMetallicRoughness;
    out.glossiness = -1;
    out.glossiness_texture = -1;
    if (!old || pbr.baseColorTexture.index != -1 || pbr.metallicRoughnessTexture.index != -1)
        return;
    for (size_t i = 0; i < 4; i++)
        out.base_color[i] = 1;
    for (size_t i = 0; i < 3; i++)
        out.specular_color[i] = 1;
    numbers(*old, "KHR_materials_pbrSpecularGlossiness", "diffuseFactor", out.base_color, 4);
    numbers(*old, "KHR_materials_pbrSpecularGlossiness", "specularFactor", out.specular_color, 3);
    for (size_t i = 0; i < 3; i++)
        out.specular_color[i] /= 0.04; /* the reflection head-on that the factor scales */
    out.metallic = 0;
    out.glossiness = factor(old, "glossinessFactor", 1);
    out.glossiness_texture = out.specular_color_texture = texture_index(old, "specularGlossinessTexture");
    const tinygltf::Value *map = member(*old, "diffuseTexture");
    if (map && map->IsObject())
        out.base_color_map = texture_use(*map);
}

void copy_material(copier &to, gltf_material &out, const tinygltf::Material &from)
{
    const auto &pbr = from.pbrMetallicRoughness;
    out.name = to.text(from.name);
    out.alpha_mode = to.text(from.alphaMode);
    for (size_t i = 0; i < 4; i++)
        out.base_color[i] = pbr.baseColorFactor.at(i);
    for (size_t i = 0; i < 3; i++)
        out.emissive[i] = from.emissiveFactor.at(i);
    out.metallic = pbr.metallicFactor;
    out.roughness = pbr.roughnessFactor;
    out.alpha_cutoff = from.alphaCutoff;
    auto strength = from.extensions.find("KHR_materials_emissive_strength");
    out.emissive_strength =
        strength == from.extensions.end() ? 1 : number(strength->second, "emissiveStrength", 1);
    out.base_color_map = texture_use(pbr.baseColorTexture, 1);
    out.metallic_roughness_map = texture_use(pbr.metallicRoughnessTexture, 1);
    out.normal_map = texture_use(from.normalTexture, from.normalTexture.scale);
    out.occlusion_map = texture_use(from.occlusionTexture, from.occlusionTexture.strength);
    out.emissive_map = texture_use(from.emissiveTexture, 1);
    out.double_sided = from.doubleSided;
    out.unlit = from.extensions.count("KHR_materials_unlit") != 0;
    copy_lobes(out, from);
    copy_specular_glossiness(out, from);
}

} /* namespace gltf_copy */
