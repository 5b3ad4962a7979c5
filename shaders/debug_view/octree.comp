// View "octree": every pixel's ray marches through the octree at one level and shows what it meets, as blocks, front to back.
// Level 0 are the finest voxels, each further one doubles the cells. Empty space is left in steps as large as the empty
// cells are.
layout(local_size_x = 8, local_size_y = 8) in;

#include "shaders/include/view.glsl"
#include "shaders/debug_view/cell_show.glsl"

layout(binding = 0, rgba16f) writeonly uniform image2D hdr_image;

// Distance to the far side of the cell that holds p.
float cell_exit(cell_place at, vec3 p_ws, vec3 direction)
{
    vec3 far = cell_low(at) + vec3(greaterThan(direction, vec3(0.0))) * at.edge;
    vec3 t = mix((far - p_ws) / direction, vec3(1e30), lessThan(abs(direction), vec3(1e-9)));
    return max(min(t.x, min(t.y, t.z)), 0.0) + 1e-3 * tree.cascade[0].w;
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

// May anything be in the cell? Sparse cells are asked for their nodes: a node's depths are too coarse to tell. Coarser
// ones hold what sparse nodes gave them where there are many levels of these, and are not asked then.
bool cell_occupied(cell_place at, vec4 seen)
{
    if (at.level > 0 && at.level < KD_SPARSE_LEVELS)
        return tree_node(at.cascade, at.level, tree_wrap(at.cascade, at.level, at.cell)) != KD_EMPTY;
    if (at.level == KD_SPARSE_LEVELS)
        return seen.a > 0.0 || tree_dense_node(at.cascade, tree_wrap(at.cascade, at.level, at.cell)) != KD_EMPTY;
    return seen.a > 0.0;
}

// Largest cells that are trusted to be empty, in a place whose finest cascade is k.
int lod_leap(int k)
{
    return KD_SPARSE_LEVELS > 2 ? k + KD_SPARSE_LEVELS : lod_most();
}

// rgb: what is shown, a: its opacity. Light adds up; of other channels it is the mean of what is met, of opacity the first.
vec4 march(vec3 origin_ws, vec3 direction, int level, uint channel)
{
    float t = enter(origin_ws, direction), transmittance = 1.0;
    vec3 sum = vec3(0.0);
    int lod = level;
    for (int i = 0; i < 2048 && t >= 0.0 && transmittance > 0.01; i++) {
        vec3 p = origin_ws + direction * (t + 1e-4 * tree.cascade[0].w);
        int k = tree_cascade_at(p, 0.0);
        if (k == tree_cascades())
            break;
        int target = clamp(level, tree_finest(k), lod_most());
        lod = clamp(lod, target, max(lod_leap(k), target));
        cell_place at = cell_at(k, lod, p);
        vec4 seen = cell_seen(at, direction);
        if (lod > target && cell_occupied(at, seen)) {
            lod--;
            continue;
        }
        float s = cell_exit(at, p, direction);
        t += s;
        lod += int(seen.a <= 0.0);
        if (seen.a <= 0.0)
            continue;
        if (channel == KD_SHOW_OPACITY)
            return vec4(cell_show(at, k, seen, channel), 1.0);
        float open = open_after(transmittance, seen.a * s / at.edge, depth_residue(FULL_DEPTH));
        sum += (transmittance - open) * cell_show(at, k, seen, channel);
        transmittance = open;
    }
    float opacity = 1.0 - transmittance;
    return vec4(channel == KD_SHOW_RADIANCE || opacity <= 0.0 ? sum : sum / opacity, opacity);
}

void main()
{
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy), size = ivec2(params.view.xy);
    if (any(greaterThanEqual(pixel, size)))
        return;
    vec2 uv = (vec2(pixel) + 0.5) / vec2(size);
    vec3 near = view_position(uv, 0.0), far = view_position(uv, 0.999);
    vec4 c = march(near, normalize(far - near), int(params.view.z), params.view.w);
    imageStore(hdr_image, ivec2(pixel.x, size.y - 1 - pixel.y), vec4(min(c.rgb, vec3(65504.0)), c.a));
}
