/* One layer against two, while the camera flies through the scene at 50 m/s: with one everything is rebuilt
 * every frame, with two only what the cascades uncover. Then two layers with more and more static voxels:
 * smaller ones, and the same hall again and again outside the cascades. */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "components/mesh_instance.h"
#include "components/scene_store.h"
#include "components/transform.h"
#include "runtime/app/voxel_bench/internal.h"
#include "runtime/core/log.h"
#include "runtime/ecs/query.h"
#include "systems/scene/scene.h"

#define SPEED_M_S 50.0f
#define FPS       30.0f

/* To and fro along the longest level axis of the scene, 20 % from its ends, 40 % up. */
typedef struct flight {
    kd_vec3 from, to;
    kd_entity camera;
    float at_m;
} flight;

static void place(rig *r, flight *f)
{
    kd_vec3 way = kd_vec3_sub(f->to, f->from);
    float length = kd_vec3_length(way), turn = fmodf(f->at_m, 2 * length);
    float along = turn <= length ? turn : 2 * length - turn;
    kd_transform *t = kd_find_mut(r->world, f->camera, kd_transform);
    if (t && length > 0)
        t->position = kd_vec3_add(f->from, kd_vec3_scale(way, along / length));
}

static void fly(rig *r, void *user)
{
    flight *f = user;
    f->at_m += SPEED_M_S / FPS;
    place(r, f);
}

static kd_status begin_flight(rig *r, flight *f)
{
    const kd_draw_list *list = kd_singleton(r->world, kd_draw_list);
    kd_vec3 low = list->bounds_min_ws, size = kd_vec3_sub(list->bounds_max_ws, low);
    kd_vec3 start = {0.5f, 0.4f, 0.5f}, end = start;
    if (size.x >= size.z)
        start.x = 0.2f, end.x = 0.8f;
    else
        start.z = 0.2f, end.z = 0.8f;
    *f = (flight){.from = {low.x + start.x * size.x, low.y + start.y * size.y, low.z + start.z * size.z},
                  .to = {low.x + end.x * size.x, low.y + end.y * size.y, low.z + end.z * size.z}};
    return rig_take_camera(r, f->from, f->to, &f->camera);
}

/* ---- more halls ---- */

static kd_entity root_of(kd_world *w, kd_entity e)
{
    for (kd_entity up = kd_get_parent(w, e); up.generation; up = kd_get_parent(w, up))
        e = up;
    return e;
}

/* Roots of what is drawn, each once. Returns how many; at most `capacity`. */
static uint32_t find_roots(rig *r, kd_entity *roots, uint32_t capacity)
{
    kd_query *q = kd_query_make(r->world, &(kd_query_desc){.terms = {KD_READ(kd_mesh_instance)}});
    uint32_t count = 0;
    if (!q)
        return 0;
    for (kd_iter it = kd_query_iter(q); kd_iter_next(&it);)
        for (uint32_t i = 0; i < it.count; i++) {
            kd_entity root = root_of(r->world, it.entities[i]);
            uint32_t k = 0;
            while (k < count && roots[k].index != root.index)
                k++;
            if (k == count && count < capacity)
                roots[count++] = root;
        }
    kd_query_destroy(q);
    return count;
}

/* Copies of all that is drawn, above each other and far from every cascade. */
static kd_status add_halls(rig *r, uint32_t halls)
{
    enum { MOST = 256 };
    kd_entity roots[MOST];
    const kd_draw_list *list = kd_singleton(r->world, kd_draw_list);
    kd_vec3 size = kd_vec3_sub(list->bounds_max_ws, list->bounds_min_ws);
    const kd_settings *s = &r->scene.settings;
    float outermost = s->voxels_span * (float)(s->voxels_resolution << (s->voxels_cascades - 1));
    float apart = size.y + 2 * outermost;
    uint32_t count = find_roots(r, roots, MOST);
    kd_status status = KD_OK;
    for (uint32_t h = 1; h < halls; h++) {
        kd_entity hall =
            kd_spawn(r->world, KD_VAL(kd_transform, {{0, apart * (float)h, 0}, {0, 0, 0, 1}, {1, 1, 1}}),
                     KD_TAG(kd_world_transform));
        for (uint32_t i = 0; i < count && status == KD_OK; i++) {
            kd_entity copy;
            status = kd_scene_clone(r->world, roots[i], hall, &copy);
        }
    }
    return status;
}

/* ---- cases ---- */

typedef struct layers_case {
    const char *name;
    bool one_layer, flies;
    float finer;    /* spans are divided by it */
    uint32_t halls; /* in the world, the scene's own among them */
} layers_case;

static const layers_case cases[] = {
    {"layers/one_flies", true, true, 1, 1},
    {"layers/two_flies", false, true, 1, 1},
    {"layers/two_flies_coarse", false, true, 0.8f, 1},
    {"layers/two_flies_fine", false, true, 1.4f, 1},
    {"layers/two_flies_2_halls", false, true, 1, 2},
    {"layers/two_flies_4_halls", false, true, 1, 4},
    {"layers/two_rests_coarse", false, false, 0.8f, 1},
    {"layers/two_rests", false, false, 1, 1},
    {"layers/two_rests_fine", false, false, 1.4f, 1},
};
enum { CASES = sizeof cases / sizeof *cases };

/* The pace of a flight is the same whatever the scenario's: a frame is a thirtieth of a second. */
static kd_status measure(const voxel_bench *b, const layers_case *c, rig_figures *f)
{
    rig r;
    flight path;
    char span[48];
    const char *sets[] = {c->one_layer ? "svo.layers=one" : "svo.layers=two", span, NULL};
    snprintf(span, sizeof span, "voxels.span=%.9g", b->span_m / (double)c->finer);
    kd_status status = rig_open(&r, b->options, b->scene, sets);
    if (status != KD_OK)
        return status;
    status = rig_run(&r, 1);
    if (status == KD_OK)
        status = add_halls(&r, c->halls);
    if (status == KD_OK)
        status = begin_flight(&r, &path);
    if (status == KD_OK)
        status = rig_measure(&r, VOXEL_BENCH_WARM_UP, c->flies ? fly : NULL, &path, f);
    if (status == KD_OK)
        status = rig_measure(&r, b->frames, c->flies ? fly : NULL, &path, f);
    rig_close(&r);
    return status;
}

/* Of up to a hundred frames the slowest is the 99th percentile. */
static void say_evenness(const voxel_bench *b, const layers_case *c, const rig_figures *f)
{
    char name[64];
    double ratio = f->frame.median_ms > 0 ? f->frame.max_ms / f->frame.median_ms : 0;
    printf("    frames: median %.1f ms, slowest %.1f ms (%.2f times the median)\n", f->frame.median_ms,
           f->frame.max_ms, ratio);
    snprintf(name, sizeof name, "%s_slowest", c->name);
    voxel_bench_value(b, name, f->voxels, "times", ratio, 0);
}

kd_status voxel_bench_layers(const voxel_bench *b)
{
    rig_figures rows[CASES];
    bool done[CASES] = {false}, begun = false;
    kd_status status = KD_OK;
    for (uint32_t i = 0; i < CASES && status == KD_OK; i++) {
        if (!voxel_bench_wanted(b, cases[i].name))
            continue;
        status = measure(b, &cases[i], &rows[i]);
        if (status != KD_OK)
            break;
        if (!begun)
            voxel_bench_head("layers, camera at 50 m/s");
        begun = done[i] = true;
        voxel_bench_row(b, cases[i].name, strchr(cases[i].name, '/') + 1, &rows[i]);
        if (cases[i].flies)
            say_evenness(b, &cases[i], &rows[i]);
    }
    if (status == KD_OK && done[0] && done[1]) {
        double ratio = rig_total_ms(&rows[0]) / rig_total_ms(&rows[1]);
        printf("two layers take %.1f times less than one\n", ratio);
        voxel_bench_value(b, "layers/ratio", rows[1].voxels, "times", ratio, 0);
    }
    return status;
}
