/* What is read past tinygltf: required extensions, buffers and images, which it would load, and cages in
 * `extras`, which it would keep as copies. */
#include "runtime/asset/gltf_copy.hpp"

#include <algorithm>
#include <climits>
#include <nlohmann/json.hpp>

namespace gltf_copy
{

/* A string member, or NULL when it is missing. */
static const char *string_member(copier &to, const nlohmann::json &object, const char *name,
                                 const std::string &where)
{
    auto it = object.find(name);
    if (it == object.end())
        return nullptr;
    if (!it->is_string())
        throw malformed("'" + std::string(name) + "' is not a string (" + where + ")");
    return to.text(it->get_ref<const std::string &>());
}

static nlohmann::json parse_list(const char *text, size_t size, const char *name)
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

/* A row for each object of a list, filled by `fill(row, object, where)`. */
template <typename Row, typename Fill>
static void object_rows(copier &to, Row *&rows, size_t &count, const nlohmann::json &list, const char *name,
                        Fill fill)
{
    rows = to.rows<Row>(list.size());
    for (const auto &item : list) {
        std::string where = std::string(name) + "[" + std::to_string(count) + "]";
        Row &row = rows[count++];
        if (!item.is_object())
            throw malformed("an entry is not an object (" + where + ")");
        fill(row, item, where);
    }
}

void copy_buffers(copier &to, gltf_document &out, const gltf_scan *scan)
{
    object_rows(to, out.buffers, out.buffer_count, parse_list(scan->buffers, scan->buffers_size, "buffers"),
                "buffers", [&](gltf_buffer &row, const nlohmann::json &item, const std::string &where) {
                    auto length = item.find("byteLength");
                    if (length == item.end() || !length->is_number_unsigned())
                        throw malformed("'byteLength' is missing or not a positive integer (" + where + ")");
                    row.byte_length = length->get<uint64_t>();
                    row.uri = string_member(to, item, "uri", where);
                });
}

void copy_images(copier &to, gltf_document &out, const gltf_scan *scan)
{
    object_rows(
        to, out.images, out.image_count, parse_list(scan->images, scan->images_size, "images"), "images",
        [&](gltf_image &row, const nlohmann::json &item, const std::string &where) {
            row.name = string_member(to, item, "name", where);
            row.uri = string_member(to, item, "uri", where);
            row.mime = string_member(to, item, "mimeType", where);
            auto view = item.find("bufferView");
            row.view = view == item.end() ? -1 : view->is_number_integer() ? view->get<int>() : INT_MAX;
            if (!row.uri == (row.view == -1))
                throw malformed("exactly one of 'uri' and 'bufferView' must be there (" + where + ")");
        });
}

/* ---- cages in `extras` ---- */

static const nlohmann::json &list_member(const nlohmann::json &object, const char *name,
                                         const std::string &where)
{
    static const nlohmann::json none = nlohmann::json::array();
    auto it = object.find(name);
    if (it == object.end())
        return none;
    if (!it->is_array())
        throw malformed("'" + std::string(name) + "' is not a list (" + where + ")");
    return *it;
}

static gltf_ints int_list(copier &to, const nlohmann::json &object, const char *name,
                          const std::string &where)
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

static gltf_reals real_list(copier &to, const nlohmann::json &object, const char *name,
                            const std::string &where)
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

static void copy_cage(copier &to, gltf_cage &out, const nlohmann::json &from, const std::string &where)
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

} /* namespace gltf_copy */
