/* A program of one's own on top of Kandil: a component, a system on the CPU and one on the GPU.
 *
 * `spin` turns what has it; `vignette` darkens the corners of the picture. Scenarios name both components as
 * they name the built-in ones, and both systems stand in the profile:
 *
 *     carousel run carousel.lua --out carousel.png --profile table */

#include <math.h>

#include "kandil.h"

/* ---- components ---- */
typedef struct spin {
    kd_vec3 axis;
    float turns_per_s;
} spin;
static const spin spin_default = {{0, 1, 0}, 0.25f};
KD_COMPONENT_DEFINE_DEFAULT(spin, "spin", &spin_default,
                            KD_FIELD(spin, axis, KD_VEC3, NULL, "axis of the parent's space to turn about"),
                            KD_FIELD_RANGE(spin, turns_per_s, KD_F32, "1/s", -100, 100, "how fast"));

typedef struct vignette {
    float strength;
} vignette;
KD_COMPONENT_DEFINE(vignette, "vignette",
                    KD_FIELD_RANGE(vignette, strength, KD_F32, NULL, 0, 1, "light that the corners lose"));

static void register_components(kd_world *w)
{
    (void)KD_ID(w, spin);
    (void)KD_ID(w, vignette);
}

/* What the systems keep: one run, one world. */
typedef struct carousel {
    kd_query *spinning, *lenses;
    kd_gpu_program vignette;
} carousel;

/* ---- turning, on a worker ---- */
static kd_status turn_init(kd_system_context *context)
{
    carousel *c = context->user;
    c->spinning =
        kd_query_make(context->world, &(kd_query_desc){.terms = {KD_READ(spin), KD_WRITE(kd_transform)}});
    return c->spinning ? KD_OK : KD_NO_MEMORY;
}

static void turn(kd_system_context *context)
{
    carousel *c = context->user;
    for (kd_iter it = kd_query_iter(c->spinning); kd_iter_next(&it);) {
        const spin *s = KD_COLUMN(&it, spin, 0);
        kd_transform *t = KD_COLUMN_MUT(&it, kd_transform, 1);
        for (uint32_t i = 0; i < it.count; i++) {
            double half = 3.14159265358979 * (double)s[i].turns_per_s * context->time_s;
            float sine = (float)sin(half);
            t[i].rotation = kd_quat_normalize(
                (kd_quat){s[i].axis.x * sine, s[i].axis.y * sine, s[i].axis.z * sine, (float)cos(half)});
        }
    }
}

/* ---- darkening, on the GPU ---- */
static const char vignette_source[] =
    "#include \"shaders/shared/bindings.h\"\n"
    "layout(local_size_x = 8, local_size_y = 8) in;\n"
    "layout(binding = 0, rgba8) uniform image2D picture;\n"
    "layout(std140, binding = KD_BIND_PASS) uniform pass { vec4 strength; };\n"
    "void main()\n"
    "{\n"
    "    ivec2 at = ivec2(gl_GlobalInvocationID.xy), size = imageSize(picture);\n"
    "    if (any(greaterThanEqual(at, size)))\n"
    "        return;\n"
    "    vec2 from_middle = (vec2(at) + 0.5) / vec2(size) * 2.0 - 1.0;\n"
    "    float left = 1.0 - strength.x * 0.5 * dot(from_middle, from_middle);\n"
    "    imageStore(picture, at, vec4(imageLoad(picture, at).rgb * left, 1.0));\n"
    "}\n";
static const kd_embedded_shader shaders[] = {
    KD_SHADER("shaders/carousel/vignette.comp", vignette_source),
    {NULL, NULL, 0},
};

static kd_status darken_init(kd_system_context *context)
{
    carousel *c = context->user;
    c->lenses = kd_query_make(context->world, &(kd_query_desc){.terms = {KD_READ(vignette)}});
    c->vignette = kd_gpu_make_program(context->gpu,
                                      &(kd_gpu_program_desc){.compute = "shaders/carousel/vignette.comp"});
    return c->lenses && c->vignette.id ? KD_OK : KD_GPU;
}

static void darken(kd_system_context *context)
{
    carousel *c = context->user;
    const kd_picture *picture = kd_singleton(context->world, kd_picture);
    float pass[4] = {0};
    for (kd_iter it = kd_query_iter(c->lenses); kd_iter_next(&it);)
        pass[0] = KD_COLUMN(&it, vignette, 0)[it.count - 1].strength;
    kd_gpu_bind_uniform(context->gpu, KD_BIND_PASS, pass, sizeof pass);
    kd_gpu_bind_image(context->gpu, 0, picture->ldr, 0, KD_IMAGE_READ_WRITE, KD_RGBA8);
    kd_gpu_dispatch(context->gpu, c->vignette, (picture->width + 7) / 8, (picture->height + 7) / 8, 1);
}

static void darken_fini(kd_system_context *context)
{
    carousel *c = context->user;
    kd_gpu_destroy_program(context->gpu, c->vignette);
}

/* ---- the program ---- */
static kd_status import_systems(kd_schedule *s)
{
    static carousel state;
    state = (carousel){0};
    kd_status status =
        kd_schedule_add(s, &(kd_system_desc){.name = "turn",
                                             .phase = KD_PHASE_ANIMATE,
                                             .components = {KD_USES(spin), KD_CHANGES(kd_transform)},
                                             .no_commands = true,
                                             .init = turn_init,
                                             .run = turn,
                                             .user = &state});
    if (status != KD_OK)
        return status;
    return kd_schedule_add(
        s, &(kd_system_desc){.name = "darken",
                             .phase = KD_PHASE_VIEW,
                             .where = KD_ON_GPU,
                             .components = {KD_USES(vignette), KD_USES(kd_picture)},
                             .resources = {{"picture", KD_USE_IMAGE_READ | KD_USE_IMAGE_WRITE}},
                             .no_commands = true,
                             .init = darken_init,
                             .run = darken,
                             .fini = darken_fini,
                             .user = &state});
}

int main(int argc, char **argv)
{
    return kd_main(argc, argv,
                   &(kd_extension){.name = "carousel",
                                   .register_components = register_components,
                                   .import_systems = import_systems,
                                   .shaders = shaders});
}
