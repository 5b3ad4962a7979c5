/* Documents that say by an extension what tinygltf refuses or drops, made to say it without. */
#include "runtime/asset/gltf_copy.hpp"

#include <algorithm>
#include <cstdio>
#include <nlohmann/json.hpp>

namespace gltf_copy
{

static bool mentions(const char *text, size_t size, const char *extension)
{
    std::string key = std::string("\"") + extension + "\"";
    return std::search(text, text + size, key.begin(), key.end()) != text + size;
}

static nlohmann::json &list_of(nlohmann::json &from, const char *name)
{
    static thread_local nlohmann::json none;
    none = nlohmann::json::array();
    return from.is_object() && from.contains(name) && from[name].is_array() ? from[name] : none;
}

static const nlohmann::json *extension_of(const nlohmann::json &object, const char *name)
{
    if (!object.is_object() || !object.contains("extensions") || !object["extensions"].is_object() ||
        !object["extensions"].contains(name))
        return nullptr;
    return &object["extensions"][name];
}

/* KHR_draco_mesh_compression: indices stand without a view. */
static bool lend_views(nlohmann::json &json, edits &out)
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

/* KHR_animation_pointer: "/nodes/3/rotation" is what a channel says without it. Other pointers take the place of
 * its path; the node that the format asks for is then without meaning. */
static bool name_targets(nlohmann::json &json)
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
            } else {
                target["node"] = 0;
                target["path"] = pointer;
            }
            changed = true;
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
    bool named = pointer && name_targets(json);
    if (lent || named)
        out.text = json.dump();
    return out;
}

} /* namespace gltf_copy */
