/* A bare model as a scene: framed when it brings no camera, lit unless it brings light or shines into its own
 * rooms, turned when it is small and does not move by itself. */
#include <math.h>

#include "components/camera.h"
#include "components/light.h"
#include "components/transform.h"
#include "runtime/app/model_survey.h"
#include "runtime/app/scene.h"
#include "runtime/core/log.h"

#define ORBIT_FOV_Y 0.6981317f /* 40 degrees */
#define HALL_FOV_Y  1.0471976f /* 60 degrees */
#define SUN_LX      4.0f
#define LAMP_LX     2.0f
#define SKY         0.3f
#define HALL_EV     2.5f /* most of a hall is in shade, and seen by what bounces */

/* Rotation that takes -Z to the target and +Y upwards; never asked to look straight up or down. */
static kd_quat look_at(kd_vec3 from, kd_vec3 to)
{
    mat4 m;
    versor q;
    kd_vec3 back = kd_vec3_normalize(kd_vec3_sub(from, to), (kd_vec3){0, 0, 1});
    kd_vec3 right = kd_vec3_normalize(kd_vec3_cross((kd_vec3){0, 1, 0}, back), (kd_vec3){1, 0, 0});
    kd_vec3 up = kd_vec3_cross(back, right);
    glm_mat4_identity(m);
    memcpy(m[0], &right, sizeof right);
    memcpy(m[1], &up, sizeof up);
    memcpy(m[2], &back, sizeof back);
    glm_mat4_quat(m, q);
    return (kd_quat){q[0], q[1], q[2], q[3]};
}

static void add_camera(app_scene *scene, kd_vec3 eye, kd_vec3 target, float fov_y, float scale)
{
    kd_world *w = scene->world;
    kd_entity e = kd_spawn(
        w, KD_VAL(kd_transform, {.position = eye, .rotation = look_at(eye, target), .scale = {1, 1, 1}}),
        KD_TAG(kd_world_transform),
        KD_VAL(kd_camera, {.fov_y = fov_y, .y_mag = 1, .z_near = scale * 0.005f, .z_far = scale * 20}));
    kd_set_name(w, e, "camera");
}

/* Distance at which a sphere fills the picture, its narrower side deciding. */
static float fitting_distance(const app_scene *scene, float radius, float fov_y)
{
    float aspect = (float)scene->width / (float)scene->height, half = tanf(fov_y / 2);
    float narrow = atanf(aspect < 1 ? half * aspect : half);
    return radius / sinf(narrow > 0.02f ? narrow : 0.02f);
}

static void frame_model(app_scene *scene, const app_survey *s)
{
    kd_vec3 extent = kd_vec3_sub(s->high, s->low), middle = kd_vec3_scale(kd_vec3_add(s->low, s->high), 0.5f);
    float radius = kd_vec3_length(extent) / 2;
    if (!(radius > 1e-6f))
        radius = 1;
    if (s->hall) {
        add_camera(scene, s->eye, s->target, HALL_FOV_Y, radius * 0.5f);
        return;
    }
    if (s->open_box) {
        /* Far enough that the open side fills the height. */
        float depth = fabsf(s->open_side.x) > 0 ? extent.x : extent.z;
        float away = depth / 2 + extent.y / 2 / tanf(ORBIT_FOV_Y / 2) * 1.05f;
        add_camera(scene, kd_vec3_add(middle, kd_vec3_scale(s->open_side, away)), middle, ORBIT_FOV_Y, away);
        return;
    }
    float away = fitting_distance(scene, radius * 0.92f, ORBIT_FOV_Y); /* boxes seldom fill their spheres */
    kd_vec3 side =
        kd_vec3_normalize((kd_vec3){0.55f, 0.38f, 1}, (kd_vec3){0, 0, 1}); /* three quarters, from above */
    add_camera(scene, kd_vec3_add(middle, kd_vec3_scale(side, away)), middle, ORBIT_FOV_Y, away);
}

/* Into a hall it shines steeply, so that it reaches the floor and one of the long sides through an open roof.
 */
static void add_sun(app_scene *scene, const app_survey *s)
{
    kd_world *w = scene->world;
    kd_vec3 from = {0.45f, 1, 0.35f};
    if (s->hall)
        from = fabsf(s->target.x - s->eye.x) > fabsf(s->target.z - s->eye.z) ? (kd_vec3){0.3f, 1, 0.18f}
                                                                             : (kd_vec3){0.18f, 1, 0.3f};
    kd_entity e =
        kd_spawn(w, KD_VAL(kd_transform, {.rotation = look_at(from, (kd_vec3){0, 0, 0}), .scale = {1, 1, 1}}),
                 KD_TAG(kd_world_transform),
                 KD_VAL(kd_light, {.type = KD_DIRECTIONAL, .color = {1, 0.97f, 0.92f}, .intensity = SUN_LX}));
    kd_set_name(w, e, "sun");
    scene->settings.light_ambient = SKY;
}

/* Three lamps under the roof of a hall that no sun enters, which light the floor below them.
 */
static void add_lamps(app_scene *scene, const app_survey *s)
{
    float over_eye = 0.7f * s->roof, over_floor = over_eye + s->eye_height;
    for (int i = 0; i < 3; i++) {
        kd_vec3 way = kd_vec3_sub(s->target, s->eye);
        kd_vec3 at = kd_vec3_add(s->eye, kd_vec3_scale(way, 0.15f + 0.35f * (float)i));
        at.y = s->eye.y + over_eye;
        kd_entity e =
            kd_spawn(scene->world,
                     KD_VAL(kd_transform, {.position = at, .rotation = {0, 0, 0, 1}, .scale = {1, 1, 1}}),
                     KD_TAG(kd_world_transform),
                     KD_VAL(kd_light, {.type = KD_POINT,
                                       .color = {1, 0.95f, 0.88f},
                                       .intensity = LAMP_LX * over_floor * over_floor}));
        kd_set_name(scene->world, e, "lamp");
    }
}

static void add_light(app_scene *scene, const app_survey *s)
{
    if (s->roof > 0)
        add_lamps(scene, s);
    else
        add_sun(scene, s);
}

static float clamp(float x, float low, float high)
{
    return x < low ? low : x > high ? high : x;
}

/* Voxels and shadows that reach over the model from where the camera stands; --set still has the last word.
 */
static void fit_settings(app_scene *scene, const app_survey *s)
{
    kd_settings *set = &scene->settings;
    float diagonal = kd_vec3_length(kd_vec3_sub(s->high, s->low));
    float reach =
        s->hall ? diagonal : diagonal * 2.2f; /* the finest cascade covers this over 2^(cascades-1) */
    float cells = (float)(set->voxels_resolution << (set->voxels_cascades - 1));
    if (diagonal > 0) {
        set->voxels_span = clamp(reach / cells, 1e-4f, 100);
        set->light_shadow_distance = clamp(reach * 1.5f, 0.1f, 1e5f);
    }
}

kd_status app_scene_load_model(app_scene *scene, const app_options *options)
{
    const char *path = options->subject;
    uint32_t number;
    kd_entity root;
    app_survey survey;
    kd_status status = app_scene_model(
        scene, path, &(kd_model_options){.scene = options->model_scene, .variant = options->variant},
        &number);
    if (status != KD_OK)
        return status;
    const kd_model *model = kd_singleton(scene->world, kd_scene_store)->models[number].model;
    status = app_survey_model(model, &survey);
    if (status == KD_OK && model->triangle_count == 0)
        status = kd_fail(KD_BAD_FORMAT, "%s: holds no triangles to draw; choose another model", path);
    if (status == KD_OK)
        status = kd_scene_instantiate(scene->world, number, KD_NO_ENTITY, "model", &root);
    if (status != KD_OK)
        return status;
    fit_settings(scene, &survey);
    if (survey.hall && survey.roof == 0)
        scene->settings.view_exposure_ev = HALL_EV;
    if (!survey.has_camera)
        frame_model(scene, &survey);
    if (!survey.has_light && !app_survey_lit_by_itself(&survey))
        add_light(scene, &survey);
    if (!survey.hall && !survey.open_box && !survey.has_animation && !survey.has_camera)
        scene->turntable = root;
    return KD_OK;
}
