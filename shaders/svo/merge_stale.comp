// First step up the tree, where the static layer is built anew. One invocation a stale patch: a word of leaf parents, which is
// eight words of cells in Morton order. Brings what was built anew into the static mask, reduces eight cells to one bit of
// their parent, joins the dynamic layer's parents, and lists words with touched parents.
layout(local_size_x = 64) in;

#include "shaders/include/svo_book.glsl"
#include "shaders/include/linear.glsl"

layout(std140, binding = 0) uniform pass_block { uvec4 pass; uvec4 layers; }; // x: patches, y: first word of the parents' mask, z: sparse levels, w: bits of its words; layers.x: 0 when nothing moves
layout(std140, binding = 1) uniform stale_places_block { kd_stale_places stale_at; };
layout(std430, binding = 1) buffer static_block { uint mask_static[]; };
layout(std430, binding = 2) buffer diff_block { uint diff[]; };
layout(std430, binding = 3) buffer parents_block { uint parents[]; };
layout(std430, binding = 4) writeonly buffer touched_block { uint touched[]; }; // bits of parents, of listed words alone
layout(std430, binding = 5) readonly buffer stale_block { uint stale[]; };
layout(std430, binding = 6) readonly buffer fresh_block { uint fresh[]; };

#include "shaders/svo/merge.glsl"

// Spreads the low four bits to bytes of ones.
uint bytes_of(uint four)
{
    uint ones = (four & 1u) | (four & 2u) << 7 | (four & 4u) << 14 | (four & 8u) << 21;
    return ones * 255u;
}

// Cells of a word that lie in stale bricks. `levels`: from the dense cells down to the level of the word.
uint stale_cells(uint levels, uint word)
{
    if (levels == 0u)
        return stale[stale_at.bits + word];
    if (levels == 1u)
        return bytes_of(stale[stale_at.bits + (word >> 3)] >> (4u * (word & 7u)));
    uint brick = levels == 2u ? word >> 1 : word >> 4;
    return (stale[stale_at.bits + (brick >> 5)] >> (brick & 31u) & 1u) != 0u ? KD_EMPTY : 0u;
}

uint load_static(uint at, uint fresh_at)
{
    uint before = mask_static[at], now = (before & ~stale_cells(pass.z, at)) | fresh[fresh_at];
    if (now != before) {
        mask_static[at] = now;
        atomicAdd(counters[KD_COUNT_STATIC], uint(bitCount(now)) - uint(bitCount(before)));
    }
    return now;
}

void main()
{
    uint n = linear_index();
    if (n >= pass.x)
        return;
    uint word = stale[stale_at.patches + n], joined = layers.x != 0u ? parents_dynamic(word) : 0u;
    for (uint i = 0u; i < 8u; i++)
        joined |= parents_of(load_static(word * 8u + i, n * 8u + i)) << (4u * i);
    put_parents(word, joined);
    uint touch = stale_cells(pass.z - 1u, word) & joined;
    if (touch == 0u)
        return;
    touched[word] = touch;
    book[places.words.w + atomicAdd(counters[KD_COUNT_TOUCHED_PARTS], 1u)] = word;
}
