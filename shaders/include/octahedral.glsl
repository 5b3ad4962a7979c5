#ifndef KD_INCLUDE_OCTAHEDRAL_GLSL
#define KD_INCLUDE_OCTAHEDRAL_GLSL

// Unit vectors in 2 x snorm8: the octahedron's lower half folded over the upper one (Cigolle et al. 2014). The opposite of what
// can be stored can be stored.
vec3 octahedral_unpack(uint word)
{
    vec2 e = vec2(ivec2(int(word << 24) >> 24, int(word << 16) >> 24)) * (1.0 / 127.0);
    float z = 1.0 - abs(e.x) - abs(e.y);
    vec2 folded = (1.0 - abs(e.yx)) * mix(vec2(-1.0), vec2(1.0), greaterThanEqual(e, vec2(0.0)));
    return normalize(vec3(z < 0.0 ? folded : e, z));
}

uint octahedral_pack(vec3 n)
{
    n /= abs(n.x) + abs(n.y) + abs(n.z);
    vec2 folded = (1.0 - abs(n.yx)) * mix(vec2(-1.0), vec2(1.0), greaterThanEqual(n.xy, vec2(0.0)));
    ivec2 e = ivec2(round((n.z < 0.0 ? folded : n.xy) * 127.0));
    return (uint(e.x) & 255u) | (uint(e.y) & 255u) << 8;
}

#endif
