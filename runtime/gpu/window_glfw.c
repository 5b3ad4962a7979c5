/* Events of the window: GLFW's calls come while events are looked for, and go into a ring. */
#include <stdlib.h>
#include <string.h>

#include "runtime/gpu/glfw_table.h"
#include "runtime/gpu/internal.h"

enum { RING = 512 };

typedef struct window_ring {
    kd_window_event events[RING];
    uint32_t first, count;
    bool pointed; /* x and y are known: of the last event, the pointer itself may be further already */
    double x, y;
} window_ring;

_Static_assert(KD_KEY_F12 == GLFW_KEY_F12 && KD_KEY_KP_ENTER == GLFW_KEY_KP_ENTER &&
                   KD_KEY_RIGHT_ALT == GLFW_KEY_RIGHT_ALT && KD_KEY_COUNT == GLFW_KEY_LAST + 1,
               "keys have GLFW's numbers");
_Static_assert((int)KD_MOUSE_MIDDLE == GLFW_MOUSE_BUTTON_MIDDLE && (int)KD_MOD_ALT == GLFW_MOD_ALT,
               "buttons and modifiers have GLFW's numbers");

/* ---- names ---- */

static const struct {
    int key;
    const char *name;
} key_names[] = {
#define KEY_NAME(name, number, text) {number, text},
    KD_KEY_LIST(KEY_NAME)
#undef KEY_NAME
};

const char *kd_key_name(int key)
{
    for (size_t i = 0; i < sizeof key_names / sizeof *key_names; i++)
        if (key_names[i].key == key)
            return key_names[i].name;
    return NULL;
}

int kd_key_find(const char *name)
{
    for (size_t i = 0; i < sizeof key_names / sizeof *key_names; i++)
        if (strcmp(key_names[i].name, name) == 0)
            return key_names[i].key;
    return KD_KEY_NONE;
}

/* ---- the ring ---- */

/* A pointer that moves on replaces where it was; of what does not fit the oldest is given up. */
static void put(GLFWwindow *window, const kd_window_event *event)
{
    window_ring *ring = gpu_glfw.user(window);
    kd_window_event *last = ring->count ? &ring->events[(ring->first + ring->count - 1) % RING] : NULL;
    if (last && last->kind == event->kind &&
        (event->kind == KD_WINDOW_POINTER || event->kind == KD_WINDOW_CHANGED)) {
        *last = *event;
        return;
    }
    if (ring->count == RING) {
        ring->first = (ring->first + 1) % RING;
        ring->count--;
    }
    ring->events[(ring->first + ring->count++) % RING] = *event;
}

/* Screen coordinates to pixels: they differ on some systems. */
static void to_pixels(GLFWwindow *window, double x, double y, kd_window_event *event)
{
    int width = 0, height = 0, pixel_width = 0, pixel_height = 0;
    gpu_glfw.window_size(window, &width, &height);
    gpu_glfw.framebuffer_size(window, &pixel_width, &pixel_height);
    event->x = (float)(width > 0 ? x * pixel_width / width : x);
    event->y = (float)(height > 0 ? y * pixel_height / height : y);
}

/* ---- what GLFW calls ---- */

static void on_key(GLFWwindow *window, int key, int scancode, int action, int modifiers)
{
    (void)scancode;
    put(window, &(kd_window_event){.kind = KD_WINDOW_KEY,
                                   .code = key,
                                   .down = action != GLFW_RELEASE,
                                   .repeat = action == GLFW_REPEAT,
                                   .modifiers = (uint32_t)modifiers & 7u});
}

static void on_text(GLFWwindow *window, unsigned code)
{
    put(window, &(kd_window_event){.kind = KD_WINDOW_TEXT, .code = (int)code});
}

static void on_button(GLFWwindow *window, int button, int action, int modifiers)
{
    window_ring *ring = gpu_glfw.user(window);
    kd_window_event event = {.kind = KD_WINDOW_BUTTON,
                             .code = button,
                             .down = action == GLFW_PRESS,
                             .modifiers = (uint32_t)modifiers & 7u};
    if (button >= KD_MOUSE_COUNT)
        return;
    if (!ring->pointed)
        gpu_glfw.cursor_position(window, &ring->x, &ring->y);
    to_pixels(window, ring->x, ring->y, &event);
    put(window, &event);
}

static void on_pointer(GLFWwindow *window, double x, double y)
{
    window_ring *ring = gpu_glfw.user(window);
    kd_window_event event = {.kind = KD_WINDOW_POINTER};
    ring->pointed = true;
    ring->x = x;
    ring->y = y;
    to_pixels(window, x, y, &event);
    put(window, &event);
}

static void on_enter(GLFWwindow *window, int entered)
{
    if (!entered)
        put(window, &(kd_window_event){.kind = KD_WINDOW_LEFT});
}

static void on_scroll(GLFWwindow *window, double x, double y)
{
    put(window, &(kd_window_event){.kind = KD_WINDOW_SCROLL, .x = (float)x, .y = (float)y});
}

static void on_focus(GLFWwindow *window, int focused)
{
    put(window, &(kd_window_event){.kind = KD_WINDOW_FOCUS, .down = focused != 0});
}

static void changed(GLFWwindow *window)
{
    put(window, &(kd_window_event){.kind = KD_WINDOW_CHANGED});
}

static void on_size(GLFWwindow *window, int width, int height)
{
    (void)width;
    (void)height;
    changed(window);
}

static void on_scale(GLFWwindow *window, float x, float y)
{
    (void)x;
    (void)y;
    changed(window);
}

bool gpu_glfw_events_begin(GLFWwindow *window)
{
    window_ring *ring = calloc(1, sizeof *ring);
    if (!ring)
        return false;
    gpu_glfw.set_user(window, ring);
    gpu_glfw.on_key(window, on_key);
    gpu_glfw.on_text(window, on_text);
    gpu_glfw.on_button(window, on_button);
    gpu_glfw.on_pointer(window, on_pointer);
    gpu_glfw.on_enter(window, on_enter);
    gpu_glfw.on_scroll(window, on_scroll);
    gpu_glfw.on_focus(window, on_focus);
    gpu_glfw.on_refresh(window, changed);
    gpu_glfw.on_size(window, on_size);
    gpu_glfw.on_scale(window, on_scale);
    return true;
}

void gpu_glfw_events_end(GLFWwindow *window)
{
    free(gpu_glfw.user(window));
    gpu_glfw.set_user(window, NULL);
}

/* ---- what frame loops ask ---- */

void kd_gpu_window_wait(kd_gpu *gpu, double seconds)
{
    if (!kd_gpu_window_native(gpu))
        return;
    if (seconds > 0)
        gpu_glfw.wait(seconds);
    else
        gpu_glfw.poll();
}

bool kd_gpu_window_event(kd_gpu *gpu, kd_window_event *out)
{
    GLFWwindow *window = kd_gpu_window_native(gpu);
    window_ring *ring = window ? gpu_glfw.user(window) : NULL;
    if (!ring || !ring->count)
        return false;
    *out = ring->events[ring->first];
    ring->first = (ring->first + 1) % RING;
    ring->count--;
    return true;
}

bool kd_gpu_window_closing(kd_gpu *gpu)
{
    GLFWwindow *window = kd_gpu_window_native(gpu);
    return window && gpu_glfw.should_close(window) != 0;
}

void kd_gpu_window_close(kd_gpu *gpu)
{
    GLFWwindow *window = kd_gpu_window_native(gpu);
    if (window)
        gpu_glfw.set_should_close(window, GLFW_TRUE);
}

bool kd_gpu_window_should_close(kd_gpu *gpu)
{
    kd_gpu_window_wait(gpu, 0);
    return kd_gpu_window_closing(gpu);
}

void kd_gpu_window_size(kd_gpu *gpu, uint32_t *width, uint32_t *height)
{
    GLFWwindow *window = kd_gpu_window_native(gpu);
    int w = 0, h = 0;
    if (window)
        gpu_glfw.framebuffer_size(window, &w, &h);
    *width = (uint32_t)w;
    *height = (uint32_t)h;
}

void kd_gpu_window_resize(kd_gpu *gpu, uint32_t width, uint32_t height)
{
    GLFWwindow *window = kd_gpu_window_native(gpu);
    int w = 0, h = 0, pixel_width = 0, pixel_height = 0;
    if (!window)
        return;
    gpu_glfw.window_size(window, &w, &h);
    gpu_glfw.framebuffer_size(window, &pixel_width, &pixel_height);
    if (pixel_width > 0 && pixel_height > 0) /* in screen coordinates */
        gpu_glfw.set_window_size(window, (int)width * w / pixel_width, (int)height * h / pixel_height);
}

float kd_gpu_window_scale(kd_gpu *gpu)
{
    GLFWwindow *window = kd_gpu_window_native(gpu);
    float x = 1, y = 1;
    if (window)
        gpu_glfw.content_scale(window, &x, &y);
    return y > 0 ? y : 1;
}

bool kd_gpu_window_minimized(kd_gpu *gpu)
{
    GLFWwindow *window = kd_gpu_window_native(gpu);
    return window && gpu_glfw.attribute(window, GLFW_ICONIFIED) != 0;
}

void kd_gpu_window_title(kd_gpu *gpu, const char *title)
{
    GLFWwindow *window = kd_gpu_window_native(gpu);
    if (window)
        gpu_glfw.set_title(window, title);
}

void kd_gpu_window_present(kd_gpu *gpu)
{
    GLFWwindow *window = kd_gpu_window_native(gpu);
    if (window)
        gpu_glfw.swap(window);
}
