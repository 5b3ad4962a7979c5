#ifndef KD_SHADERS_UI_H
#define KD_SHADERS_UI_H

#include "shaders/shared/layout.h"

#define KD_UNIT_UI_FONT 0 /* R8: opacity of letters */

/* Uniform block KD_BIND_PASS of panels. Positions are pixels, (0, 0) at the upper left. */
struct kd_ui_params {
    vec4 clip;   /* left, top, right, bottom: nothing is drawn beyond */
    /* ---- 16 */
    vec4 to_ndc; /* xy: scale from pixels, z: height of the window */
    /* ---- 32 */
};
KD_LAYOUT_CHECK(kd_ui_params, 32)

#include "shaders/shared/layout_end.h"

#endif
