/* Clear coats, other refractive indices and transmission: the shader gives what the reference renderer gives,
 * no layer sends back more than arrives, and the reference draws its directions as densely as it says. */

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>

#include <cmocka.h>

#include "runtime/core/log.h"
#include "runtime/gpu/gpu.h"
#include "runtime/reference/internal.h"

enum { SKIP = 77, CASES = 512, STEPS = 192 };

typedef struct lobe_case {
    float albedo[3], metallic, f0[3], f90, roughness, coat, coat_roughness, transmission;
    float view[4], light[4], reflected[4], tint[4];
} lobe_case;

static void print_log(void *user, kd_log_level level, const char *text)
{
    (void)user;
    (void)level;
    fprintf(stderr, "%s\n", text);
}

static float number(uint32_t *state)
{
    *state = *state * 1664525u + 1013904223u;
    return (float)(*state >> 8) / 16777216.0f;
}

/* A direction off the horizon, where both sides divide by what is nearly 0. */
static void direction(uint32_t *state, float out[4])
{
    float z = 0.1f + 0.9f * number(state), r = sqrtf(1 - z * z), phi = 2 * REFERENCE_PI * number(state);
    out[0] = r * cosf(phi);
    out[1] = r * sinf(phi);
    out[2] = z;
}

static lobe_case random_case(uint32_t *state)
{
    lobe_case c = {.metallic = number(state),
                   .f90 = number(state),
                   .roughness = 0.1f + 0.9f * number(state),
                   .coat = number(state),
                   .coat_roughness = 0.1f + 0.9f * number(state),
                   .transmission = number(state)};
    for (int k = 0; k < 3; k++) {
        c.albedo[k] = number(state);
        c.f0[k] = c.f90 * number(state);
    }
    direction(state, c.view);
    direction(state, c.light);
    return c;
}

static reference_surface surface_of(const lobe_case *c)
{
    return (reference_surface){.face = {0, 0, 1},
                               .normal = {0, 0, 1},
                               .albedo = {c->albedo[0], c->albedo[1], c->albedo[2]},
                               .metallic = c->metallic,
                               .f0 = {c->f0[0], c->f0[1], c->f0[2]},
                               .f90 = c->f90,
                               .roughness = c->roughness,
                               .coat = c->coat,
                               .coat_roughness = c->coat_roughness,
                               .transmission = c->transmission};
}

static void expect_color(const float got[4], kd_vec3 wanted, const char *what, uint32_t i)
{
    const float w[3] = {wanted.x, wanted.y, wanted.z};
    for (int k = 0; k < 3; k++)
        if (!(fabsf(got[k] - w[k]) <= 2e-4f * (1 + w[k]))) /* rounding of peaks of some 100 */
            fail_msg("case %u, %s %d: the shader says %g, the reference %g", i, what, k, (double)got[k],
                     (double)w[k]);
}

static void the_shader_agrees_with_the_reference(void **state)
{
    static lobe_case cases[CASES];
    kd_gpu *gpu = NULL;
    uint32_t random = 7;
    (void)state;
    if (kd_gpu_open(&(kd_gpu_desc){.debug = true}, &gpu) != KD_OK)
        exit(SKIP);
    for (uint32_t i = 0; i < CASES; i++)
        cases[i] = random_case(&random);
    kd_gpu_program program =
        kd_gpu_make_program(gpu, &(kd_gpu_program_desc){.compute = "tests/gpu/resolve_lobes.comp"});
    kd_gpu_buffer buffer =
        kd_gpu_make_buffer(gpu, &(kd_gpu_buffer_desc){.size = sizeof cases, .data = cases, .name = "cases"});
    kd_gpu_bind_storage(gpu, 0, buffer);
    kd_gpu_dispatch(gpu, program, CASES / 64, 1, 1);
    kd_gpu_barrier(gpu, KD_BARRIER_BUFFER_UPDATE);
    kd_gpu_read_buffer(gpu, buffer, 0, cases, sizeof cases);
    assert_false(kd_gpu_failed(gpu));
    for (uint32_t i = 0; i < CASES; i++) {
        const float *v = cases[i].view, *l = cases[i].light;
        reference_surface s = surface_of(&cases[i]);
        reference_bsdf f;
        reference_bsdf_evaluate(&s, (kd_vec3){v[0], v[1], v[2]}, (kd_vec3){l[0], l[1], l[2]}, &f);
        expect_color(cases[i].reflected, kd_vec3_add(f.diffuse, f.specular), "reflection", i);
        expect_color(cases[i].tint, reference_bsdf_tint(&s, v[2]), "tint", i);
    }
    kd_gpu_close(gpu);
}

static kd_vec3 tilted(float cosine)
{
    return (kd_vec3){sqrtf(1 - cosine * cosine), 0, cosine};
}

/* The integral over the hemisphere, by the midpoint rule in equal steps of the squared sine. */
static double reflected_share(const reference_surface *s, kd_vec3 v)
{
    double sum = 0;
    for (int i = 0; i < STEPS * 2; i++)
        for (int j = 0; j < STEPS; j++) {
            float u = ((float)i + 0.5f) / (STEPS * 2), phi = REFERENCE_PI * ((float)j + 0.5f) / STEPS;
            float r = sqrtf(u), z = sqrtf(1 - u);
            reference_bsdf f;
            reference_bsdf_evaluate(s, v, (kd_vec3){r * cosf(phi), r * sinf(phi), z}, &f);
            sum += (double)(f.diffuse.x + f.specular.x) / (double)z;
        }
    return sum * (double)REFERENCE_PI / (STEPS * 2 * STEPS);
}

/* Each layer alone and all together, under light of 1 from everywhere, with what passes through. A white base
 * under Schlick's term by the half vector gains up to 3 % at grazing view (resolve_brdf.c): it stands at 45
 * degrees and steeper here. */
static void no_layer_gains_energy(void **state)
{
    (void)state;
    static const lobe_case cases[] = {
        {.roughness = 1, .coat = 1, .coat_roughness = 0.3f}, /* a coat alone */
        {.roughness = 1, .coat = 1, .coat_roughness = 0.8f},
        {.f0 = {1, 1, 1}, .f90 = 1, .roughness = 0.4f},             /* ior 0 */
        {.f0 = {0.17f, 0.17f, 0.17f}, .f90 = 1, .roughness = 0.3f}, /* ior 2.4 */
        {.albedo = {1, 1, 1}, .metallic = 1, .f90 = 1, .roughness = 0.5f, .coat = 1, .coat_roughness = 0.3f},
        {.albedo = {1, 1, 1}, .roughness = 0.5f, .coat = 0.5f, .coat_roughness = 0.3f}, /* specular 0 */
        {.albedo = {1, 1, 1}, .f0 = {0.04f, 0.04f, 0.04f}, .f90 = 1, .roughness = 0.3f, .transmission = 1},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++)
        for (int c = 7; c <= 10; c++) {
            reference_surface s = surface_of(&cases[i]);
            float cosine = (float)c / 10;
            double share = reflected_share(&s, tilted(cosine)) + (double)reference_bsdf_tint(&s, cosine).x;
            if (!(share <= 1.005 && share > 0))
                fail_msg("case %zu, n.v %g: %g", i, (double)cosine, share);
        }
}

/* A coat over black reflects a share of weight times Fresnel's term at the view, less what single scattering
 * loses. */
static void a_coat_reflects_what_fresnel_says(void **state)
{
    (void)state;
    lobe_case c = {.roughness = 1, .coat = 0.5f, .coat_roughness = 0.25f};
    reference_surface s = surface_of(&c);
    double head_on = reflected_share(&s, tilted(1));
    assert_true(head_on > 0.5 * 0.04 * 0.97 && head_on < 0.5 * 0.04 * 1.001);
    assert_float_equal(reference_bsdf_coat(&s, 0), 0.5, 1e-6);
}

/* The mean of value over density, at directions the reference draws, is the integral. The seed is fixed; 4
 * standard errors of 40 000 draws stay below 2 %. */
static void directions_are_drawn_as_densely_as_said(void **state)
{
    (void)state;
    lobe_case c = {.albedo = {0.6f, 0.6f, 0.6f},
                   .metallic = 0.3f,
                   .f0 = {0.1f, 0.1f, 0.1f},
                   .f90 = 1,
                   .roughness = 0.6f,
                   .coat = 0.8f,
                   .coat_roughness = 0.25f,
                   .transmission = 0.4f};
    reference_surface s = surface_of(&c);
    kd_vec3 v = tilted(0.7f), l;
    double sum = 0, integral = reflected_share(&s, v);
    uint32_t random = 3;
    for (int i = 0; i < 40000; i++) {
        float u[3] = {number(&random), number(&random), number(&random)};
        reference_bsdf f;
        if (!reference_bsdf_sample(&s, v, u, &l))
            continue;
        reference_bsdf_evaluate(&s, v, l, &f);
        sum += f.pdf > 0 ? (double)((f.diffuse.x + f.specular.x) / f.pdf) : 0;
    }
    assert_true(fabs(sum / 40000 - integral) < 0.02 * integral);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_shader_agrees_with_the_reference),
        cmocka_unit_test(no_layer_gains_energy),
        cmocka_unit_test(a_coat_reflects_what_fresnel_says),
        cmocka_unit_test(directions_are_drawn_as_densely_as_said),
    };
    kd_log_set_sink(print_log, NULL);
    setenv("KANDIL_SHADER_DIR", KD_SOURCE_DIR, 1);
    return cmocka_run_group_tests(tests, NULL, NULL);
}
