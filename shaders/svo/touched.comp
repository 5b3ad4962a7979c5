// Lists the numbers of the touched leaf parents: those in stale bricks. One invocation a stale patch, a word of their mask.
layout(local_size_x = 64) in;

#include "shaders/include/svo_find.glsl"
#include "shaders/include/linear.glsl"

layout(std140, binding = 0) uniform pass_block { uvec4 pass; }; // x: patches, y: level of the leaf parents, z: first word of their mask
layout(std140, binding = 1) uniform stale_places_block { kd_stale_places stale_at; };
layout(std430, binding = 1) readonly buffer stale_block { uint stale[]; };
layout(std430, binding = 2) writeonly buffer work_block { uint work[]; };
layout(std430, binding = 5) readonly buffer parents_block { uint parents[]; };

#include "shaders/svo/stale_parents.glsl"

void main()
{
    uint n = linear_index();
    if (n >= pass.x)
        return;
    uint word = stale[stale_at.patches + n], bits = stale_parents(pass.y, word) & parents[pass.z + word];
    uint at = bits != 0u ? atomicAdd(counters[KD_COUNT_TOUCHED], uint(bitCount(bits))) : 0u;
    for (; bits != 0u && at < places.size.x; bits &= bits - 1u, at++)
        work[at] = find_node(pass.y, word * 32u + uint(findLSB(bits)));
}
