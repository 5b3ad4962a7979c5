/* The scene store: arrays numbered by those who refer to them. What models bring is added at their ends and
 * stays. Ranges of the GPU streams are reserved here, at registration; system scene_upload fills them. Room
 * is made before anything is written, so that a failed registration leaves the store as it was. */

#include <stdlib.h>
#include <string.h>

#include "runtime/core/log.h"
#include "systems/scene/internal.h"
#include "systems/scene/scene.h"

bool scene_reserve(void **items, uint32_t *capacity, uint64_t needed, size_t size)
{
    if (needed <= *capacity)
        return true;
    uint64_t grown = (uint64_t)*capacity + *capacity / 2 + 16;
    uint64_t target = needed > grown ? needed : grown;
    if (target > UINT32_MAX / 2)
        return false;
    void *bigger = realloc(*items, (size_t)target * size);
    if (!bigger)
        return false;
    *items = bigger;
    *capacity = (uint32_t)target;
    return true;
}

static void release(kd_scene_store *store)
{
    scene_internal *in = store->internal;
    for (uint32_t i = 0; i < store->model_count; i++)
        kd_model_destroy((kd_model *)(uintptr_t)store->models[i].model);
    void *const arrays[] = {store->models,
                            store->meshes,
                            store->primitives,
                            store->materials,
                            store->skins,
                            store->clips,
                            store->deformed,
                            store->deformed_primitives,
                            store->joint_entities,
                            store->node_entities,
                            (void *)in->images,
                            in->reach,
                            in->boxes,
                            in->textures,
                            in->instances,
                            in};
    kd_ranges *const ranges[] = {&in->vertices, &in->joints, &in->nodes, &in->deformed,
                                 &in->deformed_primitives};
    for (size_t i = 0; i < sizeof ranges / sizeof *ranges; i++)
        kd_ranges_fini(ranges[i]);
    for (size_t i = 0; i < sizeof arrays / sizeof *arrays; i++)
        free(arrays[i]);
    *store = (kd_scene_store){0};
}

kd_scene_store *scene_store_get(kd_world *w)
{
    kd_scene_store *store = kd_singleton(w, kd_scene_store);
    if (store && !store->internal) {
        scene_internal *in = calloc(1, sizeof *in);
        if (!in || !SCENE_RESERVE(store->materials, in->material_capacity, 1)) {
            free(in);
            return NULL;
        }
        store->materials[0] = (kd_store_material){.desc = kd_material_default()};
        store->material_count = 1;
        store->internal = in;
        store->release = release;
    }
    return store;
}

static uint32_t store_morph_count(const kd_mesh_desc *mesh)
{
    return mesh->morph_count < KD_MAX_MORPH_TARGETS ? mesh->morph_count : KD_MAX_MORPH_TARGETS;
}

static uint32_t cage_count(const kd_primitive_desc *desc)
{
    return desc->subdivision ? desc->subdivision->cage->vertex_count : 0;
}

/* Sizes of all streams together with those of the model, to be refused before a 32-bit count wraps. */
static bool streams_fit(const kd_scene_store *store, const kd_model *model, uint64_t *primitives)
{
    uint64_t vertices = store->vertex_count, indices = store->index_count, morphs = store->morph_vertex_count;
    uint64_t stencils = store->stencil_count;
    *primitives = 0;
    for (uint32_t m = 0; m < model->mesh_count; m++) {
        const kd_mesh_desc *mesh = &model->meshes[m];
        for (uint32_t i = 0; i < mesh->primitive_count; i++, ++*primitives) {
            const kd_primitive_desc *desc = &mesh->primitives[i];
            uint64_t own = (uint64_t)desc->vertex_count + cage_count(desc);
            vertices += own;
            indices += desc->index_count;
            morphs += own * store_morph_count(mesh);
            stencils += desc->subdivision ? desc->subdivision->stencil_count : 0;
        }
    }
    return vertices < INT32_MAX && indices < INT32_MAX && morphs < INT32_MAX && stencils < INT32_MAX;
}

static bool reserve_model(kd_scene_store *s, scene_internal *in, const kd_model *model, uint64_t primitives)
{
    return SCENE_RESERVE(s->models, in->model_capacity, s->model_count + 1ull) &&
           SCENE_RESERVE(s->meshes, in->mesh_capacity, (uint64_t)s->mesh_count + model->mesh_count) &&
           SCENE_RESERVE(s->primitives, in->primitive_capacity, s->primitive_count + primitives) &&
           SCENE_RESERVE(in->reach, in->reach_capacity, s->primitive_count + primitives) &&
           SCENE_RESERVE(s->materials, in->material_capacity,
                         (uint64_t)s->material_count + model->material_count) &&
           SCENE_RESERVE(s->skins, in->skin_capacity, (uint64_t)s->skin_count + model->skin_count) &&
           SCENE_RESERVE(s->clips, in->clip_capacity, (uint64_t)s->clip_count + model->clip_count) &&
           SCENE_RESERVE(in->images, in->image_capacity, (uint64_t)in->image_count + model->image_count);
}

static void rebase_image(kd_texture_ref *map, uint32_t first_image, uint32_t image_count)
{
    map->image = map->image < image_count ? map->image + first_image : KD_NONE;
}

static void rebase_images(kd_material_desc *desc, uint32_t first, uint32_t count)
{
    rebase_image(&desc->base_color_map, first, count);
    rebase_image(&desc->metallic_roughness_map, first, count);
    rebase_image(&desc->normal_map, first, count);
    rebase_image(&desc->emissive_map, first, count);
    rebase_image(&desc->occlusion_map, first, count);
}

static kd_status add_primitive(kd_scene_store *s, const kd_primitive_desc *desc, uint32_t first_material,
                               uint32_t morph_count)
{
    scene_internal *in = s->internal;
    kd_store_primitive *p = &s->primitives[s->primitive_count];
    const kd_subdivision *subdivision = desc->subdivision;
    const uint32_t own = desc->vertex_count + cage_count(desc);
    /* A limit point is a mean of cage vertices, so that their reach bounds it. */
    kd_status status = scene_reach_add(in, subdivision ? subdivision->cage : desc, morph_count,
                                       &in->reach[s->primitive_count]);
    if (status != KD_OK)
        return status;
    bool skinned = desc->joints && desc->weights && in->reach[s->primitive_count].joint_box_count;
    *p = (kd_store_primitive){
        .first_index = s->index_count,
        .index_count = desc->index_count,
        .base_vertex = s->vertex_count,
        .vertex_count = desc->vertex_count,
        .material = desc->material == KD_NONE ? 0 : first_material + desc->material,
        .first_skin_vertex = skinned ? s->skin_vertex_count : KD_NONE,
        .first_morph_vertex = morph_count ? s->morph_vertex_count : KD_NONE,
        .bounds_min = desc->bounds_min,
        .bounds_max = desc->bounds_max,
        .cage_count = own - desc->vertex_count,
        .first_row = s->stencil_row_count,
        .first_stencil = s->stencil_count,
    };
    s->primitive_count++;
    s->vertex_count += own;
    s->stencil_row_count += subdivision ? desc->vertex_count : 0;
    s->stencil_count += subdivision ? subdivision->stencil_count : 0;
    s->index_count += desc->index_count;
    s->triangle_count += desc->index_count / 3;
    s->skin_vertex_count += skinned ? own : 0;
    s->morph_vertex_count += own * morph_count;
    return KD_OK;
}

static kd_status add_mesh(kd_scene_store *s, const kd_mesh_desc *desc, uint32_t first_material)
{
    kd_store_mesh *mesh = &s->meshes[s->mesh_count];
    scene_box bounds = SCENE_BOX_EMPTY;
    *mesh = (kd_store_mesh){.name = desc->name,
                            .first_primitive = s->primitive_count,
                            .primitive_count = desc->primitive_count,
                            .morph_count = store_morph_count(desc),
                            .desc = desc};
    if (mesh->morph_count < desc->morph_count)
        kd_log(KD_LOG_WARNING, "mesh '%s': %u morph targets, the first %u are used",
               desc->name ? desc->name : "", desc->morph_count, mesh->morph_count);
    for (uint32_t i = 0; i < desc->primitive_count; i++) {
        kd_status status = add_primitive(s, &desc->primitives[i], first_material, mesh->morph_count);
        if (status != KD_OK)
            return status;
        const kd_store_primitive *p = &s->primitives[s->primitive_count - 1];
        mesh->skinned |= p->first_skin_vertex != KD_NONE;
        scene_box_join(&bounds, &(scene_box){p->bounds_min, p->bounds_max});
    }
    mesh->bounds_min = desc->primitive_count ? bounds.min : (kd_vec3){0, 0, 0};
    mesh->bounds_max = desc->primitive_count ? bounds.max : (kd_vec3){0, 0, 0};
    s->mesh_count++;
    return KD_OK;
}

static kd_status add_meshes(kd_scene_store *s, const kd_model *model, uint32_t first_material)
{
    scene_internal *in = s->internal;
    const kd_scene_store before = *s;
    uint32_t boxes = in->box_count;
    for (uint32_t i = 0; i < model->mesh_count; i++) {
        kd_status status = add_mesh(s, &model->meshes[i], first_material);
        if (status == KD_OK)
            continue;
        kd_scene_store *kept = s; /* the arrays themselves have not moved: only counts go back */
        kept->mesh_count = before.mesh_count, kept->primitive_count = before.primitive_count;
        kept->vertex_count = before.vertex_count, kept->index_count = before.index_count;
        kept->skin_vertex_count = before.skin_vertex_count,
        kept->morph_vertex_count = before.morph_vertex_count;
        kept->triangle_count = before.triangle_count;
        kept->stencil_row_count = before.stencil_row_count, kept->stencil_count = before.stencil_count;
        in->box_count = boxes;
        return status;
    }
    return KD_OK;
}

static void add_parts(kd_scene_store *s, const kd_model *model)
{
    scene_internal *in = s->internal;
    for (uint32_t i = 0; i < model->material_count; i++) {
        kd_store_material *material = &s->materials[s->material_count++];
        *material = (kd_store_material){.desc = model->materials[i]};
        rebase_images(&material->desc, in->image_count, model->image_count);
    }
    for (uint32_t i = 0; i < model->image_count; i++)
        in->images[in->image_count++] = &model->images[i];
    for (uint32_t i = 0; i < model->skin_count; i++)
        s->skins[s->skin_count++] =
            (kd_store_skin){model->skins[i].joint_count, model->skins[i].inverse_bind};
    for (uint32_t i = 0; i < model->clip_count; i++)
        s->clips[s->clip_count++] = (kd_store_clip){&model->clips[i], s->model_count};
}

kd_status kd_scene_add_model(kd_world *w, kd_model *model, uint32_t *out)
{
    kd_scene_store *s = scene_store_get(w);
    if (!s)
        return kd_fail(KD_NO_MEMORY, "%s: out of memory", model->path ? model->path : "model");
    scene_internal *in = s->internal;
    uint64_t primitives;
    if (!streams_fit(s, model, &primitives))
        return kd_fail(KD_TOO_LARGE, "%s: more vertices than 32-bit numbers address; split the scene",
                       model->path ? model->path : "model");
    uint32_t first_mesh = s->mesh_count;
    if (!reserve_model(s, in, model, primitives) || add_meshes(s, model, s->material_count) != KD_OK)
        return kd_fail(KD_NO_MEMORY, "%s: out of memory", model->path ? model->path : "model");
    s->models[s->model_count] = (kd_store_model){.model = model,
                                                 .first_mesh = first_mesh,
                                                 .first_material = s->material_count,
                                                 .first_skin = s->skin_count,
                                                 .first_clip = s->clip_count,
                                                 .first_image = in->image_count};
    add_parts(s, model);
    *out = s->model_count++;
    s->revision++;
    return KD_OK;
}

uint32_t kd_scene_add_material(kd_world *w, const kd_material_desc *desc)
{
    kd_scene_store *s = scene_store_get(w);
    scene_internal *in = s ? s->internal : NULL;
    if (!s || !SCENE_RESERVE(s->materials, in->material_capacity, s->material_count + 1ull)) {
        kd_log(KD_LOG_ERROR, "out of memory for a material; the default one is used");
        return 0;
    }
    kd_store_material *material = &s->materials[s->material_count];
    *material = (kd_store_material){.desc = *desc};
    material->desc.name = NULL; /* borrowed for the call */
    rebase_images(&material->desc, 0, in->image_count);
    s->revision++;
    return s->material_count++;
}

void kd_scene_restore_materials(kd_world *w)
{
    kd_scene_store *s = scene_store_get(w);
    for (uint32_t m = 0; s && m < s->model_count; m++) {
        const kd_store_model *known = &s->models[m];
        for (uint32_t i = 0; i < known->model->material_count; i++) {
            kd_material_desc *desc = &s->materials[known->first_material + i].desc;
            *desc = known->model->materials[i];
            rebase_images(desc, known->first_image, known->model->image_count);
        }
    }
}

const kd_image *kd_scene_image(const kd_scene_store *store, uint32_t number)
{
    const scene_internal *in = store->internal;
    return in && number < in->image_count ? in->images[number] : NULL;
}
