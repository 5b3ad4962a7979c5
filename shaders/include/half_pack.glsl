// Radiance in few bits. rgb9e5: 9 bits a channel and a shared power of two from 2^-15 to 2^16.

uint rgb9e5_pack(vec3 color)
{
    vec3 c = clamp(color, 0.0, 65408.0);
    float top = max(max(c.r, c.g), max(c.b, 1e-5));
    float exponent = clamp(ceil(log2(top)), -15.0, 16.0);
    uvec3 m = min(uvec3(round(c * exp2(9.0 - exponent))), uvec3(511u));
    return m.r | m.g << 9 | m.b << 18 | uint(exponent + 15.0) << 27;
}

vec3 rgb9e5_unpack(uint word)
{
    float scale = uintBitsToFloat(((word >> 27) + 103u) << 23); // 2^(exponent - 24)
    return vec3(word & 511u, (word >> 9) & 511u, (word >> 18) & 511u) * scale;
}
