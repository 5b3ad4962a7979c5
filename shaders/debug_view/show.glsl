// Values of channels as colours; shaders/resolve/screen.glsl brings them to the screen.

// What is missing: mid grey on the screen, whatever the exposure.
const float MISSING = 0.2;

vec3 show_missing(uint channel, float exposure)
{
    if (channel == KD_SHOW_VOXEL_NORMAL)
        return vec3(0.5);
    return vec3(channel == KD_SHOW_RADIANCE ? MISSING / exposure : MISSING);
}

vec3 show_normal(vec3 n)
{
    float l = length(n);
    return l > 1e-3 ? n / l * 0.5 + 0.5 : vec3(0.5);
}

// Red, green, blue, yellow from the finest cascade on.
vec3 show_cascade(int c)
{
    return vec3(c == 0 || c == 3, c == 1 || c == 3, c == 2);
}
