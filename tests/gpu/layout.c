/* Structs that C and shaders share lie alike in both. Every word of a buffer holds its own number; a shader
 * copies each member out, and what arrives must be the member's offset in C. */

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>

#include <cmocka.h>

#include "runtime/core/log.h"
#include "runtime/gpu/gpu.h"
#include "shaders/shared/bindings.h"
#include "shaders/shared/resolve.h"
#include "shaders/shared/scene.h"

enum { SKIP = 77, MAX_WORDS = 8192, OBJECTS = 3 };

/* Numbers ride in floats that are ordinary ones, since a driver may flush tiny ones to zero. */
static const uint32_t BASE = 0x3f800000;

typedef struct member {
    const char *name;
    size_t offset, size;
} member;
#define MEMBER(type, name)                                                                                   \
    {                                                                                                        \
#type "." #name, offsetof(struct type, name), sizeof(((struct type *)0)->name)                       \
    }
#define ELEMENT(type, name, i)                                                                               \
    {                                                                                                        \
#type "." #name "[" #i "]", offsetof(struct type, name) + (i) * sizeof(((struct type *)0)->name[0]), \
            sizeof(((struct type *)0)->name[0])                                                              \
    }
#define SECOND(type, name, i)                                                                                \
    {                                                                                                        \
#type "[" #i "]." #name, (i) * sizeof(struct type) + offsetof(struct type, name),                    \
            sizeof(((struct type *)0)->name)                                                                 \
    }

/* In the order of layout.comp. */
static const member members[] = {
    MEMBER(kd_object, model_ws),
    MEMBER(kd_object, normal_ws),
    MEMBER(kd_object, info),
    SECOND(kd_object, model_ws, 2),
    SECOND(kd_object, normal_ws, 2),
    SECOND(kd_object, info, 2),
    MEMBER(kd_material_params, base_color),
    MEMBER(kd_material_params, emissive),
    MEMBER(kd_material_params, surface),
    MEMBER(kd_material_params, maps),
    MEMBER(kd_material_params, uv_transform),
    MEMBER(kd_view_params, view),
    MEMBER(kd_view_params, projection),
    MEMBER(kd_view_params, view_projection),
    MEMBER(kd_view_params, inverse_view_projection),
    MEMBER(kd_view_params, position_ws),
    MEMBER(kd_view_params, forward_ws),
    MEMBER(kd_view_params, size),
    MEMBER(kd_view_params, lens),
    MEMBER(kd_lights_params, count),
    ELEMENT(kd_lights_params, light, 0),
    ELEMENT(kd_lights_params, light, 1),
    ELEMENT(kd_lights_params, light, KD_MAX_LIGHTS - 1),
    MEMBER(kd_lights_params, shadow_matrix),
    MEMBER(kd_lights_params, kinds),
    MEMBER(kd_lights_params, cascade_texel_ws),
    MEMBER(kd_resolve_params, mode),
};

static void print_log(void *user, kd_log_level level, const char *text)
{
    (void)user;
    (void)level;
    fprintf(stderr, "%s\n", text);
}

static void fill(uint32_t *words)
{
    for (uint32_t i = 0; i < MAX_WORDS; i++)
        words[i] = BASE + i;
}

static void shared_structs_lie_alike_in_c_and_glsl(void **state)
{
    static uint32_t words[MAX_WORDS];
    kd_gpu *gpu = *state;
    fill(words);
    kd_gpu_program program =
        kd_gpu_make_program(gpu, &(kd_gpu_program_desc){.compute = "tests/gpu/layout.comp"});
    kd_gpu_buffer objects = kd_gpu_make_buffer(
        gpu,
        &(kd_gpu_buffer_desc){.size = OBJECTS * sizeof(struct kd_object), .data = words, .name = "objects"});
    kd_gpu_buffer out =
        kd_gpu_make_buffer(gpu, &(kd_gpu_buffer_desc){.size = sizeof words, .zeroed = true, .name = "out"});
    kd_gpu_bind_storage(gpu, 0, objects);
    kd_gpu_bind_storage(gpu, 1, out);
    kd_gpu_bind_uniform(gpu, KD_BIND_PASS, words, sizeof(struct kd_resolve_params));
    kd_gpu_bind_uniform(gpu, KD_BIND_VIEW, words, sizeof(struct kd_view_params));
    kd_gpu_bind_uniform(gpu, KD_BIND_LIGHTS, words, sizeof(struct kd_lights_params));
    kd_gpu_bind_uniform(gpu, KD_BIND_MATERIAL, words, sizeof(struct kd_material_params));
    kd_gpu_dispatch(gpu, program, 1, 1, 1);
    kd_gpu_barrier(gpu, KD_BARRIER_BUFFER_UPDATE);
    kd_gpu_read_buffer(gpu, out, 0, words, sizeof words);
    assert_false(kd_gpu_failed(gpu));
    uint32_t next = 0;
    for (size_t i = 0; i < sizeof members / sizeof *members; i++)
        for (size_t word = 0; word < members[i].size / 4; word++, next++)
            if (words[next] != BASE + members[i].offset / 4 + word)
                fail_msg("%s word %zu: GLSL reads offset %d, C has %zu", members[i].name, word,
                         (int)(words[next] - BASE) * 4, members[i].offset + word * 4);
    assert_int_equal(words[next], 0); /* both lists end together */
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
        cmocka_unit_test_setup_teardown(shared_structs_lie_alike_in_c_and_glsl, setup, teardown),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
