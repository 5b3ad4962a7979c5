/* The only place that speaks C++ with tinygltf: scanned JSON text in, plain C rows out. tinygltf gets no file
 * access, no images and no buffers (gltf_scan.h tells why); what it does not check is checked in C by those
 * who read the rows. */

#include "runtime/asset/gltf_document.h"

#include <algorithm>
#include <climits>
#include <cstdio>
#include <cstring>
#include <exception>
#include <fstream> /* tinygltf's writers need it */
#include <new>
#include <stdexcept>
#include <string>
#include <vector>

#define TINYGLTF_IMPLEMENTATION
#define TINYGLTF_NO_STB_IMAGE
#define TINYGLTF_NO_STB_IMAGE_WRITE
#define TINYGLTF_NO_EXTERNAL_IMAGE
#define TINYGLTF_NO_FS
#include <tiny_gltf.h>

namespace
{

struct malformed : std::runtime_error {
    using std::runtime_error::runtime_error;
};

/* Copies tinygltf's containers into the arena. */
struct copier {
    kd_arena *arena;

    template <typename T> T *rows(size_t count)
    {
        if (!count)
            return nullptr;
        void *memory = kd_arena_alloc(arena, sizeof(T) * count);
        if (!memory)
            throw std::bad_alloc();
        return static_cast<T *>(memory);
    }

    const char *text(const std::string &from)
    {
        if (from.empty())
            return "";
        char *copy = rows<char>(from.size() + 1);
        std::memcpy(copy, from.c_str(), from.size() + 1);
        return copy;
    }

    gltf_ints ints(const std::vector<int> &from)
    {
        int *copy = rows<int>(from.size());
        for (size_t i = 0; i < from.size(); i++)
            copy[i] = from[i];
        return {copy, from.size()};
    }

    gltf_reals reals(const std::vector<double> &from)
    {
        double *copy = rows<double>(from.size());
        for (size_t i = 0; i < from.size(); i++)
            copy[i] = from[i];
        return {copy, from.size()};
    }

    gltf_strings strings(const std::vector<std::string> &from)
    {
        const char **copy = rows<const char *>(from.size());
        for (size_t i = 0; i < from.size(); i++)
            copy[i] = text(from[i]);
        return {copy, from.size()};
    }

    gltf_attributes attributes(const std::map<std::string, int> &from)
    {
        gltf_attribute *copy = rows<gltf_attribute>(from.size());
        size_t i = 0;
        for (const auto &pair : from)
            copy[i++] = {text(pair.first), pair.second};
        return {copy, from.size()};
    }

    /* Fill one row for each element with `fill(row, element)`. */
    template <typename Row, typename From, typename Fill> size_t each(Row *&out, const From &from, Fill fill)
    {
        out = rows<Row>(from.size());
        for (size_t i = 0; i < from.size(); i++)
            fill(out[i], from[i]);
        return from.size();
    }
};

const tinygltf::Value *member(const tinygltf::Value &object, const char *name)
{
    return object.Has(name) ? &object.Get(name) : nullptr;
}

double number(const tinygltf::Value &object, const char *name, double missing)
{
    const tinygltf::Value *value = member(object, name);
    return value && value->IsNumber() ? value->GetNumberAsDouble() : missing;
}

int index(const tinygltf::Value &object, const char *name, int missing)
{
    const tinygltf::Value *value = member(object, name);
    return value && value->IsInt() ? value->GetNumberAsInt() : missing;
}

void pair(const tinygltf::Value &object, const char *name, double out[2])
{
    const tinygltf::Value *value = member(object, name);
    if (!value)
        return;
    if (!value->IsArray() || value->ArrayLen() != 2 || !value->Get(0).IsNumber() || !value->Get(1).IsNumber())
        throw malformed(std::string("KHR_texture_transform: '") + name + "' is not a pair of numbers");
    out[0] = value->Get(0).GetNumberAsDouble();
    out[1] = value->Get(1).GetNumberAsDouble();
}

void transform_texture(const tinygltf::Value &transform, gltf_texture_use &use)
{
    pair(transform, "offset", use.offset);
    pair(transform, "scale", use.scale);
    use.rotation = number(transform, "rotation", 0);
    use.uv_set = index(transform, "texCoord", use.uv_set);
}

template <typename Info> gltf_texture_use texture_use(const Info &from, double strength)
{
    gltf_texture_use use = {from.index, from.texCoord, strength, {0, 0}, {1, 1}, 0};
    auto it = from.extensions.find("KHR_texture_transform");
    if (it != from.extensions.end())
        transform_texture(it->second, use);
    return use;
}

/* The same inside an extension, where the parser leaves it as it is written. */
gltf_texture_use texture_use(const tinygltf::Value &from)
{
    gltf_texture_use use = {index(from, "index", -2), index(from, "texCoord", 0), 1, {0, 0}, {1, 1}, 0};
    const tinygltf::Value *extensions = member(from, "extensions");
    const tinygltf::Value *transform =
        extensions && extensions->IsObject() ? member(*extensions, "KHR_texture_transform") : nullptr;
    if (transform && transform->IsObject())
        transform_texture(*transform, use);
    return use;
}

const tinygltf::Value *extension(const tinygltf::Material &from, const char *name)
{
    auto it = from.extensions.find(name);
    return it == from.extensions.end() ? nullptr : &it->second;
}

double factor(const tinygltf::Value *object, const char *name, double missing)
{
    return object ? number(*object, name, missing) : missing;
}

int texture_index(const tinygltf::Value *object, const char *name)
{
    const tinygltf::Value *info = object ? member(*object, name) : nullptr;
    return info && info->IsObject() ? index(*info, "index", -2) : -1;
}

/* Numbers of a list that may be missing. */
void numbers(const tinygltf::Value &object, const char *where, const char *name, double *out, int count)
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

void copy_lobes(gltf_material &out, const tinygltf::Material &from)
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
void copy_specular_glossiness(gltf_material &out, const tinygltf::Material &from)
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

/* Members of an object that are integers, by name. */
gltf_attributes int_members(copier &to, const tinygltf::Value *object)
{
    std::map<std::string, int> found;
    if (object && object->IsObject())
        for (const auto &key : object->Keys())
            if (object->Get(key).IsInt())
                found[key] = object->Get(key).GetNumberAsInt();
    return to.attributes(found);
}

uint64_t unsigned_member(const tinygltf::Value &object, const char *name, uint64_t missing)
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
const int *copy_variants(copier &to, const tinygltf::Primitive &from, size_t variants)
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

void copy_primitive(copier &to, gltf_primitive &out, const tinygltf::Primitive &from, size_t variants)
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

void copy_node(copier &to, gltf_node &out, const tinygltf::Node &from)
{
    out.name = to.text(from.name);
    out.mesh = from.mesh;
    out.skin = from.skin;
    out.camera = from.camera;
    auto light = from.extensions.find("KHR_lights_punctual");
    out.light = light == from.extensions.end() ? -1 : index(light->second, "light", INT_MAX);
    out.children = to.ints(from.children);
    out.matrix = to.reals(from.matrix);
    out.translation = to.reals(from.translation);
    out.rotation = to.reals(from.rotation);
    out.scale = to.reals(from.scale);
    out.weights = to.reals(from.weights);
    auto visibility = from.extensions.find("KHR_node_visibility");
    const tinygltf::Value *visible =
        visibility == from.extensions.end() ? nullptr : member(visibility->second, "visible");
    out.hidden = visible && visible->IsBool() && !visible->Get<bool>();
    auto instancing = from.extensions.find("EXT_mesh_gpu_instancing");
    if (instancing != from.extensions.end())
        out.instances = int_members(to, member(instancing->second, "attributes"));
}

void copy_camera(copier &to, gltf_camera &out, const tinygltf::Camera &from)
{
    out.name = to.text(from.name);
    out.orthographic = from.type == "orthographic";
    out.fov_y = from.perspective.yfov;
    out.aspect = from.perspective.aspectRatio;
    out.x_mag = from.orthographic.xmag;
    out.y_mag = from.orthographic.ymag;
    out.z_near = out.orthographic ? from.orthographic.znear : from.perspective.znear;
    out.z_far = out.orthographic ? from.orthographic.zfar : from.perspective.zfar;
}

void copy_light(copier &to, gltf_light &out, const tinygltf::Light &from)
{
    out.name = to.text(from.name);
    out.type = to.text(from.type);
    out.color = to.reals(from.color);
    out.intensity = from.intensity;
    out.range = from.range;
    out.inner_cone = from.spot.innerConeAngle;
    out.outer_cone = from.spot.outerConeAngle;
}

void copy_clip(copier &to, gltf_clip &out, const tinygltf::Animation &from)
{
    out.name = to.text(from.name);
    gltf_channel *channels = nullptr;
    out.channel_count =
        to.each(channels, from.channels, [&](gltf_channel &row, const tinygltf::AnimationChannel &c) {
            row = {c.sampler, c.target_node, to.text(c.target_path)};
        });
    out.channels = channels;
    gltf_curve *curves = nullptr;
    out.curve_count =
        to.each(curves, from.samplers, [&](gltf_curve &row, const tinygltf::AnimationSampler &s) {
            row = {s.input, s.output, to.text(s.interpolation)};
        });
    out.curves = curves;
}

void copy_scene_graph(copier &to, gltf_document &out, const tinygltf::Model &from)
{
    out.node_count = to.each(out.nodes, from.nodes,
                             [&](gltf_node &row, const tinygltf::Node &n) { copy_node(to, row, n); });
    out.skin_count = to.each(out.skins, from.skins, [&](gltf_skin &row, const tinygltf::Skin &s) {
        row = {to.text(s.name), to.ints(s.joints), s.inverseBindMatrices};
    });
    out.camera_count = to.each(out.cameras, from.cameras,
                               [&](gltf_camera &row, const tinygltf::Camera &c) { copy_camera(to, row, c); });
    out.light_count = to.each(out.lights, from.lights,
                              [&](gltf_light &row, const tinygltf::Light &l) { copy_light(to, row, l); });
    out.clip_count = to.each(out.clips, from.animations,
                             [&](gltf_clip &row, const tinygltf::Animation &a) { copy_clip(to, row, a); });
    out.scene_count = to.each(out.scenes, from.scenes,
                              [&](gltf_ints &row, const tinygltf::Scene &s) { row = to.ints(s.nodes); });
    std::vector<std::string> names;
    for (const auto &scene : from.scenes)
        names.push_back(scene.name);
    out.scene_names = to.strings(names);
    out.default_scene = from.defaultScene;
}

void copy_variant_names(copier &to, gltf_document &out, const tinygltf::Model &from)
{
    std::vector<std::string> names;
    auto it = from.extensions.find("KHR_materials_variants");
    const tinygltf::Value *list = it == from.extensions.end() ? nullptr : member(it->second, "variants");
    for (size_t i = 0; list && list->IsArray() && i < list->ArrayLen(); i++) {
        const tinygltf::Value *name = member(list->Get(i), "name");
        names.push_back(name && name->IsString() ? name->Get<std::string>() : "");
    }
    out.variants = to.strings(names);
}

void copy_model(copier &to, gltf_document &out, const tinygltf::Model &from)
{
    out.version = to.text(from.asset.version);
    out.min_version = to.text(from.asset.minVersion);
    out.generator = to.text(from.asset.generator);
    out.extensions_used = to.strings(from.extensionsUsed);
    out.view_count = to.each(out.views, from.bufferViews,
                             [&](gltf_view &row, const tinygltf::BufferView &v) { copy_view(to, row, v); });
    copy_variant_names(to, out, from);
    out.accessor_count =
        to.each(out.accessors, from.accessors,
                [&](gltf_accessor &row, const tinygltf::Accessor &a) { copy_accessor(row, a); });
    out.mesh_count = to.each(out.meshes, from.meshes, [&](gltf_mesh &row, const tinygltf::Mesh &m) {
        copy_mesh(to, row, m, out.variants.count);
    });
    out.material_count =
        to.each(out.materials, from.materials,
                [&](gltf_material &row, const tinygltf::Material &m) { copy_material(to, row, m); });
    out.texture_count =
        to.each(out.textures, from.textures, [&](gltf_texture &row, const tinygltf::Texture &t) {
            auto webp = t.extensions.find("EXT_texture_webp");
            row = {t.sampler,
                   webp == t.extensions.end() ? t.source : index(webp->second, "source", t.source)};
        });
    out.sampler_count =
        to.each(out.samplers, from.samplers, [&](gltf_sampler &row, const tinygltf::Sampler &s) {
            row = {s.magFilter, s.minFilter, s.wrapS, s.wrapT};
        });
    copy_scene_graph(to, out, from);
}

/* A string member, or NULL when it is missing. */
const char *string_member(copier &to, const nlohmann::json &object, const char *name,
                          const std::string &where)
{
    auto it = object.find(name);
    if (it == object.end())
        return nullptr;
    if (!it->is_string())
        throw malformed("'" + std::string(name) + "' is not a string (" + where + ")");
    return to.text(it->get_ref<const std::string &>());
}

nlohmann::json parse_list(const char *text, size_t size, const char *name)
{
    if (!text)
        return nlohmann::json::array();
    nlohmann::json list = nlohmann::json::parse(text, text + size);
    if (!list.is_array())
        throw malformed(std::string("'") + name + "' is not a list");
    return list;
}

/* Before all else, since what a required extension changes may look like a mistake. */
void copy_required(copier &to, gltf_document &out, const gltf_scan *scan)
{
    std::vector<std::string> names;
    for (const auto &item : parse_list(scan->required, scan->required_size, "extensionsRequired"))
        if (item.is_string())
            names.push_back(item.get<std::string>());
    out.extensions_required = to.strings(names);
}

void copy_buffers(copier &to, gltf_document &out, const gltf_scan *scan)
{
    nlohmann::json list = parse_list(scan->buffers, scan->buffers_size, "buffers");
    out.buffers = to.rows<gltf_buffer>(list.size());
    for (const auto &item : list) {
        std::string where = "buffers[" + std::to_string(out.buffer_count) + "]";
        gltf_buffer &row = out.buffers[out.buffer_count++];
        if (!item.is_object())
            throw malformed("an entry is not an object (" + where + ")");
        auto length = item.find("byteLength");
        if (length == item.end() || !length->is_number_unsigned())
            throw malformed("'byteLength' is missing or not a positive integer (" + where + ")");
        row.byte_length = length->get<uint64_t>();
        row.uri = string_member(to, item, "uri", where);
    }
}

void copy_images(copier &to, gltf_document &out, const gltf_scan *scan)
{
    nlohmann::json list = parse_list(scan->images, scan->images_size, "images");
    out.images = to.rows<gltf_image>(list.size());
    for (const auto &item : list) {
        std::string where = "images[" + std::to_string(out.image_count) + "]";
        gltf_image &row = out.images[out.image_count++];
        if (!item.is_object())
            throw malformed("an entry is not an object (" + where + ")");
        row.name = string_member(to, item, "name", where);
        row.uri = string_member(to, item, "uri", where);
        row.mime = string_member(to, item, "mimeType", where);
        auto view = item.find("bufferView");
        row.view = view == item.end() ? -1 : view->is_number_integer() ? view->get<int>() : INT_MAX;
        if (!row.uri == (row.view == -1))
            throw malformed("exactly one of 'uri' and 'bufferView' must be there (" + where + ")");
    }
}

/* ---- cages in `extras` ---- */

const nlohmann::json &list_member(const nlohmann::json &object, const char *name, const std::string &where)
{
    static const nlohmann::json none = nlohmann::json::array();
    auto it = object.find(name);
    if (it == object.end())
        return none;
    if (!it->is_array())
        throw malformed("'" + std::string(name) + "' is not a list (" + where + ")");
    return *it;
}

gltf_ints int_list(copier &to, const nlohmann::json &object, const char *name, const std::string &where)
{
    const nlohmann::json &list = list_member(object, name, where);
    int *copy = to.rows<int>(list.size());
    for (size_t i = 0; i < list.size(); i++) {
        bool whole = list[i].is_number_unsigned() && list[i].get<uint64_t>() <= INT_MAX;
        if (!whole)
            throw malformed("'" + std::string(name) + "' holds what is no index or count at place " +
                            std::to_string(i) + " (" + where + ")");
        copy[i] = list[i].get<int>();
    }
    return {copy, list.size()};
}

gltf_reals real_list(copier &to, const nlohmann::json &object, const char *name, const std::string &where)
{
    const nlohmann::json &list = list_member(object, name, where);
    double *copy = to.rows<double>(list.size());
    for (size_t i = 0; i < list.size(); i++) {
        if (!list[i].is_number())
            throw malformed("'" + std::string(name) + "' holds what is no number at place " +
                            std::to_string(i) + " (" + where + ")");
        copy[i] = list[i].get<double>();
    }
    return {copy, list.size()};
}

void copy_cage(copier &to, gltf_cage &out, const nlohmann::json &from, const std::string &where)
{
    out.scheme = string_member(to, from, "subdivisionScheme", where);
    out.boundary = string_member(to, from, "interpolateBoundary", where);
    out.uv_rule = string_member(to, from, "faceVaryingLinearInterpolation", where);
    out.face_sizes = int_list(to, from, "faceVertexCounts", where);
    out.corners = int_list(to, from, "faceVertexIndices", where);
    out.creases = int_list(to, from, "creaseIndices", where);
    out.crease_lengths = int_list(to, from, "creaseLengths", where);
    out.crease_sharpness = real_list(to, from, "creaseSharpnesses", where);
    out.sharp_corners = int_list(to, from, "cornerIndices", where);
    out.corner_sharpness = real_list(to, from, "cornerSharpnesses", where);
    out.uv = real_list(to, from, "st", where);
    out.uv_corners = int_list(to, from, "stIndices", where);
    auto level = from.find("level");
    if (level == from.end())
        return;
    if (!level->is_number_unsigned() || level->get<uint64_t>() == 0 || level->get<uint64_t>() > INT_MAX)
        throw malformed("'level' is no positive integer (" + where + ")");
    out.level = level->get<int>();
}

/* Other programs' `extras` may hold anything: without faceVertexCounts they are passed over, whatever else is
 * in them. */
void copy_extras(copier &to, gltf_document &out, const gltf_extras &extras, const char *text)
{
    static const char key[] = "\"faceVertexCounts\"";
    const char *first = text + extras.text.first, *end = first + extras.text.size;
    if (std::search(first, end, key, key + sizeof key - 1) == end || extras.mesh >= out.mesh_count)
        return;
    gltf_mesh &mesh = out.meshes[extras.mesh];
    std::string where = "meshes[" + std::to_string(extras.mesh) + "]";
    size_t primitive = extras.primitive;
    if (primitive != GLTF_WHOLE_MESH)
        where += ".primitives[" + std::to_string(primitive) + "]";
    else if (mesh.primitive_count != 1)
        throw malformed("a cage stands in a mesh with several primitives (" + where + ".extras)");
    primitive = primitive == GLTF_WHOLE_MESH ? 0 : primitive;
    where += ".extras";
    nlohmann::json json = nlohmann::json::parse(first, end, nullptr, false);
    if (json.is_discarded())
        throw malformed("the cage is not valid JSON (" + where + ")");
    if (primitive >= mesh.primitive_count || !json.contains("faceVertexCounts"))
        return;
    gltf_cage *cage = to.rows<gltf_cage>(1);
    copy_cage(to, *cage, json, where);
    const_cast<gltf_primitive &>(mesh.primitives[primitive]).cage = cage;
}

/* tinygltf writes an error and goes on where the format allows what it saw: a skin without inverse bind
 * matrices, a channel without a node. Such a channel it drops, as the format asks. */
std::string real_errors(std::string text)
{
    static const char *const harmless[] = {
        "'inverseBindMatrices' property is missing in Skin.\n",
        "'node' property is missing.\n`node` field is missing in animation.channels.target\n",
    };
    for (const char *message : harmless)
        for (size_t at; (at = text.find(message)) != std::string::npos;)
            text.erase(at, std::strlen(message));
    return text;
}

/* What is changed in the text before tinygltf sees it, which refuses or drops what two extensions leave out.
 */
struct edits {
    std::string text;                  /* nothing: it stays as it is */
    std::vector<size_t> lent;          /* accessors that were given a view */
    std::vector<std::string> pointers; /* of channels that move what is not animated here */
};

bool mentions(const char *text, size_t size, const char *extension)
{
    std::string key = std::string("\"") + extension + "\"";
    return std::search(text, text + size, key.begin(), key.end()) != text + size;
}

nlohmann::json &list_of(nlohmann::json &from, const char *name)
{
    static thread_local nlohmann::json none;
    none = nlohmann::json::array();
    return from.is_object() && from.contains(name) && from[name].is_array() ? from[name] : none;
}

const nlohmann::json *extension_of(const nlohmann::json &object, const char *name)
{
    if (!object.is_object() || !object.contains("extensions") || !object["extensions"].is_object() ||
        !object["extensions"].contains(name))
        return nullptr;
    return &object["extensions"][name];
}

/* KHR_draco_mesh_compression: indices stand without a view. */
bool lend_views(nlohmann::json &json, edits &out)
{
    nlohmann::json &accessors = json["accessors"];
    for (auto &mesh : list_of(json, "meshes"))
        for (auto &primitive : list_of(mesh, "primitives")) {
            auto indices = primitive.is_object() ? primitive.find("indices") : primitive.end();
            if (!extension_of(primitive, "KHR_draco_mesh_compression") || indices == primitive.end() ||
                !indices->is_number_unsigned() || !accessors.is_array() ||
                indices->get<size_t>() >= accessors.size())
                continue;
            auto &accessor = accessors[indices->get<size_t>()];
            if (!accessor.is_object() || accessor.contains("bufferView"))
                continue;
            accessor["bufferView"] = 0;
            out.lent.push_back(indices->get<size_t>());
        }
    return !out.lent.empty();
}

/* KHR_animation_pointer: "/nodes/3/rotation" is what a channel says without it. */
bool name_nodes(nlohmann::json &json, edits &out)
{
    bool changed = false;
    for (auto &clip : list_of(json, "animations"))
        for (auto &channel : list_of(clip, "channels")) {
            if (!channel.is_object() || !channel.contains("target"))
                continue;
            auto &target = channel["target"];
            const nlohmann::json *extension = extension_of(target, "KHR_animation_pointer");
            if (!extension || !extension->is_object() || !extension->contains("pointer") ||
                !(*extension)["pointer"].is_string())
                continue;
            std::string pointer = (*extension)["pointer"];
            int node, end = 0;
            char path[12];
            if (std::sscanf(pointer.c_str(), "/nodes/%9d/%11[a-z]%n", &node, path, &end) == 2 &&
                static_cast<size_t>(end) == pointer.size() && node >= 0) {
                target["node"] = node;
                target["path"] = path;
                changed = true;
            } else {
                out.pointers.push_back(pointer);
            }
        }
    return changed;
}

edits edit(const char *text, size_t size)
{
    edits out;
    bool draco = mentions(text, size, "KHR_draco_mesh_compression");
    bool pointer = mentions(text, size, "KHR_animation_pointer");
    if (!draco && !pointer)
        return out;
    nlohmann::json json = nlohmann::json::parse(text, text + size, nullptr, false);
    if (!json.is_object())
        return out;
    bool lent = draco && json.contains("accessors") && lend_views(json, out);
    bool named = pointer && name_nodes(json, out);
    if (lent || named)
        out.text = json.dump();
    return out;
}

void parse(copier &to, gltf_document &out, const char *text, size_t size, const gltf_scan *scan)
{
    tinygltf::TinyGLTF loader;
    const edits edited = edit(text, size);
    if (!edited.text.empty()) {
        text = edited.text.data();
        size = edited.text.size();
    }
    tinygltf::Model model;
    std::string error, warning;
    copy_required(to, out, scan);
    bool done =
        loader.LoadASCIIFromString(&model, &error, &warning, text, static_cast<unsigned int>(size), "");
    error = real_errors(error);
    if (!done && error.empty())
        error = "a required property is missing or has the wrong type";
    if (!error.empty())
        throw malformed(error);
    copy_model(to, out, model);
    for (size_t accessor : edited.lent)
        out.accessors[accessor].view = -1;
    out.unread_pointers = to.strings(edited.pointers);
    if (out.version[0] != '2')
        return; /* older files have other kinds of lists; the version is refused by whoever asks */
    copy_buffers(to, out, scan);
    copy_images(to, out, scan);
    for (size_t i = 0; i < scan->extras_count; i++)
        copy_extras(to, out, scan->extras[i], scan->copy);
}

/* One line, without control characters and the parser's own numbering, short enough for a terminal. */
void say(char *out, size_t size, const char *text)
{
    size_t n = 0;
    const char *numbering = text[0] == '[' ? std::strstr(text, "] ") : nullptr;
    text = numbering ? numbering + 2 : text;
    for (; *text && *text != '\n' && n + 1 < size && n < 200; text++)
        out[n++] = static_cast<unsigned char>(*text) < 32 ? ' ' : *text;
    while (n && (out[n - 1] == ' ' || out[n - 1] == '.'))
        n--;
    out[n] = 0;
}

} /* namespace */

extern "C" kd_status gltf_parse(const char *text, size_t size, const gltf_scan *scan, kd_arena *arena,
                                gltf_document *out, char *error, size_t error_size)
{
    *out = {};
    copier to{arena};
    try {
        parse(to, *out, text, size, scan);
        return KD_OK;
    } catch (const std::bad_alloc &) {
        say(error, error_size, "out of memory while reading the structure");
        return KD_NO_MEMORY;
    } catch (const std::length_error &) {
        say(error, error_size, "a count is too large");
        return KD_TOO_LARGE;
    } catch (const std::exception &e) {
        say(error, error_size, e.what());
        return KD_BAD_FORMAT;
    } catch (...) {
        say(error, error_size, "the structure cannot be read");
        return KD_BAD_FORMAT;
    }
}
