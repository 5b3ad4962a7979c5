/* Looked for round the brightest texel: what a disc of few degrees has beyond the mean of a ring round it. A
 * window or a bright cloud is as bright in the ring and has next to nothing beyond it. */

#include "components/sky_sun.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static const double PI = 3.14159265358979;
static const double RADIUS = 3 * 3.14159265358979 / 180, RING = 6 * 3.14159265358979 / 180;
static const double LEAST_SHARE = 0.02; /* of the light that all the rest sheds on what faces it */
static const double LEAST_EXCESS = 1;   /* of the light that the disc would have without a sun */

typedef struct sums {
    double disc[3], disc_area, ring[3], ring_area;
} sums;

static double luminance(const double *c)
{
    return 0.2126 * c[0] + 0.7152 * c[1] + 0.0722 * c[2];
}

/* Rows and columns of a map as directions: (sine * sin, cosine, -sine * cos). */
typedef struct grid {
    const kd_sky_map *map;
    double *column; /* sine and cosine of each column's azimuth */
} grid;

typedef struct grid_row {
    double sine, cosine, area; /* of the polar angle; solid angle of a texel */
} grid_row;

static bool grid_make(const kd_sky_map *map, grid *g)
{
    *g = (grid){map, malloc(map->width * 2 * sizeof *g->column)};
    for (uint32_t x = 0; g->column != NULL && x < map->width; x++) {
        double azimuth = (((double)x + 0.5) / map->width - 0.5) * 2 * PI;
        g->column[2 * x] = sin(azimuth);
        g->column[2 * x + 1] = cos(azimuth);
    }
    return g->column != NULL;
}

static grid_row row_of(const kd_sky_map *map, uint32_t y)
{
    double polar = ((double)y + 0.5) / map->height * PI, s = sin(polar);
    return (grid_row){s, cos(polar), s * (PI / map->height) * (2 * PI / map->width)};
}

static const float *texel_of(const kd_sky_map *map, uint32_t x, uint32_t y)
{
    return map->rgb + ((size_t)y * map->width + x) * 3;
}

static void direction_of(const grid *g, const grid_row *row, uint32_t x, double *d)
{
    d[0] = row->sine * g->column[2 * x];
    d[1] = row->cosine;
    d[2] = -row->sine * g->column[2 * x + 1];
}

/* May a row have texels so near to a direction? */
static bool row_is_near(const grid_row *row, double height, double angle)
{
    return fabs(acos(fmin(fmax(row->cosine, -1), 1)) - acos(fmin(fmax(height, -1), 1))) <= angle;
}

/* ---- looking ---- */

/* Mean radiance of the whole sphere, and the direction of the brightest texel, the first of equals. */
static void survey(const grid *g, double *mean, double *brightest)
{
    double best = -1, area = 0;
    mean[0] = mean[1] = mean[2] = 0;
    for (uint32_t y = 0; y < g->map->height; y++) {
        grid_row row = row_of(g->map, y);
        for (uint32_t x = 0; x < g->map->width; x++) {
            const float *t = texel_of(g->map, x, y);
            const double c[3] = {(double)t[0], (double)t[1], (double)t[2]};
            for (int k = 0; k < 3; k++)
                mean[k] += row.area * c[k];
            if (luminance(c) > best) {
                best = luminance(c);
                direction_of(g, &row, x, brightest);
            }
        }
        area += row.area * g->map->width;
    }
    for (int k = 0; k < 3; k++)
        mean[k] /= area;
}

typedef void (*near_texel)(void *user, const double *direction, double cosine, double area,
                           const float *texel);

static void go_near(const grid *g, const double *axis, near_texel visit, void *user)
{
    for (uint32_t y = 0; y < g->map->height; y++) {
        grid_row row = row_of(g->map, y);
        bool near = row_is_near(&row, axis[1], RING);
        for (uint32_t x = 0; near && x < g->map->width; x++) {
            double d[3];
            direction_of(g, &row, x, d);
            double cosine = d[0] * axis[0] + d[1] * axis[1] + d[2] * axis[2];
            if (cosine >= cos(RING))
                visit(user, d, cosine, row.area, texel_of(g->map, x, y));
        }
    }
}

static void add_up(void *user, const double *direction, double cosine, double area, const float *texel)
{
    sums *s = user;
    (void)direction;
    bool disc = cosine >= cos(RADIUS);
    for (int k = 0; k < 3; k++)
        *(disc ? &s->disc[k] : &s->ring[k]) += area * (double)texel[k];
    *(disc ? &s->disc_area : &s->ring_area) += area;
}

typedef struct beyond {
    double round[3], light[3], way[3];
} beyond;

static void add_beyond(void *user, const double *direction, double cosine, double area, const float *texel)
{
    beyond *b = user;
    if (cosine < cos(RADIUS))
        return;
    double more[3];
    for (int k = 0; k < 3; k++) {
        more[k] = area * fmax((double)texel[k] - b->round[k], 0);
        b->light[k] += more[k];
    }
    for (int k = 0; k < 3; k++)
        b->way[k] += luminance(more) * direction[k];
}

/* The light of the disc round `axis` beyond that of its ring, and where its middle is. */
static beyond look(const grid *g, const double *axis, sums *s)
{
    beyond b = {{0}, {0}, {0}};
    *s = (sums){{0}, 0, {0}, 0};
    go_near(g, axis, add_up, s);
    for (int k = 0; k < 3; k++)
        b.round[k] = s->ring_area > 0 ? s->ring[k] / s->ring_area : 0;
    go_near(g, axis, add_beyond, &b);
    return b;
}

static bool turn_to(const beyond *b, double *axis)
{
    double l = sqrt(b->way[0] * b->way[0] + b->way[1] * b->way[1] + b->way[2] * b->way[2]);
    for (int k = 0; k < 3 && l > 0; k++)
        axis[k] = b->way[k] / l;
    return l > 0;
}

static bool is_sun(const beyond *b, const sums *s, const double *mean)
{
    double light = luminance(b->light), rest = PI * luminance(mean) - 0.25 * light;
    return light > LEAST_SHARE * rest && light > LEAST_EXCESS * luminance(b->round) * s->disc_area;
}

static kd_vec3 vec3_of(const double *v)
{
    return (kd_vec3){(float)v[0], (float)v[1], (float)v[2]};
}

bool kd_sky_sun_find(const kd_sky_map *map, kd_sky_sun *out)
{
    grid g;
    sums s;
    double mean[3], axis[3] = {0, 1, 0};
    *out = (kd_sky_sun){0};
    if (map->height < KD_SKY_SUN_ROWS || !grid_make(map, &g))
        return false;
    survey(&g, mean, axis);
    beyond b = look(&g, axis, &s);
    bool found = turn_to(&b, axis); /* of a disc that is all alike the first texel is at its rim */
    if (found) {
        b = look(&g, axis, &s);
        found = turn_to(&b, axis) && is_sun(&b, &s, mean);
    }
    free(g.column);
    if (found)
        *out = (kd_sky_sun){kd_vec3_normalize(vec3_of(axis), (kd_vec3){0, 1, 0}), vec3_of(b.light),
                            vec3_of(b.round)};
    return found;
}

/* ---- taking it out ---- */

void kd_sky_sun_remove(const kd_sky_map *map, const kd_sky_sun *sun, float *rgb)
{
    const float *most = &sun->round.x;
    memcpy(rgb, map->rgb, (size_t)map->width * map->height * 3 * sizeof *rgb);
    for (uint32_t y = 0; y < map->height; y++) {
        grid_row row = row_of(map, y);
        bool near = row_is_near(&row, (double)sun->direction.y, RADIUS + 1e-3);
        for (uint32_t x = 0; near && x < map->width; x++) {
            kd_vec3 d = kd_sky_direction(
                (kd_vec2){((float)x + 0.5f) / (float)map->width, ((float)y + 0.5f) / (float)map->height});
            float *t = rgb + ((size_t)y * map->width + x) * 3;
            if (kd_vec3_dot(d, sun->direction) >= (float)cos(RADIUS))
                for (int k = 0; k < 3; k++)
                    t[k] = fminf(t[k], most[k]);
        }
    }
}
