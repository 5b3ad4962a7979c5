#ifndef KD_APP_WINDOW_CAMERA_H
#define KD_APP_WINDOW_CAMERA_H

/* Three ways to look: by the scene's own camera, round a point of interest, and walking.
 * Source  Yalciner 2016, appendix A */

#include "components/camera.h"
#include "runtime/gpu/window.h"

typedef enum window_camera_mode {
    WINDOW_CAMERA_FIXED, /* the scene's own, which the scenario moves */
    WINDOW_CAMERA_ORBIT, /* left: turn; middle or right: move the point; wheel: nearer */
    WINDOW_CAMERA_WALK,  /* left: look; W A S D Q E: go; Shift: faster; wheel: speed */
    WINDOW_CAMERA_MODES
} window_camera_mode;
extern const char *const window_camera_words[WINDOW_CAMERA_MODES];

typedef struct window_camera {
    window_camera_mode mode;
    kd_vec3 position; /* m */
    float yaw, pitch; /* rad; 0: along -z, pitch > 0: up */
    float distance;   /* m, to the point of interest */
    float speed;      /* m/s */
    bool held[KD_KEY_COUNT];
    bool buttons[KD_MOUSE_COUNT];
    float x, y;  /* of the pointer */
    bool turned; /* moved since the last picture */
} window_camera;

/** Change the way to look; the picture stays what it is. interest_m: distance of what it shows in its middle
 */
void window_camera_set(window_camera *camera, window_camera_mode mode, const kd_view *view, float interest_m);
/** Take an event. Returns true when it moved something. */
bool window_camera_event(window_camera *camera, const kd_window_event *event, const kd_view *view);
/** Go on for that long with the keys that are held. */
void window_camera_advance(window_camera *camera, float dt_s);
/** Let go of every key and button: the window has lost the focus. */
void window_camera_release(window_camera *camera);
/** Tell whether a key moves it at present. */
bool window_camera_goes(const window_camera *camera);
kd_vec3 window_camera_interest(const window_camera *camera);
kd_mat4 window_camera_world(const window_camera *camera);

#endif
