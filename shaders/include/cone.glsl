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

// The sequence of distances depends on the aperture and the start alone, so all pixels of a surface change levels at the
// same steps, and no interpolation between levels is needed to keep it free of bands; inside a level it is linear.
//
// `facing` is the direction of which it is asked what side of matter is met: the axis for a narrow cone, another of its rays
// for a wide one.
cone_result cone_trace(vec3 origin_ws, vec3 direction, vec3 facing, float tan_half, float start, cone_settings settings)
{
    cone_result r = cone_result(vec3(0.0), 1.0, 0.0, 0);
    float span = tree.cascade[0].w;
    float t = start;
    int k = 0;
    for (int i = 0; i < 256; i++) {
        vec3 p = origin_ws + direction * t;
        k = tree_cascade_at(p, 0.5);
        if (k == tree_cascades() || t > settings.max_distance || r.transmittance < 0.01)
            break;
        float diameter = max(2.0 * tan_half * t, settings.least * span * float(1 << k));
        int lod = max(int(floor(log2(diameter / span) - CONE_SHARPNESS + 0.5)), k);
        vec4 v = tree_sample(k, lod, p, facing);
        r.samples++;
        float s = settings.step * diameter;
        float through = exp(-v.a * s);
        float gained = r.transmittance * (1.0 - through);
        if (v.a > 0.0)
            r.radiance += gained * (v.rgb / v.a);
        r.occlusion += gained / (1.0 + settings.falloff * t);
        r.transmittance *= through;
        t += s;
    }
    return r;
}
