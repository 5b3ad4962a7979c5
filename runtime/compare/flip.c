/* FLIP: what an eye sees when two pictures take turns. Both are blurred as the eye blurs each colour channel,
 * compared in a uniform colour space, and the difference is raised where edges or points differ. Source
 * Andersson et al. 2020, FLIP: A Difference Evaluator for Alternating Images */

#include "runtime/compare/compare.h"

#include <math.h>
#include <stdbool.h>
#include <stdlib.h>

#include "runtime/compare/filter.h"
#include "runtime/compare/internal.h"
#include "runtime/core/color.h"
#include "runtime/core/log.h"

/* Section 5: exponents and the knee of the colour difference, the width and exponent of features. */
static const float COLOR_POWER = 0.7f, KNEE = 0.4f, KNEE_ERROR = 0.95f;
static const float FEATURE_DEG = 0.082f, FEATURE_POWER = 0.5f;

/* ---- colour spaces: planes of three floats a texel ---- */

/* Source  IEC 61966-2-1, D65 */
static const double to_xyz[3][3] = {{10135552.0 / 24577794, 8788810.0 / 24577794, 4435075.0 / 24577794},
                                    {2613072.0 / 12288897, 8788810.0 / 12288897, 887015.0 / 12288897},
                                    {1425312.0 / 73733382, 8788810.0 / 73733382, 70074185.0 / 73733382}};

typedef struct color_space {
    float to[3][3], from[3][3]; /* linear RGB to XYZ over that of white, and back */
} color_space;

static void invert3(float m[3][3], float out[3][3])
{
    for (int r = 0; r < 3; r++)
        for (int c = 0; c < 3; c++) {
            int r1 = (r + 1) % 3, r2 = (r + 2) % 3, c1 = (c + 1) % 3, c2 = (c + 2) % 3;
            out[c][r] = m[r1][c1] * m[r2][c2] - m[r1][c2] * m[r2][c1];
        }
    float det = m[0][0] * out[0][0] + m[0][1] * out[1][0] + m[0][2] * out[2][0];
    for (int i = 0; i < 9; i++)
        (&out[0][0])[i] /= det;
}

static color_space color_space_make(void)
{
    color_space s;
    for (int r = 0; r < 3; r++)
        for (int c = 0; c < 3; c++)
            s.to[r][c] = (float)(to_xyz[r][c] / (to_xyz[r][0] + to_xyz[r][1] + to_xyz[r][2]));
    invert3(s.to, s.from);
    return s;
}

static kd_vec3 apply(const float m[3][3], kd_vec3 v)
{
    return (kd_vec3){m[0][0] * v.x + m[0][1] * v.y + m[0][2] * v.z,
                     m[1][0] * v.x + m[1][1] * v.y + m[1][2] * v.z,
                     m[2][0] * v.x + m[2][1] * v.y + m[2][2] * v.z};
}

/* Lightness, red-green, blue-yellow. */
static kd_vec3 to_opponent(const color_space *s, kd_vec3 rgb)
{
    kd_vec3 n = apply(s->to, rgb);
    return (kd_vec3){116 * n.y - 16, 500 * (n.x - n.y), 200 * (n.y - n.z)};
}

static kd_vec3 from_opponent(const color_space *s, kd_vec3 o)
{
    float y = (o.x + 16) / 116;
    return apply(s->from, (kd_vec3){y + o.y / 500, y, y - o.z / 200});
}

static float lab_curve(float t)
{
    const float d = 6.0f / 29;
    return t > d * d * d ? cbrtf(t) : t / (3 * d * d) + 4.0f / 29;
}

/* CIELAB with chroma that fades in the dark, as Hunt found. Equations 4 and 5 */
static kd_vec3 to_uniform(const color_space *s, kd_vec3 rgb)
{
    kd_vec3 n = apply(s->to, rgb);
    float x = lab_curve(n.x), y = lab_curve(n.y), z = lab_curve(n.z), l = 116 * y - 16;
    return (kd_vec3){l, 0.01f * l * 500 * (x - y), 0.01f * l * 200 * (y - z)};
}

/* Source  Abasi et al. 2020, Distance Metrics for Very Large Color Differences */
static float hyab(kd_vec3 a, kd_vec3 b)
{
    return fabsf(a.x - b.x) + hypotf(a.y - b.y, a.z - b.z);
}

static float clamp01(float x)
{
    return x > 0 ? (x < 1 ? x : 1) : 0;
}

/* ---- the eye's blur ---- */

typedef struct sensitivity {
    float weight, scale;
} sensitivity; /* Gaussian weight sqrt(pi / scale) exp(-pi^2 x^2 / scale), x in degrees */

/* Section 4.1, table 1; the third channel is a sum of two. */
static const sensitivity achromatic = {1, 0.0047f}, red_green = {1, 0.0053f},
                         blue_yellow[2] = {{34.1f, 0.04f}, {13.5f, 0.025f}};

/* All channels' windows are as wide as the widest needs. */
static int sensitivity_radius(float ppd)
{
    int r = (int)ceilf(3 * sqrtf(blue_yellow[0].scale / (2 * FLIP_PI * FLIP_PI)) * ppd);
    return r < FILTER_MAX_RADIUS ? r : FILTER_MAX_RADIUS;
}

/* Returns the kernel's sum in two dimensions before it was made to sum up to one. */
static float sensitivity_kernel(const sensitivity *s, float ppd, filter_kernel *out)
{
    double sum = 0;
    out->radius = sensitivity_radius(ppd);
    for (int i = -out->radius; i <= out->radius; i++) {
        double x = i / (double)ppd, w = exp(-(double)(FLIP_PI * FLIP_PI) * x * x / (double)s->scale);
        out->weights[i + out->radius] = (float)w;
        sum += w;
    }
    for (int i = 0; i <= 2 * out->radius; i++)
        out->weights[i] = (float)((double)out->weights[i] / sum);
    return s->weight * sqrtf(FLIP_PI / s->scale) * (float)(sum * sum);
}

static void blur(flip_planes *p, const sensitivity *s, int parts, float *plane)
{
    filter_kernel *k = &p->kernels[0];
    float total = sensitivity_kernel(&s[0], p->ppd, k);
    filter_plane(plane, parts > 1 ? p->spare[0] : plane, p->spare[2], p->width, p->height, k, k);
    if (parts == 1)
        return;
    float second = sensitivity_kernel(&s[1], p->ppd, k), share = second / (total + second);
    filter_plane(plane, p->spare[1], p->spare[2], p->width, p->height, k, k);
    for (size_t i = 0; i < p->count; i++)
        plane[i] = p->spare[0][i] * (1 - share) + p->spare[1][i] * share;
}

/* ---- features ---- */

/* Gaussian, its first and its second derivative; positive weights sum up to 1 and negative ones to -1 where
 * there are both. Equations 8 and 9 */
static void feature_kernels(float ppd, filter_kernel *gauss, filter_kernel *edge, filter_kernel *point)
{
    double sd = 0.5 * (double)FEATURE_DEG * (double)ppd, sums[5] = {0};
    int radius = (int)ceil(3 * sd);
    radius = radius < FILTER_MAX_RADIUS ? radius : FILTER_MAX_RADIUS;
    gauss->radius = edge->radius = point->radius = radius;
    for (int pass = 0; pass < 2; pass++)
        for (int x = -radius; x <= radius; x++) {
            double g = exp(-x * x / (2 * sd * sd)), e = -x * g, q = (x * x / (sd * sd) - 1) * g;
            if (pass == 0) {
                sums[0] += g;
                sums[e > 0 ? 1 : 2] += fabs(e);
                sums[q > 0 ? 3 : 4] += fabs(q);
                continue;
            }
            gauss->weights[x + radius] = (float)(g / sums[0]);
            edge->weights[x + radius] = (float)(e / fmax(sums[e > 0 ? 1 : 2], 1e-30));
            point->weights[x + radius] = (float)(q / fmax(sums[q > 0 ? 3 : 4], 1e-30));
        }
}

/* Length of the feature vector of every pixel of plane `y`, lightness 0 … 1. */
static void feature_length(flip_planes *p, const float *y, const filter_kernel *derivative, float *out)
{
    filter_plane(y, p->spare[0], p->spare[2], p->width, p->height, derivative, &p->kernels[0]);
    filter_plane(y, p->spare[1], p->spare[2], p->width, p->height, &p->kernels[0], derivative);
    for (size_t i = 0; i < p->count; i++)
        out[i] = hypotf(p->spare[0][i], p->spare[1][i]);
}

/* Exponent by which features raise the colour difference. Equations 10 and 11 */
static void feature_difference(flip_planes *p)
{
    feature_kernels(p->ppd, &p->kernels[0], &p->kernels[1], &p->kernels[2]);
    for (size_t i = 0; i < p->count; i++)
        p->feature[i] = 0;
    for (int kind = 1; kind <= 2; kind++) {
        feature_length(p, p->lightness[0], &p->kernels[kind], p->length[0]);
        feature_length(p, p->lightness[1], &p->kernels[kind], p->length[1]);
        for (size_t i = 0; i < p->count; i++)
            p->feature[i] = fmaxf(p->feature[i], fabsf(p->length[0][i] - p->length[1][i]));
    }
    for (size_t i = 0; i < p->count; i++)
        p->feature[i] = clamp01(powf(p->feature[i] * sqrtf(0.5f), FEATURE_POWER));
}

/* ---- colour ---- */

static float largest_difference(const color_space *s)
{
    kd_vec3 green = to_uniform(s, (kd_vec3){0, 1, 0}), blue = to_uniform(s, (kd_vec3){0, 0, 1});
    return powf(hyab(green, blue), COLOR_POWER);
}

/* Small differences take most of 0 … 1. Equation 7 */
static float redistribute(float difference, float largest)
{
    float d = powf(difference, COLOR_POWER), knee = KNEE * largest;
    float e =
        d < knee ? KNEE_ERROR / knee * d : KNEE_ERROR + (d - knee) / (largest - knee) * (1 - KNEE_ERROR);
    return clamp01(e);
}

/* Planes of one picture as the eye gets them, in the uniform space. Lightness goes to features unblurred. */
static void prepare(flip_planes *p, const color_space *s, const float *linear, int which)
{
    float **planes = p->color[which];
    for (size_t i = 0; i < p->count; i++) {
        kd_vec3 o = to_opponent(
            s, (kd_vec3){clamp01(linear[i * 3]), clamp01(linear[i * 3 + 1]), clamp01(linear[i * 3 + 2])});
        p->lightness[which][i] = (o.x + 16) / 116;
        planes[0][i] = o.x;
        planes[1][i] = o.y;
        planes[2][i] = o.z;
    }
    blur(p, &achromatic, 1, planes[0]);
    blur(p, &red_green, 1, planes[1]);
    blur(p, blue_yellow, 2, planes[2]);
    for (size_t i = 0; i < p->count; i++) {
        kd_vec3 c = from_opponent(s, (kd_vec3){planes[0][i], planes[1][i], planes[2][i]});
        c = to_uniform(s, (kd_vec3){clamp01(c.x), clamp01(c.y), clamp01(c.z)});
        planes[0][i] = c.x;
        planes[1][i] = c.y;
        planes[2][i] = c.z;
    }
}

void flip_linear(flip_planes *p, const float *a, const float *b, float *map)
{
    color_space s = color_space_make();
    float largest = largest_difference(&s);
    prepare(p, &s, a, 0);
    prepare(p, &s, b, 1);
    feature_difference(p);
    for (size_t i = 0; i < p->count; i++) {
        kd_vec3 ca = {p->color[0][0][i], p->color[0][1][i], p->color[0][2][i]};
        kd_vec3 cb = {p->color[1][0][i], p->color[1][1][i], p->color[1][2][i]};
        map[i] = powf(redistribute(hyab(ca, cb), largest), 1 - p->feature[i]);
    }
}

/* ---- memory ---- */

bool flip_planes_make(flip_planes *p, uint32_t width, uint32_t height, float ppd)
{
    *p = (flip_planes){.width = width, .height = height, .count = (size_t)width * height};
    p->ppd = ppd > 0 ? ppd : KD_FLIP_PIXELS_PER_DEGREE;
    p->memory = malloc(p->count * FLIP_PLANES * sizeof(float));
    p->kernels = malloc(3 * sizeof *p->kernels);
    if (!p->memory || !p->kernels) {
        flip_planes_fini(p);
        kd_fail(KD_NO_MEMORY, "compare: no memory for pictures of %ux%u; choose a smaller size", width,
                height);
        return false;
    }
    float *next = p->memory;
    float **const all[FLIP_PLANES] = {
        &p->color[0][0], &p->color[0][1],  &p->color[0][2],  &p->color[1][0], &p->color[1][1],
        &p->color[1][2], &p->lightness[0], &p->lightness[1], &p->length[0],   &p->length[1],
        &p->feature,     &p->spare[0],     &p->spare[1],     &p->spare[2],
    };
    for (int i = 0; i < FLIP_PLANES; i++, next += p->count)
        *all[i] = next;
    return true;
}

void flip_planes_fini(flip_planes *p)
{
    free(p->memory);
    free(p->kernels);
    *p = (flip_planes){0};
}

double flip_mean(const float *map, size_t count)
{
    double sum = 0;
    for (size_t i = 0; i < count; i++)
        sum += (double)map[i];
    return count ? sum / (double)count : 0;
}

kd_status kd_flip_ldr(const float *a, const float *b, uint32_t width, uint32_t height, float ppd, float *map,
                      double *mean)
{
    flip_planes p;
    if (!flip_planes_make(&p, width, height, ppd))
        return KD_NO_MEMORY;
    float *linear = malloc(p.count * 7 * sizeof *linear);
    if (!linear) {
        flip_planes_fini(&p);
        return kd_fail(KD_NO_MEMORY, "compare: no memory for pictures of %ux%u; choose a smaller size", width,
                       height);
    }
    float *second = linear + p.count * 3, *own = linear + p.count * 6;
    for (size_t i = 0; i < p.count * 3; i++) {
        linear[i] = kd_color_srgb_decode(a[i]);
        second[i] = kd_color_srgb_decode(b[i]);
    }
    flip_linear(&p, linear, second, map ? map : own);
    *mean = flip_mean(map ? map : own, p.count);
    free(linear);
    flip_planes_fini(&p);
    return KD_OK;
}
