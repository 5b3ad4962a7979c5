// The traced pixels that need cones of their own, in any order: each is worked on alone. Buffer "gi.refine": arguments of an
// indirect dispatch of groups of 64, the count, and the pixels.

#ifndef KD_LIST_ACCESS
#define KD_LIST_ACCESS readonly
#endif

layout(std430, binding = 0) KD_LIST_ACCESS buffer refine_block {
    uint refine_args[3];
    uint refine_count;
    uint refine_pixels[]; // x | y << 16
};

ivec2 refine_item(uint i)
{
    return ivec2(refine_pixels[i] & 0xFFFFu, refine_pixels[i] >> 16);
}
