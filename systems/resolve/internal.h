#ifndef KD_SYSTEMS_RESOLVE_INTERNAL_H
#define KD_SYSTEMS_RESOLVE_INTERNAL_H

/* What the two systems that make the picture share: the sum of all light, and the way to the screen when that
 * has to wait for a measured exposure or a view that is drawn later. */

#include "components/camera.h"
#include "components/frame.h"
#include "components/render_targets.h"
#include "components/surface_access.h"
#include "runtime/ecs/system.h"
#include "shaders/shared/bindings.h"
#include "shaders/shared/resolve.h"
#include "shaders/shared/scene.h"

enum { RESOLVE_GROUP = 8, RESOLVE_LUMINANCE_GROUP = 16, RESOLVE_KINDS = KD_SURFACE_KINDS };

typedef struct resolve_variant {
    kd_gpu_program program;
    bool tried; /* a program that failed is not compiled again every frame */
} resolve_variant;

typedef struct resolve_steady {
    kd_gpu_program mix[2]; /* [1]: what is shown too */
    bool tried;
    kd_gpu_texture sum;           /* that kd_picture.hdr is while a frame is summed up; id 0: it is now */
    kd_gpu_texture before, mixed; /* the picture of the frame before; what this frame's becomes */
    uint32_t width, height;
    uint64_t made,
        followed; /* frame of `before`, and that in which the camera was looked at, plus one; 0: none */
    kd_view view; /* then */
    uint32_t still_frames; /* that the camera has not moved */
} resolve_steady;

typedef struct resolve_state {
    /* by view, kinds of light (bit 0 directional, bit 1 local) and of surfaces (bit 2: blended, bit 3: they
     * tint, bit 4: layered), whether the picture is made at once, and whether tiles have their own lights */
    resolve_variant resolve[KD_SHOW_COUNT][RESOLVE_KINDS][2][2];
    resolve_variant tiles;
    resolve_steady steady;
    kd_gpu_buffer tile_lights; /* shaders/include/tile_lights.glsl */
    kd_gpu_program tonemap, luminance, exposure;
    kd_gpu_texture black;
    kd_gpu_buffer exposure_buffer, partials;
} resolve_state;

/** Groups that cover `size` pixels. */
uint32_t resolve_groups(uint32_t size, uint32_t group);
struct kd_resolve_params resolve_params(kd_system_context *context);
/** KD_SHOW_* by which the tone map treats what the frame shows: light, or data that it leaves alone. */
uint32_t resolve_show(const kd_frame *frame);
/** Tell whether this frame's exposure is measured. */
bool resolve_measures(const kd_frame *frame);

/** Mark the lights of each tile, where that pays, and leave the marks bound. Everything of kd_surface_bind is
 * bound before. Returns whether there are marks. */
bool resolve_tiles_run(kd_system_context *context, resolve_state *s);
void resolve_tiles_fini(kd_gpu *gpu, resolve_state *s);

/** Let the picture be summed up where it was before it was mixed. */
void resolve_steady_begin(resolve_steady *s, kd_picture *picture);
/** Mix the picture with the one before, when that is asked for. `ldr`: what is shown was made from it
 * already. */
void resolve_steady_run(kd_system_context *context, resolve_steady *s, bool ldr);
void resolve_steady_fini(kd_gpu *gpu, resolve_steady *s);

kd_status resolve_tonemap_init(kd_system_context *context);
void resolve_tonemap_run(kd_system_context *context);
void resolve_tonemap_fini(kd_system_context *context);

#endif
