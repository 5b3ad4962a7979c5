// View "octree": every pixel's ray marches through the octree at one level and shows the radiance of what it meets, as
// blocks (nearest cell, no interpolation), front to back. `--level` chooses the cell size: 0 the finest voxels, each step
// doubles it.
layout(local_size_x = 8, local_size_y = 8) in;

#include "shaders/include/tree.glsl"
#include "shaders/include/view.glsl"

layout(std140, binding = KD_BIND_PASS) uniform pass_block { ivec4 pass; }; // xy: size, z: level
layout(binding = 0, rgba16f) writeonly uniform image2D hdr_image;

vec4 cell_value(int k, int lod, vec3 p_ws, vec3 direction)
{
    lod = max(lod, k);
    if (lod < k + KD_SPARSE_LEVELS) {
        int level = lod - k;
        ivec3 cell = ivec3(floor((p_ws - tree.cascade[k].xyz) / (tree.cascade[k].w * float(1 << level))));
        return tree_fetch_sparse(k, level, clamp(cell, ivec3(0), ivec3((tree_resolution() >> level) - 1)), direction);
    }
    int c = min(lod - KD_SPARSE_LEVELS, tree_cascades() - 1), mip = max(lod - KD_SPARSE_LEVELS - c, 0);
    float edge = tree.cascade[c].w * float(1 << (KD_SPARSE_LEVELS + mip));
    vec3 centre = (floor((p_ws - tree.cascade[c].xyz) / edge) + 0.5) * edge + tree.cascade[c].xyz;
    return tree_sample_dense(c, mip, centre, direction);
}

// Distance to the far side of the cell that holds p.
float cell_exit(vec3 p_ws, vec3 direction, vec3 origin, float edge)
{
    vec3 cell = floor((p_ws - origin) / edge);
    vec3 far = origin + (cell + vec3(greaterThan(direction, vec3(0.0)))) * edge;
    vec3 t = mix((far - p_ws) / direction, vec3(1e30), lessThan(abs(direction), vec3(1e-9)));
    return max(min(t.x, min(t.y, t.z)), 0.0) + 1e-3 * edge;
}

// Where the ray enters the outermost cascade; negative when it misses it.
float enter(vec3 origin_ws, vec3 direction)
{
    int c = tree_cascades() - 1;
    vec3 low = tree.cascade[c].xyz, high = low + tree.cascade[c].w * float(tree_resolution());
    vec3 a = (low - origin_ws) / direction, b = (high - origin_ws) / direction;
    vec3 near = min(a, b), far = max(a, b);
    float from = max(max(near.x, near.y), max(near.z, 0.0)), to = min(far.x, min(far.y, far.z));
    return from <= to ? from : -1.0;
}

vec3 march(vec3 origin_ws, vec3 direction)
{
    float t = enter(origin_ws, direction), transmittance = 1.0;
    vec3 light = vec3(0.0);
    for (int i = 0; i < 1024 && t >= 0.0 && transmittance > 0.01; i++) {
        vec3 p = origin_ws + direction * (t + 1e-4 * tree.cascade[0].w);
        int k = tree_cascade_at(p, 0.0);
        if (k == tree_cascades())
            break;
        int lod = max(pass.z, k);
        float edge = tree.cascade[0].w * exp2(float(lod));
        float s = cell_exit(p, direction, tree.cascade[min(k, tree_cascades() - 1)].xyz, edge);
        vec4 v = cell_value(k, lod, p, direction);
        float through = exp(-v.a * s / edge);
        if (v.a > 0.0)
            light += transmittance * (1.0 - through) * v.rgb / v.a;
        transmittance *= through;
        t += s;
    }
    return light;
}

void main()
{
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(pixel, pass.xy)))
        return;
    vec2 uv = (vec2(pixel) + 0.5) / vec2(pass.xy);
    vec3 near = view_position(uv, 0.0), far = view_position(uv, 0.999);
    ivec2 top_down = ivec2(pixel.x, pass.y - 1 - pixel.y);
    imageStore(hdr_image, top_down, vec4(march(near, normalize(far - near)) * tree.light.z, 1.0));
}
