/* Resolving paths to fields. Reading and writing the values is in reflect_value.c. */

#include <ctype.h>
#include <stdio.h>

#include "runtime/ecs/internal.h"
#include "runtime/ecs/reflect.h"

static const struct {
    const char *name;
    uint32_t numbers;
} types[] = {
    [KD_BOOL] = {"bool", 1},     [KD_I32] = {"i32", 1},   [KD_U32] = {"u32", 1},
    [KD_F32] = {"f32", 1},       [KD_VEC2] = {"vec2", 2}, [KD_VEC3] = {"vec3", 3},
    [KD_VEC4] = {"vec4", 4},     [KD_QUAT] = {"quat", 4}, [KD_MAT4] = {"mat4", 16},
    [KD_COLOR] = {"color", 3},   [KD_ENUM] = {"enum", 1}, [KD_ENTITY] = {"entity", 0},
    [KD_STRING] = {"string", 0},
};

uint32_t kd_field_type_numbers(kd_field_type type)
{
    return types[type].numbers;
}
const char *kd_field_type_name(kd_field_type type)
{
    return types[type].name;
}

int kd_field_enum_find(const kd_field *field, const char *word)
{
    for (int i = 0; field->enum_names && field->enum_names[i]; i++)
        if (strcmp(field->enum_names[i], word) == 0)
            return i;
    return -1;
}

/* ---- one field's path ---- */
static const kd_field *find_field(const kd_component_desc *desc, const char *name, size_t length)
{
    for (uint32_t i = 0; i < desc->field_count; i++)
        if (strncmp(desc->fields[i].name, name, length) == 0 && !desc->fields[i].name[length])
            return &desc->fields[i];
    return NULL;
}

static kd_field_ref whole_field(const kd_component_desc *desc, const kd_field *f)
{
    uint32_t elements = f->count ? f->count : 1;
    return (kd_field_ref){.desc = desc,
                          .field = f,
                          .type = f->type,
                          .offset = f->offset,
                          .elements = elements,
                          .numbers = elements * types[f->type].numbers};
}

/* Take "[3]" or ".3" off the path: one element of an array. */
static bool take_index(const char **path, kd_field_ref *ref)
{
    const char *at = *path;
    bool bracket = *at == '[';
    uint64_t index = 0;
    at++;
    if (!isdigit((unsigned char)*at))
        return false;
    for (; isdigit((unsigned char)*at); at++)
        if ((index = index * 10 + (uint64_t)(*at - '0')) >= ref->elements)
            return false;
    if (bracket && *at++ != ']')
        return false;
    uint32_t size = ref->field->size / ref->elements;
    ref->offset += (uint32_t)index * size;
    ref->elements = 1;
    ref->numbers = types[ref->type].numbers;
    *path = at;
    return true;
}

/* Take ".x" off the path: one number of a vector, quaternion or colour. */
static bool take_part(const char **path, kd_field_ref *ref)
{
    static const char vector[] = "xyzw", color[] = "rgb";
    const char *letters = ref->type == KD_COLOR ? color : vector;
    char letter = (*path)[1];
    const char *found = letter ? strchr(letters, letter) : NULL;
    bool has_parts = (ref->type >= KD_VEC2 && ref->type <= KD_QUAT) || ref->type == KD_COLOR;
    if (!has_parts || !found || (uint32_t)(found - letters) >= types[ref->type].numbers)
        return false;
    ref->offset += (uint32_t)(found - letters) * (uint32_t)sizeof(float);
    ref->type = KD_F32;
    ref->numbers = 1;
    ref->part = true;
    *path += 2;
    return true;
}

bool kd_desc_field_find(const kd_component_desc *desc, const char *path, kd_field_ref *ref)
{
    size_t length = strcspn(path, ".[");
    const kd_field *field = find_field(desc, path, length);
    if (!field)
        return false;
    *ref = whole_field(desc, field);
    path += length;
    if (*path && ref->elements > 1 && !take_index(&path, ref))
        return false;
    if (*path == '.' && ref->elements == 1 && !take_part(&path, ref))
        return false;
    return !*path;
}

/* ---- a world's path ---- */
static bool resolve(kd_world *w, const char *path, kd_field_ref *ref)
{
    const char *dot = strchr(path, '.');
    for (; dot; dot = strchr(dot + 1, '.')) {
        uint32_t count = kd_component_count(w);
        for (kd_component_id id = 1; id <= count; id++) {
            const kd_component_desc *desc = w->components[id].desc;
            size_t length = (size_t)(dot - path);
            if (strncmp(desc->name, path, length) || desc->name[length] ||
                !kd_desc_field_find(desc, dot + 1, ref))
                continue;
            ref->component = id;
            return true;
        }
    }
    return false;
}

static kd_status no_component(const kd_world *w, const char *path)
{
    char names[512] = "";
    size_t used = 0;
    for (kd_component_id id = 1; id <= kd_component_count(w) && used < sizeof names; id++)
        used += (size_t)snprintf(names + used, sizeof names - used, " %s", w->components[id].desc->name);
    return kd_fail(KD_NOT_FOUND, "%s: there is no such component; choose one of:%s", path, names);
}

static kd_status no_field(const kd_component_desc *desc, const char *path)
{
    char names[512] = "";
    size_t used = 0;
    for (uint32_t i = 0; i < desc->field_count && used < sizeof names; i++)
        used += (size_t)snprintf(names + used, sizeof names - used, " %s", desc->fields[i].name);
    return kd_fail(KD_NOT_FOUND, "%s: component %s has no such field; choose one of:%s", path, desc->name,
                   names);
}

kd_status kd_field_resolve(kd_world *w, const char *path, kd_field_ref *ref)
{
    if (resolve(w, path, ref))
        return KD_OK;
    size_t length = strcspn(path, ".");
    for (kd_component_id id = 1; id <= kd_component_count(w); id++) {
        const kd_component_desc *desc = w->components[id].desc;
        if (strncmp(desc->name, path, length) == 0 && !desc->name[length])
            return no_field(desc, path);
    }
    return no_component(w, path);
}

kd_status kd_entity_field_resolve(kd_world *w, const char *path, kd_entity *e, kd_field_ref *ref)
{
    char name[256];
    bool known = false;
    for (const char *dot = strchr(path, '.'); dot && (size_t)(dot - path) < sizeof name;
         dot = strchr(dot + 1, '.')) {
        memcpy(name, path, (size_t)(dot - path));
        name[dot - path] = 0;
        *e = kd_find_named(w, name);
        known |= e->generation != 0;
        if (e->generation && resolve(w, dot + 1, ref))
            return KD_OK;
    }
    *e = KD_NO_ENTITY;
    if (!known)
        return kd_fail(KD_NOT_FOUND,
                       "%s: no entity has that name; give one in the scenario with name = \"…\"", path);
    return kd_fail(KD_NOT_FOUND,
                   "%s: the entity is there, but no component field of that name; "
                   "write ENTITY.COMPONENT.FIELD as in lamp.light.intensity",
                   path);
}
