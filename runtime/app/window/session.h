#ifndef KD_APP_WINDOW_SESSION_H
#define KD_APP_WINDOW_SESSION_H

/* What the files of the window share: the scene that is on, how its time passes, how it is looked at, and
 * what the panels have said. Invariant: the stage is open; when `stopped` its last step failed and it is
 * shown as it was until another takes its place. */

#include "runtime/app/window/camera.h"
#include "runtime/app/window/history.h"
#include "runtime/app/window/reload.h"
#include "runtime/app/window/window.h"
#include "runtime/core/file.h"
#include "runtime/ecs/query.h"
#include "runtime/ui/ui.h"

enum { WINDOW_MESSAGES = 32, WINDOW_MAX_SCENES = 256 };

typedef enum window_panel {
    WINDOW_PANEL_RUN,
    WINDOW_PANEL_SCENE,
    WINDOW_PANEL_LIGHTS,
    WINDOW_PANEL_VOXELS,
    WINDOW_PANEL_CONES,
    WINDOW_PANEL_VIEW,
    WINDOW_PANEL_PROFILE,
    WINDOW_PANEL_MESSAGES,
    WINDOW_PANEL_COUNT
} window_panel;

typedef struct window_message {
    bool error;
    char text[512];
} window_message;

typedef struct window_session {
    const app_window_desc *desc;
    app_options options; /* of the scene that is on */
    char subject[KD_PATH_MAX];
    app_stage *stage;
    kd_gpu *gpu;
    kd_ui *ui;

    /* ---- time ---- */
    uint64_t frame; /* the next simulation step */
    bool paused, stopped;
    uint32_t steps;        /* to be made though it is paused */
    double speed;          /* simulated by real time */
    double next_step_s;    /* when the next step is due */
    double now_s, drawn_s; /* of this turn; of the last drawing */
    uint32_t settling;     /* pictures to be made though nothing moves: light is on its way */
    uint32_t redraws;      /* drawings of panels still to be made */

    /* ---- looking ---- */
    window_camera camera;
    bool keeps_size;        /* what is written has one size, whatever the window's */
    uint32_t coarseness;    /* window pixels per pixel of the picture */
    uint32_t width, height; /* of the window */
    window_history history;
    kd_query *lamps, *everything; /* of the stage's world */

    /* ---- panels ---- */
    bool panels; /* shown at all */
    bool open[WINDOW_PANEL_COUNT];
    kd_entity chosen;
    bool chosen_world; /* the values that the world has one of are shown */
    uint32_t profile_row;
    window_message messages[WINDOW_MESSAGES]; /* a ring */
    uint32_t message_first, message_count;
    bool alarm;                      /* an error nobody has mended yet */
    char *scenes[WINDOW_MAX_SCENES]; /* names of scenes beside the one that is on, sorted */
    uint32_t scene_count;

    window_watch *watch;
    const char **kept_sets; /* of options, when a scene took another's place */
    bool broken_shaders;    /* some do not compile as they stand */
    bool reload_asked;
    bool whole_due;                 /* models or shaders have changed since the stage was loaded */
    uint32_t renewals;              /* of the stage, since it came on */
    char next_subject[KD_PATH_MAX]; /* "": no other scene is asked for */
} window_session;

/* ---- session.c ---- */
/** Make pictures until the light has settled: something was changed by hand. */
void window_touch(window_session *s);
void window_note(window_session *s, bool error, const char *text);
double window_interest_m(window_session *s);
void window_set_camera(window_session *s, window_camera_mode mode);
/** Write the picture beside the current folder's other ones. */
void window_screenshot(window_session *s);

/** Stop simulated time or let it go on; make one step of it; change its speed. */
void window_pause(window_session *s);
void window_step(window_session *s);
void window_change_speed(window_session *s, double factor);
/** Follow the stage that has come on, or leave it before it goes. Errors NO_MEMORY */
kd_status window_stage_begin(window_session *s);
void window_stage_end(window_session *s);

/* ---- input.c ---- */
void window_take_events(window_session *s);

/* ---- panels.c and panel_*.c ---- */
void window_draw_panels(window_session *s);
void window_panel_run(window_session *s);
void window_panel_scene(window_session *s);
void window_panel_field(window_session *s, kd_entity e, kd_component_id id, const char *name);
void window_panel_component(window_session *s, kd_entity e, kd_component_id id);
void window_panel_lights(window_session *s);
void window_panel_voxels(window_session *s);
void window_panel_cones(window_session *s);
void window_panel_view(window_session *s);
void window_panel_profile(window_session *s);
void window_panel_messages(window_session *s);
/** A widget for a setting; for all of a group when the key ends in a dot. */
void window_setting(window_session *s, const char *key);
void window_settings(window_session *s, const char *group);
/** "12.3 MB" */
const char *window_bytes(uint64_t bytes, char out[16]);

/* ---- switch.c ---- */
/** List the scenes beside the one that is on. */
void window_list_scenes(window_session *s);
/** Ask for the scene that comes `by` after the one that is on. */
void window_next_scene(window_session *s, int by);
/** Watch the files that the scene which is on was made of. */
void window_watch_files(window_session *s);
/** Ask for one of the list. */
void window_choose_scene(window_session *s, uint32_t index);
/** Do what was asked for: another scene, or the same anew. Errors only when nothing is left to be shown */
kd_status window_switch(window_session *s);

#endif
