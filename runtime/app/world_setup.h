#ifndef KD_APP_WORLD_SETUP_H
#define KD_APP_WORLD_SETUP_H

/* The composition root: the one place that knows every system. */

#include "runtime/app/extension.h"

/** Register the components of which entities are made. */
void app_register_components(kd_world *w, const kd_extension *extension);

/** Register every system of a frame, in the order in which those of one phase run. */
kd_status app_import_systems(kd_schedule *s, const kd_extension *extension);

/** Register the systems that bring the world to its state of a frame, and leave out all work of the GPU: for
 *  those who make pictures in another way. */
kd_status app_import_state_systems(kd_schedule *s, const kd_extension *extension);

/** The extension's shaders, for kd_gpu_desc; NULL: none. */
const kd_embedded_shader *app_shaders(const kd_extension *extension);

#endif
