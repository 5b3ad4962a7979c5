#ifndef KD_ASSET_GLTF_COPY_HPP
#define KD_ASSET_GLTF_COPY_HPP

/* Steps between tinygltf's containers and the plain rows of gltf_document.h: for the C++ files of this folder
 * alone. Whatever is wrong with a document is thrown as `malformed`; gltf_shim.cpp turns it into a status. */

#include "runtime/asset/gltf_document.h"

#include <cstring>
#include <map>
#include <new>
#include <stdexcept>
#include <string>
#include <vector>

/* gltf_scan.h tells why tinygltf gets no file access, no images and no buffers. */
#define TINYGLTF_NO_STB_IMAGE
#define TINYGLTF_NO_STB_IMAGE_WRITE
#define TINYGLTF_NO_EXTERNAL_IMAGE
#define TINYGLTF_NO_FS
#include <tiny_gltf.h>

namespace gltf_copy
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

inline const tinygltf::Value *member(const tinygltf::Value &object, const char *name)
{
    return object.Has(name) ? &object.Get(name) : nullptr;
}

inline double number(const tinygltf::Value &object, const char *name, double missing)
{
    const tinygltf::Value *value = member(object, name);
    return value && value->IsNumber() ? value->GetNumberAsDouble() : missing;
}

inline int index(const tinygltf::Value &object, const char *name, int missing)
{
    const tinygltf::Value *value = member(object, name);
    return value && value->IsInt() ? value->GetNumberAsInt() : missing;
}

/* What is changed in the text before tinygltf sees it, which refuses or drops what two extensions leave out.
 */
struct edits {
    std::string text;                  /* nothing: it stays as it is */
    std::vector<size_t> lent;          /* accessors that were given a view */
};

/* Change what draco's and animation pointers' extensions need changed; nothing in most documents. */
edits edit(const char *text, size_t size);

/* The JSON that tinygltf does not see or drops. */
void copy_required(copier &to, gltf_document &out, const gltf_scan *scan);
void copy_buffers(copier &to, gltf_document &out, const gltf_scan *scan);
void copy_images(copier &to, gltf_document &out, const gltf_scan *scan);
void copy_extras(copier &to, gltf_document &out, const gltf_extras &extras, const char *text);

void copy_material(copier &to, gltf_material &out, const tinygltf::Material &from);
void copy_accessor(gltf_accessor &out, const tinygltf::Accessor &from);
void copy_view(copier &to, gltf_view &out, const tinygltf::BufferView &from);
/* variants: how many sets of materials the document has. */
void copy_mesh(copier &to, gltf_mesh &out, const tinygltf::Mesh &from, size_t variants);
/* Members of an object that are integers, by name; of none: none. */
gltf_attributes int_members(copier &to, const tinygltf::Value *object);

} /* namespace gltf_copy */

#endif
