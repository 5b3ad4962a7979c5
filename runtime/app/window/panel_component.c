/* Fields of a component, each by the widget of its kind: what reflection knows can be edited. */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "runtime/app/console.h"
#include "runtime/app/window/session.h"
#include "runtime/ecs/reflect.h"

enum { MAX_NUMBERS = 256, MAX_SHOWN = 16 };
#define DEG_PER_RAD 57.29577951308232

static bool is_angle(const kd_field *f)
{
    return f->unit && strcmp(f->unit, "rad") == 0;
}

/* Drag a number so far by a pixel: by its range if that says something, else by its size. */
static double drag_speed(const kd_field *f, const double *values, uint32_t count)
{
    double size = 0, range = f->max - f->min;
    for (uint32_t i = 0; i < count; i++)
        size = fmax(size, fabs(values[i]));
    if (range > 0 && range <= 10)
        return range * 0.004;
    return size > 0.1 ? size * 0.01 : 0.01;
}

static bool edit_flag(kd_ui *ui, const char *label, double *number)
{
    bool value = *number != 0;
    bool changed = kd_ui_check(ui, label, &value);
    *number = value;
    return changed;
}

static bool edit_word(kd_ui *ui, const char *label, const kd_field *f, double *number)
{
    uint32_t count = 0, index = (uint32_t)*number;
    while (f->enum_names[count])
        count++;
    bool changed = kd_ui_choose(ui, label, f->enum_names, count, &index);
    *number = index;
    return changed;
}

static bool edit_color(kd_ui *ui, const char *label, double *numbers)
{
    float rgb[3] = {(float)numbers[0], (float)numbers[1], (float)numbers[2]};
    bool changed = kd_ui_color(ui, label, rgb);
    for (int i = 0; i < 3; i++)
        numbers[i] = (double)rgb[i];
    return changed;
}

/* A quaternion is no thing for hands: three angles, about x, then y, then z. Source  Diebel 2006 */
static bool edit_rotation(kd_ui *ui, const char *label, double *q)
{
    double a[3] = {atan2(2 * (q[3] * q[0] + q[1] * q[2]), 1 - 2 * (q[0] * q[0] + q[1] * q[1])),
                   asin(fmax(-1, fmin(1, 2 * (q[3] * q[1] - q[2] * q[0])))),
                   atan2(2 * (q[3] * q[2] + q[0] * q[1]), 1 - 2 * (q[1] * q[1] + q[2] * q[2]))};
    for (int i = 0; i < 3; i++)
        a[i] *= DEG_PER_RAD;
    if (!kd_ui_numbers(ui, label, a, 3, 0.5, 0, 0, false))
        return false;
    double s[3], c[3];
    for (int i = 0; i < 3; i++) {
        s[i] = sin(a[i] / DEG_PER_RAD / 2);
        c[i] = cos(a[i] / DEG_PER_RAD / 2);
    }
    q[0] = s[0] * c[1] * c[2] - c[0] * s[1] * s[2];
    q[1] = c[0] * s[1] * c[2] + s[0] * c[1] * s[2];
    q[2] = c[0] * c[1] * s[2] - s[0] * s[1] * c[2];
    q[3] = c[0] * c[1] * c[2] + s[0] * s[1] * s[2];
    return true;
}

static bool edit_numbers(kd_ui *ui, const char *label, const kd_field *f, double *numbers, uint32_t count)
{
    bool whole = f->type == KD_I32 || f->type == KD_U32;
    double scale = is_angle(f) ? DEG_PER_RAD : 1, min = f->min * scale, max = f->max * scale;
    if (f->type == KD_U32 && min == max)
        max = 4294967295.0;
    for (uint32_t i = 0; i < count; i++)
        numbers[i] *= scale;
    double speed = scale != 1 ? 0.3 : whole ? 0.1 : drag_speed(f, numbers, count);
    bool changed = kd_ui_numbers(ui, label, numbers, count, speed, min, max, whole);
    for (uint32_t i = 0; i < count; i++)
        numbers[i] = scale != 1 && f->min != f->max ? fmin(fmax(numbers[i] / scale, f->min), f->max)
                                                    : numbers[i] / scale;
    return changed;
}

/* Edit one element of a field. */
static bool edit_element(kd_ui *ui, const char *label, const kd_field *f, double *numbers, uint32_t count)
{
    switch (f->type) {
    case KD_BOOL: return edit_flag(ui, label, numbers);
    case KD_ENUM: return edit_word(ui, label, f, numbers);
    case KD_COLOR: return edit_color(ui, label, numbers);
    case KD_QUAT: return edit_rotation(ui, label, numbers);
    case KD_MAT4: {
        bool changed = false;
        for (uint32_t i = 0; i < 4; i++) {
            kd_ui_id_begin(ui, i + 1);
            changed =
                kd_ui_numbers(ui, i ? "##column" : label, numbers + (size_t)i * 4, 4, 0.01, 0, 0, false) ||
                changed;
            kd_ui_id_end(ui);
        }
        return changed;
    }
    default: return edit_numbers(ui, label, f, numbers, count);
    }
}

static void label_of(const kd_field *f, uint32_t element, char *out, size_t size)
{
    const char *unit = f->type == KD_QUAT || is_angle(f) ? "deg" : f->unit;
    char place[16] = "";
    if (f->count > 1)
        snprintf(place, sizeof place, "[%u]", element);
    snprintf(out, size, "%s%s%s%s%s", f->name, place, unit ? " [" : "", unit ? unit : "", unit ? "]" : "");
}

/* Text and entities: shown, and texts edited. */
static void draw_words(window_session *s, kd_entity e, const kd_field_ref *ref)
{
    char text[256];
    kd_field_read_text(s->stage->world, e, ref, text, sizeof text);
    if (ref->type == KD_STRING && kd_ui_string(s->ui, ref->field->name, text, sizeof text)) {
        (void)kd_field_write_text(s->stage->world, e, ref, text);
        window_touch(s);
    } else if (ref->type != KD_STRING) {
        kd_ui_text(s->ui, "%s: %s", ref->field->name, *text ? text : "none");
    }
}

static void draw_field(window_session *s, kd_entity e, const kd_field_ref *ref)
{
    double numbers[MAX_NUMBERS];
    char label[96];
    bool changed = false;
    const kd_field *f = ref->field;
    uint32_t each = ref->elements ? ref->numbers / ref->elements : 0;
    if (!ref->numbers) {
        draw_words(s, e, ref);
        return;
    }
    if (ref->numbers > MAX_NUMBERS || kd_field_read(s->stage->world, e, ref, numbers, MAX_NUMBERS) != KD_OK)
        return;
    for (uint32_t i = 0; i < ref->elements && i < MAX_SHOWN; i++) {
        label_of(f, i, label, sizeof label);
        kd_ui_id_begin(s->ui, (uint64_t)i + 1000);
        changed = edit_element(s->ui, label, f, numbers + (size_t)i * each, each) || changed;
        kd_ui_id_end(s->ui);
        if (f->doc)
            kd_ui_hint(s->ui, f->doc);
    }
    if (ref->elements > MAX_SHOWN)
        kd_ui_text_dim(s->ui, "... and %u more", ref->elements - MAX_SHOWN);
    if (!changed)
        return;
    if (kd_field_write(s->stage->world, e, ref, numbers, ref->numbers) != KD_OK)
        app_console_recover();
    window_touch(s);
}

void window_panel_field(window_session *s, kd_entity e, kd_component_id id, const char *name)
{
    kd_field_ref ref;
    const kd_component_desc *desc = kd_component_info(s->stage->world, id);
    if (!kd_desc_field_find(desc, name, &ref))
        return;
    ref.component = id;
    ref.desc = desc;
    kd_ui_disabled_begin(s->ui, !app_may_write(desc->name, name));
    draw_field(s, e, &ref);
    kd_ui_disabled_end(s->ui);
}

void window_panel_component(window_session *s, kd_entity e, kd_component_id id)
{
    const kd_component_desc *desc = kd_component_info(s->stage->world, id);
    kd_ui_id_begin(s->ui, id);
    if (kd_ui_heading(s->ui, desc->name, app_may_write(desc->name, "")))
        for (uint32_t i = 0; i < desc->field_count; i++)
            window_panel_field(s, e, id, desc->fields[i].name);
    kd_ui_id_end(s->ui);
}
