// A pixel in a list of work: x | y << 16.
uint pixel_item(ivec2 pixel) { return uint(pixel.x) | uint(pixel.y) << 16; }

ivec2 listed_pixel(uint i)
{
    return ivec2(work_items[i] & 0xFFFFu, work_items[i] >> 16);
}
