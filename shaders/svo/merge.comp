// First step up the tree: joins the masks of the two layers and reduces eight cells to one bit of their parent. One
// invocation a parent word, which is eight words of cells in Morton order.
layout(local_size_x = 64) in;

layout(std140, binding = 0) uniform pass_block { uvec4 pass; }; // x: parent words, y: 1 when there is a static mask
layout(std430, binding = 0) readonly buffer static_block { uint mask_static[]; };
layout(std430, binding = 1) readonly buffer dynamic_block { uint mask_dynamic[]; };
layout(std430, binding = 2) writeonly buffer parents_block { uint parents[]; };

void main()
{
    uint word = gl_GlobalInvocationID.x;
    if (word >= pass.x)
        return;
    uint parent = 0u;
    for (uint i = 0u; i < 8u; i++) {
        uint bits = mask_static[word * 8u + i] | mask_dynamic[word * 8u + i];
        for (uint k = 0u; k < 4u; k++)
            parent |= uint(((bits >> (8u * k)) & 255u) != 0u) << (4u * i + k);
    }
    parents[word] = parent;
}
