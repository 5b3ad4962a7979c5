/* Where shadow maps look from. A matrix takes world space straight to texture space [0,1]^3; drawing undoes
 * the last step. Cascades are spheres round one centre, so their size does not depend on where the camera
 * looks, and their centre moves in whole texels, so edges of shadows do not crawl. The outermost covers just
 * what is drawn when that is less, wherever the camera stands. */

#include "systems/shadow/internal.h"

#include <math.h>

/* Of neighbouring radii: two cascades span 1:4, a room to a hall. */
static const float CASCADE_RATIO = 2.0f;

static const float SMALLEST = 1e-12f; /* of any extent, in whatever unit a scene is made */

static void write_row(kd_mat4 *m, int row, kd_vec3 v, float w)
{
    m->m[row] = v.x;
    m->m[4 + row] = v.y;
    m->m[8 + row] = v.z;
    m->m[12 + row] = w;
}

/* Two axes at right angles to a direction; they depend on nothing else. */
static void make_basis(kd_vec3 forward, kd_vec3 *right, kd_vec3 *up)
{
    kd_vec3 hint = fabsf(forward.y) < 0.99f ? (kd_vec3){0, 1, 0} : (kd_vec3){0, 0, 1};
    *right = kd_vec3_normalize(kd_vec3_cross(forward, hint), (kd_vec3){1, 0, 0});
    *up = kd_vec3_cross(*right, forward);
}

static float clampf(float x, float low, float high)
{
    return x < low ? low : x > high ? high : x;
}

/* What follows from the bounds is rounded up in steps: maps keep their matrix while bounds and camera move a
 * little, so that one caster that walks does not have all others drawn again. */
static float quantize_radius(float radius)
{
    return exp2f(ceilf(log2f(fmaxf(radius, SMALLEST)) * 2) / 2);
}

float shadow_farthest(const shadow_bounds *b, kd_vec3 p)
{
    kd_vec3 d = {fmaxf(fabsf(b->low.x - p.x), fabsf(b->high.x - p.x)),
                 fmaxf(fabsf(b->low.y - p.y), fabsf(b->high.y - p.y)),
                 fmaxf(fabsf(b->low.z - p.z), fabsf(b->high.z - p.z))};
    return quantize_radius(kd_vec3_length(d));
}

/* The bounds' extent along a direction, to both sides on a lattice of a sixteenth to a 32nd of it. */
static void extent_along(const shadow_bounds *b, kd_vec3 direction, float *low, float *high)
{
    kd_vec3 centre = kd_vec3_scale(kd_vec3_add(b->low, b->high), 0.5f);
    kd_vec3 half = kd_vec3_scale(kd_vec3_sub(b->high, b->low), 0.5f);
    float middle = kd_vec3_dot(centre, direction);
    float reach = fabsf(direction.x) * half.x + fabsf(direction.y) * half.y + fabsf(direction.z) * half.z;
    reach = fmaxf(reach * 1.01f + 0.002f * kd_vec3_length(half), SMALLEST); /* a flat scene has a depth too */
    float step = exp2f(ceilf(log2f(reach)) - 4);
    *low = floorf((middle - reach) / step) * step;
    *high = ceilf((middle + reach) / step) * step;
}

/* A square that a cascade covers, seen along the light. */
typedef struct shadow_square {
    float x, y, half; /* of its middle along right and up */
} shadow_square;

/* All that is drawn. */
static shadow_square square_of_all(const shadow_bounds *bounds, kd_vec3 right, kd_vec3 up)
{
    float low_x, high_x, low_y, high_y;
    extent_along(bounds, right, &low_x, &high_x);
    extent_along(bounds, up, &low_y, &high_y);
    return (shadow_square){(low_x + high_x) / 2, (low_y + high_y) / 2,
                           fmaxf(high_x - low_x, high_y - low_y) / 2};
}

/* A cascade moves in steps of a 32nd of its width: whole texels, and seldom, since a map that moves is drawn
 * again. */
static shadow_cascade make_cascade(kd_vec3 direction, kd_vec3 right, kd_vec3 up, shadow_square square,
                                   float low, float high, uint32_t edge)
{
    /* besides what a step may lose, two texels at each border are the filter's margin */
    uint32_t step = edge / 32 > 0 ? edge / 32 : 1, margin = step + 5;
    float texel = 2 * square.half / (float)(edge > 2 * margin ? edge - margin : edge);
    float size = texel * (float)edge, stride = texel * (float)step;
    float x = roundf(square.x / stride) * stride, y = roundf(square.y / stride) * stride;
    kd_mat4 m = {{0}};
    write_row(&m, 0, kd_vec3_scale(right, 1 / size), 0.5f - x / size);
    write_row(&m, 1, kd_vec3_scale(up, 1 / size), 0.5f - y / size);
    write_row(&m, 2, kd_vec3_scale(direction, 1 / (high - low)), -low / (high - low));
    m.m[15] = 1;
    return (shadow_cascade){m, texel, (high - low) / 2};
}

void shadow_cascades_make(shadow_cascade *out, uint32_t count, kd_vec3 direction, kd_vec3 eye,
                          const shadow_bounds *bounds, float distance, uint32_t edge)
{
    kd_vec3 right, up,
        centre = {clampf(eye.x, bounds->low.x, bounds->high.x), clampf(eye.y, bounds->low.y, bounds->high.y),
                  clampf(eye.z, bounds->low.z, bounds->high.z)};
    make_basis(direction, &right, &up);
    float low, high, radius = fminf(distance, shadow_farthest(bounds, centre));
    extent_along(bounds, direction, &low, &high);
    shadow_square all = square_of_all(bounds, right, up);
    radius = fminf(radius, all.half);
    for (uint32_t i = count; i-- > 0; radius /= CASCADE_RATIO) {
        shadow_square round = {kd_vec3_dot(right, centre), kd_vec3_dot(up, centre), radius};
        bool covers_all = i + 1 == count && all.half <= radius;
        out[i] = make_cascade(direction, right, up, covers_all ? all : round, low, high, edge);
    }
}

kd_mat4 shadow_spot_matrix(kd_vec3 position, kd_vec3 forward, float tangent, float z_near, float z_far)
{
    kd_vec3 right, up, eye = kd_vec3_scale(position, -1);
    make_basis(forward, &right, &up);
    kd_vec3 u = kd_vec3_add(kd_vec3_scale(right, 0.5f / tangent), kd_vec3_scale(forward, 0.5f));
    kd_vec3 v = kd_vec3_add(kd_vec3_scale(up, 0.5f / tangent), kd_vec3_scale(forward, 0.5f));
    float a = z_far / (z_far - z_near); /* depth = a - a * z_near / distance: 0 at z_near, 1 at z_far */
    kd_mat4 m = {{0}};
    write_row(&m, 0, u, kd_vec3_dot(u, eye));
    write_row(&m, 1, v, kd_vec3_dot(v, eye));
    write_row(&m, 2, kd_vec3_scale(forward, a), a * kd_vec3_dot(forward, eye) - a * z_near);
    write_row(&m, 3, forward, kd_vec3_dot(forward, eye));
    return m;
}

kd_vec3 shadow_cube_axis(uint32_t face)
{
    float sign = face % 2 == 0 ? 1.0f : -1.0f;
    return (kd_vec3){face / 2 == 0 ? sign : 0, face / 2 == 1 ? sign : 0, face / 2 == 2 ? sign : 0};
}
