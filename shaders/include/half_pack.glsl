// Radiance in few bits. rgb9e5: 9 bits a channel and a shared power of two from 2^-15 to 2^16.

uint rgb9e5_pack(vec3 color)
{
    vec3 c = clamp(color, 0.0, 65408.0);
    float top = max(max(c.r, c.g), max(c.b, 1e-5));
    uint exponent = clamp((floatBitsToUint(top) + 0x7FFFFFu) >> 23, 112u, 143u); // of the power of two that is not below it, + 127
    uvec3 m = min(uvec3(c * uintBitsToFloat((263u - exponent) << 23) + 0.5), uvec3(511u));
    return m.r | m.g << 9 | m.b << 18 | (exponent - 112u) << 27;
}

vec3 rgb9e5_unpack(uint word)
{
    float scale = uintBitsToFloat(((word >> 27) + 103u) << 23); // 2^(exponent - 24)
    return vec3(word & 511u, (word >> 9) & 511u, (word >> 18) & 511u) * scale;
}
