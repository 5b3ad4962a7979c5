// Light of emitters (shaders/shared/emitters.h) at a point: each as a disc that faces it, with a narrow cone for its shadow.

#include "shaders/include/cone.glsl"
#include "shaders/include/color.glsl"
#include "shaders/include/emitters_params.glsl"

// Cosine that a sphere shows to a surface, of which it covers sine to the horizon's both sides: goes down to 0 smoothly while
// the sphere sets.
float setting_cosine(float cosine, float sine)
{
    float above = clamp(cosine + sine, 0.0, 2.0 * sine);
    return cosine > sine ? cosine : above * above / (4.0 * sine);
}

#ifndef KD_COUNT_EMITTER_CONES
void count_emitter_cone(int samples) {}
#endif

// Share of its area that an emitter shows to a ray along `direction`: its flat part the cosine, what glows in all directions
// a quarter.
float emitter_shown(kd_emitter e, vec3 direction)
{
    float directed = min(length(e.normal.xyz), 1.0), front = -dot(e.normal.xyz, direction);
    return mix(max(front, 0.0), abs(front), e.normal.w) + 0.25 * (1.0 - directed) * (1.0 + e.normal.w);
}

// Mean radiance over the disc of its radius.
vec3 emitter_radiance(kd_emitter e, vec3 direction)
{
    return e.power.rgb * (emitter_shown(e, direction) / max(3.14159265 * e.place.w * e.place.w, e.power.w));
}

// Irradiance / pi from emitter i on a surface with normal n, without shadow.
// The disc's exact form factor on its axis, A / (pi d^2 + A), holds close by too.
vec3 emitter_light(uint i, vec3 p_ws, vec3 n_ws)
{
    kd_emitter e = emitters.emitter[i];
    vec3 to_it = e.place.xyz - p_ws;
    float d2 = max(dot(to_it, to_it), 1e-8), inverse = inversesqrt(d2);
    vec3 direction = to_it * inverse;
    float shown = emitter_shown(e, direction);
    float cosine = setting_cosine(dot(n_ws, direction), clamp(e.place.w * inverse, 1e-3, 1.0));
    return e.power.rgb * (shown * cosine / (3.14159265 * d2 + e.power.w * shown));
}

// Narrow cones have far to go: steps of up to 1.6 cells, of cells of two voxels at least.
cone_settings emitter_settings(cone_settings of)
{
    return cone_settings(of.step * CONE_NARROW_STEP, of.max_distance, of.falloff, 4.0, 1.0, CONE_LEAST, CONE_NARROW_DENSITY);
}

// Radius of a cone that covers as much as an emitter shows along `direction`: a flat one seen from its edge is thin, and what it
// lies in would shade it.
float emitter_width(kd_emitter e, vec3 direction)
{
    float directed = min(length(e.normal.xyz), 1.0);
    return e.place.w * sqrt(mix(1.0, min(emitter_shown(e, direction), 1.0), directed));
}

// Voxels that a shadow's cone ends in front of an emitter seen from its edge: what a lamp is let into does not shade what it
// lights.
const float EMITTER_LIFT = 3.0;

// Share of an emitter's light that reaches a point. Its own cells are left out, and those that a sample there would touch.
float emitter_visible(uint i, vec3 p_ws, float start, float least_tan, cone_settings settings)
{
    kd_emitter e = emitters.emitter[i];
    float span = tree_finest_edge(min(tree_cascade_at(e.place.xyz, 0.5), tree_cascades() - 1));
    vec3 to_it = e.place.xyz - p_ws, side = dot(e.normal.xyz, to_it) <= 0.0 ? e.normal.xyz : -e.normal.xyz;
    float edgewise = 1.0 - min(emitter_shown(e, normalize(to_it)), 1.0);
    to_it += side * (edgewise * min(EMITTER_LIFT * span, 0.25 * length(to_it)));
    float d = length(to_it);
    vec3 direction = to_it / max(d, 1e-6);
    float tan_half = max(0.7 * emitter_width(e, direction) / max(d, 1e-6), least_tan);
    settings.max_distance = d - e.place.w - 1.5 * max(span, tan_half * d);
    if (settings.max_distance <= start)
        return 1.0;
    cone_result r = cone_trace_wide(p_ws, direction, direction, tan_half, start, settings);
    count_emitter_cone(r.samples);
    return r.transmittance;
}

const float LEAST_SHARE_TRACED = 0.01;

// Light of all emitters on a surface at place_ws: `samples` of them, drawn by how much they would light it, stand for all.
// Four variants take strata between each other, so that the mean of four neighbours has four times as many. Shadows are
// traced from origin_ws, unless all of it is next to nothing beside the light that has come from elsewhere. Loops end in their
// condition: software drivers run a body that is left at its head once more.
vec3 emitters_light(vec3 others, vec3 place_ws, vec3 origin_ws, vec3 n_ws, float start, float least_tan, uint samples, uint variant,
                    cone_settings settings)
{
    uint count = emitters.info.x, i = 0u, k = 0u;
    float all_of_it = 0.0;
    vec3 sum = vec3(0.0);
    if (count == 0u)
        return sum;
    do
        all_of_it += color_luminance(emitter_light(i, place_ws, n_ws));
    while (++i < count);
    if (all_of_it <= LEAST_SHARE_TRACED * color_luminance(others))
        return sum;
    samples = count <= 8u ? 1u : samples;
    float each = all_of_it / float(samples);
    do {
        float target = each * (float(k) + (float(variant) + 0.5) * 0.25), before = 0.0;
        uint pick = 0u;
        i = 0u;
        do {
            before += color_luminance(emitter_light(i, place_ws, n_ws));
            pick += uint(before < target);
        } while (++i < count);
        pick = min(pick, count - 1u);
        vec3 light = emitter_light(pick, place_ws, n_ws);
        float seen = emitter_visible(pick, origin_ws, start, least_tan, settings);
        sum += light * (seen * each / max(color_luminance(light), 1e-20));
    } while (++k < samples);
    return sum;
}

// Radiance that emitters send along a reflection: each is a disc that covers a part of the cone. The shadow is that of the
// one that gives most.
vec3 emitters_reflected(vec3 place_ws, vec3 origin_ws, vec3 direction, float tan_half, float start, cone_settings settings)
{
    vec3 sum = vec3(0.0);
    float most = 0.0, own = min(tan_half, 1.0); // angles by their sines and chords: what is wide is soft anyhow
    uint best = 0u;
    for (uint i = 0u; i < emitters.info.x; i++) {
        kd_emitter e = emitters.emitter[i];
        vec3 to_it = e.place.xyz - place_ws;
        float d = max(length(to_it), 1e-4), radius = min(e.place.w / d, 1.0), apart = distance(to_it / d, direction);
        float smaller = min(radius, own), inside = 1.0 - smoothstep(abs(radius - own), radius + own, apart);
        vec3 light = emitter_radiance(e, to_it / d) * (inside * smaller * smaller / (own * own));
        sum += light;
        float given = color_luminance(light);
        best = given > most ? i : best;
        most = max(most, given);
    }
    return most > 0.0 ? sum * emitter_visible(best, origin_ws, start, tan_half, settings) : vec3(0.0);
}
