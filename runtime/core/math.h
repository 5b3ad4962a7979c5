#ifndef KD_CORE_MATH_H
#define KD_CORE_MATH_H

/* Plain vector types for components and asset descriptions; cglm works on their .v through the casts below.
 * Column vectors, right-handed, +Y up, metres, radians; matrices are column-major as in GL. */

#include <string.h>

#include <cglm/cglm.h>

typedef struct kd_vec2 {
    float x, y;
} kd_vec2;
typedef struct kd_vec3 {
    float x, y, z;
} kd_vec3;
typedef struct kd_vec4 {
    float x, y, z, w;
} kd_vec4;
typedef struct kd_quat {
    float x, y, z, w;
} kd_quat; /* (0,0,0,1) is no rotation */
typedef struct kd_mat4 {
    float m[16];
} kd_mat4; /* column-major */

#define KD_MAT4_IDENTITY ((kd_mat4){{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1}})

/** Multiply: out = a * b. The result may be one of the inputs. */
static inline kd_mat4 kd_mat4_mul(const kd_mat4 *a, const kd_mat4 *b)
{
    kd_mat4 out;
    for (int c = 0; c < 4; c++)
        for (int r = 0; r < 4; r++)
            out.m[c * 4 + r] = a->m[r] * b->m[c * 4] + a->m[4 + r] * b->m[c * 4 + 1] +
                               a->m[8 + r] * b->m[c * 4 + 2] + a->m[12 + r] * b->m[c * 4 + 3];
    return out;
}

/** Of unit length; no rotation when q has none. */
static inline kd_quat kd_quat_normalize(kd_quat q)
{
    float length = sqrtf(q.x * q.x + q.y * q.y + q.z * q.z + q.w * q.w);
    return length > 0 ? (kd_quat){q.x / length, q.y / length, q.z / length, q.w / length}
                      : (kd_quat){0, 0, 0, 1};
}
/** Rotation a share t of the way from a to b, the short way round (Shoemake 1985). */
static inline kd_quat kd_quat_slerp(kd_quat a, kd_quat b, float t)
{
    float cosine = a.x * b.x + a.y * b.y + a.z * b.z + a.w * b.w, sign = cosine < 0 ? -1.0f : 1.0f;
    float wa = 1 - t, wb = t;
    cosine *= sign;
    if (cosine < 0.9995f) { /* nearer than that the chord is the arc, and the sine has too few digits */
        float angle = acosf(cosine);
        wa = sinf((1 - t) * angle) / sinf(angle);
        wb = sinf(t * angle) / sinf(angle);
    }
    wb *= sign;
    return kd_quat_normalize(
        (kd_quat){wa * a.x + wb * b.x, wa * a.y + wb * b.y, wa * a.z + wb * b.z, wa * a.w + wb * b.w});
}

/** Compose translation * rotation * scale. */
static inline kd_mat4 kd_mat4_from_trs(kd_vec3 t, kd_quat q, kd_vec3 s)
{
    float xx = q.x * q.x, yy = q.y * q.y, zz = q.z * q.z, xy = q.x * q.y, xz = q.x * q.z, yz = q.y * q.z;
    float wx = q.w * q.x, wy = q.w * q.y, wz = q.w * q.z;
    return (kd_mat4){{(1 - 2 * (yy + zz)) * s.x, 2 * (xy + wz) * s.x, 2 * (xz - wy) * s.x, 0,
                      2 * (xy - wz) * s.y, (1 - 2 * (xx + zz)) * s.y, 2 * (yz + wx) * s.y, 0,
                      2 * (xz + wy) * s.z, 2 * (yz - wx) * s.z, (1 - 2 * (xx + yy)) * s.z, 0, t.x, t.y, t.z,
                      1}};
}

/** Transform a point (w = 1) by an affine matrix. */
static inline kd_vec3 kd_mat4_point(const kd_mat4 *m, kd_vec3 p)
{
    return (kd_vec3){m->m[0] * p.x + m->m[4] * p.y + m->m[8] * p.z + m->m[12],
                     m->m[1] * p.x + m->m[5] * p.y + m->m[9] * p.z + m->m[13],
                     m->m[2] * p.x + m->m[6] * p.y + m->m[10] * p.z + m->m[14]};
}

/** Transform a direction (w = 0) by an affine matrix; the result is not normalised. */
static inline kd_vec3 kd_mat4_direction(const kd_mat4 *m, kd_vec3 d)
{
    return (kd_vec3){m->m[0] * d.x + m->m[4] * d.y + m->m[8] * d.z,
                     m->m[1] * d.x + m->m[5] * d.y + m->m[9] * d.z,
                     m->m[2] * d.x + m->m[6] * d.y + m->m[10] * d.z};
}

static inline kd_vec3 kd_vec3_add(kd_vec3 a, kd_vec3 b)
{
    return (kd_vec3){a.x + b.x, a.y + b.y, a.z + b.z};
}
static inline kd_vec3 kd_vec3_sub(kd_vec3 a, kd_vec3 b)
{
    return (kd_vec3){a.x - b.x, a.y - b.y, a.z - b.z};
}
static inline kd_vec3 kd_vec3_scale(kd_vec3 a, float s)
{
    return (kd_vec3){a.x * s, a.y * s, a.z * s};
}
static inline float kd_vec3_dot(kd_vec3 a, kd_vec3 b)
{
    return a.x * b.x + a.y * b.y + a.z * b.z;
}
static inline kd_vec3 kd_vec3_cross(kd_vec3 a, kd_vec3 b)
{
    return (kd_vec3){a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
static inline float kd_vec3_length(kd_vec3 a)
{
    return sqrtf(kd_vec3_dot(a, a));
}
/** Normalise; a zero vector gives `fallback`. */
static inline kd_vec3 kd_vec3_normalize(kd_vec3 a, kd_vec3 fallback)
{
    float l = kd_vec3_length(a);
    return l > 0 ? kd_vec3_scale(a, 1 / l) : fallback;
}

/** Get the largest factor by which a linear map lengthens a vector: its largest singular value. The same for
 * the map's columns and for its rows; exact where they stand at right angles to each other. Source  Smith
 * 1961, "Eigenvalues of a symmetric 3 x 3 matrix", applied to the products of the columns */
static inline float kd_mat3_stretch(kd_vec3 a, kd_vec3 b, kd_vec3 c)
{
    float aa = kd_vec3_dot(a, a), bb = kd_vec3_dot(b, b), cc = kd_vec3_dot(c, c);
    float ab = kd_vec3_dot(a, b), ac = kd_vec3_dot(a, c), bc = kd_vec3_dot(b, c);
    float mean = (aa + bb + cc) / 3, off = ab * ab + ac * ac + bc * bc;
    float da = aa - mean, db = bb - mean, dc = cc - mean;
    float p = sqrtf((da * da + db * db + dc * dc + 2 * off) / 6);
    if (!(off > 1e-10f * mean * mean))
        return sqrtf(fmaxf(aa, fmaxf(bb, cc)));
    float det = da * (db * dc - bc * bc) - ab * (ab * dc - bc * ac) + ac * (ab * bc - db * ac);
    float turn = acosf(fminf(fmaxf(det / (2 * p * p * p), -1), 1)) / 3;
    return sqrtf(mean + 2 * p * cosf(turn));
}

/** Invert an affine or projective matrix. A singular one gives non-finite values. */
static inline kd_mat4 kd_mat4_inverse(const kd_mat4 *a)
{
    mat4 in, out;
    kd_mat4 result;
    memcpy(in, a->m, sizeof in);
    glm_mat4_inv(in, out);
    memcpy(result.m, out, sizeof out);
    return result;
}

#endif
