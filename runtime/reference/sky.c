/* The picture of a sky as a light: directions are chosen by the brightness of its texels, a row by its sum
 * and then a texel of the row. None has less than a hundredth of the mean. Source  Pharr, Jakob and Humphreys
 * 2016, Physically Based Rendering, 14.2.4 */

#include "components/sky.h"

#include <math.h>

#include "components/transform.h"
#include "runtime/core/log.h"
#include "runtime/reference/internal.h"

static const float LEAST = 0.01f; /* of the mean brightness */

/* The brightest of a texel and its neighbours: interpolation carries their light into it. */
static float brightness(const kd_sky_map *map, uint32_t x, uint32_t y)
{
    float most = 0;
    for (uint32_t j = y > 0 ? y - 1 : 0; j <= y + 1 && j < map->height; j++)
        for (uint32_t i = 0; i < 3; i++) {
            const float *c = map->rgb + ((size_t)j * map->width + (x + map->width + i - 1) % map->width) * 3;
            most = fmaxf(most, reference_luminance((kd_vec3){c[0], c[1], c[2]}));
        }
    return most;
}

/* Rows count by the solid angle of their texels. */
static double row_weight(const kd_sky_map *map, uint32_t y)
{
    return sin(3.14159265358979 * ((double)y + 0.5) / (double)map->height);
}

static double mean_brightness(const kd_sky_map *map)
{
    double sum = 0, weights = 0;
    for (uint32_t y = 0; y < map->height; y++) {
        double w = row_weight(map, y);
        for (uint32_t x = 0; x < map->width; x++)
            sum += w * (double)brightness(map, x, y);
        weights += w * map->width;
    }
    return sum / weights;
}

static void fill_sums(reference_sky *sky, double least)
{
    const kd_sky_map *map = &sky->map;
    double total = 0;
    for (uint32_t y = 0; y < map->height; y++) {
        float *row = sky->cdf + (size_t)y * map->width;
        double sum = 0, row_sum = 0;
        for (uint32_t x = 0; x < map->width; x++)
            row_sum += (double)brightness(map, x, y) + least;
        for (uint32_t x = 0; x < map->width; x++)
            row[x] = (float)((sum += (double)brightness(map, x, y) + least) / row_sum);
        sky->row_cdf[y] = (float)(total += row_sum * row_weight(map, y));
    }
    for (uint32_t y = 0; y < map->height; y++)
        sky->row_cdf[y] = (float)((double)sky->row_cdf[y] / total);
}

static kd_status keep_gradient(reference_scene *s, const kd_sky_map *map)
{
    size_t count = (size_t)map->width * map->height * 3;
    float *copy = KD_ARENA_NEW(&s->arena, float, count);
    for (size_t i = 0; copy != NULL && i < count; i++)
        copy[i] = map->rgb[i];
    s->sky.map.rgb = copy;
    return copy != NULL ? KD_OK : KD_NO_MEMORY;
}

static kd_status build(kd_world *w, reference_scene *s, const kd_sky *sky, const kd_mat4 *world)
{
    float gradient[KD_SKY_GRADIENT_WIDTH * KD_SKY_GRADIENT_HEIGHT * 3];
    s->sky.map = kd_sky_map_of(w, sky, gradient);
    s->sky.factor = sky->intensity;
    kd_sky_rows(world, s->sky.rows);
    if (s->sky.map.rgb == gradient && keep_gradient(s, &s->sky.map) != KD_OK)
        return KD_NO_MEMORY;
    double mean = mean_brightness(&s->sky.map);
    if (!(mean * (double)sky->intensity > 0)) { /* black: as if there were none */
        s->sky.map.width = 0;
        return KD_OK;
    }
    s->sky.row_cdf = KD_ARENA_NEW(&s->arena, float, s->sky.map.height);
    s->sky.cdf = KD_ARENA_NEW(&s->arena, float, (size_t)s->sky.map.width * s->sky.map.height);
    if (s->sky.row_cdf == NULL || s->sky.cdf == NULL)
        return KD_NO_MEMORY;
    fill_sums(&s->sky, (double)LEAST * mean);
    return KD_OK;
}

kd_status reference_sky_build(kd_world *w, reference_scene *s)
{
    kd_sky sky;
    kd_mat4 world;
    kd_query *query =
        kd_query_make(w, &(kd_query_desc){.terms = {KD_READ(kd_sky), KD_READ(kd_world_transform)},
                                          .name = "reference sky"});
    kd_status status = query != NULL ? KD_OK : KD_NO_MEMORY;
    if (status == KD_OK && kd_sky_pick(query, &sky, &world))
        status = build(w, s, &sky, &world);
    if (query != NULL)
        kd_query_destroy(query);
    return status == KD_OK ? KD_OK
                           : kd_fail(status, "reference: out of memory for the sky; use a smaller picture");
}

static kd_vec3 to_map(const reference_sky *sky, kd_vec3 d)
{
    return (kd_vec3){kd_vec3_dot(sky->rows[0], d), kd_vec3_dot(sky->rows[1], d),
                     kd_vec3_dot(sky->rows[2], d)};
}

kd_vec3 reference_sky_picture(const reference_scene *scene, kd_vec3 direction)
{
    const reference_sky *sky = &scene->sky;
    if (sky->map.width == 0)
        return (kd_vec3){0, 0, 0};
    return kd_vec3_scale(kd_sky_sample(&sky->map, to_map(sky, direction)), sky->factor);
}

kd_vec3 reference_sky_radiance(const reference_scene *scene, kd_vec3 direction)
{
    return kd_vec3_add(scene->ambient, reference_sky_picture(scene, direction));
}

/* First of the sums that is above u; *share gets where u lies in its step, *width the step. */
static uint32_t find(const float *cdf, uint32_t count, float u, float *share, float *width)
{
    uint32_t low = 0, high = count - 1;
    while (low < high) {
        uint32_t middle = low + (high - low) / 2;
        if (cdf[middle] > u)
            high = middle;
        else
            low = middle + 1;
    }
    float before = low > 0 ? cdf[low - 1] : 0;
    *width = cdf[low] - before;
    *share = *width > 0 ? fminf(fmaxf((u - before) / *width, 0), 1) : 0.5f;
    return low;
}

/* Density on the sphere of a texel that is chosen with these two probabilities: its solid angle is that of
 * its place in the row. */
static float density(const kd_sky_map *map, float row, float column, float y)
{
    float sine = sinf(REFERENCE_PI * y / (float)map->height);
    float texels = (float)map->width * (float)map->height;
    return sine > 0 ? row * column * texels / (2 * REFERENCE_PI * REFERENCE_PI * sine) : 0;
}

float reference_sky_choose(const reference_scene *scene, float u, float v, kd_vec3 *direction)
{
    const reference_sky *sky = &scene->sky;
    float dx, dy, row, column;
    uint32_t y = find(sky->row_cdf, sky->map.height, v, &dy, &row);
    uint32_t x = find(sky->cdf + (size_t)y * sky->map.width, sky->map.width, u, &dx, &column);
    kd_vec2 place = {((float)x + dx) / (float)sky->map.width, ((float)y + dy) / (float)sky->map.height};
    kd_vec3 d = kd_sky_direction(place);
    *direction = kd_vec3_add(kd_vec3_scale(sky->rows[0], d.x),
                             kd_vec3_add(kd_vec3_scale(sky->rows[1], d.y), kd_vec3_scale(sky->rows[2], d.z)));
    return density(&sky->map, row, column, (float)y + dy);
}

float reference_sky_pdf(const reference_scene *scene, kd_vec3 direction)
{
    const reference_sky *sky = &scene->sky;
    if (sky->map.width == 0)
        return 0;
    kd_vec2 place = kd_sky_place(to_map(sky, direction));
    float fx = place.x * (float)sky->map.width, fy = place.y * (float)sky->map.height;
    uint32_t x = (uint32_t)fminf(fmaxf(fx, 0), (float)sky->map.width - 1),
             y = (uint32_t)fminf(fmaxf(fy, 0), (float)sky->map.height - 1);
    const float *row = sky->cdf + (size_t)y * sky->map.width;
    float of_row = sky->row_cdf[y] - (y > 0 ? sky->row_cdf[y - 1] : 0);
    return density(&sky->map, of_row, row[x] - (x > 0 ? row[x - 1] : 0), fy);
}
