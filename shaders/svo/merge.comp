// First step up the tree. One invocation a word of leaf parents, which is eight words of cells in Morton order (a patch): reduces
// the static layer's eight cells to one bit of their parent, joins the dynamic layer's parents, and tells which parents are touched: the static layer was
// built anew there, or something dynamic is or was there.
// With KD_STALE it goes over the stale patches alone and brings what was built anew into the static mask.
layout(local_size_x = 64) in;

#include "shaders/include/svo_book.glsl"
#include "shaders/include/linear.glsl"

layout(std140, binding = 0) uniform pass_block { uvec4 pass; uvec4 layers; }; // x: words of parents, y: first of their mask, z: sparse levels, w: patches; layers.x: 0 when nothing moves
layout(std430, binding = 1) buffer static_block { uint mask_static[]; };
layout(std430, binding = 2) readonly buffer dynamic_block { uint parents_dynamic[]; }; // bits of parents
layout(std430, binding = 3) writeonly buffer parents_block { uint parents[]; };
layout(std430, binding = 4) buffer touched_block { uint touched[]; }; // bits of parents; then those with dynamic cells
#ifdef KD_STALE
layout(std140, binding = 1) uniform stale_places_block { kd_stale_places stale_at; };
layout(std430, binding = 5) readonly buffer stale_block { uint stale[]; };
layout(std430, binding = 6) readonly buffer fresh_block { uint fresh[]; };

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
#endif

uint parents_of(uint cells)
{
    uint four = 0u;
    for (uint k = 0u; k < 4u; k++)
        four |= uint(((cells >> (8u * k)) & 255u) != 0u) << k;
    return four;
}

void main()
{
    uint n = linear_index();
#ifdef KD_STALE
    if (n >= pass.w)
        return;
    uint word = stale[stale_at.patches + n];
#else
    if (n >= pass.x)
        return;
    uint word = n;
#endif
    uint moving = layers.x != 0u ? parents_dynamic[word] : 0u, joined = moving;
    for (uint i = 0u; i < 8u; i++) {
#ifdef KD_STALE
        uint still = load_static(word * 8u + i, n * 8u + i);
#else
        uint still = mask_static[word * 8u + i];
#endif
        joined |= parents_of(still) << (4u * i);
    }
    parents[pass.y + word] = joined;
#ifdef KD_STALE
    uint touch = stale_cells(pass.z - 1u, word);
#else
    uint touch = touched[word] | moving | touched[pass.x + word];
    touched[pass.x + word] = moving;
#endif
    touch &= joined;
    touched[word] = touch;
    if (touch != 0u)
        book[places.words.w + atomicAdd(counters[KD_COUNT_TOUCHED_PARTS], 1u)] = word;
}
