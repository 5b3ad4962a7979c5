#include "components/cone_set.h"

#include <math.h>

#define PI 3.14159265f

/* Cosine-weighted share of the hemisphere between the polar angles a and b: the integral of 2 sin cos. */
static float share(float a, float b)
{
    float sa = sinf(a), sb = sinf(b);
    return sb * sb - sa * sa;
}

static void put(struct kd_gl_vec4 *out, float x, float y, float z, float weight)
{
    float inverse = 1 / sqrtf(x * x + y * y + z * z);
    *out = (struct kd_gl_vec4){x * inverse, y * inverse, z * inverse, weight};
}

/* The sets are turned against each other by `turn`. */
static uint32_t ring(struct kd_gl_vec4 *out, uint32_t count, float polar, float first, float turn, float tilt,
                     float weight)
{
    for (uint32_t i = 0; i < count; i++)
        for (uint32_t v = 0; v < KD_CONE_SETS; v++) {
            float azimuth = first + 2 * PI * (float)i / (float)count + turn * (float)v;
            put(&out[KD_CONE_SETS * i + v], sinf(polar) * cosf(azimuth), sinf(polar) * sinf(azimuth),
                cosf(polar) + tilt * ((float)v - 1.5f), weight / (float)count);
        }
    return KD_CONE_SETS * count;
}

static uint32_t cap(struct kd_gl_vec4 *out, float polar, float tilt)
{
    for (uint32_t v = 0; v < KD_CONE_SETS; v++) {
        float azimuth = 0.25f * PI + 0.5f * PI * (float)v, aside = tilt;
        put(&out[v], aside * cosf(azimuth), aside * sinf(azimuth), 1, share(0, polar));
    }
    return KD_CONE_SETS;
}

/* Up to 4 cones form one ring at the polar angle whose cosine is the weighted mean (2/3); up to 8 a cap of 30
 * degrees and a ring at 60 degrees below it; more get a second ring. */
void kd_cone_set_make(struct kd_gl_vec4 *out, uint32_t count, float tilt, float cap_tilt)
{
    const float quarter = 0.5f * PI;
    if (count <= 4) {
        ring(out, count, acosf(2.0f / 3.0f), 0, quarter / (float)count, tilt, 1);
        return;
    }
    if (count <= 8) {
        out += cap(out, PI / 6, cap_tilt);
        ring(out, count - 1, PI / 3, 0, quarter / (float)(count - 1), tilt, share(PI / 6, PI / 2));
        return;
    }
    float inner = 18 * PI / 180, middle = 54 * PI / 180;
    uint32_t rest = count - 1, first = rest * 3 / 8;
    float turn = quarter / (float)(rest - first);
    out += cap(out, inner, cap_tilt);
    out += ring(out, first, 36 * PI / 180, 0, turn, tilt, share(inner, middle));
    ring(out, rest - first, 68 * PI / 180, 0.3f, turn, tilt, share(middle, PI / 2));
}
