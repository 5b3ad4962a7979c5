// From every n-th pixel to all: the four traced pixels round each one, weighted by bilinear distance and by belonging.
layout(local_size_x = 8, local_size_y = 8) in;

#include "shaders/cone_trace/traced.glsl"

void main()
{
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(pixel, ivec2(gather.size.xy))))
        return;
    float depth = gbuffer_load_depth(pixel);
    if (depth >= 1.0) {
        store(pixel, vec4(0.0), vec4(0.0), 0.0);
        return;
    }
    place p = place_load(pixel, depth);
    int n = int(gather.size.z);
    ivec2 low = pixel / n, last = (ivec2(gather.size.xy) - 1) / n;
    vec2 f = (vec2(pixel) - vec2(low * n)) / float(n);
    vec4 diffuse = vec4(0.0), specular = vec4(0.0);
    float sum = 0.0;
    for (int i = 0; i < 4; i++) {
        ivec2 o = ivec2(i & 1, i >> 1), at = min(low + o, last);
        float other_depth = gbuffer_load_depth(at * n);
        if (other_depth >= 1.0)
            continue;
        vec2 b = mix(1.0 - f, f, vec2(o)) + 1e-3;
        float w = b.x * b.y * belonging(p, at * n, other_depth);
        diffuse += w * texelFetch(diffuse_in, at, 0);
        specular += w * texelFetch(specular_in, at, 0);
        sum += w;
    }
    store(pixel, diffuse, specular, sum);
}
