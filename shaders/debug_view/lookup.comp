// View "lookup": asks the tree at every visible surface, by the cell that it lies in; grey where the tree has nothing there.
// Source: Yalciner 2016, appendix A ("SVO lookup").
layout(local_size_x = 8, local_size_y = 8) in;

#include "shaders/include/gbuffer.glsl"
#include "shaders/debug_view/cell_show.glsl"

layout(binding = 0, rgba16f) writeonly uniform image2D hdr_image;

// A surface on the border of two cells belongs to either: both sides are asked, this far off [cells].
const float REACH = 0.25;

vec3 look_up(surface s, int level, uint channel)
{
    vec3 n = s.face_normal_ws;
    for (int i = 0; i < 4; i++) {
        int k = tree_cascade_at(s.position_ws, 0.0);
        if (k == tree_cascades())
            break;
        int lod = clamp(level, tree_finest(k), lod_most());
        float reach = REACH * tree.cascade[0].w * exp2(float(lod));
        vec3 p = s.position_ws + n * ((i & 1) == 0 ? -reach : reach);
        k = min(tree_cascade_at(p, 0.0), tree_cascades() - 1);
        lod = clamp(level, tree_finest(k), lod_most());
        cell_place at = cell_at(k, lod, p);
        vec4 seen = cell_seen(at, i < 2 ? -n : n); // matter is asked for its front first
        if (seen.a > 0.0)
            return cell_show(at, k, seen, channel);
    }
    return show_missing(channel, kd_view.lens.z);
}

void main()
{
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy), size = ivec2(params.view.xy);
    if (any(greaterThanEqual(pixel, size)))
        return;
    surface s = gbuffer_load(pixel);
    vec3 c = s.hit ? look_up(s, int(params.view.z), params.view.w) : vec3(0.0);
    imageStore(hdr_image, ivec2(pixel.x, size.y - 1 - pixel.y), vec4(min(c, vec3(65504.0)), s.hit ? 1.0 : 0.0));
}
