/* Animations. Channels that move nothing here (a node outside the scene, an unknown path) are left out. */

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "runtime/asset/gltf_loader.h"

/* ---- times ---- */

static kd_status load_times(gltf_loader *l, int accessor, const char *where, kd_channel_desc *out)
{
    gltf_span span;
    kd_status status = gltf_span_of(l, accessor, where, &span);
    if (status)
        return status;
    if (span.component != GLTF_FLOAT || span.width != 1)
        return gltf_fail(l, KD_BAD_FORMAT,
                         "times are not single floats (%s, accessor %d); export the model again", where,
                         accessor);
    float *times;
    status = gltf_alloc(l, &l->kept, span.count, sizeof *times, &times);
    if (!status)
        status = gltf_read_floats(l, &span, NULL, span.count, times, 1, where);
    if (status)
        return status;
    for (uint32_t i = 0; i < span.count; i++)
        if (times[i] < 0 || (i && times[i] <= times[i - 1]))
            return gltf_fail(
                l, KD_BAD_FORMAT,
                "key %u does not follow the one before in time (%s, accessor %d); export the model again", i,
                where, accessor);
    out->times = times;
    out->key_count = span.count;
    return KD_OK;
}

/* ---- values ---- */

static uint32_t values_a_key(const kd_channel_desc *c)
{
    return c->interpolation == KD_INTERPOLATE_CUBIC ? 3 : 1;
}

/* Quaternions of unit length; those without length become no rotation. The tangents of a cubic key stay as
 * they are. */
static uint32_t normalize_rotations(const kd_channel_desc *c, float *values)
{
    uint32_t per_key = values_a_key(c), bad = 0;
    for (uint32_t k = 0; k < c->key_count; k++) {
        float *q = values + ((size_t)k * per_key + per_key / 2) * 4;
        float length = sqrtf(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
        bool usable = length > 1e-6f && isfinite(length);
        for (int i = 0; i < 4; i++)
            q[i] = usable ? q[i] / length : (float)(i == 3);
        bad += !usable;
    }
    return bad;
}

static kd_status check_values(gltf_loader *l, const gltf_span *span, const kd_channel_desc *c,
                              const char *where, int accessor)
{
    bool small = c->path == KD_PATH_ROTATION || c->path == KD_PATH_WEIGHTS; /* may be normalised integers */
    int width = c->path == KD_PATH_WEIGHTS ? 1 : (int)c->width;
    if (span->width != width ||
        (span->component != GLTF_FLOAT && !(small && span->normalized && span->component != GLTF_UINT)))
        return gltf_fail(
            l, KD_BAD_FORMAT,
            "values have a type that the path may not have (%s, accessor %d); export the model again", where,
            accessor);
    uint64_t wanted = (uint64_t)c->key_count * values_a_key(c) * (c->path == KD_PATH_WEIGHTS ? c->width : 1);
    if (span->count != wanted)
        return gltf_fail(l, KD_BAD_FORMAT,
                         "%u values where %llu are wanted (%s, accessor %d); export the model again",
                         span->count, (unsigned long long)wanted, where, accessor);
    return KD_OK;
}

static kd_status load_values(gltf_loader *l, int accessor, const char *where, kd_channel_desc *out)
{
    gltf_span span;
    kd_status status = gltf_span_of(l, accessor, where, &span);
    if (!status)
        status = check_values(l, &span, out, where, accessor);
    float *values;
    if (!status)
        status = gltf_alloc(l, &l->kept, (size_t)span.count * (uint32_t)span.width, sizeof *values, &values);
    if (!status)
        status = gltf_read_floats(l, &span, NULL, span.count, values, (uint32_t)span.width, where);
    if (status)
        return status;
    uint32_t bad = out->path == KD_PATH_ROTATION ? normalize_rotations(out, values) : 0;
    if (bad)
        gltf_warn(l, "%s: %u rotations have no length and are taken as none", where, bad);
    out->values = values;
    return KD_OK;
}

/* ---- channels ---- */

static kd_status set_interpolation(gltf_loader *l, const char *name, const char *where, kd_interpolation *out)
{
    if (strcmp(name, "LINEAR") == 0)
        *out = KD_INTERPOLATE_LINEAR;
    else if (strcmp(name, "STEP") == 0)
        *out = KD_INTERPOLATE_STEP;
    else if (strcmp(name, "CUBICSPLINE") == 0)
        *out = KD_INTERPOLATE_CUBIC;
    else
        return gltf_fail(l, KD_BAD_FORMAT,
                         "'%.40s' is no interpolation (%s); use LINEAR, STEP or CUBICSPLINE", name, where);
    return KD_OK;
}

static bool find_path(const char *name, kd_channel_path *out)
{
    static const char *const names[] = {"translation", "rotation", "scale", "weights"};
    for (int i = 0; i < 4; i++)
        if (strcmp(name, names[i]) == 0) {
            *out = (kd_channel_path)i;
            return true;
        }
    return false;
}

/* Decide what a channel moves. Returns false, after a warning where it matters, when it is left out. */
static bool find_target(gltf_loader *l, const gltf_channel *c, const char *where, kd_channel_desc *out)
{
    out->node = l->node_of[c->node];
    if (out->node == KD_NONE)
        return false;
    if (!find_path(c->path, &out->path)) {
        gltf_warn(l, "%s: the path '%.40s' is not animated", where, c->path);
        return false;
    }
    const kd_node_desc *node = &l->model->nodes[out->node];
    if (out->path != KD_PATH_WEIGHTS && node->has_matrix) {
        gltf_warn(l, "%s: the node has a matrix with shear and is not animated", where);
        return false;
    }
    out->width = out->path == KD_PATH_ROTATION ? 4 : out->path == KD_PATH_WEIGHTS ? node->morph_count : 3;
    if (!out->width)
        gltf_warn(l, "%s: the node has no morph targets", where);
    return out->width > 0;
}

/* Which paths of each node, and which properties of each material, light and camera behind them, the current
 * clip animates already: repetitions are found without a search. */
typedef struct claim {
    uint32_t clip, paths;
} claim;

static bool is_repeated(claim *c, size_t clip, uint32_t path)
{
    if (c->clip != (uint32_t)clip + 1)
        *c = (claim){(uint32_t)clip + 1, 0};
    bool repeated = c->paths >> path & 1;
    c->paths |= 1u << path;
    return repeated;
}

static kd_status load_curve(gltf_loader *l, const gltf_clip *from, size_t clip_index, int sampler,
                            kd_channel_desc *out, kd_clip_desc *clip)
{
    char where[80];
    const gltf_curve *curve = &from->curves[sampler];
    snprintf(where, sizeof where, "animations[%zu].samplers[%d]", clip_index, sampler);
    kd_status status = set_interpolation(l, curve->interpolation, where, &out->interpolation);
    if (!status)
        status = load_times(l, curve->input, where, out);
    if (!status)
        status = load_values(l, curve->output, where, out);
    if (!status)
        clip->duration = fmaxf(clip->duration, out->times[out->key_count - 1]);
    return status;
}

/* ---- pointers to what is no node ---- */

typedef enum pointed { POINTED_MATERIAL, POINTED_LIGHT, POINTED_CAMERA } pointed;

typedef struct pointer_row {
    pointed what;
    const char *after; /* the number */
    kd_property property;
    uint32_t width;
} pointer_row;

static const pointer_row pointer_rows[] = {
    {POINTED_MATERIAL, "/pbrMetallicRoughness/baseColorFactor", KD_PROPERTY_BASE_COLOR, 4},
    {POINTED_MATERIAL, "/pbrMetallicRoughness/metallicFactor", KD_PROPERTY_METALLIC, 1},
    {POINTED_MATERIAL, "/pbrMetallicRoughness/roughnessFactor", KD_PROPERTY_ROUGHNESS, 1},
    {POINTED_MATERIAL, "/emissiveFactor", KD_PROPERTY_EMISSIVE, 3},
    {POINTED_MATERIAL, "/extensions/KHR_materials_emissive_strength/emissiveStrength",
     KD_PROPERTY_EMISSIVE_STRENGTH, 1},
    {POINTED_LIGHT, "/color", KD_PROPERTY_LIGHT_COLOR, 3},
    {POINTED_LIGHT, "/intensity", KD_PROPERTY_LIGHT_INTENSITY, 1},
    {POINTED_LIGHT, "/range", KD_PROPERTY_LIGHT_RANGE, 1},
    {POINTED_LIGHT, "/spot/innerConeAngle", KD_PROPERTY_LIGHT_INNER_CONE, 1},
    {POINTED_LIGHT, "/spot/outerConeAngle", KD_PROPERTY_LIGHT_OUTER_CONE, 1},
    {POINTED_CAMERA, "/perspective/yfov", KD_PROPERTY_CAMERA_FOV_Y, 1},
    {POINTED_CAMERA, "/orthographic/ymag", KD_PROPERTY_CAMERA_Y_MAG, 1},
};

/* Returns NULL when nothing of this kind is animated. */
static const pointer_row *find_pointer(const char *pointer, uint32_t *number)
{
    static const char *const before[] = {"/materials/%9u%n", "/extensions/KHR_lights_punctual/lights/%9u%n",
                                         "/cameras/%9u%n"};
    for (size_t i = 0; i < sizeof pointer_rows / sizeof *pointer_rows; i++) {
        int end = 0;
        if (sscanf(pointer, before[pointer_rows[i].what], number, &end) == 1 &&
            strcmp(pointer + end, pointer_rows[i].after) == 0)
            return &pointer_rows[i];
    }
    return NULL;
}

static uint32_t pointed_count(const gltf_loader *l, pointed what)
{
    return what == POINTED_MATERIAL ? l->model->material_count
           : what == POINTED_LIGHT  ? l->model->light_count
                                    : l->model->camera_count;
}

/* Factors are kept as radiance, strengths as shares: either then moves what the other leaves. */
static void scale_emission(gltf_loader *l, const kd_property_channel *c, const char *where)
{
    float strength = (float)l->doc.materials[c->target].emissive_strength;
    float scale = c->property == KD_PROPERTY_EMISSIVE ? strength : strength > 0 ? 1 / strength : 0;
    float *values = (float *)(uintptr_t)c->curve.values; /* made by load_values, const for readers */
    if (c->property == KD_PROPERTY_EMISSIVE_STRENGTH && !(strength > 0))
        gltf_warn(l, "%s: the material's emissive strength is 0 at rest and stays so", where);
    for (size_t i = 0; i < (size_t)c->curve.key_count * values_a_key(&c->curve) * c->curve.width; i++)
        values[i] *= scale;
}

static claim *pointed_claim(const gltf_loader *l, claim *claims, pointed what, uint32_t number)
{
    claims += l->model->node_count;
    for (int before = 0; before < (int)what; before++)
        claims += pointed_count(l, (pointed)before);
    return claims + number;
}

static kd_status load_property(gltf_loader *l, claim *claims, size_t clip_index, const gltf_channel *c,
                               const char *where, kd_clip_desc *clip)
{
    uint32_t number = 0;
    const pointer_row *row = find_pointer(c->path, &number);
    if (!row) {
        gltf_warn(l, "%s: '%.160s' is not animated", where, c->path);
        return KD_OK;
    }
    if (number >= pointed_count(l, row->what))
        return gltf_fail(l, KD_BAD_FORMAT,
                         "'%.160s' points to what is not there (%s); export the model again", c->path, where);
    if (is_repeated(pointed_claim(l, claims, row->what, number), clip_index, row->property)) {
        gltf_warn(l, "%s: '%.160s' is animated before; left out", where, c->path);
        return KD_OK;
    }
    kd_property_channel out = {.property = row->property,
                               .target = number,
                               .curve = {.node = KD_NONE, .path = KD_PATH_PROPERTY, .width = row->width}};
    kd_status status = load_curve(l, &l->doc.clips[clip_index], clip_index, c->sampler, &out.curve, clip);
    if (status)
        return status;
    if (out.property == KD_PROPERTY_EMISSIVE || out.property == KD_PROPERTY_EMISSIVE_STRENGTH) {
        scale_emission(l, &out, where);
        ((kd_material_desc *)(uintptr_t)l->model->materials)[number].glows_in_clips = true; /* ours so far */
    }
    ((kd_property_channel *)clip->properties)[clip->property_count++] = out; /* made by load_clip */
    return KD_OK;
}

static kd_status load_channel(gltf_loader *l, claim *claims, size_t clip_index, size_t index,
                              kd_clip_desc *clip)
{
    const gltf_clip *from = &l->doc.clips[clip_index];
    const gltf_channel *c = &from->channels[index];
    char where[80];
    snprintf(where, sizeof where, "animations[%zu].channels[%zu]", clip_index, index);
    if (c->sampler < 0 || (size_t)c->sampler >= from->curve_count)
        return gltf_fail(l, KD_BAD_FORMAT, "there is no sampler %d (%s); export the model again", c->sampler,
                         where);
    if (c->path[0] == '/')
        return load_property(l, claims, clip_index, c, where, clip);
    if (c->node == -1) /* the format says: ignore it */
        return KD_OK;
    if (c->node < 0 || (size_t)c->node >= l->doc.node_count)
        return gltf_fail(l, KD_BAD_FORMAT, "there is no node %d (%s.target); export the model again", c->node,
                         where);
    kd_channel_desc out = {0};
    if (!find_target(l, c, where, &out))
        return KD_OK;
    if (is_repeated(&claims[out.node], clip_index, out.path)) {
        gltf_warn(l, "%s: the same path of the same node is animated before; left out", where);
        return KD_OK;
    }
    kd_status status = load_curve(l, from, clip_index, c->sampler, &out, clip);
    if (status)
        return status;
    kd_channel_desc *channels = (kd_channel_desc *)clip->channels; /* made by load_clip, const for readers */
    channels[clip->channel_count++] = out;
    return KD_OK;
}

static int compare_properties(const void *a, const void *b)
{
    const kd_property_channel *x = a, *y = b;
    return x->target != y->target ? (x->target > y->target) - (x->target < y->target)
                                  : (int)x->property - (int)y->property;
}

static kd_status load_clip(gltf_loader *l, claim *claims, size_t index, kd_clip_desc *out)
{
    const gltf_clip *from = &l->doc.clips[index];
    kd_channel_desc *channels;
    kd_property_channel *properties = NULL;
    size_t pointers = 0;
    for (size_t i = 0; i < from->channel_count; i++)
        pointers += from->channels[i].path[0] == '/';
    out->name = gltf_name(l, from->name, "clip", index);
    kd_status status = gltf_alloc(l, &l->kept, from->channel_count, sizeof *channels, &channels);
    if (!status && pointers)
        status = gltf_alloc(l, &l->kept, pointers, sizeof *properties, &properties);
    out->channels = channels;
    out->properties = properties;
    for (size_t i = 0; !status && i < from->channel_count; i++)
        status = load_channel(l, claims, index, i, out);
    if (properties)
        qsort(properties, out->property_count, sizeof *properties, compare_properties);
    return status;
}

kd_status gltf_load_clips(gltf_loader *l)
{
    kd_clip_desc *clips;
    claim *claims = NULL;
    kd_status status = gltf_alloc(l, &l->kept, l->doc.clip_count, sizeof *clips, &clips);
    if (!status)
        status = gltf_alloc(l, &l->scratch,
                            (size_t)l->model->node_count + l->model->material_count + l->model->light_count +
                                l->model->camera_count,
                            sizeof *claims, &claims);
    for (size_t i = 0; !status && i < l->doc.clip_count; i++)
        status = load_clip(l, claims, i, &clips[i]);
    l->model->clips = clips;
    l->model->clip_count = (uint32_t)l->doc.clip_count;
    return status;
}
