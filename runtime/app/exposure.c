/* One track for each component that is mixed: what every entity had after the last step, by entity index, and
 * the list of those who had something else after the step before. Only rows that the world has stamped are
 * looked at. */
#include "runtime/app/exposure.h"

#include <stdlib.h>
#include <string.h>

#include "components/camera.h"
#include "components/light.h"
#include "components/mesh_instance.h"
#include "components/transform.h"
#include "runtime/core/log.h"
#include "runtime/ecs/query.h"

/* ---- what is mixed ---- */

static float mix(float a, float b, float t)
{
    return a + (b - a) * t;
}

static kd_vec3 mix3(kd_vec3 a, kd_vec3 b, float t)
{
    return (kd_vec3){mix(a.x, b.x, t), mix(a.y, b.y, t), mix(a.z, b.z, t)};
}

static void mix_transform(void *to, const void *from, float t)
{
    kd_transform *b = to;
    const kd_transform *a = from;
    b->position = mix3(a->position, b->position, t);
    b->rotation = kd_quat_slerp(a->rotation, b->rotation, t);
    b->scale = mix3(a->scale, b->scale, t);
}

static void mix_camera(void *to, const void *from, float t)
{
    kd_camera *b = to;
    const kd_camera *a = from;
    b->fov_y = mix(a->fov_y, b->fov_y, t);
    b->y_mag = mix(a->y_mag, b->y_mag, t);
    b->z_near = mix(a->z_near, b->z_near, t);
    b->z_far = mix(a->z_far, b->z_far, t);
}

static void mix_light(void *to, const void *from, float t)
{
    kd_light *b = to;
    const kd_light *a = from;
    b->color = mix3(a->color, b->color, t);
    b->intensity = mix(a->intensity, b->intensity, t);
    b->inner_cone = mix(a->inner_cone, b->inner_cone, t);
    b->outer_cone = mix(a->outer_cone, b->outer_cone, t);
}

static void mix_weights(void *to, const void *from, float t)
{
    kd_morph_weights *b = to;
    const kd_morph_weights *a = from;
    for (uint32_t i = 0; i < KD_MAX_MORPH_TARGETS; i++)
        b->weights[i] = mix(a->weights[i], b->weights[i], t);
}

static const struct {
    const kd_component_desc *desc;
    size_t size;
    void (*mix)(void *to, const void *from, float t); /* `to` holds the later one */
} kinds[] = {{&kd_transform_desc, sizeof(kd_transform), mix_transform},
             {&kd_camera_desc, sizeof(kd_camera), mix_camera},
             {&kd_light_desc, sizeof(kd_light), mix_light},
             {&kd_morph_weights_desc, sizeof(kd_morph_weights), mix_weights}};
enum { KIND_COUNT = sizeof kinds / sizeof *kinds };

/* ---- tracks ---- */

typedef struct track {
    kd_query *query;
    kd_component_id id;
    uint32_t *generations; /* [capacity] of the entities that are known; 0: none */
    uint8_t *known;        /* [capacity] values after the last step */
    uint32_t capacity;
    kd_entity *moving; /* [moving_count] */
    uint8_t *before;   /* [moving_count] their values after the step before */
    uint32_t moving_count, moving_capacity;
} track;

struct app_exposure {
    kd_world *world;
    track tracks[KIND_COUNT];
    uint64_t version; /* of the world when it was last noted */
};

/* Make room for a value behind each of two arrays of equal length; half as much again is kept free. */
static bool reserve(void **first, size_t first_size, uint8_t **second, size_t second_size, uint32_t *capacity,
                    uint32_t needed)
{
    if (needed <= *capacity)
        return true;
    uint32_t more = needed + needed / 2 + 16;
    void *a = realloc(*first, more * first_size);
    *first = a ? a : *first;
    uint8_t *b = realloc(*second, more * second_size);
    *second = b ? b : *second;
    if (!a || !b)
        return false;
    memset((uint8_t *)a + *capacity * first_size, 0, (more - *capacity) * first_size);
    *capacity = more;
    return true;
}

static bool note_row(track *t, size_t size, kd_entity e, const void *value)
{
    if (!reserve((void **)&t->generations, sizeof *t->generations, &t->known, size, &t->capacity,
                 e.index + 1))
        return false;
    uint8_t *known = t->known + e.index * size;
    if (t->generations[e.index] == e.generation && memcmp(known, value, size) != 0) {
        if (!reserve((void **)&t->moving, sizeof *t->moving, &t->before, size, &t->moving_capacity,
                     t->moving_count + 1))
            return false;
        t->moving[t->moving_count] = e;
        memcpy(t->before + t->moving_count++ * size, known, size);
    }
    t->generations[e.index] = e.generation;
    memcpy(known, value, size);
    return true;
}

static bool note_track(track *t, size_t size, uint64_t version)
{
    bool noted = true;
    kd_iter it = kd_query_iter(t->query);
    it.changed_since = version;
    t->moving_count = 0;
    while (kd_iter_next(&it)) {
        const uint8_t *values = it.columns[0];
        for (uint32_t i = 0; i < it.count; i++)
            noted = note_row(t, size, it.entities[i], values + i * size) && noted;
    }
    return noted;
}

kd_status app_exposure_note(app_exposure *x)
{
    bool noted = true;
    for (int i = 0; i < KIND_COUNT; i++)
        noted = note_track(&x->tracks[i], kinds[i].size, x->version) && noted;
    x->version = kd_world_version(x->world);
    return noted ? KD_OK : kd_fail(KD_NO_MEMORY, "out of memory for what moves; film without sub-frames");
}

static void show_track(kd_world *w, const track *t, int kind, float share)
{
    size_t size = kinds[kind].size;
    for (uint32_t i = 0; i < t->moving_count; i++) {
        void *value = kd_find_mut_id(w, t->moving[i], t->id);
        if (!value)
            continue;
        memcpy(value, t->known + t->moving[i].index * size, size);
        if (share < 1)
            kinds[kind].mix(value, t->before + i * size, share);
    }
}

void app_exposure_show(app_exposure *x, float share)
{
    for (int i = 0; i < KIND_COUNT; i++)
        show_track(x->world, &x->tracks[i], i, share);
}

kd_status app_exposure_make(kd_world *w, app_exposure **out)
{
    app_exposure *x = calloc(1, sizeof *x);
    *out = x;
    bool made = x != NULL;
    for (int i = 0; made && i < KIND_COUNT; i++) {
        x->world = w;
        x->tracks[i].id = kd_component_ensure(w, kinds[i].desc);
        x->tracks[i].query =
            kd_query_make(w, &(kd_query_desc){.terms = {{.kind = KD_TERM_READ, .desc = kinds[i].desc}},
                                              .name = "exposure"});
        made = x->tracks[i].query != NULL;
    }
    return made ? KD_OK : kd_fail(KD_NO_MEMORY, "out of memory");
}

void app_exposure_destroy(app_exposure *x)
{
    for (int i = 0; x && i < KIND_COUNT; i++) {
        if (x->tracks[i].query)
            kd_query_destroy(x->tracks[i].query);
        free(x->tracks[i].generations);
        free(x->tracks[i].known);
        free(x->tracks[i].moving);
        free(x->tracks[i].before);
    }
    free(x);
}
