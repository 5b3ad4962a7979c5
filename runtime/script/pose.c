/* Rotations that scenarios write: three angles, or a point to look at. */
#include "runtime/script/internal.h"

#include <math.h>

#define DEG  (0.017453292519943295)
#define POLE 4e-7 /* cosine that rounding to floats leaves of a right angle, with some room */

static kd_quat quat_mul(kd_quat a, kd_quat b)
{
    return (kd_quat){
        a.w * b.x + a.x * b.w + a.y * b.z - a.z * b.y, a.w * b.y - a.x * b.z + a.y * b.w + a.z * b.x,
        a.w * b.z + a.x * b.y - a.y * b.x + a.z * b.w, a.w * b.w - a.x * b.x - a.y * b.y - a.z * b.z};
}

/* Half an angle in degrees, reduced first so that large angles stay exact. */
static void half_angle(float deg, float *sine, float *cosine)
{
    double half = fmod((double)deg, 720.0) * 0.5 * DEG;
    *sine = (float)sin(half);
    *cosine = (float)cos(half);
}

kd_quat script_rotation_from_deg(kd_vec3 deg)
{
    kd_quat x = {0, 0, 0, 1}, y = x, z = x;
    half_angle(deg.x, &x.x, &x.w);
    half_angle(deg.y, &y.y, &y.w);
    half_angle(deg.z, &z.z, &z.w);
    return quat_mul(z, quat_mul(y, x));
}

/* An arc sine would lose half the digits near 90 degrees; every angle comes from an arc tangent instead,
 * whose two sides are the matrix's elements times the quaternion's squared length. At the pole itself x and z
 * turn about the same axis: all of it goes to x. */
kd_vec3 script_rotation_to_deg(kd_quat q)
{
    double x = (double)q.x, y = (double)q.y, z = (double)q.z, w = (double)q.w;
    double r00 = w * w + x * x - y * y - z * z, r10 = 2 * (x * y + w * z);
    double r21 = 2 * (y * z + w * x), r22 = w * w - x * x - y * y + z * z;
    double sine = 2 * (w * y - x * z), cosine = hypot(r00, r10);
    double about_x = atan2(r21, r22), about_y = atan2(sine, cosine), about_z = atan2(r10, r00);
    if (cosine < POLE * fabs(sine)) {
        about_x = remainder(2 * atan2(x, w), 360 * DEG);
        about_z = 0;
    }
    return (kd_vec3){(float)(about_x / DEG), (float)(about_y / DEG), (float)(about_z / DEG)};
}

/* Quaternion of the rotation whose columns are right, up, back. */
static kd_quat quat_from_axes(kd_vec3 r, kd_vec3 u, kd_vec3 b)
{
    float trace = r.x + u.y + b.z;
    if (trace > 0) {
        float s = 2 * sqrtf(trace + 1);
        return (kd_quat){(u.z - b.y) / s, (b.x - r.z) / s, (r.y - u.x) / s, s / 4};
    }
    if (r.x >= u.y && r.x >= b.z) {
        float s = 2 * sqrtf(1 + r.x - u.y - b.z);
        return (kd_quat){s / 4, (u.x + r.y) / s, (b.x + r.z) / s, (u.z - b.y) / s};
    }
    if (u.y >= b.z) {
        float s = 2 * sqrtf(1 + u.y - r.x - b.z);
        return (kd_quat){(u.x + r.y) / s, s / 4, (b.y + u.z) / s, (b.x - r.z) / s};
    }
    float s = 2 * sqrtf(1 + b.z - r.x - u.y);
    return (kd_quat){(b.x + r.z) / s, (b.y + u.z) / s, s / 4, (r.y - u.x) / s};
}

kd_quat script_look_at(kd_vec3 from, kd_vec3 to)
{
    kd_vec3 back = kd_vec3_sub(from, to);
    float length = kd_vec3_length(back);
    if (!(length > 0))
        return (kd_quat){0, 0, 0, 1};
    back = kd_vec3_scale(back, 1 / length);
    kd_vec3 up = {0, 1, 0};
    if (fabsf(back.y) >
        0.99999f) /* straight up or down: the picture's top points to -Z, or +Z when looking up */
        up = (kd_vec3){0, 0, back.y > 0 ? -1.0f : 1.0f};
    kd_vec3 right = kd_vec3_normalize(kd_vec3_cross(up, back), (kd_vec3){1, 0, 0});
    return quat_from_axes(right, kd_vec3_cross(back, right), back);
}
