/* OpenEXR files of pictures: texels taken apart into a plane a channel. */
#include <math.h>
#include <stdlib.h>

#include "runtime/app/image_write.h"
#include "runtime/asset/exr_shim.h"
#include "runtime/core/file.h"
#include "runtime/core/half.h"
#include "runtime/core/log.h"
#include "shaders/shared/film.h"

/* Where a channel's values are: a part of the texels of one picture of several. */
typedef struct channel {
    const char *name;
    uint32_t slice, part;
} channel;

/* As some tools understand it: nothing was met. */
static const float no_depth = 1e10f;

static const char depth_name[] = "Z";

typedef struct source {
    const void *slices;
    bool floats;   /* of what is given, four a texel; halfs are written, but for the depth */
    size_t texels; /* of a slice */
} source;

static float value_at(const source *s, uint32_t slice, size_t texel, uint32_t part)
{
    size_t i = (slice * s->texels + texel) * 4 + part;
    return s->floats ? ((const float *)s->slices)[i] : kd_half_to_float(((const uint16_t *)s->slices)[i]);
}

static void take_halfs(const source *s, const channel *c, uint16_t *out)
{
    for (size_t i = 0; i < s->texels; i++)
        out[i] = s->floats ? kd_half_from_float(value_at(s, c->slice, i, c->part))
                           : ((const uint16_t *)s->slices)[(c->slice * s->texels + i) * 4 + c->part];
}

/* Two halfs are added up. */
static void take_depth(const source *s, const channel *c, float *out)
{
    for (size_t i = 0; i < s->texels; i++) {
        float z = value_at(s, c->slice, i, c->part);
        out[i] = z < 0 ? no_depth : z + value_at(s, c->slice, i, c->part + 1);
    }
}

static kd_status write_channels(const char *path, uint32_t width, uint32_t height, const source *s,
                                const channel *channels, uint32_t count)
{
    unsigned char *data = NULL;
    size_t size = 0;
    exr_plane *planes = malloc(count * sizeof *planes);
    float *values = malloc(s->texels * count * sizeof *values); /* room for floats in each */
    for (uint32_t i = 0; planes && values && i < count; i++) {
        float *plane = values + i * s->texels;
        bool depth = channels[i].name == depth_name;
        if (depth)
            take_depth(s, &channels[i], plane);
        else
            take_halfs(s, &channels[i], (uint16_t *)(void *)plane);
        planes[i] = (exr_plane){channels[i].name, depth, plane};
    }
    if (planes && values)
        size = exr_shim_encode(width, height, planes, count, &data);
    free(planes);
    free(values);
    if (!data)
        return kd_fail(KD_NO_MEMORY, "%s: the picture could not be encoded; choose a smaller size", path);
    kd_status status = kd_file_write(path, data, size);
    free(data);
    return status;
}

static const channel rgb[] = {{"B", 0, 2}, {"G", 0, 1}, {"R", 0, 0}};

kd_status app_exr_write(const char *path, uint32_t width, uint32_t height, const uint16_t *rgba)
{
    const source s = {rgba, false, (size_t)width * height};
    return write_channels(path, width, height, &s, rgb, 3);
}

kd_status app_exr_write_floats(const char *path, uint32_t width, uint32_t height, const float *rgba)
{
    const source s = {rgba, true, (size_t)width * height};
    return write_channels(path, width, height, &s, rgb, 3);
}

#define COLOR(name, slice)                                                                                   \
    {name ".B", slice, 2}, {name ".G", slice, 1},                                                            \
    {                                                                                                        \
        name ".R", slice, 0                                                                                  \
    }

kd_status app_exr_write_layers(const char *path, uint32_t width, uint32_t height, const void *slices,
                               bool floats)
{
    static const channel channels[] = {{"B", KD_LAYER_FINAL, 2},
                                       {"G", KD_LAYER_FINAL, 1},
                                       {"N.X", KD_LAYER_NORMAL, 0},
                                       {"N.Y", KD_LAYER_NORMAL, 1},
                                       {"N.Z", KD_LAYER_NORMAL, 2},
                                       {"R", KD_LAYER_FINAL, 0},
                                       {depth_name, KD_LAYER_MOTION, 2},
                                       COLOR("albedo", KD_LAYER_ALBEDO),
                                       {"blended.A", KD_LAYER_BLENDED, 3},
                                       COLOR("blended", KD_LAYER_BLENDED),
                                       COLOR("direct", KD_LAYER_DIRECT),
                                       COLOR("emission", KD_LAYER_EMISSION),
                                       COLOR("indirect", KD_LAYER_INDIRECT),
                                       {"motion.X", KD_LAYER_MOTION, 0},
                                       {"motion.Y", KD_LAYER_MOTION, 1},
                                       COLOR("specular", KD_LAYER_SPECULAR)};
    const source s = {slices, floats, (size_t)width * height};
    return write_channels(path, width, height, &s, channels, sizeof channels / sizeof *channels);
}
