#ifndef KD_REFERENCE_REFERENCE_H
#define KD_REFERENCE_REFERENCE_H

/* Path tracing of the world as its systems left it after a frame: what the renderer's picture should be.
 * Camera, materials, lights and sky follow the conventions of the shaders; visibility and all bounces are
 * exact up to noise.
 *
 * What differs from the renderer on purpose: blended surfaces let light through by their opacity; occlusion
 * maps are not used, since occlusion is found by rays; a picture averages over its pixels' areas unless asked
 * not to.
 *
 * The same seed gives the same bytes, whatever the number of threads. */

#include <stdbool.h>
#include <stdint.h>

#include "runtime/core/status.h"
#include "runtime/ecs/world.h"

struct kd_jobs;

/* What can be asked of a picture. Light that reaches the first surface straight from a directional, point or
 * spot light is direct, as is what the surface emits and the background; all other light (sky, emitters,
 * bounces) is indirect. */
typedef enum kd_reference_term {
    KD_REFERENCE_FINAL,    /* radiance: direct + indirect */
    KD_REFERENCE_DIRECT,   /* radiance */
    KD_REFERENCE_INDIRECT, /* radiance: diffuse + specular */
    KD_REFERENCE_DIFFUSE,  /* radiance: indirect light that the first surface reflects diffusely */
    KD_REFERENCE_SPECULAR, /* radiance: indirect light that the first surface reflects specularly */
    KD_REFERENCE_AO,     /* share of the sky that is open, fading with distance as setting ao.falloff says; 0
                            where     nothing is */
    KD_REFERENCE_ALBEDO, /* base colour, linear */
    KD_REFERENCE_NORMAL, /* shading normal, world space, -1 … 1 mapped to 0 … 1 */
    KD_REFERENCE_DEPTH,  /* m along the viewing axis; 0 where nothing is */
    KD_REFERENCE_TERM_COUNT
} kd_reference_term;

#define KD_REFERENCE_ENDLESS (-1)

typedef struct kd_reference_desc {
    uint32_t spp;    /* samples a pixel; 0: 64 */
    int32_t bounces; /* light that bounced more often is left out; 0: what comes straight from lights,
                        emitters and sky */
    bool gathered;   /* count as a renderer does that gathers lit surfaces `bounces` times: light of emitters
                        and sky   then bounces once less than that of directional, point and spot lights */
    uint64_t seed;
    bool lambert; /* every material is its base colour, ideally diffuse, lit from both sides; maps are
                     interpolated as they are stored. For comparison with renderers that know no more */
    bool centre;  /* edges as of one ray through each pixel's middle, as the renderer draws them, instead of
                     their mean;  maps are filtered over the pixel all the same */
    bool ambient_occlusion; /* compute KD_REFERENCE_AO: a ray a sample more */
    double time_budget_s;   /* end after this long, samples done so far count; 0: no limit */
    double noise; /* end when the mean relative squared error of the final term is estimated below this; 0:
                     never */
    /* Called between passes; false interrupts. May be NULL. */
    bool (*progress)(void *user, uint32_t done_spp, uint32_t spp, double pass_ms);
    void *user;
} kd_reference_desc;

typedef struct kd_reference kd_reference;

/** Build the scene of the world's present state: singletons kd_view, kd_frame, kd_joint_palette and
 * kd_scene_store, entities with meshes and lights.
 *
 *  Errors  KD_NO_MEMORY, KD_UNSUPPORTED when Embree cannot start; one message
 *  Owns    nothing of the world is kept but images and vertex attributes of the scene store
 */
kd_status kd_reference_open(kd_world *w, struct kd_jobs *jobs, const kd_reference_desc *desc,
                            kd_reference **out);

/** Trace all samples.
 *  Errors  KD_INTERRUPTED when progress said so; samples done so far count
 */
kd_status kd_reference_render(kd_reference *r);

/** Write one term.
 *  Shapes  rgb: height rows of width texels of 3 floats, row 0 on top; one-channel terms three times
 */
void kd_reference_read(const kd_reference *r, kd_reference_term term, float *rgb);

typedef struct kd_reference_info {
    uint32_t width, height, spp; /* samples done */
    uint64_t triangles, emitters, lights, rays;
    double build_s, trace_s;
    double noise;          /* estimated mean relative squared error of the final term */
    double indirect_noise; /* the same of the indirect term */
    uint64_t bad_samples;  /* not finite, counted as black */
} kd_reference_info;
kd_reference_info kd_reference_get_info(const kd_reference *r);

void kd_reference_close(kd_reference *r); /* NULL does nothing */

#endif
