// Joins the sets of cones of neighbouring traced pixels: a 3x3 tent (1 2 1), which weighs the four turns of trace.glsl
// equally, kept to pixels of the same surface. Traced reflections are left as they are; rough ones are the diffuse light.

#include "shaders/cone_trace/traced.glsl"

void smooth_pixel(ivec2 at)
{
    int n = int(gather.size.z), scale = int(gather.flags.y);
    ivec2 last = (ivec2(gather.size.xy) - 1) / n;
    if (any(greaterThan(at, last)))
        return;
    float depth = gbuffer_load_depth(at * n);
    vec4 specular = texelFetch(specular_in, at, 0);
    if (depth >= 1.0) {
        store(at, vec4(0.0), vec4(0.0), 0.0);
        return;
    }
    place p = place_load(at * n, depth);
    vec4 diffuse = vec4(0.0);
    float sum = 0.0;
    for (int i = 0; i < 9; i++) {
        ivec2 o = ivec2(i % 3, i / 3) - 1, other = clamp(at + o, ivec2(0), last);
        vec4 guide = texelFetch(guide_in, other * scale, 0);
        if (guide_is_background(guide))
            continue;
        float w = float((2 - abs(o.x)) * (2 - abs(o.y))) * belonging(p, other * n, guide);
        diffuse += w * texelFetch(diffuse_in, other, 0);
        sum += w;
    }
    store(at, diffuse, specular.a >= KD_TRACED_GLOSSY ? specular * sum : diffuse, sum);
}
