// Tracing one cone through the octree, front to back, as emission and absorption: over a step of length s through matter of
// optical depth d per metre and radiance S, the light gained is T (1 - exp(-d s)) S and T falls by exp(-d s).

#include "shaders/include/tree.glsl"

// Cells are half as large as the cone is wide, since linear interpolation makes every cell reach over two edge lengths. With
// steps of half a diameter a sample then falls on every cell length, and the interpolated depths of a wall add up exactly.
const float CONE_SHARPNESS = 1.0;

struct cone_settings {
    float step;         // in diameters
    float max_distance; // m
    float falloff;      // of occlusion with distance, 1/m
    float least;        // least diameter, in voxels
};

struct cone_result {
    vec3 radiance;
    float transmittance;
    float occlusion;    // weighted by 1 / (1 + falloff t)
    int samples;
};

// Where the next sample of a cone lies.
struct cone_place {
    vec3 p_ws;
    float diameter;
    int cascade, lod;
    bool goes_on, sparse; // sparse: below the dense levels
};

cone_place cone_place_at(float t, cone_result so_far, vec3 origin_ws, vec3 direction, float tan_half, cone_settings settings)
{
    cone_place o;
    float span = tree.cascade[0].w;
    o.p_ws = origin_ws + direction * t;
    o.cascade = tree_cascade_at(o.p_ws, 0.5);
    o.goes_on = o.cascade < tree_cascades() && t <= settings.max_distance && so_far.transmittance >= 0.01 && so_far.samples < 256;
    o.diameter = max(2.0 * tan_half * t, settings.least * span * float(1 << o.cascade));
    o.lod = max(int(floor(log2(o.diameter / span) - CONE_SHARPNESS + 0.5)), o.cascade);
    o.sparse = tree_is_sparse(o.cascade, o.lod);
    return o;
}

// v: what the sample at t gave.
void cone_step(inout cone_result r, inout float t, vec4 v, float diameter, cone_settings settings)
{
    float s = settings.step * diameter;
    float through = exp(-v.a * s);
    float gained = r.transmittance * (1.0 - through);
    if (v.a > 0.0)
        r.radiance += gained * (v.rgb / v.a);
    r.occlusion += gained / (1.0 + settings.falloff * t);
    r.transmittance *= through;
    r.samples++;
    t += s;
}

// The sequence of distances depends on the aperture and the start alone, so all pixels of a surface change levels at the
// same steps, and no interpolation between levels is needed to keep it free of bands; inside a level it is linear.
//
// `facing` is the direction of which it is asked what side of matter is met: the axis for a narrow cone, another of its rays
// for a wide one.
//
// Software drivers run both sides of a branch, and what follows a `break` once more: so sparse and dense samples have loops
// of their own, which end at their ends.
cone_result cone_trace(vec3 origin_ws, vec3 direction, vec3 facing, float tan_half, float start, cone_settings settings)
{
    cone_result r = cone_result(vec3(0.0), 1.0, 0.0, 0);
    float t = start;
    cone_place at = cone_place_at(t, r, origin_ws, direction, tan_half, settings);
    do {
        do {
            if (at.goes_on && at.sparse) {
                cone_step(r, t, tree_sample_sparse(at.cascade, at.lod, at.p_ws, facing), at.diameter, settings);
                at = cone_place_at(t, r, origin_ws, direction, tan_half, settings);
            }
        } while (at.goes_on && at.sparse);
        do {
            if (at.goes_on && !at.sparse) {
                cone_step(r, t, tree_sample_wide(at.cascade, at.lod, at.p_ws, facing), at.diameter, settings);
                at = cone_place_at(t, r, origin_ws, direction, tan_half, settings);
            }
        } while (at.goes_on && !at.sparse);
    } while (at.goes_on);
    return r;
}
