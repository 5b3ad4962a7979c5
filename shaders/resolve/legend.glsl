// A heat map and its legend: a bar along the bottom with numbers under it.

// From few to many: blue, cyan, green, yellow, red.
vec3 heat(float share)
{
    float x = clamp(share, 0.0, 1.0) * 4.0;
    return clamp(vec3(x - 2.0, x < 3.0 ? x : 4.0 - x, 2.0 - x), 0.0, 1.0);
}

// c.r: samples, none of which is nearly black, a: 0 background
vec3 heat_color(vec4 c, uint scale)
{
    return c.r > 0.0 ? heat(c.r / float(scale)) : vec3(0.1 * c.a);
}

// Rows of three bits, the top one first.
const uint DIGITS[10] = uint[10](0x7B6Fu, 0x2C97u, 0x73E7u, 0x73CFu, 0x5BC9u, 0x79CFu, 0x79EFu, 0x7252u, 0x7BEFu, 0x7BCFu);

int digits_of(uint value) { return value < 10u ? 1 : value < 100u ? 2 : value < 1000u ? 3 : 4; }

// Is the dot at `at` (0, 0 the top left one) of a number lit?
bool number_lit(uint value, ivec2 at)
{
    int count = digits_of(value), i = at.x / 4, column = at.x % 4;
    if (any(lessThan(at, ivec2(0))) || i >= count || column == 3 || at.y >= 5)
        return false;
    for (int k = i + 1; k < count; k++)
        value /= 10u;
    return (DIGITS[value % 10u] >> (14 - at.y * 3 - column) & 1u) != 0u;
}

const int MARKS = 4; // parts of the bar

vec3 legend_over(vec3 picture, ivec2 pixel, ivec2 size, uint scale)
{
    int dot_size = max(size.y / 180, 1), y = (size.y - 1 - pixel.y) / dot_size; // dots from the bottom
    int first = size.x / 10, width = size.x - 2 * first;
    if (y >= 14)
        return picture;
    float share = (float(pixel.x - first) + 0.5) / float(width);
    if (y >= 8 && y < 12 && share >= 0.0 && share <= 1.0)
        return heat(share);
    for (int i = 0; i <= MARKS; i++) {
        uint value = (scale * uint(i) + uint(MARKS / 2)) / uint(MARKS);
        int low = first + width * i / MARKS - digits_of(value) * 2 * dot_size;
        if (pixel.x >= low && number_lit(value, ivec2((pixel.x - low) / dot_size, 6 - y)))
            return vec3(1.0);
    }
    return vec3(0.0);
}
