#ifndef SAMPLES_ASSETS_VEC_H
#define SAMPLES_ASSETS_VEC_H

/* Vectors and quaternions for the asset generator, in double precision. Only operations that IEEE 754 rounds
 * exactly are used (+ - * / sqrt floor), and the sine is a polynomial: files come out equal on any machine.
 */

#include <math.h>

typedef struct vec3 {
    double x, y, z;
} vec3;
typedef struct quat {
    double x, y, z, w;
} quat; /* (0,0,0,1) is no rotation */

static inline vec3 v_add(vec3 a, vec3 b)
{
    return (vec3){a.x + b.x, a.y + b.y, a.z + b.z};
}
static inline vec3 v_sub(vec3 a, vec3 b)
{
    return (vec3){a.x - b.x, a.y - b.y, a.z - b.z};
}
static inline vec3 v_mul(vec3 a, double s)
{
    return (vec3){a.x * s, a.y * s, a.z * s};
}
static inline vec3 v_mix(vec3 a, vec3 b, double t)
{
    return v_add(v_mul(a, 1 - t), v_mul(b, t));
}
static inline double v_dot(vec3 a, vec3 b)
{
    return a.x * b.x + a.y * b.y + a.z * b.z;
}
static inline vec3 v_cross(vec3 a, vec3 b)
{
    return (vec3){a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
static inline double v_length(vec3 a)
{
    return sqrt(v_dot(a, a));
}
static inline vec3 v_unit(vec3 a)
{
    double l = v_length(a);
    return l > 0 ? v_mul(a, 1 / l) : (vec3){0, 1, 0};
}

static inline double clamp01(double x)
{
    return x < 0 ? 0 : x > 1 ? 1 : x;
}
static inline double mix(double a, double b, double t)
{
    return a + (b - a) * t;
}
/** Rise smoothly from 0 at x = a to 1 at x = b. */
static inline double smooth(double a, double b, double x)
{
    double t = clamp01((x - a) / (b - a));
    return t * t * (3 - 2 * t);
}

/** Sine of an angle given in turns (1 turn = 360 degrees). */
static inline double sin_turns(double turns)
{
    double t = turns - floor(turns + 0.5); /* -0.5 .. 0.5 */
    if (t > 0.25)
        t = 0.5 - t;
    else if (t < -0.25)
        t = -0.5 - t;
    double x = t * 6.283185307179586, xx = x * x;
    /* Taylor series to x^13: below 1e-11 within a quarter turn. */
    return x * (1 + xx * (-1.0 / 6 +
                          xx * (1.0 / 120 + xx * (-1.0 / 5040 +
                                                  xx * (1.0 / 362880 + xx * (-1.0 / 39916800 +
                                                                             xx * (1.0 / 6227020800.0)))))));
}
static inline double cos_turns(double turns)
{
    return sin_turns(turns + 0.25);
}

static inline quat q_mul(quat a, quat b)
{
    return (quat){
        a.w * b.x + a.x * b.w + a.y * b.z - a.z * b.y, a.w * b.y - a.x * b.z + a.y * b.w + a.z * b.x,
        a.w * b.z + a.x * b.y - a.y * b.x + a.z * b.w, a.w * b.w - a.x * b.x - a.y * b.y - a.z * b.z};
}
static inline quat q_inverse(quat q)
{
    return (quat){-q.x, -q.y, -q.z, q.w};
}
static inline quat q_unit(quat q)
{
    double s = 1 / sqrt(q.x * q.x + q.y * q.y + q.z * q.z + q.w * q.w);
    return (quat){q.x * s, q.y * s, q.z * s, q.w * s};
}
static inline vec3 q_rotate(quat q, vec3 v)
{
    vec3 u = {q.x, q.y, q.z}, c = v_mul(v_cross(u, v), 2);
    return v_add(v, v_add(v_mul(c, q.w), v_cross(u, c)));
}
/** Turn about the unit vector `axis`. */
static inline quat q_axis(vec3 axis, double degrees)
{
    double s = sin_turns(degrees / 720), c = cos_turns(degrees / 720);
    return (quat){axis.x * s, axis.y * s, axis.z * s, c};
}
/** Turn about x (nose down is positive), then z (roll), then y (to the left is positive). */
static inline quat q_euler(double pitch_deg, double yaw_deg, double roll_deg)
{
    quat x = q_axis((vec3){1, 0, 0}, pitch_deg), y = q_axis((vec3){0, 1, 0}, yaw_deg);
    return q_mul(y, q_mul(q_axis((vec3){0, 0, 1}, roll_deg), x));
}
/** The shortest turn from unit vector `a` to unit vector `b`, which must not be opposite. */
static inline quat q_between(vec3 a, vec3 b)
{
    vec3 c = v_cross(a, b);
    return q_unit((quat){c.x, c.y, c.z, 1 + v_dot(a, b)});
}

#endif
