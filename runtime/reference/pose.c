/* Morphs and skins a primitive by the C form of the deform pass, on the same packed streams, so that both
 * renderers see the same vertices. */

#include <string.h>

#include "runtime/core/log.h"
#include "runtime/reference/internal.h"
#include "systems/deform/deform_reference.h"
#include "systems/scene/internal.h"

/* Targets that weigh something, as pairs of target and weight; their deltas one behind the other. */
static bool pack_morphs(kd_arena *arena, const kd_primitive_desc *desc, const kd_morph_weights *weights,
                        deform_streams *streams, struct kd_deform_item *item)
{
    uint32_t used = 0, n = desc->vertex_count;
    for (uint32_t t = 0; weights && t < weights->count && t < desc->morph_count; t++)
        used += weights->weights[t] != 0;
    uint32_t *words = KD_ARENA_NEW(arena, uint32_t, 2 * (size_t)used + 1);
    uint32_t *deltas = KD_ARENA_NEW(arena, uint32_t, (size_t)used * n * KD_MORPH_WORDS + 1);
    if (!words || !deltas)
        return false;
    for (uint32_t t = 0; used && t < weights->count && t < desc->morph_count; t++) {
        if (weights->weights[t] == 0)
            continue;
        words[2 * item->morph.z] = item->morph.z;
        memcpy(&words[2 * item->morph.z + 1], &weights->weights[t], sizeof *words);
        scene_pack_morph(desc, t, deltas + (size_t)item->morph.z * n * KD_MORPH_WORDS);
        item->morph.z++;
    }
    streams->morphs = deltas;
    streams->words = words;
    return true;
}

static bool pack_skin(kd_arena *arena, const kd_primitive_desc *desc, const kd_vec4 (*rows)[3],
                      uint32_t row_count, deform_streams *streams, struct kd_deform_item *item)
{
    item->range.w = KD_DEFORM_NONE;
    if (!rows || !row_count || !desc->joints)
        return true;
    uint32_t *words = KD_ARENA_NEW(arena, uint32_t, (size_t)desc->vertex_count * KD_SKIN_WORDS);
    if (!words)
        return false;
    scene_pack_skin(desc, words);
    streams->skins = words;
    streams->joints = rows;
    item->range.w = 0;
    item->skin.y = row_count;
    return true;
}

static bool unpack(kd_arena *arena, const uint32_t *w, uint32_t count, reference_pose *out)
{
    kd_vec3 *positions = KD_ARENA_NEW(arena, kd_vec3, count), *normals = KD_ARENA_NEW(arena, kd_vec3, count);
    kd_vec4 *tangents = KD_ARENA_NEW(arena, kd_vec4, count);
    if (!positions || !normals || !tangents)
        return false;
    for (uint32_t v = 0; v < count; v++, w += KD_GEOMETRY_WORDS) {
        positions[v] = (kd_vec3){deform_float(w[0]), deform_float(w[1]), deform_float(w[2])};
        normals[v] = (kd_vec3){deform_snorm(w[3], 0), deform_snorm(w[3], 1), deform_snorm(w[4], 0)};
        tangents[v] = (kd_vec4){deform_snorm(w[5], 0), deform_snorm(w[5], 1), deform_snorm(w[6], 0),
                                deform_snorm(w[6], 1)};
    }
    *out = (reference_pose){positions, normals, tangents};
    return true;
}

kd_status reference_pose_make(kd_arena *arena, const kd_primitive_desc *desc, const kd_vec4 (*rows)[3],
                              uint32_t row_count, const kd_morph_weights *weights, reference_pose *out)
{
    uint32_t n = desc->vertex_count;
    deform_streams streams = {0};
    struct kd_deform_item item = {.range = {.y = n, .z = n}};
    streams.geometry = KD_ARENA_NEW(arena, uint32_t, 2 * (size_t)n * KD_GEOMETRY_WORDS);
    bool ok = streams.geometry && pack_morphs(arena, desc, weights, &streams, &item) &&
              pack_skin(arena, desc, rows, row_count, &streams, &item);
    if (ok) {
        scene_pack_geometry(desc, streams.geometry);
        deform_reference(&streams, &item);
        ok = unpack(arena, streams.geometry + (size_t)n * KD_GEOMETRY_WORDS, n, out);
    }
    return ok ? KD_OK
              : kd_fail(KD_NO_MEMORY,
                        "reference: out of memory for a pose of %u vertices; use a smaller scene", n);
}
