#ifndef KD_APP_MODEL_SURVEY_H
#define KD_APP_MODEL_SURVEY_H

/* What a viewer wants to know of a model before it places a camera. */

#include "runtime/asset/model.h"

typedef struct app_survey {
    bool has_camera, has_light, has_animation;
    bool has_emissive;   /* triangles that shine */
    kd_vec3 low, high;   /* bounds, m */
    bool hall;           /* one can stand inside: floor and walls face inwards; open ones are large */
    bool open_box;       /* closed on all sides but one: seen best through that side */
    bool closed_box;     /* closed on all sides, its faces turned inwards */
    kd_vec3 open_side;   /* unit axis that leads out of the open box */
    kd_vec3 eye, target; /* of a hall: a place to stand, and where the view is longest */
    float eye_height;    /* of that place above the floor, m */
    float roof;          /* of a hall closed on all sides, m above the eye; 0: light comes in somewhere */
} app_survey;

/** Tell whether the model's own shining surfaces light it: they do inside a room, whose walls pass the light
 * on; a lit label on a thing in the open leaves the rest of it black. */
bool app_survey_lit_by_itself(const app_survey *survey);

/** Look at a model in its rest pose.
 *  Cost  some dozen rays against every triangle: 10 ms for a quarter of a million */
kd_status app_survey_model(const kd_model *model, app_survey *out);

#endif
