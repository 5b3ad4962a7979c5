#ifndef KD_TESTS_DEFORM_FIXTURE_H
#define KD_TESTS_DEFORM_FIXTURE_H

/* The scene's streams packed on the CPU and deformed by the reference: what the GPU must hold, and what
 * bounds must hold. */

#include "systems/deform/deform_reference.h"
#include "systems/deform/internal.h"
#include "systems/scene/internal.h"
#include "tests/systems_fixture.h"

typedef struct deform_picture {
    uint32_t *geometry, *skins, *morphs, *words;
} deform_picture;

static inline void deform_picture_free(deform_picture *p)
{
    free(p->geometry);
    free(p->skins);
    free(p->morphs);
    free(p->words);
}

static inline void deform_pack_mesh(const kd_scene_store *s, const kd_store_mesh *mesh, deform_picture *out)
{
    for (uint32_t i = 0; i < mesh->primitive_count; i++) {
        const kd_store_primitive *p = &s->primitives[mesh->first_primitive + i];
        const kd_primitive_desc *desc = &mesh->desc->primitives[i];
        scene_pack_geometry(desc, out->geometry + (size_t)p->base_vertex * KD_GEOMETRY_WORDS);
        if (p->first_skin_vertex != KD_NONE)
            scene_pack_skin(desc, out->skins + (size_t)p->first_skin_vertex * KD_SKIN_WORDS);
        for (uint32_t t = 0; t < mesh->morph_count; t++)
            scene_pack_morph(desc, t,
                             out->morphs +
                                 (size_t)(p->first_morph_vertex + t * p->vertex_count) * KD_MORPH_WORDS);
    }
}

/* Deform everything as this frame's work list says. */
static inline deform_picture deform_by_reference(kd_world *w)
{
    const kd_scene_store *s = kd_singleton(w, kd_scene_store);
    const kd_joint_palette *palette = kd_singleton(w, kd_joint_palette);
    const deform_work *work = palette->internal;
    deform_picture out = {
        .geometry = calloc((size_t)s->vertex_count + 1, KD_GEOMETRY_WORDS * 4),
        .skins = calloc((size_t)s->skin_vertex_count + 1, KD_SKIN_WORDS * 4),
        .morphs = calloc((size_t)s->morph_vertex_count + 1, KD_MORPH_WORDS * 4),
        .words = calloc((size_t)work->groups.count + work->weights.count + 1, 8),
    };
    assert_true(out.geometry && out.skins && out.morphs && out.words);
    for (uint32_t i = 0; i < s->mesh_count; i++)
        deform_pack_mesh(s, &s->meshes[i], &out);
    if (work->groups.count)
        memcpy(out.words, work->groups.items, work->groups.count * 8u);
    if (work->weights.count)
        memcpy(out.words + 2 * (size_t)work->groups.count, work->weights.items, work->weights.count * 8u);
    const deform_streams streams = {out.geometry, out.skins, out.morphs, palette->rows, out.words};
    const struct kd_deform_item *items = work->items.items;
    for (uint32_t i = 0; i < work->items.count; i++)
        deform_reference(&streams, &items[i]);
    return out;
}

static inline kd_vec3 deform_position(const deform_picture *p, uint32_t vertex)
{
    kd_vec3 out;
    memcpy(&out, p->geometry + (size_t)vertex * KD_GEOMETRY_WORDS, sizeof out);
    return out;
}

#endif
