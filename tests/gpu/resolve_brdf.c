/* The white furnace: under light of 1 from everywhere a surface must not send back more than 1. */

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

enum { SKIP = 77, MAX_CASES = 64 };

typedef struct brdf_case {
    float albedo, metallic, roughness, n_dot_v;
    float reflected, env, unused[2];
} brdf_case;

static const float roughnesses[] = {0.2f, 0.35f, 0.5f, 0.7f, 0.85f, 1};
static const float cosines[] = {0.1f, 0.3f, 0.5f, 0.7f, 0.9f, 1};

static void print_log(void *user, kd_log_level level, const char *text)
{
    (void)user;
    (void)level;
    fprintf(stderr, "%s\n", text);
}

/* All pairs of roughness and cosine for one material. Returns their number. */
static uint32_t integrate(kd_gpu *gpu, float albedo, float metallic, brdf_case *cases)
{
    uint32_t count = 0;
    for (size_t i = 0; i < sizeof roughnesses / sizeof *roughnesses; i++)
        for (size_t j = 0; j < sizeof cosines / sizeof *cosines; j++)
            cases[count++] = (brdf_case){albedo, metallic, roughnesses[i], cosines[j], 0, 0, {0, 0}};
    kd_gpu_program program =
        kd_gpu_make_program(gpu, &(kd_gpu_program_desc){.compute = "tests/gpu/resolve_brdf.comp"});
    kd_gpu_buffer buffer = kd_gpu_make_buffer(
        gpu, &(kd_gpu_buffer_desc){.size = count * sizeof *cases, .data = cases, .name = "cases"});
    kd_gpu_bind_storage(gpu, 0, buffer);
    kd_gpu_dispatch(gpu, program, count, 1, 1);
    kd_gpu_barrier(gpu, KD_BARRIER_BUFFER_UPDATE);
    kd_gpu_read_buffer(gpu, buffer, 0, cases, count * sizeof *cases);
    assert_false(kd_gpu_failed(gpu));
    return count;
}

/* With albedo 1 a metal's Fresnel term is 1 everywhere: what is missing to 1 is light lost to single
 * scattering, which grows with roughness: nothing at alpha = 0, known to be up to about 60 % at grazing view
 * and alpha = 1. 0.5 % for the sums. */
static void white_metal_never_gains_energy(void **state)
{
    brdf_case cases[MAX_CASES];
    uint32_t count = integrate(*state, 1, 1, cases);
    for (uint32_t i = 0; i < count; i++) {
        if (!(cases[i].reflected <= 1.005f && cases[i].reflected > 0.3f))
            fail_msg("roughness %g, n.v %g: %g", (double)cases[i].roughness, (double)cases[i].n_dot_v,
                     (double)cases[i].reflected);
        if (cases[i].roughness <= 0.2f && cases[i].n_dot_v >= 0.5f)
            assert_true(cases[i].reflected > 0.99f);
    }
}

/* glTF mixes diffuse and specular by the Fresnel term at the half vector alone, so that a white dielectric
 * gains at grazing view; away from there it must not. Its own diffuse part keeps it above 0.85. */
static void white_dielectric_is_a_furnace_away_from_grazing_view(void **state)
{
    brdf_case cases[MAX_CASES];
    uint32_t count = integrate(*state, 1, 0, cases);
    for (uint32_t i = 0; i < count; i++) {
        if (cases[i].n_dot_v >= 0.7f && !(cases[i].reflected <= 1.01f && cases[i].reflected > 0.85f))
            fail_msg("roughness %g, n.v %g: %g", (double)cases[i].roughness, (double)cases[i].n_dot_v,
                     (double)cases[i].reflected);
    }
}

/* The fit against the integral it stands for: a black dielectric, which has specular light alone, and a white
 * metal. The tolerance is the fit's own error, which the shader states. */
static void env_fit_is_near_the_integral(void **state)
{
    brdf_case cases[MAX_CASES];
    uint32_t count = integrate(*state, 0, 0, cases);
    for (int pass = 0; pass < 2; pass++) {
        for (uint32_t i = 0; i < count; i++)
            if (!(fabsf(cases[i].env - cases[i].reflected) < 0.09f))
                fail_msg("pass %d roughness %g, n.v %g: fit %g, integral %g", pass,
                         (double)cases[i].roughness, (double)cases[i].n_dot_v, (double)cases[i].env,
                         (double)cases[i].reflected);
        count = integrate(*state, 1, 1, cases);
    }
}

static int setup(void **state)
{
    kd_gpu *gpu = NULL;
    kd_log_set_sink(print_log, NULL);
    setenv("KANDIL_SHADER_DIR", KD_SOURCE_DIR, 1);
    if (kd_gpu_open(&(kd_gpu_desc){.debug = true}, &gpu) != KD_OK)
        exit(SKIP);
    *state = gpu;
    return 0;
}

static int teardown(void **state)
{
    kd_gpu_close(*state);
    return 0;
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(white_metal_never_gains_energy, setup, teardown),
        cmocka_unit_test_setup_teardown(white_dielectric_is_a_furnace_away_from_grazing_view, setup,
                                        teardown),
        cmocka_unit_test_setup_teardown(env_fit_is_near_the_integral, setup, teardown),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
