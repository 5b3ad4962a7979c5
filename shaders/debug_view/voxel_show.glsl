// What the pixels show of the voxels that were drawn into them.
layout(local_size_x = 8, local_size_y = 8) in;

#include "shaders/include/view.glsl"
#include "shaders/debug_view/voxel_box.glsl"
#include "shaders/debug_view/tree_cell.glsl"
#include "shaders/debug_view/show.glsl"

layout(binding = 5) uniform usamplerBuffer color; // r32ui
layout(binding = 0, rgba16f) writeonly uniform image2D hdr_image;

// Light of the tree's cell, as large as the voxel, in which its centre lies.
vec3 show_light(voxel_box box, int c)
{
    int k = tree_cascade_at(box.centre_ws, 0.0);
    for (int i = 0; i < 2 && k < tree_cascades(); i++) {
        cell_place at = cell_at(k, max(k, c), box.centre_ws);
        vec4 seen = cell_seen(at, i == 0 ? -box.normal_ws : box.normal_ws);
        if (seen.a > 0.0)
            return seen.rgb / seen.a * tree.light.z;
    }
    return show_missing(KD_SHOW_RADIANCE, kd_view.lens.z);
}

vec3 show_voxel(kd_voxel_segment segment, voxel_box box, uint i)
{
    int c = int(segment.chunk_cascade >> 28);
    switch (params.view.w) {
    case KD_SHOW_VOXEL_NORMAL:
        return show_normal(box.normal_ws);
    case KD_SHOW_OPACITY:
        return vec3(depth_opacity(FULL_DEPTH * box.coverage));
    case KD_SHOW_CASCADE:
        return show_cascade(c);
    case KD_SHOW_RADIANCE:
        return show_light(box, c);
    }
    return albedo_unpack(texelFetch(color, int(segment.first + i)).r);
}

void main()
{
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy), size = ivec2(params.view.xy);
    if (any(greaterThanEqual(pixel, size)))
        return;
    uint n = pixels[uint(size.x * size.y + pixel.y * size.x + pixel.x)] - voxels_of.source.x;
    kd_voxel_segment segment;
    voxel_box box;
    if (!box_find(n, segment, box))
        return; // nothing here, or a voxel of the other layer
    vec3 c = show_voxel(segment, box, n % KD_SEGMENT_VOXELS);
    imageStore(hdr_image, ivec2(pixel.x, size.y - 1 - pixel.y), vec4(min(c, vec3(65504.0)), 1.0));
}
