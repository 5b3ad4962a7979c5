// What both merges do with a word of leaf parents.

layout(binding = 0) uniform usamplerBuffer moving; // rgba32ui: words of the dynamic layer, four a texel

// Bits of the dynamic layer's leaf parents.
uvec4 four_parents_dynamic(uint four_words) { return texelFetch(moving, int(four_words)); }

uint parents_dynamic(uint word) { return four_parents_dynamic(word >> 2)[word & 3u]; }

// Writes a word of leaf parents, and notes when it is not what it was. Nodes that stayed away left their parents there, so that
// all words are noted then.
void put_parents(uint word, uint joined)
{
    if (parents[pass.y + word] == joined && counters[KD_COUNT_AWAY] == 0u)
        return;
    parents[pass.y + word] = joined;
    atomicOr(diff[pass.w + (word >> 5)], 1u << (word & 31u));
}
