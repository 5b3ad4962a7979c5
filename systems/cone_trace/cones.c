#include "systems/cone_trace/cones.h"

#include <math.h>

static const float PI = 3.14159265f;

/* Cosine-weighted share of the hemisphere between the polar angles a and b: the integral of 2 sin cos. */
static float share(float a, float b)
{
    float sa = sinf(a), sb = sinf(b);
    return sb * sb - sa * sa;
}

static unsigned ring(kd_vec4 *out, unsigned count, float polar, float turn, float weight)
{
    for (unsigned i = 0; i < count; i++) {
        float azimuth = turn + 2 * PI * (float)i / (float)count;
        out[i] = (kd_vec4){sinf(polar) * cosf(azimuth), sinf(polar) * sinf(azimuth), cosf(polar),
                           weight / (float)count};
    }
    return count;
}

/* Up to 4 cones form one ring at the polar angle whose cosine is the weighted mean (2/3); up to 8 a cap of 30
 * degrees and a ring at 60 degrees below it; more get a second ring. */
float cones_make(kd_vec4 *out, unsigned count)
{
    if (count <= 4) {
        ring(out, count, acosf(2.0f / 3.0f), 0, 1);
        return 2 * PI / (float)count;
    }
    float cap = PI / 6;
    if (count <= 8) {
        out[0] = (kd_vec4){0, 0, 1, share(0, cap)};
        ring(out + 1, count - 1, PI / 3, 0, share(cap, PI / 2));
        return 2 * PI / (float)(count - 1);
    }
    float inner = 18 * PI / 180, middle = 54 * PI / 180;
    unsigned rest = count - 1, first = rest * 3 / 8;
    out[0] = (kd_vec4){0, 0, 1, share(0, inner)};
    ring(out + 1, first, 36 * PI / 180, 0, share(inner, middle));
    ring(out + 1 + first, rest - first, 68 * PI / 180, 0.3f, share(middle, PI / 2));
    return 2 * PI / (float)(rest - first);
}
