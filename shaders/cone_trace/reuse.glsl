// Light that was traced at a place in the frame before, where it still holds: the same surface was seen from as near as makes no
// difference, with cones turned the same way, little has come or gone in front of it, and light has not jumped.

#include "shaders/shared/jump.h"
#define KD_CHANGES_BINDING 3
#include "shaders/include/changes.glsl"

layout(binding = KD_UNIT_BEFORE_DIFFUSE) uniform sampler2D before_diffuse;
layout(binding = KD_UNIT_BEFORE_SPECULAR) uniform sampler2D before_specular;
layout(binding = KD_UNIT_BEFORE_GUIDE) uniform sampler2D before_guide;
layout(std430, binding = 2) readonly buffer jump_block { uint jump[]; };

struct reused_light {
    bool found;
    vec4 diffuse, specular;
};

// Whose turn it is: every second pixel like a chessboard, or one of every two by two. smooth.glsl weighs all turns alike.
bool is_due(ivec2 at)
{
    uint turn = gather.reuse.x == 2u ? uint(at.x + at.y) & 1u : uint(at.x & 1) | uint(at.y & 1) << 1;
    return turn == (gather.reuse.y & (gather.reuse.x - 1u));
}

// Did leaf cells come or go near the surface, as far as 16 voxels in front of it?
bool changed_near(vec3 p_ws, vec3 normal_ws)
{
    vec3 from_centre = abs(p_ws - tree.centre.xyz) * tree.centre.w;
    float reach = max(from_centre.x, max(from_centre.y, from_centre.z));
    bool changed = false;
    uint c = min(uint(reach >= 1.0) + uint(reach >= 2.0) + uint(reach >= 4.0), tree.info.x - 1u);
    for (int i = 1; i <= 16; i *= 2) {
        vec3 at = (p_ws + normal_ws * (float(i) * tree.cascade[c].w) - tree.cascade[c].xyz) / tree.cascade[c].w;
        ivec3 cell = clamp(ivec3(floor(at)), ivec3(0), ivec3(int(tree.info.y) - 1));
        changed = changed || cells_changed_around(c, cell);
    }
    return changed;
}

const float NEAREST = 0.25;     // of the spacing of traced pixels
const float SAME_DEPTH = 0.003; // of the distance
const float SAME_SIDE = 0.97;   // cosine

// at: of the grid of every n-th pixel; guide_scale: texels of the guide for each of them
reused_light reuse_find(ivec2 at, int n, int guide_scale, vec3 p_ws, vec3 normal_ws)
{
    reused_light o = reused_light(false, vec4(0.0), vec4(0.0));
    if (gather.reuse.x == 0u || jump[KD_JUMP_NOW] != 0u || is_due(at))
        return o;
    vec4 clip = gather.before * vec4(p_ws, 1.0);
    vec2 place = ((clip.xy / clip.w * 0.5 + 0.5) * vec2(gather.size.xy) - 0.5) / float(n);
    ivec2 was = ivec2(round(place)), last = (ivec2(gather.size.xy) - 1) / n;
    if (any(greaterThan(abs(place - vec2(was)), vec2(NEAREST))) || any(lessThan(was, ivec2(0))) || any(greaterThan(was, last)) ||
        ((was ^ at) & 1) != ivec2(0))
        return o;
    vec4 guide = texelFetch(before_guide, was * guide_scale, 0);
    float depth = dot(gather.before_eye.xyz, p_ws) + gather.before_eye.w;
    vec4 specular = texelFetch(before_specular, was, 0);
    float oldest = KD_TRACED_ROUGH + KD_TRACED_AGE * (float(gather.reuse.x) - 1.5);
    if (abs(guide.w - depth) > SAME_DEPTH * abs(depth) || dot(guide.xyz, normal_ws) < SAME_SIDE || specular.a < KD_TRACED_ROUGH ||
        specular.a > oldest || changed_near(p_ws, normal_ws))
        return o;
    return reused_light(true, texelFetch(before_diffuse, was, 0), specular + vec4(0.0, 0.0, 0.0, KD_TRACED_AGE));
}
