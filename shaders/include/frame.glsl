#ifndef KD_INCLUDE_FRAME_GLSL
#define KD_INCLUDE_FRAME_GLSL

// A frame round n, without a seam where n.z changes sign (Duff et al. 2017, listing 3).
mat3 frame_round(vec3 n)
{
    float s = n.z >= 0.0 ? 1.0 : -1.0;
    float a = -1.0 / (s + n.z), b = n.x * n.y * a;
    return mat3(vec3(1.0 + s * n.x * n.x * a, s * b, -s * n.x), vec3(b, s + n.y * n.y * a, -n.y), n);
}

#endif
