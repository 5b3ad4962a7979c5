// Further steps up: eight nodes to one bit of their parent, inside one buffer of all levels' masks, for words in which any of
// the eight words below has changed. One invocation a block of 32 words.
layout(local_size_x = 64) in;

layout(std140, binding = 0) uniform pass_block { uvec4 pass; uvec4 at; }; // x: blocks, y: first child word, z: first parent word; at.x: bits of the children's words, y: of the parents'
layout(std430, binding = 0) buffer masks_block { uint masks[]; };
layout(std430, binding = 1) buffer diff_block { uint diff[]; };

uint parents_of(uint word)
{
    uint parent = 0u;
    for (uint i = 0u; i < 8u; i++) {
        uint bits = masks[pass.y + word * 8u + i];
        for (uint k = 0u; k < 4u; k++)
            parent |= uint(((bits >> (8u * k)) & 255u) != 0u) << (4u * i + k);
    }
    return parent;
}

// Bits of the words that have a changed word below.
uint words_below(uint block)
{
    uint words = 0u;
    for (uint i = 0u; i < 8u; i++) {
        uint below = diff[at.x + block * 8u + i];
        for (uint k = 0u; k < 4u; k++)
            words |= uint(((below >> (8u * k)) & 255u) != 0u) << (4u * i + k);
    }
    return words;
}

void main()
{
    uint block = gl_GlobalInvocationID.x, changed = 0u;
    if (block >= pass.x)
        return;
    for (uint words = words_below(block); words != 0u; words &= words - 1u) {
        uint bit = uint(findLSB(words)), word = block * 32u + bit, parents = parents_of(word);
        if (masks[pass.z + word] == parents)
            continue;
        masks[pass.z + word] = parents;
        changed |= 1u << bit;
    }
    diff[at.y + block] = changed;
}
