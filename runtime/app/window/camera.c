#include "runtime/app/window/camera.h"

#include <math.h>
#include <string.h>

#define TURN_RAD_PER_PIXEL 0.006f
#define MAX_PITCH          1.55f /* short of straight up, where yaw means nothing */
#define FAST               4.0f

const char *const window_camera_words[WINDOW_CAMERA_MODES] = {"fixed", "orbit", "walk"};

static kd_vec3 forward_of(const window_camera *c)
{
    return (kd_vec3){-sinf(c->yaw) * cosf(c->pitch), sinf(c->pitch), -cosf(c->yaw) * cosf(c->pitch)};
}

static kd_vec3 right_of(const window_camera *c)
{
    return (kd_vec3){cosf(c->yaw), 0, -sinf(c->yaw)};
}

static kd_vec3 ahead(kd_vec3 from, kd_vec3 direction, float distance)
{
    return kd_vec3_add(from, kd_vec3_scale(direction, distance));
}

kd_vec3 window_camera_interest(const window_camera *c)
{
    return ahead(c->position, forward_of(c), c->distance);
}

kd_mat4 window_camera_world(const window_camera *c)
{
    kd_vec3 f = forward_of(c), r = right_of(c), u = kd_vec3_cross(r, f);
    return (kd_mat4){{r.x, r.y, r.z, 0, u.x, u.y, u.z, 0, -f.x, -f.y, -f.z, 0, c->position.x, c->position.y,
                      c->position.z, 1}};
}

void window_camera_set(window_camera *c, window_camera_mode mode, const kd_view *view, float interest_m)
{
    if (c->mode == WINDOW_CAMERA_FIXED && mode != WINDOW_CAMERA_FIXED) {
        c->position = view->position_ws;
        c->pitch = asinf(fminf(fmaxf(view->forward_ws.y, -1), 1));
        c->yaw = atan2f(-view->forward_ws.x, -view->forward_ws.z);
    }
    if (c->mode != WINDOW_CAMERA_ORBIT && mode != WINDOW_CAMERA_FIXED) {
        c->distance = interest_m;
        c->speed = interest_m * 0.5f;
    }
    c->mode = mode;
    c->turned = true;
}

/* Turn about the camera, or with it about the point of interest. */
static void turn(window_camera *c, float dx, float dy)
{
    kd_vec3 interest = window_camera_interest(c);
    c->yaw -= dx * TURN_RAD_PER_PIXEL;
    c->pitch = fminf(fmaxf(c->pitch - dy * TURN_RAD_PER_PIXEL, -MAX_PITCH), MAX_PITCH);
    if (c->mode == WINDOW_CAMERA_ORBIT)
        c->position = ahead(interest, forward_of(c), -c->distance);
}

/* Move so that the point of interest stays under the pointer. */
static void slide(window_camera *c, float dx, float dy, const kd_view *view)
{
    float tan_half = view->tan_half_fov_y > 0 ? view->tan_half_fov_y : 0.4f;
    float m_per_pixel = 2 * c->distance * tan_half / (float)(view->height ? view->height : 1);
    kd_vec3 r = right_of(c), u = kd_vec3_cross(r, forward_of(c));
    c->position = ahead(ahead(c->position, r, -dx * m_per_pixel), u, dy * m_per_pixel);
}

static bool move_pointer(window_camera *c, float x, float y, const kd_view *view)
{
    float dx = x - c->x, dy = y - c->y;
    c->x = x;
    c->y = y;
    if (c->buttons[KD_MOUSE_LEFT])
        turn(c, dx, dy);
    else if (c->mode == WINDOW_CAMERA_ORBIT && (c->buttons[KD_MOUSE_MIDDLE] || c->buttons[KD_MOUSE_RIGHT]))
        slide(c, dx, dy, view);
    else
        return false;
    return true;
}

static void zoom(window_camera *c, float notches)
{
    float factor = powf(0.9f, notches);
    if (c->mode == WINDOW_CAMERA_WALK) {
        c->speed /= factor;
        return;
    }
    c->position = ahead(c->position, forward_of(c), c->distance * (1 - factor));
    c->distance *= factor;
}

bool window_camera_event(window_camera *c, const kd_window_event *e, const kd_view *view)
{
    bool moved = false;
    if (c->mode != WINDOW_CAMERA_FIXED && e->kind == KD_WINDOW_POINTER)
        moved = move_pointer(c, e->x, e->y, view);
    else if (c->mode != WINDOW_CAMERA_FIXED && e->kind == KD_WINDOW_SCROLL)
        moved = (zoom(c, e->y), c->mode == WINDOW_CAMERA_ORBIT);
    else if (e->kind == KD_WINDOW_BUTTON)
        c->buttons[e->code] = e->down;
    else if (e->kind == KD_WINDOW_KEY && e->code >= 0 && e->code < KD_KEY_COUNT)
        c->held[e->code] = e->down && !(e->modifiers & KD_MOD_CONTROL);
    if (e->kind == KD_WINDOW_POINTER || e->kind == KD_WINDOW_BUTTON) {
        c->x = e->x;
        c->y = e->y;
    }
    c->turned = c->turned || moved;
    return moved;
}

/* Steps to the right, up and ahead that the held keys ask for. */
static kd_vec3 wish(const window_camera *c)
{
    const bool *h = c->held;
    return (kd_vec3){(float)h[KD_KEY_D] - (float)h[KD_KEY_A], (float)h[KD_KEY_E] - (float)h[KD_KEY_Q],
                     (float)h[KD_KEY_W] - (float)h[KD_KEY_S]};
}

bool window_camera_goes(const window_camera *c)
{
    kd_vec3 w = wish(c);
    return c->mode == WINDOW_CAMERA_WALK && (w.x != 0 || w.y != 0 || w.z != 0);
}

void window_camera_advance(window_camera *c, float dt_s)
{
    kd_vec3 w = wish(c);
    if (!window_camera_goes(c))
        return;
    float step = c->speed * dt_s * (c->held[KD_KEY_LEFT_SHIFT] || c->held[KD_KEY_RIGHT_SHIFT] ? FAST : 1);
    c->position = ahead(c->position, right_of(c), w.x * step);
    c->position = ahead(c->position, (kd_vec3){0, 1, 0}, w.y * step);
    c->position = ahead(c->position, forward_of(c), w.z * step);
    c->turned = true;
}

void window_camera_release(window_camera *c)
{
    memset(c->held, 0, sizeof c->held);
    memset(c->buttons, 0, sizeof c->buttons);
}
