#ifndef KD_ECS_REFLECT_H
#define KD_ECS_REFLECT_H

/* Fields of components by name: what scripts, `--set lamp.light.intensity=3` and panels read and write.
 *
 *     kd_field_ref ref;
 *     if (kd_field_resolve(w, "transform.position.x", &ref) == KD_OK)
 *         kd_field_write(w, e, &ref, &(double){1.5}, 1);
 *
 * A path is COMPONENT.FIELD, then for a single element [INDEX] (from 0; also .INDEX) and for one number of a
 * vector or colour .x .y .z .w or .r .g .b. Numbers pass as doubles: one for bool, integers, floats and
 * enumerations, 2, 3, 4 for vectors, 16 for a matrix (column-major), and as many times more for a whole
 * array. Entities and strings have functions of their own. The entity KD_NO_ENTITY stands for the world's
 * singleton of that component.
 *
 * What is written is checked first: the count, finite, whole where an integer is kept, and the field's range;
 * an error writes one message and changes nothing. */

#include "runtime/ecs/world.h"

typedef struct kd_field_ref {
    kd_component_id component;
    const kd_component_desc *desc;
    const kd_field *field;
    kd_field_type type; /* of one element */
    uint32_t offset;    /* into the component */
    uint32_t elements;  /* values of `type` meant: 1, or all of an array */
    uint32_t numbers;   /* numbers that read and write pass; 0 for strings and entities */
    bool part;          /* one number out of a vector */
} kd_field_ref;

/* ---- finding ---- */
/** Resolve COMPONENT.FIELD…. Errors NOT_FOUND with a message that lists what there is. */
kd_status kd_field_resolve(kd_world *w, const char *path, kd_field_ref *ref);
/** Resolve ENTITY.COMPONENT.FIELD…, where ENTITY is a name (it may contain dots). */
kd_status kd_entity_field_resolve(kd_world *w, const char *path, kd_entity *e, kd_field_ref *ref);
/** Resolve a field of a description alone: "intensity", "position.x". Returns false, silently, when there is
 * none. */
bool kd_desc_field_find(const kd_component_desc *desc, const char *path, kd_field_ref *ref);

/* ---- values of an entity (KD_NO_ENTITY: of the singleton) ---- */
/** Read `ref->numbers` numbers. Errors NOT_FOUND without the component, OUT_OF_RANGE when capacity is too
 * small. */
kd_status kd_field_read(kd_world *w, kd_entity e, const kd_field_ref *ref, double *numbers,
                        uint32_t capacity);
/** Write numbers; marks the component as changed. One number for a vector or colour sets each of its parts.
 */
kd_status kd_field_write(kd_world *w, kd_entity e, const kd_field_ref *ref, const double *numbers,
                         uint32_t count);
/** Read a string, an entity's name, an enumeration's word, or numbers written out. Returns `out`, "" when it
 * is missing. */
const char *kd_field_read_text(kd_world *w, kd_entity e, const kd_field_ref *ref, char *out, size_t out_size);
/** Write from text: words of an enumeration, true/false, numbers separated by commas or blanks, strings,
 * entity names. */
kd_status kd_field_write_text(kd_world *w, kd_entity e, const kd_field_ref *ref, const char *text);
/** Read and write element `index` of an entity field. */
kd_status kd_field_read_entity(kd_world *w, kd_entity e, const kd_field_ref *ref, uint32_t index,
                               kd_entity *value);
kd_status kd_field_write_entity(kd_world *w, kd_entity e, const kd_field_ref *ref, uint32_t index,
                                kd_entity value);

/* ---- values in memory: `component` points to a value of ref->desc ---- */
void kd_field_load(const kd_field_ref *ref, const void *component,
                   double *numbers); /* ref->numbers of them */
kd_status kd_field_store(const kd_field_ref *ref, void *component, const double *numbers, uint32_t count);
kd_status kd_field_store_text(const kd_field_ref *ref, void *component,
                              const char *text); /* not for entities */

/** Index of a word of an enumeration. Returns -1 when it has none such. */
int kd_field_enum_find(const kd_field *field, const char *word);
/** Numbers in one value of a type: 1, 2, 3, 4, 16; 0 for strings and entities. */
uint32_t kd_field_type_numbers(kd_field_type type);
/** Name of a type as documentation writes it: "vec3". Returns a static string. */
const char *kd_field_type_name(kd_field_type type);

#endif
