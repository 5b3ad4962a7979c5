/* The layered material: shaders/include/brdf.glsl, and directions drawn from it.
 * Source  glTF 2.0, appendix B; Dupuy and Benyoub 2023, Sampling Visible GGX Normals with Spherical Caps */

#include <math.h>

#include "runtime/reference/internal.h"
#include "shaders/shared/brdf.h"

static const kd_vec3 black = {0, 0, 0};

/* A frame round n without a seam where n.z changes sign. Source  Duff et al. 2017, listing 3 */
static void frame_round(kd_vec3 n, kd_vec3 *x, kd_vec3 *y)
{
    float s = n.z >= 0 ? 1.0f : -1.0f, a = -1 / (s + n.z), b = n.x * n.y * a;
    *x = (kd_vec3){1 + s * n.x * n.x * a, s * b, -s * n.x};
    *y = (kd_vec3){b, s + n.y * n.y * a, -n.y};
}

kd_vec3 reference_from_frame(kd_vec3 n, kd_vec3 local)
{
    kd_vec3 x, y;
    frame_round(n, &x, &y);
    return reference_mad(x, local.x, reference_mad(y, local.y, kd_vec3_scale(n, local.z)));
}

static kd_vec3 to_frame(kd_vec3 n, kd_vec3 v)
{
    kd_vec3 x, y;
    frame_round(n, &x, &y);
    return (kd_vec3){kd_vec3_dot(x, v), kd_vec3_dot(y, v), kd_vec3_dot(n, v)};
}

kd_vec3 reference_cosine(float u, float v)
{
    float r = sqrtf(u), phi = 2 * REFERENCE_PI * v;
    return (kd_vec3){r * cosf(phi), r * sinf(phi), sqrtf(fmaxf(1 - u, 0))};
}

/* ---- terms ---- */

static float alpha_of(float roughness)
{
    float r = fmaxf(roughness, (float)KD_BRDF_MIN_ROUGHNESS);
    return r * r;
}

static kd_vec3 f0_of(const reference_surface *s)
{
    return (kd_vec3){s->f0.x + (s->albedo.x - s->f0.x) * s->metallic,
                     s->f0.y + (s->albedo.y - s->f0.y) * s->metallic,
                     s->f0.z + (s->albedo.z - s->f0.z) * s->metallic};
}

static kd_vec3 fresnel(const reference_surface *s, float v_dot_h)
{
    kd_vec3 f0 = f0_of(s);
    float x = fminf(fmaxf(1 - v_dot_h, 0), 1), x2 = x * x, x5 = x2 * x2 * x;
    float f90 = s->f90 + (1 - s->f90) * s->metallic;
    return (kd_vec3){f0.x + (f90 - f0.x) * x5, f0.y + (f90 - f0.y) * x5, f0.z + (f90 - f0.z) * x5};
}

float reference_bsdf_coat(const reference_surface *s, float n_dot_v)
{
    const float f0 = (float)KD_BRDF_DIELECTRIC_F0;
    float x = fminf(fmaxf(1 - n_dot_v, 0), 1), x2 = x * x;
    return s->coat * (f0 + (1 - f0) * x2 * x2 * x);
}

/* What of the albedo is left under a layer that reflects f. */
static kd_vec3 passed_on(kd_vec3 f, kd_vec3 albedo)
{
    return (kd_vec3){(1 - f.x) * albedo.x, (1 - f.y) * albedo.y, (1 - f.z) * albedo.z};
}

kd_vec3 reference_bsdf_tint(const reference_surface *s, float n_dot_v)
{
    float below = (1 - reference_bsdf_coat(s, n_dot_v)) * s->transmission * (1 - s->metallic);
    return kd_vec3_scale(passed_on(fresnel(s, n_dot_v), s->albedo), below);
}

/* GGX. The sine comes from a cross product: 1 - cos^2 has no digits left where the lobe is narrow. */
static float distribution(kd_vec3 n, kd_vec3 h, float alpha)
{
    kd_vec3 c = kd_vec3_cross(n, h);
    float cosine = fmaxf(kd_vec3_dot(n, h), 0), a2 = alpha * alpha;
    float d = cosine * cosine * a2 + kd_vec3_dot(c, c);
    return a2 / (REFERENCE_PI * d * d);
}

static float slope(float cosine, float a2)
{
    return sqrtf(cosine * cosine * (1 - a2) + a2);
}

/* Height-correlated Smith term over 4 (n.l)(n.v). Source  Heitz 2014, equation 99 */
static float visibility(float n_dot_l, float n_dot_v, float alpha)
{
    float a2 = alpha * alpha;
    return 0.5f / fmaxf(n_dot_l * slope(n_dot_v, a2) + n_dot_v * slope(n_dot_l, a2), 1e-7f);
}

/* Share of the light that enters the dielectric and is scattered back. */
static float scattered(const reference_surface *s)
{
    return (1 - s->metallic) * (1 - s->transmission);
}

/* Probabilities of drawing from the lobes: their shares of what is about to be reflected. A view from behind
 * the shading normal has no visible normals to draw from. */
typedef struct lobe_choice {
    float coat, specular; /* the rest is diffuse */
} lobe_choice;

static lobe_choice choose_lobes(const reference_surface *s, float n_dot_v)
{
    if (s->lambert || n_dot_v <= 1e-4f)
        return (lobe_choice){0, 0};
    float coat = reference_bsdf_coat(s, n_dot_v), under = 1 - coat;
    float specular = under * reference_luminance(fresnel(s, n_dot_v));
    float diffuse = under * reference_luminance(s->albedo) * scattered(s);
    coat = coat > 0 ? fmaxf(coat / (coat + specular + diffuse), 0.1f) : 0;
    if (diffuse <= 0)
        return (lobe_choice){coat, 1 - coat};
    return (lobe_choice){coat, (1 - coat) * fminf(fmaxf(specular / (specular + diffuse), 0.1f), 0.9f)};
}

/* ---- evaluation ---- */

/* One GGX lobe: its value without Fresnel's term, and the density of drawing l from its visible normals. */
typedef struct lobe {
    float value, pdf;
} lobe;

static lobe evaluate_lobe(kd_vec3 n, kd_vec3 h, float n_dot_l, float n_dot_v, float alpha)
{
    float d = distribution(n, h, alpha);
    return (lobe){d * visibility(n_dot_l, n_dot_v, alpha) * n_dot_l,
                  d / (2 * (n_dot_v + slope(n_dot_v, alpha * alpha)))};
}

static void evaluate_lobes(const reference_surface *s, kd_vec3 v, kd_vec3 l, float n_dot_l,
                           lobe_choice choice, reference_bsdf *out)
{
    float n_dot_v = fmaxf(kd_vec3_dot(s->normal, v), 1e-4f), coat = reference_bsdf_coat(s, n_dot_v);
    kd_vec3 h = kd_vec3_normalize(kd_vec3_add(v, l), s->normal);
    kd_vec3 f = fresnel(s, kd_vec3_dot(v, h));
    lobe base = evaluate_lobe(s->normal, h, n_dot_l, n_dot_v, alpha_of(s->roughness));
    float below = scattered(s) * n_dot_l / REFERENCE_PI;
    out->specular = kd_vec3_scale(f, base.value * (1 - coat));
    out->diffuse = kd_vec3_scale(passed_on(f, s->albedo), below * (1 - coat));
    out->pdf = choice.specular * base.pdf + (1 - choice.specular - choice.coat) * n_dot_l / REFERENCE_PI;
    if (coat <= 0)
        return;
    lobe over = evaluate_lobe(s->normal, h, n_dot_l, n_dot_v, alpha_of(s->coat_roughness));
    float value = coat * over.value;
    out->specular = kd_vec3_add(out->specular, (kd_vec3){value, value, value});
    out->pdf += choice.coat * over.pdf;
}

void reference_bsdf_evaluate(const reference_surface *s, kd_vec3 v, kd_vec3 l, reference_bsdf *out)
{
    float n_dot_l = kd_vec3_dot(s->normal, l);
    *out = (reference_bsdf){black, black, 0};
    if (n_dot_l <= 0 || kd_vec3_dot(s->face, l) <= 0)
        return;
    if (s->lambert) {
        out->diffuse = kd_vec3_scale(s->albedo, n_dot_l / REFERENCE_PI);
        out->pdf = n_dot_l / REFERENCE_PI;
        return;
    }
    evaluate_lobes(s, v, l, n_dot_l, choose_lobes(s, kd_vec3_dot(s->normal, v)), out);
}

/* ---- sampling ---- */

static kd_vec3 visible_normal(kd_vec3 v, float alpha, float u0, float u1)
{
    kd_vec3 w = kd_vec3_normalize((kd_vec3){v.x * alpha, v.y * alpha, v.z}, (kd_vec3){0, 0, 1});
    float phi = 2 * REFERENCE_PI * u0, z = (1 - u1) * (1 + w.z) - w.z;
    float r = sqrtf(fminf(fmaxf(1 - z * z, 0), 1));
    kd_vec3 c = {r * cosf(phi) + w.x, r * sinf(phi) + w.y, z + w.z};
    return kd_vec3_normalize((kd_vec3){c.x * alpha, c.y * alpha, fmaxf(c.z, 0)}, (kd_vec3){0, 0, 1});
}

bool reference_bsdf_sample(const reference_surface *s, kd_vec3 v, const float u[3], kd_vec3 *l)
{
    float n_dot_v = kd_vec3_dot(s->normal, v);
    kd_vec3 local;
    lobe_choice choice = choose_lobes(s, n_dot_v);
    if (u[0] < choice.coat + choice.specular) {
        float alpha = alpha_of(u[0] < choice.coat ? s->coat_roughness : s->roughness);
        kd_vec3 from = to_frame(s->normal, v), h = visible_normal(from, alpha, u[1], u[2]);
        local = reference_mad(h, 2 * kd_vec3_dot(from, h), kd_vec3_scale(from, -1));
    } else {
        local = reference_cosine(u[1], u[2]);
    }
    if (local.z <= 0)
        return false;
    *l = kd_vec3_normalize(reference_from_frame(s->normal, local), s->normal);
    return kd_vec3_dot(s->face, *l) > 0;
}
