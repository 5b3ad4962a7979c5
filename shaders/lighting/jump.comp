// Compares the light in the tree, and what glows, with the frame before: shaders/shared/jump.h. One group, so that sums have an
// order.
layout(local_size_x = 256) in;

#include "shaders/shared/jump.h"
#include "shaders/include/color.glsl"
#include "shaders/include/tree_params.glsl"
#include "shaders/include/emitters_params.glsl"

layout(binding = KD_UNIT_TREE_RADIANCE) uniform sampler3D tree_atlas;
layout(std430, binding = 1) buffer jump_block { uint jump[]; };

const uint THREADS = 256u;
const float MOST_CHANGE = 0.05;       // of all light
const float MOST_EMITTED = 0.1;       // of the emitters' power
const float MOST_WAY = 4.0;           // of the emitters' middle, in voxels
shared float changes[THREADS], sums[THREADS];

float light_of(uint i)
{
    ivec3 cell = ivec3(i % uint(KD_JUMP_EDGE), i / uint(KD_JUMP_EDGE) % uint(KD_JUMP_EDGE), i / uint(KD_JUMP_EDGE * KD_JUMP_EDGE));
    ivec3 first = ivec3(0, KD_DENSE - (2 * KD_DENSE >> KD_JUMP_LEVEL), int(tree.info.x) * 6 * KD_ATLAS_BLOCK);
    vec3 sum = vec3(0.0);
    for (int direction = 0; direction < 6; direction++)
        sum += texelFetch(tree_atlas, cell + first + ivec3(0, 0, direction * (KD_DENSE / 2)), 0).rgb;
    return color_luminance(sum) * tree.light.z;
}

bool emitters_jumped()
{
    vec4 now = vec4(0.0);
    for (uint i = 0u; i < emitters.info.x; i++) {
        float power = color_luminance(emitters.emitter[i].power.rgb);
        now += vec4(power, emitters.emitter[i].place.xyz * power);
    }
    now.yzw /= max(now.x, 1e-20);
    vec4 before;
    for (int k = 0; k < 4; k++) {
        before[k] = uintBitsToFloat(jump[KD_JUMP_EMITTERS + k]);
        jump[KD_JUMP_EMITTERS + k] = floatBitsToUint(now[k]);
    }
    float larger = max(now.x, before.x), way = distance(now.yzw, before.yzw);
    return larger > 0.0 && (abs(now.x - before.x) > MOST_EMITTED * larger || way > MOST_WAY * tree.cascade[0].w);
}

// Cells of a tree that moved are not those of the frame before.
bool tree_has_moved()
{
    bool moved = false;
    for (int k = 0; k < 3; k++) {
        uint corner = uint(tree.origin[tree.info.x - 1u][k]);
        moved = moved || corner != jump[KD_JUMP_ORIGIN + k];
        jump[KD_JUMP_ORIGIN + k] = corner;
    }
    return moved;
}

void main()
{
    uint self = gl_LocalInvocationIndex;
    float change = 0.0, sum = 0.0;
    for (uint i = self; i < uint(KD_JUMP_WORDS - KD_JUMP_CELLS); i += THREADS) {
        float now = light_of(i), before = uintBitsToFloat(jump[uint(KD_JUMP_CELLS) + i]);
        jump[uint(KD_JUMP_CELLS) + i] = floatBitsToUint(now);
        change += abs(now - before);
        sum += max(now, before);
    }
    changes[self] = change;
    sums[self] = sum;
    barrier();
    if (self != 0u)
        return;
    for (uint i = 1u; i < THREADS; i++) {
        change += changes[i];
        sum += sums[i];
    }
    bool moved = tree_has_moved(), glow = emitters_jumped(), now = glow || (!moved && change > MOST_CHANGE * sum);
    jump[KD_JUMP_NOW] = uint(now);
    jump[KD_JUMP_MEASURE] = uint(1e6 * change / max(sum, 1e-20));
}
