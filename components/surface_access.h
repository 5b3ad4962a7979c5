#ifndef KD_COMPONENTS_SURFACE_ACCESS_H
#define KD_COMPONENTS_SURFACE_ACCESS_H

/* What passes need that shade the G-buffer: the kinds of light and surfaces there are, for their programs,
 * and everything bound. Bits of kinds: 0 directional lights, 1 local ones, 2 blended surfaces in front, 3
 * that let colours through unequally, 4 materials of several layers. */

#include "components/render_targets.h"
#include "components/sky.h"

enum { KD_SURFACE_KINDS = 32 };

/* Resources of a system that calls kd_surface_bind and kd_surface_bind_gathered. */
#define KD_SURFACE_RESOURCES                                                                                 \
    {"gbuffer", KD_USE_SAMPLED}, {"blended", KD_USE_SAMPLED}, {"sky", KD_USE_UNIFORM | KD_USE_SAMPLED},      \
        {"shadow.maps", KD_USE_SAMPLED}, {"lights.uniform", KD_USE_UNIFORM},                                 \
    {                                                                                                        \
        "gi", KD_USE_SAMPLED                                                                                 \
    }

/** Get the kinds of this frame. */
uint32_t kd_surface_kinds(const kd_gbuffer *g, const kd_lighting *lighting);
/** Write the defines of some kinds, at most 5, to `out`. Returns how many. */
int kd_surface_defines(uint32_t kinds, const char **out);
/** Bind G-buffer, blended surfaces, lights, shadow maps, sky and view. */
void kd_surface_bind(kd_gpu *gpu, const kd_gbuffer *g, const kd_lighting *lighting, const kd_sky_light *sky);
/** Bind light that was gathered; `black` stands in for what there is not. */
void kd_surface_bind_gathered(kd_gpu *gpu, const kd_gi_targets *gi, bool there, kd_gpu_texture black);

#endif
