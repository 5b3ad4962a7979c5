/* The only place where tinygltf runs: scanned JSON text in, plain C rows out. What it does not check is
 * checked in C by those who read the rows. */

#include <fstream> /* tinygltf's writers need it */

#define TINYGLTF_IMPLEMENTATION
#include "runtime/asset/gltf_copy.hpp"

#include <climits>
#include <exception>

namespace
{

using namespace gltf_copy;

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
