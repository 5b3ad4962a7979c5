// From every n-th pixel to all: the four traced pixels round each one, weighted by bilinear distance and by belonging. One
// invocation does the n by n pixels between the same four.
layout(local_size_x = 8, local_size_y = 8) in;

#include "shaders/cone_trace/traced.glsl"

struct corner {
    ivec2 pixel;
    vec4 guide, diffuse, specular;
};

void interpolate(ivec2 pixel, ivec2 within, int n, corner corners[4])
{
    float depth = gbuffer_load_depth(pixel);
    place p = place_load(pixel, depth);
    vec2 f = vec2(within) / float(n);
    vec4 diffuse = vec4(0.0), specular = vec4(0.0);
    float sum = 0.0;
    for (int i = 0; i < 4; i++) {
        vec2 b = mix(1.0 - f, f, vec2(i & 1, i >> 1)) + 1e-3;
        float w = b.x * b.y * belonging(p, corners[i].pixel, corners[i].guide);
        if (guide_is_background(corners[i].guide))
            w = 0.0;
        diffuse += w * corners[i].diffuse;
        specular += w * corners[i].specular;
        sum += w;
    }
    store(pixel, diffuse, specular, depth < 1.0 ? sum : 0.0);
}

void main()
{
    ivec2 low = ivec2(gl_GlobalInvocationID.xy);
    int n = int(gather.size.z);
    ivec2 size = ivec2(gather.size.xy), last = (size - 1) / n;
    if (any(greaterThan(low, last)))
        return;
    corner corners[4];
    for (int i = 0; i < 4; i++) {
        ivec2 at = min(low + ivec2(i & 1, i >> 1), last);
        corners[i] = corner(at * n, texelFetch(guide_in, at, 0), texelFetch(diffuse_in, at, 0), texelFetch(specular_in, at, 0));
    }
    ivec2 within = ivec2(0);
    do {
        if (all(lessThan(low * n + within, size)))
            interpolate(low * n + within, within, n, corners);
        within = within.x + 1 < n ? within + ivec2(1, 0) : ivec2(0, within.y + 1);
    } while (within.y < n);
}
