#include "runtime/script/curve.h"

#include <math.h>

uint32_t script_curve_segments(const script_curve *curve)
{
    return curve->closed ? curve->point_count : curve->point_count - 1;
}

/* Point i of the path; beyond the ends of an open one the first and the last step are repeated. */
static kd_vec3 control(const script_curve *c, int64_t i)
{
    int64_t n = c->point_count;
    if (c->closed)
        return c->points[((i % n) + n) % n];
    if (i < 0)
        return kd_vec3_sub(kd_vec3_scale(c->points[0], 2), c->points[1]);
    if (i >= n)
        return kd_vec3_sub(kd_vec3_scale(c->points[n - 1], 2), c->points[n - 2]);
    return c->points[i];
}

static float knot_distance(kd_vec3 a, kd_vec3 b)
{
    float d = sqrtf(kd_vec3_length(kd_vec3_sub(a, b)));
    return d > 1e-6f ? d : 1e-6f; /* points that coincide */
}

static kd_vec3 mix(kd_vec3 a, kd_vec3 b, float t)
{
    return kd_vec3_add(a, kd_vec3_scale(kd_vec3_sub(b, a), t));
}

/* The pyramid of Barry and Goldman over centripetal knots; u runs from 0 to 1 between the two middle points.
 */
static kd_vec3 evaluate(const script_curve *c, uint32_t segment, float u)
{
    kd_vec3 p0 = control(c, (int64_t)segment - 1), p1 = control(c, segment);
    kd_vec3 p2 = control(c, (int64_t)segment + 1), p3 = control(c, (int64_t)segment + 2);
    float d0 = knot_distance(p0, p1), d1 = knot_distance(p1, p2), d2 = knot_distance(p2, p3), t = u * d1;
    kd_vec3 a1 = mix(p0, p1, (t + d0) / d0), a2 = mix(p1, p2, t / d1), a3 = mix(p2, p3, (t - d1) / d2);
    kd_vec3 b1 = mix(a1, a2, (t + d0) / (d0 + d1)), b2 = mix(a2, a3, t / (d1 + d2));
    return mix(b1, b2, t / d1);
}

void script_curve_measure(script_curve *curve)
{
    uint32_t count = script_curve_segments(curve) * SCRIPT_CURVE_STEPS;
    double length = 0;
    kd_vec3 last = curve->points[0];
    curve->lengths_m[0] = 0;
    for (uint32_t i = 1; i <= count; i++) {
        uint32_t segment = (i - 1) / SCRIPT_CURVE_STEPS, step = i - segment * SCRIPT_CURVE_STEPS;
        kd_vec3 p = evaluate(curve, segment, (float)step / SCRIPT_CURVE_STEPS);
        length += (double)kd_vec3_length(kd_vec3_sub(p, last));
        curve->lengths_m[i] = (float)length;
        last = p;
    }
    curve->length_m = (float)length;
}

/* Number of the piece in which a length lies. */
static uint32_t find_piece(const script_curve *curve, float length_m)
{
    uint32_t low = 0, high = script_curve_segments(curve) * SCRIPT_CURVE_STEPS - 1;
    while (low < high) {
        uint32_t middle = low + (high - low + 1) / 2;
        if (curve->lengths_m[middle] <= length_m)
            low = middle;
        else
            high = middle - 1;
    }
    return low;
}

kd_vec3 script_curve_at(const script_curve *curve, double share, kd_vec3 *direction)
{
    share = curve->closed ? share - floor(share) : share < 0 ? 0 : share > 1 ? 1 : share;
    float length_m = (float)(share * (double)curve->length_m);
    uint32_t piece = find_piece(curve, length_m), segment = piece / SCRIPT_CURVE_STEPS;
    float from = curve->lengths_m[piece], span = curve->lengths_m[piece + 1] - from;
    float part = span > 0 ? (length_m - from) / span : 0;
    float u = ((float)(piece % SCRIPT_CURVE_STEPS) + (part > 1 ? 1 : part)) / SCRIPT_CURVE_STEPS;
    if (direction) {
        const float around = 1e-3f;
        kd_vec3 before = evaluate(curve, segment, u - around), after = evaluate(curve, segment, u + around);
        *direction = kd_vec3_normalize(kd_vec3_sub(after, before), (kd_vec3){0, 0, -1});
    }
    return evaluate(curve, segment, u);
}
