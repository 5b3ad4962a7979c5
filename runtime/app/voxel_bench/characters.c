/* A crowd of skinned characters, doubled from one to 256: all their voxels are transformed and the tree is
 * rebuilt every frame. The crowd stands in a square that the cascades just hold, the first in its middle. */
#include <math.h>
#include <stdio.h>

#include "components/animation.h"
#include "components/scene_store.h"
#include "components/transform.h"
#include "runtime/app/voxel_bench/internal.h"
#include "runtime/core/log.h"
#include "systems/scene/scene.h"

#define DEFAULT_MODEL "samples/assets/walker.gltf"
#define CROWD_SHARE   0.94f /* of the outermost cascade's edge: bends and steps stay inside */
enum { MOST = 256, SIDE = 16, DOUBLINGS = 9 };

typedef struct crowd {
    rig r;
    uint32_t model, count;
    float spacing_m, scale;
} crowd;

/* Cell i of a square spiral round the origin. */
static void spiral(uint32_t i, int32_t *x, int32_t *z)
{
    int32_t dx = 1, dz = 0, run = 1, left = 1, turns = 0;
    *x = *z = 0;
    for (; i > 0; i--) {
        *x += dx;
        *z += dz;
        if (--left > 0)
            continue;
        int32_t old = dx;
        dx = -dz;
        dz = old;
        run += ++turns % 2 == 0;
        left = run;
    }
}

/* Each stands in its own cell of the square, and starts its clip at another time. */
static kd_status add_one(crowd *c)
{
    int32_t x, z;
    kd_entity root;
    kd_world *w = c->r.world;
    spiral(c->count, &x, &z);
    kd_status status = kd_scene_instantiate(w, c->model, KD_NO_ENTITY, NULL, &root);
    if (status != KD_OK)
        return status;
    kd_transform *t = kd_find_mut(w, root, kd_transform);
    if (!t)
        return kd_fail(KD_UNSUPPORTED, "a character's root has no transform");
    t->position = (kd_vec3){(float)x * c->spacing_m, 0, (float)z * c->spacing_m};
    t->scale = (kd_vec3){c->scale, c->scale, c->scale};
    kd_animation *animation = kd_find_mut(w, root, kd_animation);
    if (animation)
        animation->time_s = 0.137f * (float)c->count;
    c->count++;
    return KD_OK;
}

/* The scene is the model alone, which shows how large it is; then the first of the crowd takes its place. */
static kd_status open_crowd(crowd *c, const voxel_bench *b, const char *model)
{
    kd_entity camera;
    static const char *const sets[] = {"voxels.span=0.01", "voxels.resolution=256", "voxels.cascades=3",
                                       NULL};
    kd_status status = rig_open(&c->r, b->options, model, sets);
    if (status != KD_OK)
        return status;
    status = rig_run(&c->r, 1);
    const kd_draw_list *list = kd_singleton(c->r.world, kd_draw_list);
    kd_vec3 size = kd_vec3_sub(list->bounds_max_ws, list->bounds_min_ws);
    const kd_settings *s = &c->r.scene.settings;
    float outermost = s->voxels_span * (float)s->voxels_resolution * (float)(1 << (s->voxels_cascades - 1));
    c->spacing_m = CROWD_SHARE * outermost / SIDE;
    c->scale = c->spacing_m / fmaxf(fmaxf(size.x, size.z), 0.5f * size.y);
    if (status == KD_OK)
        status = app_scene_model(&c->r.scene, model, &(kd_model_options){0}, &c->model);
    if (status == KD_OK)
        status = rig_hide_all(&c->r);
    kd_vec3 eye = {0, 0.5f * c->scale * size.y, 0};
    return status == KD_OK ? rig_take_camera(&c->r, eye, (kd_vec3){0, eye.y, -1}, &camera) : status;
}

kd_status voxel_bench_characters(const voxel_bench *b)
{
    const char *model = b->options->bench_model ? b->options->bench_model : DEFAULT_MODEL;
    rig_figures rows[DOUBLINGS];
    char name[32];
    uint32_t count = 0;
    crowd c = {0};
    if (!voxel_bench_wanted(b, "characters"))
        return KD_OK;
    kd_status status = open_crowd(&c, b, model);
    if (status != KD_OK)
        return status;
    printf("\n%s, each %.2f m wide\n", model, (double)c.spacing_m);
    voxel_bench_head("characters");
    uint32_t only = b->options->bench_n;
    for (uint32_t n = only ? only : 1; n <= (only ? only : MOST) && status == KD_OK; n *= 2) {
        while (c.count < n && status == KD_OK)
            status = add_one(&c);
        if (status == KD_OK)
            status = rig_run(&c.r, VOXEL_BENCH_WARM_UP);
        if (status == KD_OK)
            status = rig_measure(&c.r, b->frames, NULL, NULL, &rows[count]);
        snprintf(name, sizeof name, "characters/%u", n);
        if (status == KD_OK)
            voxel_bench_row(b, name, name + 11, &rows[count++]);
    }
    rig_close(&c.r);
    if (status == KD_OK) {
        voxel_bench_fit(b, "characters", rows, count);
        voxel_bench_traffic(b, "characters", &rows[count - 1]);
    }
    return status;
}
