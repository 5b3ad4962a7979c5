#include "systems/bounce/sources.h"

#include <math.h>
#include <stdlib.h>

#include "components/frame.h"
#include "components/light.h"
#include "components/scene_store.h"
#include "components/sky.h"
#include "components/transform.h"
#include "components/voxel_scene.h"
#include "runtime/core/log.h"

static const float PI = 3.14159265f;
static const float SHARE_SEEN = 0.02f;  /* of all light: less may come and go unnoticed */
static const float SHARE_DRIFT = 0.2f;  /* of all light in one frame, by many small changes */
static const float SOURCE_JUMP = 0.5f;  /* of a source's light */
static const float PLACE_JUMP = 0.125f; /* of the finest cascade's width */

/* Sources that went and are looked for among those that came: more have jumped. */
enum { MOST_REPLACED = 1024 };

enum { KIND_LAMP, KIND_SKY, KIND_AMBIENT, KIND_GLOW };

static uint64_t key_of(unsigned kind, kd_entity e, uint32_t part)
{
    uint64_t h = ((uint64_t)e.generation << 32 | e.index) * 0x9E3779B97F4A7C15u;
    h = (h ^ h >> 29 ^ part) * 0xBF58476D1CE4E5B9u;
    return (uint64_t)kind << 62 | h >> 2;
}

static float luminance(kd_vec3 c)
{
    return kd_vec3_dot(c, (kd_vec3){0.2126f, 0.7152f, 0.0722f});
}

static void add(light_sources *s, uint64_t key, float flux, kd_vec3 place)
{
    if (!(flux > 0) || !isfinite(flux))
        return;
    if (s->now_count == s->now_capacity) {
        uint32_t capacity = s->now_capacity ? s->now_capacity * 2 : 64;
        light_source *grown = realloc(s->now, capacity * sizeof *grown);
        if (!grown)
            return; /* it then counts as gone: light begins anew, which is never wrong */
        s->now = grown;
        s->now_capacity = capacity;
    }
    s->now[s->now_count++] = (light_source){key, flux, {place.x, place.y, place.z}, false};
}

/* ---- kinds ---- */

static void add_lamps(light_sources *s, float width)
{
    for (kd_iter it = kd_query_iter(s->lights); kd_iter_next(&it);) {
        const kd_light *light = KD_COLUMN(&it, kd_light, 0);
        const kd_world_transform *world = KD_COLUMN(&it, kd_world_transform, 1);
        for (uint32_t i = 0; i < it.count; i++) {
            const float *m = world[i].matrix.m;
            bool far = light[i].type == KD_DIRECTIONAL;
            kd_vec3 place =
                far ? kd_vec3_scale((kd_vec3){m[8], m[9], m[10]}, width) : (kd_vec3){m[12], m[13], m[14]};
            float flux = luminance(light[i].color) * light[i].intensity * (far ? width * width : 4 * PI);
            add(s, key_of(KIND_LAMP, it.entities[i], 0), flux, place);
        }
    }
}

static void add_skies(light_sources *s, kd_world *w, const kd_frame *frame, float width)
{
    float area = PI * 6 * width * width;
    add(s, key_of(KIND_AMBIENT, KD_NO_ENTITY, 0), frame->settings.light_ambient * area, (kd_vec3){0});
    for (kd_iter it = kd_query_iter(s->skies); kd_iter_next(&it);) {
        const kd_sky *sky = KD_COLUMN(&it, kd_sky, 0);
        for (uint32_t i = 0; i < it.count; i++) {
            kd_vec3 mean = sky[i].image ? (kd_vec3){1, 1, 1}
                                        : kd_vec3_scale(kd_vec3_add(sky[i].zenith, sky[i].horizon), 0.5f);
            add(s, key_of(KIND_SKY, it.entities[i], sky[i].image), luminance(mean) * sky[i].intensity * area,
                (kd_vec3){0});
        }
    }
    kd_light sun;
    kd_mat4 at;
    if (kd_sky_sun_light(w, s->skies, &sun, &at))
        add(s, key_of(KIND_SKY, KD_NO_ENTITY, 0), luminance(sun.color) * sun.intensity * width * width,
            kd_vec3_scale((kd_vec3){at.m[8], at.m[9], at.m[10]}, width));
}

static void add_glowing(light_sources *s, const kd_voxel_scene *scene, const kd_scene_store *store)
{
    for (uint32_t i = 0; i < scene->object_count; i++) {
        const kd_voxel_object *o = &scene->objects[i];
        float radiance = o->alive ? luminance(store->materials[o->material].desc.emissive) : 0;
        if (radiance <= 0)
            continue;
        kd_vec3 e = kd_vec3_sub(o->bounds_max_ws, o->bounds_min_ws);
        float area = 2 * (e.x * e.y + e.y * e.z + e.z * e.x);
        uint32_t part =
            o->draw_primitive * 31 + (uint32_t)(o->tile.x * 73 + o->tile.y * 179 + o->tile.z * 283);
        add(s, key_of(KIND_GLOW, o->entity, part), PI * radiance * area,
            kd_vec3_scale(kd_vec3_add(o->bounds_min_ws, o->bounds_max_ws), 0.5f));
    }
}

/* ---- comparing ---- */

static int by_key(const void *a, const void *b)
{
    uint64_t x = ((const light_source *)a)->key, y = ((const light_source *)b)->key;
    return (x > y) - (x < y);
}

static float total(const light_source *list, uint32_t count)
{
    float sum = 0;
    for (uint32_t i = 0; i < count; i++)
        sum += list[i].flux;
    return sum;
}

/* Light of a source that is not what it was a frame ago. */
static float jump_of(const light_source *a, const light_source *b, float width)
{
    float most = fmaxf(a->flux, b->flux), change = fabsf(a->flux - b->flux), d2 = 0;
    for (int k = 0; k < 3; k++)
        d2 += (a->place_ws[k] - b->place_ws[k]) * (a->place_ws[k] - b->place_ws[k]);
    if (d2 > PLACE_JUMP * PLACE_JUMP * width * width)
        return most;
    return change > SOURCE_JUMP * most ? change : 0;
}

static bool same_kind(const light_source *a, const light_source *b)
{
    return a->key >> 62 == b->key >> 62;
}

/* A source that is new may stand for one that went, with the same light in the same place: a scenario that is
 * loaded anew makes its lamps again. Takes that one off the list. */
static bool replaces_one(light_source *gone, uint32_t *count, const light_source *is, float width)
{
    for (uint32_t i = 0; i < *count; i++) {
        if (!same_kind(&gone[i], is) || jump_of(&gone[i], is, width) > 0)
            continue;
        gone[i] = gone[--*count];
        return true;
    }
    return false;
}

/* Turns the list of the frame before into that of what went, which nobody needs after. */
static float jumps(light_sources *s, float width)
{
    float sum = 0;
    uint32_t a = 0, gone = 0;
    for (uint32_t b = 0; b < s->now_count; b++) {
        light_source *is = &s->now[b];
        while (a < s->before_count && s->before[a].key < is->key)
            s->before[gone++] = s->before[a++];
        is->fresh = a == s->before_count || s->before[a].key != is->key;
        if (!is->fresh)
            sum += jump_of(&s->before[a++], is, width);
    }
    while (a < s->before_count)
        s->before[gone++] = s->before[a++];
    bool few = gone <= MOST_REPLACED;
    for (uint32_t b = 0; b < s->now_count; b++)
        if (s->now[b].fresh && !(few && replaces_one(s->before, &gone, &s->now[b], width)))
            sum += s->now[b].flux;
    return sum + total(s->before, gone);
}

static void turn_over(light_sources *s)
{
    light_source *list = s->before;
    uint32_t capacity = s->before_capacity;
    s->before = s->now;
    s->before_count = s->now_count;
    s->before_capacity = s->now_capacity;
    s->now = list;
    s->now_count = 0;
    s->now_capacity = capacity;
    s->compared = true;
}

bool light_sources_jumped(light_sources *s, kd_world *world)
{
    const kd_voxel_scene *scene = kd_singleton(world, kd_voxel_scene);
    float width = scene->span_m * (float)scene->resolution;
    add_lamps(s, width);
    add_skies(s, world, kd_singleton(world, kd_frame), width);
    if (scene->brightest_emission > 0)
        add_glowing(s, scene, kd_singleton(world, kd_scene_store));
    if (s->now_count > 1) /* an empty list has no address, and qsort takes none */
        qsort(s->now, s->now_count, sizeof *s->now, by_key);
    float was = total(s->before, s->before_count), is = total(s->now, s->now_count), whole = fmaxf(was, is);
    bool jumped =
        s->compared && (fabsf(is - was) > SHARE_DRIFT * whole || jumps(s, width) > SHARE_SEEN * whole);
    turn_over(s);
    return jumped;
}

kd_status light_sources_init(light_sources *s, kd_world *world)
{
    s->lights =
        kd_query_make(world, &(kd_query_desc){.terms = {KD_READ(kd_light), KD_READ(kd_world_transform)},
                                              .name = "bounce.lights"});
    s->skies = kd_query_make(world, &(kd_query_desc){.terms = {KD_READ(kd_sky), KD_READ(kd_world_transform)},
                                                     .name = "bounce.skies"});
    return s->lights && s->skies ? KD_OK
                                 : kd_fail(KD_NO_MEMORY, "bounce: no memory for its queries; free some");
}

void light_sources_fini(light_sources *s)
{
    kd_query_destroy(s->lights);
    kd_query_destroy(s->skies);
    free(s->now);
    free(s->before);
    *s = (light_sources){0};
}
