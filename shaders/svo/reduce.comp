// Further steps up: eight nodes to one bit of their parent, inside one buffer of all levels' masks.
layout(local_size_x = 64) in;

layout(std140, binding = 0) uniform pass_block { uvec4 pass; }; // x: parent words, y: first child word, z: first parent word
layout(std430, binding = 0) buffer masks_block { uint masks[]; };

void main()
{
    uint word = gl_GlobalInvocationID.x;
    if (word >= pass.x)
        return;
    uint parent = 0u;
    for (uint i = 0u; i < 8u; i++) {
        uint bits = masks[pass.y + word * 8u + i];
        for (uint k = 0u; k < 4u; k++)
            parent |= uint(((bits >> (8u * k)) & 255u) != 0u) << (4u * i + k);
    }
    masks[pass.z + word] = parent;
}
