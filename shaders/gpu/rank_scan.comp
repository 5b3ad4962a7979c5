// Ranks of set bits, pass 2 of 3: exclusive prefix sum of the block sums in one work group; the total goes to a counter.
layout(local_size_x = 256) in;

layout(std140, binding = 0) uniform pass_block { uvec4 pass; }; // y: words, w: counter
layout(std430, binding = 1) buffer sums_block { uint sums[]; };
layout(std430, binding = 2) buffer counters_block { uint counters[]; };

shared uint partial[256];

void main()
{
    uint t = gl_LocalInvocationIndex;
    uint blocks = (pass.y + 31u) / 32u;
    uint each = (blocks + 255u) / 256u;
    uint begin = min(t * each, blocks);
    uint end = min(begin + each, blocks);
    uint sum = 0u;
    for (uint i = begin; i < end; i++)
        sum += sums[i];
    partial[t] = sum;
    barrier();
    if (t == 0u) {
        uint running = 0u;
        for (uint i = 0u; i < 256u; i++) {
            uint own = partial[i];
            partial[i] = running;
            running += own;
        }
        counters[pass.w] = running;
    }
    barrier();
    uint running = partial[t];
    for (uint i = begin; i < end; i++) {
        uint own = sums[i];
        sums[i] = running;
        running += own;
    }
}
