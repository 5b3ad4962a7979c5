/* System sky: the sky's picture and its means over cones to the GPU, when they differ from what is there. Its
 * factor, its turn and the uniform part are a small block that is written every frame. */

#include "systems/sky/sky.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "components/frame.h"
#include "components/sky.h"
#include "components/transform.h"
#include "runtime/core/half.h"
#include "runtime/core/log.h"
#include "shaders/shared/sky.h"
#include "systems/sky/cones.h"

enum { CONE_HALVES = KD_SKY_LAYERS * KD_SKY_EDGE * KD_SKY_EDGE * 4 };

typedef struct sky_state {
    kd_query *query;
    bool shows;             /* textures of a sky are there */
    kd_sky shown;           /* whose they are, whatever its factor */
    bool shown_without_sun; /* by the means over cones */
    float gradient[KD_SKY_GRADIENT_WIDTH * KD_SKY_GRADIENT_HEIGHT * 3];
    uint16_t cones[CONE_HALVES];
    uint64_t bytes_moved;
    struct kd_sky_params params; /* of the frame before */
} sky_state;

static kd_gpu_texture make_map(kd_gpu *gpu, const kd_sky_map *map)
{
    size_t count = (size_t)map->width * map->height;
    uint16_t *halves = malloc(count * 4 * sizeof *halves);
    if (halves == NULL) {
        kd_fail(KD_NO_MEMORY, "sky: no memory for %u x %u texels; use a smaller picture", map->width,
                map->height);
        return (kd_gpu_texture){0};
    }
    for (size_t i = 0; i < count; i++) {
        for (size_t c = 0; c < 3; c++)
            halves[i * 4 + c] = kd_half_from_float(map->rgb[i * 3 + c]);
        halves[i * 4 + 3] = 0;
    }
    kd_gpu_texture texture = kd_gpu_make_texture(gpu, &(kd_gpu_texture_desc){.format = KD_RGBA16F,
                                                                             .width = map->width,
                                                                             .height = map->height,
                                                                             .wrap_s = KD_REPEAT,
                                                                             .data = halves,
                                                                             .name = "sky"});
    free(halves);
    return texture;
}

static kd_gpu_texture make_cones(kd_gpu *gpu, uint32_t edge, uint32_t layers, const uint16_t *texels)
{
    return kd_gpu_make_texture(gpu, &(kd_gpu_texture_desc){.kind = KD_TEXTURE_3D,
                                                           .format = KD_RGBA16F,
                                                           .width = edge,
                                                           .height = edge,
                                                           .depth = layers,
                                                           .data = texels,
                                                           .name = "sky cones"});
}

static void replace(kd_gpu *gpu, kd_sky_light *light, kd_gpu_texture map, kd_gpu_texture cones)
{
    kd_gpu_destroy_texture(gpu, light->map);
    kd_gpu_destroy_texture(gpu, light->cones);
    light->map = map;
    light->cones = cones;
    light->version++;
}

/* Without a sky both are one black texel. */
static void show_nothing(kd_gpu *gpu, sky_state *s, kd_sky_light *light)
{
    static const uint16_t black[4] = {0};
    static const float black_map[3] = {0};
    replace(gpu, light, make_map(gpu, &(kd_sky_map){1, 1, black_map}), make_cones(gpu, 1, 1, black));
    s->shows = false;
}

/* Means of a sky whose sun is a light of its own are of all the rest. */
static bool make_means(const kd_sky_map *map, const kd_sky_sun *sun, uint16_t *out)
{
    if (sun == NULL)
        return sky_cones_make(map, out);
    float *rest = malloc((size_t)map->width * map->height * 3 * sizeof *rest);
    if (rest == NULL)
        return false;
    kd_sky_sun_remove(map, sun, rest);
    bool made = sky_cones_make(&(kd_sky_map){map->width, map->height, rest}, out);
    free(rest);
    return made;
}

static void show(kd_system_context *context, sky_state *s, kd_sky_light *light, const kd_sky *sky,
                 const kd_sky_sun *sun)
{
    kd_sky_map map = kd_sky_map_of(context->world, sky, s->gradient);
    if (!make_means(&map, sun, s->cones)) {
        kd_fail(KD_NO_MEMORY, "sky: no memory for its means over cones; use a smaller picture");
        return;
    }
    replace(context->gpu, light, make_map(context->gpu, &map),
            make_cones(context->gpu, KD_SKY_EDGE, KD_SKY_LAYERS, s->cones));
    s->bytes_moved = sizeof s->cones + (uint64_t)map.width * map.height * 8;
    s->shows = true;
    s->shown = *sky;
    s->shown_without_sun = sun != NULL;
}

/* Of a picture the colours do not count. */
static bool looks_alike(const kd_sky *a, const kd_sky *b)
{
    return a->image == b->image &&
           (a->image > 0 || (memcmp(&a->zenith, &b->zenith, sizeof a->zenith) == 0 &&
                             memcmp(&a->horizon, &b->horizon, sizeof a->horizon) == 0 &&
                             memcmp(&a->ground, &b->ground, sizeof a->ground) == 0));
}

static void sky_run(kd_system_context *context)
{
    sky_state *s = context->user;
    kd_sky_light *light = kd_singleton(context->world, kd_sky_light);
    const kd_settings *settings = &kd_singleton(context->world, kd_frame)->settings;
    float ambient = settings->light_ambient;
    kd_sky sky = {.intensity = 0};
    kd_mat4 world = KD_MAT4_IDENTITY;
    bool there = kd_sky_pick(s->query, &sky, &world);
    const kd_sky_sun *sun = there && settings->light_sky_sun ? kd_sky_sun_of(context->world, &sky) : NULL;
    s->bytes_moved = 0;
    if (there && !(s->shows && looks_alike(&sky, &s->shown) && s->shown_without_sun == (sun != NULL)))
        show(context, s, light, &sky, sun);
    else if (!there && (s->shows || light->map.id == 0))
        show_nothing(context->gpu, s, light);
    kd_vec3 rows[3];
    kd_sky_rows(&world, rows);
    struct kd_sky_params params = {.ambient = {ambient, ambient, ambient, 0}};
    for (int i = 0; i < 3; i++)
        params.to_map[i] = (kd_gl_vec4){rows[i].x, rows[i].y, rows[i].z, i == 0 ? sky.intensity : 0};
    if (memcmp(&s->params, &params, sizeof params) != 0)
        light->version++;
    s->params = params;
    kd_gpu_write_buffer(context->gpu, light->uniform, 0, &params, sizeof params);
}

static kd_status sky_init(kd_system_context *context)
{
    sky_state *s = context->user;
    kd_sky_light *light = kd_singleton(context->world, kd_sky_light);
    s->query = kd_query_make(
        context->world,
        &(kd_query_desc){.terms = {KD_READ(kd_sky), KD_READ(kd_world_transform)}, .name = "sky"});
    if (s->query == NULL)
        return kd_fail(KD_NO_MEMORY, "sky: no memory for its query; free some");
    light->uniform = kd_gpu_make_buffer(
        context->gpu, &(kd_gpu_buffer_desc){
                          .size = sizeof(struct kd_sky_params), .usage = KD_BUFFER_STREAM, .name = "sky"});
    return light->uniform.id != 0 ? KD_OK : KD_GPU;
}

static void sky_fini(kd_system_context *context)
{
    sky_state *s = context->user;
    kd_sky_light *light = kd_singleton(context->world, kd_sky_light);
    replace(context->gpu, light, (kd_gpu_texture){0}, (kd_gpu_texture){0});
    kd_gpu_destroy_buffer(context->gpu, light->uniform);
    *light = (kd_sky_light){0};
    if (s->query != NULL)
        kd_query_destroy(s->query);
    free(s);
}

static uint64_t sky_bytes(const kd_system_context *context)
{
    return ((const sky_state *)context->user)->bytes_moved;
}

kd_status kd_sky_import(kd_schedule *schedule)
{
    sky_state *s = calloc(1, sizeof *s);
    if (s == NULL)
        return kd_fail(KD_NO_MEMORY, "sky: no memory for its state; free some");
    kd_status status = kd_schedule_add(
        schedule,
        &(kd_system_desc){.name = "sky",
                          .phase = KD_PHASE_SHADOW,
                          .where = KD_ON_GPU,
                          .components = {KD_USES(kd_sky), KD_USES(kd_world_transform), KD_USES(kd_sky_images),
                                         KD_USES(kd_frame), KD_CHANGES(kd_sky_light)},
                          .resources = {{"sky", KD_USE_COPY_WRITE}},
                          .no_commands = true,
                          .init = sky_init,
                          .run = sky_run,
                          .fini = sky_fini,
                          .bytes_moved = sky_bytes,
                          .user = s});
    if (status != KD_OK)
        free(s);
    return status;
}
