/* A world as JSON for people: entities in order of iteration, components by their described fields. */

#include <stdio.h>
#include <stdlib.h>

#include "runtime/ecs/internal.h"
#include "runtime/ecs/reflect.h"
#include "runtime/ecs/relation.h"
#include "runtime/ecs/snapshot.h"

static void write_entity(kd_json *j, kd_entity e)
{
    if (!e.generation) {
        kd_json_null(j);
        return;
    }
    kd_json_array_begin(j);
    kd_json_uint(j, e.index);
    kd_json_uint(j, e.generation);
    kd_json_array_end(j);
}

/* The shortest decimals that read back as the same float: 0.1, not 0.10000000149. */
static double short_float(float value)
{
    char text[32];
    for (int digits = 1; digits <= 9; digits++) {
        snprintf(text, sizeof text, "%.*g", digits, (double)value);
        if (strtof(text, NULL) == value)
            return strtod(text, NULL);
    }
    return (double)value; /* not a number */
}

static void write_number(kd_json *j, const kd_field_ref *ref, double number)
{
    switch (ref->type) {
    case KD_BOOL: kd_json_bool(j, number != 0); break;
    case KD_I32:
    case KD_U32: kd_json_int(j, (int64_t)number); break;
    default: kd_json_double(j, short_float((float)number));
    }
}

/* A word of an enumeration, or its number when it has no word. */
static void write_word(kd_json *j, const kd_field *f, uint32_t value)
{
    for (uint32_t i = 0; f->enum_names && f->enum_names[i]; i++)
        if (i == value) {
            kd_json_string(j, f->enum_names[i]);
            return;
        }
    kd_json_uint(j, value);
}

static void write_text(kd_json *j, const uint8_t *at, uint32_t size)
{
    char *text = malloc((size_t)size + 1);
    j->failed |= !text;
    if (text) {
        memcpy(text, at, size);
        text[size] = 0;
    }
    kd_json_string(j, text);
    free(text);
}

static void write_element(kd_json *j, const kd_field_ref *ref, const uint8_t *value, uint32_t size)
{
    double numbers[16] = {0};
    kd_entity e;
    uint32_t word;
    switch (ref->type) {
    case KD_ENTITY:
        memcpy(&e, value + ref->offset, sizeof e);
        write_entity(j, e);
        return;
    case KD_STRING: write_text(j, value + ref->offset, size); return;
    case KD_ENUM:
        memcpy(&word, value + ref->offset, sizeof word);
        write_word(j, ref->field, word);
        return;
    default: break;
    }
    kd_field_load(ref, value, numbers);
    if (ref->numbers == 1) {
        write_number(j, ref, numbers[0]);
        return;
    }
    kd_json_array_begin(j);
    for (uint32_t i = 0; i < ref->numbers; i++)
        write_number(j, ref, numbers[i]);
    kd_json_array_end(j);
}

static void write_field(kd_json *j, const kd_component_desc *desc, const kd_field *f, const uint8_t *value)
{
    uint32_t elements = f->count ? f->count : 1, size = f->size / elements;
    kd_field_ref ref = {
        .desc = desc, .field = f, .type = f->type, .elements = 1, .numbers = kd_field_type_numbers(f->type)};
    kd_json_key(j, f->name);
    if (elements > 1)
        kd_json_array_begin(j);
    for (uint32_t i = 0; i < elements; i++) {
        ref.offset = f->offset + i * size;
        write_element(j, &ref, value, size);
    }
    if (elements > 1)
        kd_json_array_end(j);
}

static void write_value(kd_json *j, const kd_component_desc *desc, const void *value)
{
    kd_json_key(j, desc->name);
    if (!desc->size) {
        kd_json_bool(j, true); /* a tag */
        return;
    }
    if (!desc->field_count) {
        kd_json_null(j);
        return;
    }
    kd_json_object_begin(j);
    for (uint32_t i = 0; i < desc->field_count; i++)
        write_field(j, desc, &desc->fields[i], value);
    kd_json_object_end(j);
}

/* A pair of a relation: its target and, when it has one, its value. */
static void write_pair(kd_json *j, const kd_component_desc *desc, kd_entity target, const uint8_t *value)
{
    kd_json_object_begin(j);
    kd_json_key(j, "target");
    write_entity(j, target);
    if (desc->size)
        write_value(j, desc, value);
    kd_json_object_end(j);
}

static void write_relations(const kd_world *w, kd_json *j, kd_entity e)
{
    kd_json_key(j, "relations");
    kd_json_object_begin(j);
    for (uint32_t r = 0; r < w->relation_count; r++) {
        const kd_component_desc *desc = w->components[w->relation_ids[r]].desc;
        kd_entities targets = kd_targets_id(w, e, w->relation_ids[r]);
        const uint8_t *values = kd_target_values_id(w, e, w->relation_ids[r]);
        if (!targets.count)
            continue;
        kd_json_key(j, desc->name);
        kd_json_array_begin(j);
        for (uint32_t i = 0; i < targets.count; i++)
            write_pair(j, desc, targets.at[i], values ? values + (size_t)i * desc->size : NULL);
        kd_json_array_end(j);
    }
    kd_json_object_end(j);
}

static void write_row(const kd_world *w, kd_json *j, const ecs_table *t, uint32_t row)
{
    kd_entity e = ecs_entities(t)[row];
    const char *name = kd_get_name(w, e);
    kd_json_object_begin(j);
    kd_json_key(j, "entity");
    write_entity(j, e);
    if (*name) {
        kd_json_key(j, "name");
        kd_json_string(j, name);
    }
    if (t->depth) {
        kd_json_key(j, "parent");
        write_entity(j, ecs_parents(t)[row]);
    }
    kd_json_key(j, "components");
    kd_json_object_begin(j);
    for (kd_component_id id = 1; id <= kd_component_count(w); id++) {
        const void *value = kd_find_id(w, e, id);
        if (value && !w->components[id].relation)
            write_value(j, w->components[id].desc, value);
    }
    kd_json_object_end(j);
    if (w->pair_count)
        write_relations(w, j, e);
    kd_json_object_end(j);
}

void kd_world_write_json(const kd_world *w, kd_json *j)
{
    kd_json_object_begin(j);
    kd_json_key(j, "entities");
    kd_json_array_begin(j);
    for (uint32_t i = 0; i < w->head.table_count; i++)
        for (uint32_t row = 0; row < w->head.tables[i]->count; row++)
            write_row(w, j, w->head.tables[i], row);
    kd_json_array_end(j);
    kd_json_key(j, "singletons");
    kd_json_object_begin(j);
    for (kd_component_id id = 1; id <= kd_component_count(w); id++)
        if (kd_singleton_find(w, id))
            write_value(j, w->components[id].desc, kd_singleton_find(w, id));
    kd_json_object_end(j);
    kd_json_object_end(j);
}
