/* Reading and writing the values of fields, with their checks. */

#include <float.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "runtime/ecs/internal.h"
#include "runtime/ecs/reflect.h"

#define MAX_NUMBERS 1024u /* of one field: 64 matrices */

/* ---- numbers in memory ---- */
static double load_number(kd_field_type type, const uint8_t *at)
{
    uint32_t u;
    int32_t i;
    float f;
    switch (type) {
    case KD_BOOL: return *at != 0;
    case KD_I32: memcpy(&i, at, sizeof i); return i;
    case KD_U32:
    case KD_ENUM: memcpy(&u, at, sizeof u); return u;
    default: memcpy(&f, at, sizeof f); return (double)f;
    }
}

static void store_number(kd_field_type type, uint8_t *at, double number)
{
    uint32_t u;
    int32_t i;
    float f;
    switch (type) {
    case KD_BOOL: *at = number != 0; break;
    case KD_I32:
        i = (int32_t)number;
        memcpy(at, &i, sizeof i);
        break;
    case KD_U32:
    case KD_ENUM:
        u = (uint32_t)number;
        memcpy(at, &u, sizeof u);
        break;
    default:
        f = (float)number;
        memcpy(at, &f, sizeof f);
        break;
    }
}

static uint32_t number_bytes(kd_field_type type)
{
    return type == KD_BOOL ? 1 : 4;
}

void kd_field_load(const kd_field_ref *ref, const void *component, double *numbers)
{
    const uint8_t *at = (const uint8_t *)component + ref->offset;
    for (uint32_t i = 0; i < ref->numbers; i++, at += number_bytes(ref->type))
        numbers[i] = load_number(ref->type, at);
}

/* ---- checks ---- */
static uint32_t enum_count(const kd_field *f)
{
    uint32_t count = 0;
    while (f->enum_names && f->enum_names[count])
        count++;
    return count;
}

static void type_limits(const kd_field_ref *ref, double *low, double *high)
{
    const kd_field *f = ref->field;
    *low = ref->type == KD_I32                           ? (double)INT32_MIN
           : ref->type == KD_F32 || ref->type >= KD_VEC2 ? -(double)FLT_MAX
                                                         : 0;
    *high = ref->type == KD_I32   ? (double)INT32_MAX
            : ref->type == KD_U32 ? (double)UINT32_MAX
                                  : (double)FLT_MAX;
    if (ref->type == KD_BOOL)
        *high = 1;
    if (ref->type == KD_ENUM) {
        *low = 0;
        *high = enum_count(f) ? enum_count(f) - 1 : (double)UINT32_MAX;
    }
    if ((f->min != 0 || f->max != 0) && ref->type != KD_ENUM && ref->type != KD_BOOL) {
        *low = f->min > *low ? f->min : *low;
        *high = f->max < *high ? f->max : *high;
    }
}

static kd_status check_number(const kd_field_ref *ref, double number)
{
    const char *component = ref->desc->name, *field = ref->field->name, *unit = ref->field->unit;
    bool whole = ref->type == KD_I32 || ref->type == KD_U32 || ref->type == KD_ENUM || ref->type == KD_BOOL;
    double low, high;
    type_limits(ref, &low, &high);
    if (!isfinite(number))
        return kd_fail(KD_OUT_OF_RANGE, "%s.%s: a value is not finite; give a number", component, field);
    if (whole && number != floor(number))
        return kd_fail(KD_OUT_OF_RANGE, "%s.%s: %g is not whole; give an integer", component, field, number);
    if (number < low || number > high)
        return kd_fail(KD_OUT_OF_RANGE, "%s.%s: %g is out of range; give a value from %g to %g%s%s",
                       component, field, number, low, high, unit ? " " : "", unit ? unit : "");
    return KD_OK;
}

kd_status kd_field_store(const kd_field_ref *ref, void *component, const double *numbers, uint32_t count)
{
    bool spread =
        count == 1 && ref->numbers > 1 && ref->elements == 1 && ref->type != KD_MAT4 && ref->type != KD_QUAT;
    if (!ref->numbers)
        return kd_fail(KD_BAD_FORMAT, "%s.%s: takes %s, not numbers", ref->desc->name, ref->field->name,
                       ref->type == KD_STRING ? "a text" : "an entity");
    if (count != ref->numbers && !spread)
        return kd_fail(KD_OUT_OF_RANGE, "%s.%s: takes %u numbers, not %u", ref->desc->name, ref->field->name,
                       ref->numbers, count);
    for (uint32_t i = 0; i < count; i++) {
        kd_status status = check_number(ref, numbers[i]);
        if (status)
            return status;
    }
    uint8_t *at = (uint8_t *)component + ref->offset;
    for (uint32_t i = 0; i < ref->numbers; i++, at += number_bytes(ref->type))
        store_number(ref->type, at, numbers[spread ? 0 : i]);
    return KD_OK;
}

/* ---- text ---- */
static kd_status store_string(const kd_field_ref *ref, void *component, const char *text)
{
    size_t size = ref->field->size / (ref->field->count ? ref->field->count : 1), length = strlen(text);
    if (length >= size)
        return kd_fail(KD_TOO_LARGE, "%s.%s: the text has %zu bytes; give at most %zu", ref->desc->name,
                       ref->field->name, length, size - 1);
    uint8_t *at = (uint8_t *)component + ref->offset;
    memset(at, 0, size); /* what was behind a longer text must not stay */
    memcpy(at, text, length);
    return KD_OK;
}

static kd_status no_word(const kd_field_ref *ref, const char *text)
{
    char words[512] = "";
    size_t used = 0;
    const char *const *names = ref->field->enum_names;
    for (uint32_t i = 0; i < enum_count(ref->field) && used < sizeof words; i++)
        used += (size_t)snprintf(words + used, sizeof words - used, " %s", names[i]);
    return kd_fail(KD_OUT_OF_RANGE, "%s.%s: \"%s\" is not one of its words; choose one of:%s",
                   ref->desc->name, ref->field->name, text, words);
}

/* Numbers separated by commas or blanks, perhaps in brackets; returns how many, UINT32_MAX when something
 * else is there. */
static uint32_t parse_numbers(const char *text, double *numbers, uint32_t capacity)
{
    uint32_t count = 0;
    for (;;) {
        text += strspn(text, " \t,[]{}()");
        if (!*text)
            return count;
        char *end;
        double number = strtod(text, &end);
        if (end == text || count == capacity)
            return UINT32_MAX;
        numbers[count++] = number;
        text = end;
    }
}

kd_status kd_field_store_text(const kd_field_ref *ref, void *component, const char *text)
{
    double numbers[MAX_NUMBERS];
    if (ref->type == KD_STRING)
        return store_string(ref, component, text);
    int word = ref->type == KD_ENUM && ref->elements == 1 ? kd_field_enum_find(ref->field, text) : -1;
    if (ref->type == KD_BOOL && (!strcmp(text, "true") || !strcmp(text, "on")))
        word = 1;
    if (ref->type == KD_BOOL && (!strcmp(text, "false") || !strcmp(text, "off")))
        word = 0;
    if (word >= 0)
        return kd_field_store(ref, component, &(double){word}, 1);
    uint32_t count = parse_numbers(text, numbers, MAX_NUMBERS);
    if (count == UINT32_MAX || !count)
        return ref->type == KD_ENUM
                   ? no_word(ref, text)
                   : kd_fail(KD_BAD_FORMAT, "%s.%s: \"%s\" is not %s; give %u of them, separated by commas",
                             ref->desc->name, ref->field->name, text,
                             ref->type == KD_BOOL ? "true or false" : "a list of numbers", ref->numbers);
    return kd_field_store(ref, component, numbers, count);
}

/* ---- values of an entity ---- */
/* The component's value, stamped as changed when it will be written; NULL after a message. */
static void *value_of(kd_world *w, kd_entity e, const kd_field_ref *ref, bool write)
{
    void *value;
    if (!e.generation)
        value = kd_singleton_ensure(w, ref->desc);
    else
        value = write ? kd_find_mut_id(w, e, ref->component)
                      : (void *)(uintptr_t)kd_find_id(w, e, ref->component);
    if (!value)
        kd_fail(KD_NOT_FOUND, "%s: entity %s has no %s; give it one first", ref->desc->name,
                *kd_get_name(w, e) ? kd_get_name(w, e)
                : kd_alive(w, e)   ? "without a name"
                                   : "(destroyed)",
                ref->desc->name);
    return value;
}

kd_status kd_field_read(kd_world *w, kd_entity e, const kd_field_ref *ref, double *numbers, uint32_t capacity)
{
    const void *value = value_of(w, e, ref, false);
    if (!value)
        return KD_NOT_FOUND;
    if (!ref->numbers || capacity < ref->numbers)
        return KD_OUT_OF_RANGE;
    kd_field_load(ref, value, numbers);
    return KD_OK;
}

kd_status kd_field_write(kd_world *w, kd_entity e, const kd_field_ref *ref, const double *numbers,
                         uint32_t count)
{
    void *value = value_of(w, e, ref, true);
    return value ? kd_field_store(ref, value, numbers, count) : KD_NOT_FOUND;
}

kd_status kd_field_read_entity(kd_world *w, kd_entity e, const kd_field_ref *ref, uint32_t index,
                               kd_entity *value)
{
    const uint8_t *component = value_of(w, e, ref, false);
    if (!component)
        return KD_NOT_FOUND;
    if (ref->type != KD_ENTITY || index >= ref->elements)
        return KD_OUT_OF_RANGE;
    memcpy(value, component + ref->offset + index * sizeof *value, sizeof *value);
    return KD_OK;
}

kd_status kd_field_write_entity(kd_world *w, kd_entity e, const kd_field_ref *ref, uint32_t index,
                                kd_entity value)
{
    uint8_t *component = value_of(w, e, ref, true);
    if (!component)
        return KD_NOT_FOUND;
    if (ref->type != KD_ENTITY || index >= ref->elements)
        return kd_fail(KD_BAD_FORMAT, "%s.%s: takes no entity", ref->desc->name, ref->field->name);
    memcpy(component + ref->offset + index * sizeof value, &value, sizeof value);
    return KD_OK;
}

static void write_numbers(const kd_field_ref *ref, const void *component, char *out, size_t out_size)
{
    double numbers[MAX_NUMBERS];
    size_t used = 0;
    if (ref->numbers > MAX_NUMBERS)
        return;
    kd_field_load(ref, component, numbers);
    for (uint32_t i = 0; i < ref->numbers && used < out_size; i++)
        used += (size_t)snprintf(out + used, out_size - used, "%s%.9g", i ? "," : "", numbers[i]);
}

const char *kd_field_read_text(kd_world *w, kd_entity e, const kd_field_ref *ref, char *out, size_t out_size)
{
    const uint8_t *component = value_of(w, e, ref, false);
    out[0] = 0;
    if (!component)
        return out;
    if (ref->type == KD_STRING) {
        snprintf(out, out_size, "%.*s", (int)(ref->field->size / (ref->field->count ? ref->field->count : 1)),
                 (const char *)component + ref->offset);
    } else if (ref->type == KD_ENTITY) {
        kd_entity value;
        memcpy(&value, component + ref->offset, sizeof value);
        snprintf(out, out_size, "%s", kd_get_name(w, value));
    } else if (ref->type == KD_BOOL && ref->elements == 1) {
        snprintf(out, out_size, "%s", component[ref->offset] ? "true" : "false");
    } else if (ref->type == KD_ENUM && ref->elements == 1 &&
               load_number(KD_ENUM, component + ref->offset) < enum_count(ref->field)) {
        snprintf(out, out_size, "%s",
                 ref->field->enum_names[(uint32_t)load_number(KD_ENUM, component + ref->offset)]);
    } else {
        write_numbers(ref, component, out, out_size);
    }
    return out;
}

kd_status kd_field_write_text(kd_world *w, kd_entity e, const kd_field_ref *ref, const char *text)
{
    if (ref->type == KD_ENTITY) {
        kd_entity value = kd_find_named(w, text);
        if (*text && !value.generation)
            return kd_fail(KD_NOT_FOUND, "%s.%s: no entity has the name \"%s\"; give the name of one",
                           ref->desc->name, ref->field->name, text);
        return kd_field_write_entity(w, e, ref, 0, value);
    }
    void *value = value_of(w, e, ref, true);
    return value ? kd_field_store_text(ref, value, text) : KD_NOT_FOUND;
}
