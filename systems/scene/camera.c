/* System camera: the active camera's matrices into singleton kd_view. A world without a camera is seen from
 * the origin along -Z with the default lens. */

#include <math.h>
#include <stdlib.h>

#include "components/camera.h"
#include "components/frame.h"
#include "components/transform.h"
#include "runtime/core/log.h"
#include "systems/scene/internal.h"

typedef struct camera_state {
    kd_query *query;
} camera_state;

static const kd_vec3 ahead = {0, 0, -1};

/* World to view of a pose whose scale is left out: a scaled parent must not stretch the picture. */
static kd_mat4 view_matrix(const kd_mat4 *world, kd_view *view)
{
    kd_vec3 back = kd_vec3_normalize((kd_vec3){world->m[8], world->m[9], world->m[10]}, (kd_vec3){0, 0, 1});
    kd_vec3 up = {world->m[4], world->m[5], world->m[6]};
    kd_vec3 right = kd_vec3_normalize(kd_vec3_cross(up, back), (kd_vec3){1, 0, 0});
    kd_vec3 eye = {world->m[12], world->m[13], world->m[14]};
    up = kd_vec3_cross(back, right);
    view->position_ws = eye;
    view->forward_ws = kd_vec3_normalize(kd_vec3_scale(back, -1), ahead);
    return (kd_mat4){{right.x, up.x, back.x, 0, right.y, up.y, back.y, 0, right.z, up.z, back.z, 0,
                      -kd_vec3_dot(right, eye), -kd_vec3_dot(up, eye), -kd_vec3_dot(back, eye), 1}};
}

static kd_mat4 perspective(float tan_half, float aspect, float n, float f)
{
    return (kd_mat4){{1 / (tan_half * aspect), 0, 0, 0, 0, 1 / tan_half, 0, 0, 0, 0, (f + n) / (n - f), -1, 0,
                      0, 2 * f * n / (n - f), 0}};
}

static kd_mat4 orthographic(float half_height, float aspect, float n, float f)
{
    return (kd_mat4){{1 / (half_height * aspect), 0, 0, 0, 0, 1 / half_height, 0, 0, 0, 0, 2 / (n - f), 0, 0,
                      0, (f + n) / (n - f), 1}};
}

/* A script may set any number: a lens that cannot be is bent to the nearest that can. */
static kd_camera usable(kd_camera camera)
{
    if (!(camera.fov_y > 0.001f && camera.fov_y < 3.1f))
        camera.fov_y = 0.785398163f;
    if (!(camera.y_mag > 0))
        camera.y_mag = 1;
    if (!(camera.z_near > 1e-6f))
        camera.z_near = camera.orthographic ? 0 : 1e-3f;
    if (!(camera.z_far > camera.z_near))
        camera.z_far = camera.z_near + 1000;
    return camera;
}

static void fill_view(kd_view *view, const kd_camera *given, const kd_mat4 *world, const kd_frame *frame)
{
    kd_camera camera = usable(*given);
    view->width = frame->width ? frame->width : 1;
    view->height = frame->height ? frame->height : 1;
    float aspect = (float)view->width / (float)view->height;
    view->z_near = camera.z_near;
    view->z_far = camera.z_far;
    view->tan_half_fov_y = camera.orthographic ? 0 : tanf(camera.fov_y * 0.5f);
    view->view = view_matrix(world, view);
    view->projection = camera.orthographic
                           ? orthographic(camera.y_mag, aspect, camera.z_near, camera.z_far)
                           : perspective(view->tan_half_fov_y, aspect, camera.z_near, camera.z_far);
    view->view_projection = kd_mat4_mul(&view->projection, &view->view);
    view->inverse_view_projection = kd_mat4_inverse(&view->view_projection);
}

static void camera_run(kd_system_context *c)
{
    const camera_state *state = c->user;
    kd_camera camera = *(const kd_camera *)kd_camera_desc.default_value;
    kd_mat4 world = KD_MAT4_IDENTITY;
    uint32_t lowest = UINT32_MAX;
    for (kd_iter it = kd_query_iter(state->query); kd_iter_next(&it);) {
        const kd_camera *cameras = KD_COLUMN(&it, kd_camera, 0);
        const kd_world_transform *worlds = KD_COLUMN(&it, kd_world_transform, 1);
        for (uint32_t i = 0; i < it.count; i++) {
            if (cameras[i].inactive || it.entities[i].index >= lowest)
                continue;
            lowest = it.entities[i].index;
            camera = cameras[i];
            world = worlds[i].matrix;
        }
    }
    const kd_free_camera *free_camera = kd_singleton(c->world, kd_free_camera);
    if (free_camera->on)
        world = free_camera->world;
    fill_view(kd_singleton(c->world, kd_view), &camera, &world, kd_singleton(c->world, kd_frame));
}

static kd_status camera_init(kd_system_context *c)
{
    camera_state *state = c->user;
    state->query =
        kd_query_make(c->world, &(kd_query_desc){.terms = {KD_READ(kd_camera), KD_READ(kd_world_transform)},
                                                 .name = "camera"});
    return state->query ? KD_OK : kd_fail(KD_NO_MEMORY, "out of memory for the camera's query");
}

static void camera_fini(kd_system_context *c)
{
    camera_state *state = c->user;
    if (state->query)
        kd_query_destroy(state->query);
    free(state);
}

kd_status scene_register_camera(kd_schedule *s)
{
    camera_state *state = calloc(1, sizeof *state);
    if (!state)
        return kd_fail(KD_NO_MEMORY, "out of memory for the camera system");
    kd_status status = kd_schedule_add(s, &(kd_system_desc){
                                              .name = "camera",
                                              .phase = KD_PHASE_CULL,
                                              .where = KD_ON_CPU,
                                              .components = {KD_CHANGES(kd_view), KD_USES(kd_camera),
                                                             KD_USES(kd_world_transform), KD_USES(kd_free_camera),
                                                             KD_USES(kd_frame)},
                                              .no_commands = true,
                                              .run = camera_run,
                                              .init = camera_init,
                                              .fini = camera_fini,
                                              .user = state,
                                          });
    if (status != KD_OK)
        free(state);
    return status;
}
