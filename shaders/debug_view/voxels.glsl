// Draws voxels as boxes without a rasteriser: one invocation a voxel goes over the pixels that its box may cover and meets it
// with their rays. A first pass keeps the nearest depth of each pixel, a second, same to the bit, the number of the voxel
// that has it; of equal ones the lowest, so that the picture does not depend on order. Voxels that cover many pixels are
// listed and drawn by a work group each.
layout(local_size_x = 64) in;

#include "shaders/include/linear.glsl"
#include "shaders/include/view.glsl"
#include "shaders/debug_view/voxel_box.glsl"

layout(std430, binding = 6) buffer large_block { // as in work_list.glsl, but a group an item
    uint large_args[3];
    uint large_count;
    uint large[];
};

const uint LARGE_PIXELS = 256u, LARGE_MOST = 65535u;

struct pixel_rect {
    ivec2 low, size;
};

// Is all of a box beyond one side of the view? In clip space, so that boxes beside or behind the eye are told too.
bool outside(vec4 c, vec4 x, vec4 y, vec4 z)
{
    vec2 low = c.w + c.xy + abs(x.w + x.xy) + abs(y.w + y.xy) + abs(z.w + z.xy);
    vec2 high = c.w - c.xy + abs(x.w - x.xy) + abs(y.w - y.xy) + abs(z.w - z.xy);
    float front = c.w + c.z + abs(x.w + x.z) + abs(y.w + y.z) + abs(z.w + z.z);
    return any(lessThan(low, vec2(0.0))) || any(lessThan(high, vec2(0.0))) || front < 0.0;
}

// Pixels whose centres the box may cover: all of them when it reaches behind the eye.
pixel_rect box_rect(voxel_box box)
{
    mat4 m = kd_view.view_projection;
    vec4 c = m * vec4(box.centre_ws, 1.0);
    vec4 x = m * vec4(box.axes[0], 0.0), y = m * vec4(box.axes[1], 0.0), z = m * vec4(box.axes[2], 0.0);
    float reach = abs(x.w) + abs(y.w) + abs(z.w);
    vec2 size = vec2(params.view.xy), low = vec2(1e9), high = vec2(-1e9);
    if (outside(c, x, y, z))
        return pixel_rect(ivec2(0), ivec2(0));
    if (c.w - reach <= 1e-5)
        return pixel_rect(ivec2(0), ivec2(params.view.xy));
    for (int i = 0; i < 8; i++) {
        vec4 corner = c + ((i & 1) == 0 ? -x : x) + ((i & 2) == 0 ? -y : y) + ((i & 4) == 0 ? -z : z);
        low = min(low, corner.xy / corner.w);
        high = max(high, corner.xy / corner.w);
    }
    const float SLACK = 0.02; // pixels, for rounding
    ivec2 from = ivec2(ceil(clamp((low * 0.5 + 0.5) * size - 0.5 - SLACK, vec2(0.0), size)));
    ivec2 to = ivec2(floor(clamp((high * 0.5 + 0.5) * size - 0.5 + SLACK, vec2(-1.0), size - 1.0)));
    return pixel_rect(from, max(to - from + 1, ivec2(0)));
}

// The ray of a pixel as origin + t direction; t is the viewing depth.
void pixel_ray(ivec2 pixel, out vec3 origin, out vec3 direction)
{
    vec2 ndc = (vec2(pixel) + 0.5) / vec2(params.view.xy) * 2.0 - 1.0;
    mat4 m = kd_view.inverse_view_projection;
    vec4 far = m[0] * ndc.x + m[1] * ndc.y + (m[2] + m[3]);
    vec3 eye = kd_view.position_ws.xyz, forward = kd_view.forward_ws.xyz;
    origin = eye;
    direction = far.xyz - eye * far.w;
    direction /= dot(direction, forward);
    if (view_is_orthographic()) {
        direction = forward;
        origin = far.xyz / far.w;
        origin -= forward * dot(origin - eye, forward);
    }
}

// Depth at which the ray enters the box; negative when it does not, or before the near plane.
float box_depth(voxel_box box, mat3 to_box, vec3 origin, vec3 direction)
{
    vec3 o = to_box * (origin - box.centre_ws), d = to_box * direction;
    vec3 a = (-1.0 - o) / d, b = (1.0 - o) / d, near = min(a, b), far = max(a, b);
    float enters = max(near.x, max(near.y, near.z)), leaves = min(far.x, min(far.y, far.z));
    return enters <= leaves && enters >= kd_view.position_ws.w ? enters : -1.0;
}

void draw(voxel_box box, pixel_rect rect, uint number, uint first, uint stride)
{
    mat3 to_box = inverse(box.axes);
    uint count = uint(rect.size.x * rect.size.y), all = params.view.x * params.view.y;
    for (uint i = first; i < count; i += stride) {
        ivec2 pixel = rect.low + ivec2(int(i) % rect.size.x, int(i) / rect.size.x);
        vec3 origin, direction;
        pixel_ray(pixel, origin, direction);
        float t = box_depth(box, to_box, origin, direction);
        uint at = uint(pixel.y) * params.view.x + uint(pixel.x), depth = floatBitsToUint(t);
        if (t < 0.0 || depth > pixels[at])
            continue;
        if (voxels_of.source.z == 0u)
            atomicMin(pixels[at], depth);
        else if (depth == pixels[at])
            atomicMin(pixels[all + at], number);
    }
}

// Returns false when there is no room.
bool list_large(uint n)
{
    uint at = atomicAdd(large_count, 1u);
    if (at >= LARGE_MOST)
        return false;
    large[at] = n;
    atomicAdd(large_args[0], 1u);
    return true;
}

void main()
{
    bool listed = voxels_of.source.w != 0u;
    uint n = listed ? large[gl_WorkGroupID.x] : linear_index();
    kd_voxel_segment segment;
    voxel_box box;
    if (!box_find(n, segment, box) || abs(determinant(box.axes)) < 1e-30)
        return;
    pixel_rect rect = box_rect(box);
    uint count = uint(rect.size.x * rect.size.y);
    if (count == 0u || (!listed && count > LARGE_PIXELS && list_large(n)))
        return;
    draw(box, rect, voxels_of.source.x + n, listed ? gl_LocalInvocationIndex : 0u, listed ? 64u : 1u);
}
