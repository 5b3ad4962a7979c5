#ifndef KD_SYSTEMS_RESOLVE_INTERNAL_H
#define KD_SYSTEMS_RESOLVE_INTERNAL_H

/* What the three systems that make the picture share: direct light, the sum of all light, and the way to the screen. */

#include "components/camera.h"
#include "components/frame.h"
#include "components/render_targets.h"
#include "runtime/ecs/system.h"
#include "shaders/shared/bindings.h"
#include "shaders/shared/resolve.h"
#include "shaders/shared/scene.h"

enum { RESOLVE_GROUP = 8, RESOLVE_LUMINANCE_GROUP = 16 };

typedef struct resolve_state {
    kd_gpu_program direct[4]; /* bit 0: directional lights, bit 1: local ones */
    bool tried[4];            /* a program that failed is not compiled again every frame */
    kd_gpu_program resolve, tonemap, luminance, exposure;
    kd_gpu_texture direct_texture, black;
    uint32_t direct_width, direct_height;
    kd_gpu_buffer exposure_buffer, partials;
} resolve_state;

/** Bind the G-buffer, the camera and the lights for a pass that shades. */
void resolve_bind_scene(kd_system_context *context);
/** Groups that cover `size` pixels. */
uint32_t resolve_groups(uint32_t size, uint32_t group);
struct kd_resolve_params resolve_params(kd_system_context *context);

void resolve_direct_run(kd_system_context *context);
void resolve_direct_fini(kd_system_context *context); /* frees the state: registered first, ends last */
kd_status resolve_tonemap_init(kd_system_context *context);
void resolve_tonemap_run(kd_system_context *context);
void resolve_tonemap_fini(kd_system_context *context);

#endif
