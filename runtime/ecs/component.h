#ifndef KD_ECS_COMPONENT_H
#define KD_ECS_COMPONENT_H

/* Reflection. A component is plain data described once by a static kd_component_desc; a world gives it an id
 * of its own (ids live in the world, never in globals). Scripting, panels, snapshots and the documentation
 * read the field tables.
 *
 *     typedef struct kd_light { uint32_t type; kd_vec3 color; float intensity; } kd_light;
 *     KD_COMPONENT_DECLARE(kd_light);                                   // in the header
 *
 *     static const char *const light_types[] = {"directional", "point", "spot", NULL};   // in the source
 *     KD_COMPONENT_DEFINE(kd_light, "light",
 *         KD_FIELD_ENUM(kd_light, type, light_types, "kind of light"),
 *         KD_FIELD_RANGE(kd_light, intensity, KD_F32, "cd or lx", 0, 1e6, "luminous intensity or
 * illuminance"));
 */

#include <stdalign.h>
#include <stddef.h>
#include <stdint.h>

typedef enum kd_field_type {
    KD_BOOL, /* one byte */
    KD_I32,
    KD_U32,
    KD_F32,
    KD_VEC2,
    KD_VEC3,
    KD_VEC4,
    KD_QUAT,
    KD_MAT4,
    KD_COLOR,  /* three linear floats */
    KD_ENUM,   /* u32 with names */
    KD_ENTITY, /* kd_entity */
    KD_STRING, /* fixed char array of `size` bytes, NUL-terminated */
} kd_field_type;

typedef struct kd_field {
    const char *name;
    kd_field_type type;
    uint32_t offset;
    uint32_t size;                 /* bytes of the whole field (of all elements of an array) */
    uint32_t count;                /* elements of an array; 0 and 1 both mean a single value */
    const char *unit;              /* "m", "rad", "cd", NULL when it has none */
    double min, max;               /* range; both 0 means unbounded */
    const char *const *enum_names; /* NULL-terminated, for KD_ENUM */
    const char *doc;               /* one line */
} kd_field;

struct kd_world;

typedef struct kd_component_desc {
    const char *name; /* as scripts and files write it: "light" */
    uint32_t size;    /* 0: a tag */
    uint32_t align;   /* bytes; values lie at multiples of it, 64 at most */
    const kd_field *fields;
    uint32_t field_count;
    const void *default_value;                  /* size bytes; NULL means zeros */
    void (*on_remove)(void *value, void *user); /* frees what the component owns; NULL: plain data */
    void *hook_user;
    uint32_t flags; /* kd_component_flags */
} kd_component_desc;

typedef enum kd_component_flags {
    KD_COMPONENT_TRANSIENT =
        1, /* left out of snapshots (handles of a device, caches): the restored world lacks it */
    KD_COMPONENT_SPARSE =
        2, /* kept beside the tables: adding and removing moves no row, iterating costs a look-up a row */
    KD_COMPONENT_TOGGLE = 4, /* kd_disable hides it from queries, value and place kept */
    KD_COMPONENT_RELATION =
        8, /* each value has a target entity, and an entity any number of them: relation.h */
    KD_COMPONENT_EXCLUSIVE = 16, /* relations: one target at a time, relating to another replaces it */
    KD_COMPONENT_CASCADE = 32,   /* relations: a source dies with its target; else only the pair goes */
} kd_component_flags;

#define KD_COMPONENT_DECLARE(type) extern const kd_component_desc type##_desc

#define KD_FIELD(type_, member, kind, unit_, doc_)                                                           \
    {                                                                                                        \
        .name = #member, .type = (kind), .offset = (uint32_t)offsetof(type_, member),                        \
        .size = (uint32_t)sizeof(((type_ *)0)->member), .unit = (unit_), .doc = (doc_)                       \
    }
#define KD_FIELD_RANGE(type_, member, kind, unit_, min_, max_, doc_)                                         \
    {                                                                                                        \
        .name = #member, .type = (kind), .offset = (uint32_t)offsetof(type_, member),                        \
        .size = (uint32_t)sizeof(((type_ *)0)->member), .unit = (unit_), .min = (min_), .max = (max_),       \
        .doc = (doc_)                                                                                        \
    }
#define KD_FIELD_ENUM(type_, member, names, doc_)                                                            \
    {                                                                                                        \
        .name = #member, .type = KD_ENUM, .offset = (uint32_t)offsetof(type_, member),                       \
        .size = (uint32_t)sizeof(((type_ *)0)->member), .enum_names = (names), .doc = (doc_)                 \
    }
#define KD_FIELD_ARRAY(type_, member, kind, count_, unit_, doc_)                                             \
    {                                                                                                        \
        .name = #member, .type = (kind), .offset = (uint32_t)offsetof(type_, member),                        \
        .size = (uint32_t)sizeof(((type_ *)0)->member), .count = (count_), .unit = (unit_), .doc = (doc_)    \
    }

#define KD_COMPONENT_DEFINE_DEFAULT(type, name_, default_, ...)                                              \
    static const kd_field type##_fields[] = {__VA_ARGS__};                                                   \
    const kd_component_desc type##_desc = {.name = (name_),                                                  \
                                           .size = (uint32_t)sizeof(type),                                   \
                                           .align = (uint32_t)alignof(type),                                 \
                                           .fields = type##_fields,                                          \
                                           .field_count =                                                    \
                                               (uint32_t)(sizeof type##_fields / sizeof(kd_field)),          \
                                           .default_value = (default_)}
#define KD_COMPONENT_DEFINE(type, name_, ...) KD_COMPONENT_DEFINE_DEFAULT(type, name_, NULL, __VA_ARGS__)
#define KD_COMPONENT_DEFINE_FLAGS(type, name_, flags_, ...)                                                  \
    static const kd_field type##_fields[] = {__VA_ARGS__};                                                   \
    const kd_component_desc type##_desc = {.name = (name_),                                                  \
                                           .size = (uint32_t)sizeof(type),                                   \
                                           .align = (uint32_t)alignof(type),                                 \
                                           .fields = type##_fields,                                          \
                                           .field_count =                                                    \
                                               (uint32_t)(sizeof type##_fields / sizeof(kd_field)),          \
                                           .flags = (flags_)}
#define KD_RELATION_DEFINE(type, name_, flags_, ...)                                                         \
    KD_COMPONENT_DEFINE_FLAGS(type, name_, KD_COMPONENT_RELATION | (flags_), __VA_ARGS__)
#define KD_RELATION_TAG_DEFINE(type, name_, flags_)                                                          \
    const kd_component_desc type##_desc = {                                                                  \
        .name = (name_), .align = 1, .flags = KD_COMPONENT_RELATION | (flags_)}
#define KD_TAG_DEFINE(type, name_) const kd_component_desc type##_desc = {.name = (name_), .align = 1}

#endif
