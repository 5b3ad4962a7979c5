// Fills the traced grid from one of half its resolution where that is good enough, and lists the pixels where it is not:
// at edges, where light changes quickly, and on glossy surfaces, whose reflections are traced.
layout(local_size_x = 8, local_size_y = 8) in;

#include "shaders/cone_trace/traced.glsl"
#include "shaders/cone_trace/reuse.glsl"
#include "shaders/include/work_list_fill.glsl"
#include "shaders/cone_trace/listed_pixel.glsl"
#include "shaders/include/color.glsl"

// What is to be smoothed: what is traced, and what the frame before traced; a list like that of work.
layout(std430, binding = 1) buffer smooth_block {
    uint smooth_args[3];
    uint smooth_count;
    uint smooth_items[];
};
// What is traced with its reflection.
layout(std430, binding = 4) buffer glossy_block {
    uint glossy_args[3];
    uint glossy_count;
    uint glossy_items[];
};
layout(binding = 2, rgba16f) writeonly uniform image2D diffuse_smooth_out;
layout(binding = 3, rgba16f) writeonly uniform image2D specular_smooth_out;

// Least share of the interpolation's weight that must lie on the pixel's own surface.
const float LEAST_SHARE = 0.6;

void add_to_smooth(uint item)
{
    uint i = atomicAdd(smooth_count, 1u);
    if (i >= uint(smooth_items.length()))
        return;
    if (i % 64u == 0u)
        atomicAdd(smooth_args[0], 1u);
    smooth_items[i] = item;
}

void add_to_glossy(uint item)
{
    uint i = atomicAdd(glossy_count, 1u);
    if (i >= uint(glossy_items.length()))
        return;
    if (i % 64u == 0u)
        atomicAdd(glossy_args[0], 1u);
    glossy_items[i] = item;
}

void trace_or_reuse(ivec2 at, int n, bool glossy, vec3 p_ws, vec3 normal_ws)
{
    add_to_smooth(pixel_item(at));
    reused_light light = reuse_find(at, n, 1, p_ws, normal_ws);
    if (glossy) {
        add_to_glossy(pixel_item(at));
        return;
    }
    if (!light.found) {
        work_add(pixel_item(at));
        return;
    }
    imageStore(diffuse_out, at, light.diffuse);
    imageStore(specular_out, at, light.specular);
}

void main()
{
    ivec2 at = ivec2(gl_GlobalInvocationID.xy);
    int n = int(gather.size.z);
    ivec2 pixel = at * n;
    if (any(greaterThanEqual(pixel, ivec2(gather.size.xy))))
        return;
    float depth = gbuffer_load_depth(pixel);
    vec4 diffuse = vec4(0.0, 0.0, 0.0, 1.0);
    if (depth < 1.0) {
        bool glossy = gather.flags.x != 0u && texelFetch(gbuffer_material, pixel, 0).g < KD_GATHER_ROUGH;
        place p = place_load(pixel, depth);
        ivec2 low = at / 2, last = (ivec2(gather.size.xy) - 1) / (2 * n);
        vec2 f = 0.5 * vec2(at & 1);
        vec4 sum = vec4(0.0);
        float weight = 0.0, all_weight = 0.0, darkest = 1e30, brightest = 0.0;
        for (int i = 0; i < 4; i++) {
            ivec2 o = ivec2(i & 1, i >> 1), other = min(low + o, last);
            vec2 b = mix(1.0 - f, f, vec2(o)) + 0.02;
            all_weight += b.x * b.y;
            vec4 guide = texelFetch(guide_in, other * 2, 0);
            if (guide_is_background(guide))
                continue;
            float belongs = belonging(p, other * 2 * n, guide);
            vec4 v = texelFetch(diffuse_in, other, 0);
            sum += b.x * b.y * belongs * v;
            weight += b.x * b.y * belongs;
            float light = color_luminance(v.rgb);
            darkest = min(darkest, mix(1e30, light, float(belongs > 0.1)));
            brightest = max(brightest, mix(0.0, light, float(belongs > 0.1)));
        }
        if (glossy || weight < LEAST_SHARE * all_weight || brightest - darkest > gather.refine.x * brightest) {
            trace_or_reuse(at, n, glossy, gbuffer_position(pixel, depth), p.normal_ws);
            return;
        }
        diffuse = sum / weight;
    }
    imageStore(diffuse_out, at, diffuse);
    imageStore(specular_out, at, vec4(diffuse.rgb, KD_TRACED_NOT));
    imageStore(diffuse_smooth_out, at, diffuse);
    imageStore(specular_smooth_out, at, vec4(diffuse.rgb, 0.0));
}
