// What one traced pixel does: diffuse cones round the normal give irradiance and ambient visibility, one glossy cone along
// the mirror direction gives the reflection; with KD_GLOSSY alone, since software drivers would go through it for every pixel.
// cone_trace.c makes the set of cones.
// Source: Crassin 2011; Yalciner 2016, section 4.6.

#include "shaders/shared/gather.h"
#include "shaders/include/gbuffer.glsl"
#include "shaders/include/sky.glsl"
#include "shaders/include/frame.glsl"

layout(std140, binding = KD_BIND_PASS) uniform gather_block { kd_gather_params gather; };
#include "shaders/cone_trace/count.glsl"
#define KD_COUNT_EMITTER_CONES
void count_emitter_cone(int samples) { count_cone(KD_MAX_CONES + 1, samples); }
#include "shaders/include/emitters.glsl"

layout(binding = 0, rgba16f) writeonly uniform image2D diffuse_out;
layout(binding = 1, rgba16f) writeonly uniform image2D specular_out;

cone_settings settings()
{
    return cone_settings(gather.cone.y, gather.cone.z, gather.light.y, 1.0, gather.light.w, CONE_CLOSED, 1.0);
}

// One of a cone's rays, another for each variant: over and under the axis and on both sides of it, at the distance that has
// the second moment of the cone's disc. Which cell a wide cone samples follows from its axis, but a ceiling that its axis
// runs along is met by half of its rays.
vec3 ray_of(vec3 cone, float variant)
{
    const float SPREAD = 0.7071;
    vec3 across = normalize(vec3(-cone.y, cone.x, 0.0) + vec3(1e-6, 0.0, 0.0)), up = cross(across, cone);
    bool sideways = variant == 1.0 || variant == 3.0;
    return normalize(cone + (gather.cone.x * SPREAD * (variant < 1.5 ? 1.0 : -1.0)) * (sideways ? across : up));
}

// Cone i of the set. Neighbours have different sets of cones; smooth.comp, whose weights add up equally over any two by two
// pixels, makes one set of four times as many directions of them.
struct set_cone {
    vec3 axis, facing;
    float weight;
};

set_cone cone_of_set(uint i, uint variant, mat3 frame)
{
    vec4 cone = gather.cones[uint(KD_CONE_SETS) * i + variant];
    vec3 axis = frame * cone.xyz;
#ifdef KD_LEAK_STRICT
    return set_cone(axis, axis, cone.w); // a ray that leaves a wall would let the whole cone through it
#else
    bool capping = i == 0u && gather.size.w > 4u && gather.light.w < 1.0; // four round the normal: different rays already
    return set_cone(axis, capping ? axis : frame * ray_of(cone.xyz, float(variant)), cone.w);
#endif
}

#ifdef KD_CONES_PAPER

#include "shaders/cone_trace/march.glsl"

#else

// Every cone of the set by itself. Returns irradiance, and how much of the hemisphere is open.
vec4 trace_set(vec3 origin, mat3 frame, uint variant, float start)
{
    vec3 irradiance = vec3(0.0);
    float visible = 0.0;
    cone_near near = cone_near_of(origin, frame[2], gather.cone.x, start, settings());
    uint i = 0u;
    do {
        set_cone cone = cone_of_set(i, variant, frame);
        cone_result r = cone_trace(origin, cone.axis, cone.facing, gather.cone.x, cone_start(near, cone.facing, start), settings());
        count_cone(i, r.samples);
        irradiance += cone.weight * (r.radiance * tree.light.z + r.transmittance * sky_cone(cone.axis, gather.cone.x * gather.light.w));
        visible += cone.weight * (1.0 - r.occlusion);
    } while (++i < gather.size.w);
    return vec4(irradiance, visible);
}

#endif

vec4 trace_diffuse(vec3 place_ws, vec3 origin, vec3 normal, float span, ivec2 at)
{
    uint variant = uint((at.x & 1) + 2 * (at.y & 1));
    float start = 0.25 * span;
    vec4 set = trace_set(origin, frame_round(normal), variant, start);
    vec3 irradiance = set.rgb;
    irradiance += emitters_light(irradiance, place_ws, origin, normal, start, 0.05, 2u, variant, emitter_settings(settings()));
    return vec4(irradiance * gather.light.x, clamp(1.0 - gather.light.z * (1.0 - set.a), 0.0, 1.0));
}

#ifdef KD_GLOSSY
// The cone that holds most of a GGX lobe: its half angle grows with roughness squared (half of the lobe's energy lies within
// atan(alpha) of the mirror direction).
vec3 trace_specular(vec3 place_ws, vec3 origin, surface s, vec3 view, float span)
{
    float alpha = s.roughness * s.roughness;
    vec3 direction = reflect(view, s.normal_ws);
    float below = dot(direction, s.face_normal_ws);
    if (below < 0.05)
        direction = normalize(direction + (0.05 - below) * s.face_normal_ws);
    cone_settings far = settings();
    far.step *= CONE_NARROW_STEP;
    far.density = CONE_NARROW_DENSITY;
    far.far = 1.0;
    float tan_half = clamp(alpha, 0.03, 1.0);
    cone_result r = cone_trace(origin, direction, direction, tan_half, span, far);
    count_cone(KD_MAX_CONES, r.samples);
    vec3 glow = emitters_reflected(place_ws, origin, direction, tan_half, span, emitter_settings(settings()));
    return (r.radiance * tree.light.z + r.transmittance * sky_cone(direction, tan_half) + glow) * gather.light.x;
}
#endif

// Traces pixel at * n of the picture into texel `at`.
void trace_pixel(ivec2 at, int n)
{
    surface s = gbuffer_load(at * n);
    if (!s.hit) {
        imageStore(diffuse_out, at, vec4(0.0, 0.0, 0.0, 1.0));
        imageStore(specular_out, at, vec4(0.0));
        return;
    }
    int k = min(tree_cascade_at(s.position_ws, 0.5), tree_cascades() - 1);
    float span = tree_finest_edge(k);
    vec3 view = view_direction(s.position_ws);
    vec3 face = dot(s.face_normal_ws, view) > 0.0 ? -s.face_normal_ws : s.face_normal_ws;
    // What lies beyond the outermost cascade is lit as its border is: no jump, and no more sky than there.
    int outer = tree_cascades() - 1;
    vec3 reach = vec3(tree.cascade[outer].w * float(tree_resolution()) * 0.5 * (1.0 - 4.0 / float(KD_DENSE)));
    vec3 origin = clamp(s.position_ws + face * (gather.cone.w * span), tree.centre.xyz - reach, tree.centre.xyz + reach);
    vec4 diffuse = trace_diffuse(s.position_ws, origin, s.normal_ws, span, at);
    float kept = gather.refine.y;
    imageStore(diffuse_out, at, diffuse * vec4(vec3(kept), 1.0));
    // A rough surface's lobe is about as wide as the hemisphere: the diffuse cones have seen it already, and smooth.comp takes
    // the smoothed diffuse light.
    vec4 specular = vec4(diffuse.rgb, KD_TRACED_ROUGH);
#ifdef KD_GLOSSY
    if (gather.flags.x != 0u && s.roughness < KD_GATHER_ROUGH)
        specular = vec4(trace_specular(s.position_ws, origin, s, view, span), KD_TRACED_GLOSSY);
#endif
    imageStore(specular_out, at, specular * vec4(vec3(kept), 1.0));
    count_pixel(at * n);
}
