// Makes emitters of the blocks that glow: of the finest lattice whose blocks are few enough, each twice as coarse as the one
// before. With too many in every lattice, or when they stand round their middle like the walls of a room, what glows is large:
// cones light by it as well as narrow ones would, and near to it better.
layout(local_size_x = 256) in;

#include "shaders/include/tree_params.glsl"
#include "shaders/shared/emitters.h"

layout(std430, binding = 0) readonly buffer sums_block { uint sums[]; };
layout(std430, binding = 1) coherent buffer emitters_block { kd_emitters_params made; };

const uint THREADS = 256u;
const int LATTICES = 2;
const float MOST_ROUND = 0.25; // share of all directions in which glowing surface is seen from the middle of all
shared uint counts[THREADS];

// Moments of what glows, in cells from the cascade's low corner.
struct moments {
    float weight, area, double_sided;
    vec3 power, first, normal;
    float second;
};

uint blocks_of(int lattice) { return uint(KD_EMITTER_BLOCKS) >> lattice; }

uvec3 block_at(int lattice, uint i)
{
    uint n = blocks_of(lattice);
    return uvec3(i % n, i / n % n, i / (n * n) % n);
}

void add_finest(inout moments m, uint c, uvec3 block)
{
    uint n = uint(KD_EMITTER_BLOCKS), at = (((c * n + block.z) * n + block.y) * n + block.x) * KD_EMITTER_WORDS;
    float weight = float(sums[at + 13u]);
    if (weight == 0.0)
        return;
    vec3 corner = vec3(block << (tree.info.w + uint(KD_EMITTER_BLOCK_LOG2)));
    for (int k = 0; k < 3; k++) {
        m.power[k] += float(sums[at + uint(k)]);
        float first = 0.5 * float(sums[at + 3u + uint(k)]), second = float(sums[at + 6u + uint(k)]) + 0.25 * weight;
        m.second += second + 2.0 * corner[k] * first + corner[k] * corner[k] * weight;
        m.first[k] += first + corner[k] * weight;
        m.normal[k] += float(int(sums[at + 9u + uint(k)])) / 127.0;
    }
    m.double_sided += float(sums[at + 12u]);
    m.weight += weight;
    m.area += float(sums[at + 14u]);
}

moments sum_of(int lattice, uint i)
{
    moments m = moments(0.0, 0.0, 0.0, vec3(0.0), vec3(0.0), vec3(0.0), 0.0);
    uint n = blocks_of(lattice), c = i / (n * n * n), children = 1u << lattice;
    uvec3 block = block_at(lattice, i) << lattice;
    for (uint k = 0u; k < children * children * children; k++)
        add_finest(m, c, block + uvec3(k, k / children, k / (children * children)) % children);
    return m;
}

bool glows(int lattice, uint i)
{
    uint n = blocks_of(lattice), c = i / (n * n * n), children = 1u << lattice;
    uvec3 block = block_at(lattice, i) << lattice;
    uint some = 0u, edge = uint(KD_EMITTER_BLOCKS);
    for (uint k = 0u; k < children * children * children; k++) {
        uvec3 at = block + uvec3(k, k / children, k / (children * children)) % children;
        some |= sums[(((c * edge + at.z) * edge + at.y) * edge + at.x) * KD_EMITTER_WORDS + 13u];
    }
    return some != 0u;
}

kd_emitter emitter_of(moments m, uint c)
{
    float span = tree.cascade[c].w, inverse = 1.0 / m.weight;
    vec3 middle = m.first * inverse;
    // A disc's mean squared distance from its middle is half of its radius squared.
    float spread = max(m.second * inverse - dot(middle, middle), 0.0), radius = sqrt(2.0 * spread + 0.25);
    kd_emitter e;
    e.place = vec4(tree.cascade[c].xyz + middle * span, radius * span);
    e.normal = vec4(m.normal * inverse, m.double_sided * inverse);
    float face = span * span / KD_EMITTER_AREA_ONE;
    e.power = vec4(m.power * (face * tree.light.x / KD_EMITTER_RADIANCE_ONE), m.area * face);
    return e;
}

// Share of all directions in which a point sees the front of what glows.
float share_seen(uint count, vec3 p_ws)
{
    float sum = 0.0;
    for (uint i = 0u; i < count; i++) {
        kd_emitter e = made.emitter[i];
        vec3 to_point = p_ws - e.place.xyz;
        float d2 = dot(to_point, to_point) + e.place.w * e.place.w;
        sum += e.power.w * max(dot(e.normal.xyz, to_point), 0.0) * inversesqrt(d2) / d2;
    }
    return sum / (4.0 * 3.14159265);
}

bool stand_round(uint count)
{
    vec4 sum = vec4(0.0);
    for (uint i = 0u; i < count; i++)
        sum += vec4(made.emitter[i].place.xyz, 1.0) * made.emitter[i].power.w;
    return share_seen(count, sum.xyz / max(sum.w, 1e-20)) > MOST_ROUND;
}

void main()
{
    uint self = gl_LocalInvocationIndex;
    for (int lattice = 0; lattice < LATTICES; lattice++) {
        uint n = blocks_of(lattice), total = tree.info.x * n * n * n, share = (total + THREADS - 1u) / THREADS;
        uint first = min(self * share, total), last = min(first + share, total), own = 0u;
        for (uint i = first; i < last; i++)
            own += uint(glows(lattice, i));
        barrier();
        counts[self] = own;
        barrier();
        uint before = 0u, all_of_them = 0u;
        for (uint i = 0u; i < THREADS; i++) {
            before += i < self ? counts[i] : 0u;
            all_of_them += counts[i];
        }
        if (all_of_them > uint(KD_MAX_EMITTERS))
            continue;
        for (uint i = first; i < last; i++)
            if (glows(lattice, i))
                made.emitter[before++] = emitter_of(sum_of(lattice, i), i / (n * n * n));
        memoryBarrierBuffer();
        barrier();
        if (self == 0u)
            made.info = uvec4(stand_round(all_of_them) ? 0u : all_of_them, 0u, 0u, 0u);
        return;
    }
    if (self == 0u)
        made.info = uvec4(0u);
}
