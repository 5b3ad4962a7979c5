#include "runtime/core/half.h"

#include <math.h>
#include <string.h>

/* The largest float that rounds to a finite half, 65504. */
#define LARGEST 65519.996f

uint16_t kd_half_from_float(float f)
{
    if (!(f == f))
        return 0;
    uint32_t bits, sign;
    f = f > LARGEST ? 65504 : f < -LARGEST ? -65504 : f;
    memcpy(&bits, &f, sizeof bits);
    sign = bits >> 16 & 0x8000u;
    bits &= 0x7fffffffu;
    if (bits < 0x38800000u) { /* below 2^-14: a multiple of 2^-24 */
        float scaled = fabsf(f) * 16777216.0f;
        return (uint16_t)(sign | (uint32_t)lrintf(scaled));
    }
    uint32_t odd = bits >> 13 & 1u;
    return (uint16_t)(sign | (bits - 0x38000000u + 0xfffu + odd) >> 13);
}

float kd_half_to_float(uint16_t half)
{
    int exponent = half >> 10 & 31, mantissa = half & 1023;
    float v = exponent == 0    ? ldexpf((float)mantissa, -24)
              : exponent == 31 ? (mantissa ? NAN : INFINITY)
                               : ldexpf((float)(mantissa + 1024), exponent - 25);
    return half & 0x8000 ? -v : v;
}
