/* Registers the scene's systems. */

#include "systems/scene/scene.h"

#include "systems/scene/internal.h"

kd_status kd_scene_import(kd_schedule *s)
{
    kd_status (*const parts[])(kd_schedule *) = {scene_register_upload, scene_register_draw_list,
                                                 scene_register_draw_upload, scene_register_camera};
    kd_status status = KD_OK;
    for (size_t i = 0; status == KD_OK && i < sizeof parts / sizeof *parts; i++)
        status = parts[i](s);
    return status;
}
