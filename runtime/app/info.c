#include "runtime/app/info.h"

#include <stdio.h>

#include "runtime/asset/model.h"
#include "runtime/app/voxelize.h"
#include "runtime/core/file.h"
#include "runtime/core/log.h"

#define MAX_NODES_SHOWN 200

static void print_meshes(const kd_model *m)
{
    for (uint32_t i = 0; i < m->mesh_count; i++) {
        const kd_mesh_desc *mesh = &m->meshes[i];
        uint64_t triangles = 0, vertices = 0;
        bool skinned = false;
        for (uint32_t p = 0; p < mesh->primitive_count; p++) {
            triangles += mesh->primitives[p].index_count / 3;
            vertices += mesh->primitives[p].vertex_count;
            skinned = skinned || mesh->primitives[p].joints;
        }
        printf("  mesh %u '%s': %u primitives, %llu triangles, %llu vertices%s", i,
               mesh->name ? mesh->name : "", mesh->primitive_count, (unsigned long long)triangles,
               (unsigned long long)vertices, skinned ? ", skinned" : "");
        if (mesh->morph_count)
            printf(", %u morph targets", mesh->morph_count);
        printf("\n");
    }
}

static void print_lobes(const kd_material_desc *d)
{
    const kd_vec3 *c = &d->specular_color;
    if (d->unlit)
        printf(", unlit");
    if (d->ior != 1.5f)
        printf(", ior %.3g", (double)d->ior);
    if (d->specular != 1 || c->x != 1 || c->y != 1 || c->z != 1)
        printf(", specular %.3g (%.3g %.3g %.3g)", (double)d->specular, (double)c->x, (double)c->y,
               (double)c->z);
    if (d->clearcoat > 0)
        printf(", clear coat %.3g of roughness %.3g", (double)d->clearcoat, (double)d->clearcoat_roughness);
    if (d->transmission > 0)
        printf(", transmission %.3g", (double)d->transmission);
}

static void print_materials(const kd_model *m)
{
    static const char *const alpha[] = {"", ", mask", ", blend"};
    for (uint32_t i = 0; i < m->material_count; i++) {
        const kd_material_desc *d = &m->materials[i];
        printf("  material %u '%s': base colour %.3g %.3g %.3g, metallic %.3g, roughness %.3g%s%s", i,
               d->name ? d->name : "", (double)d->base_color.x, (double)d->base_color.y,
               (double)d->base_color.z, (double)d->metallic, (double)d->roughness, alpha[d->alpha_mode],
               d->double_sided ? ", double sided" : "");
        if (kd_vec3_length(d->emissive) > 0)
            printf(", emissive %.3g %.3g %.3g", (double)d->emissive.x, (double)d->emissive.y,
                   (double)d->emissive.z);
        print_lobes(d);
        printf("\n");
    }
}

static void print_clips(const kd_model *m)
{
    for (uint32_t i = 0; i < m->skin_count; i++)
        printf("  skin %u '%s': %u joints\n", i, m->skins[i].name ? m->skins[i].name : "",
               m->skins[i].joint_count);
    for (uint32_t i = 0; i < m->clip_count; i++)
        printf("  clip %u '%s': %.3f s, %u channels\n", i, m->clips[i].name ? m->clips[i].name : "",
               (double)m->clips[i].duration, m->clips[i].channel_count + m->clips[i].property_count);
}

static void print_lights_and_cameras(const kd_model *m)
{
    static const char *const kinds[] = {"directional", "point", "spot"};
    for (uint32_t i = 0; i < m->light_count; i++)
        printf("  light %u '%s': %s, intensity %g\n", i, m->lights[i].name ? m->lights[i].name : "",
               kinds[m->lights[i].type], (double)m->lights[i].intensity);
    for (uint32_t i = 0; i < m->camera_count; i++)
        printf("  camera %u '%s': %s\n", i, m->cameras[i].name ? m->cameras[i].name : "",
               m->cameras[i].orthographic ? "orthographic" : "perspective");
}

static uint32_t depth_of(const kd_model *m, uint32_t node)
{
    uint32_t depth = 0;
    while (m->nodes[node].parent != KD_NONE && depth < 40) {
        node = m->nodes[node].parent;
        depth++;
    }
    return depth;
}

static void print_nodes(const kd_model *m)
{
    for (uint32_t i = 0; i < m->node_count && i < MAX_NODES_SHOWN; i++) {
        const kd_node_desc *n = &m->nodes[i];
        printf("  %*snode '%s'", (int)depth_of(m, i) * 2, "", n->name);
        if (n->mesh != KD_NONE)
            printf(" mesh %u", n->mesh);
        if (n->skin != KD_NONE)
            printf(" skin %u", n->skin);
        if (n->light != KD_NONE)
            printf(" light %u", n->light);
        if (n->camera != KD_NONE)
            printf(" camera %u", n->camera);
        printf("\n");
    }
    if (m->node_count > MAX_NODES_SHOWN)
        printf("  … and %u nodes more\n", m->node_count - MAX_NODES_SHOWN);
}

static void print_bounds(const kd_model *m)
{
    if (m->triangle_count)
        printf("  bounds %.4g %.4g %.4g to %.4g %.4g %.4g m\n", (double)m->bounds_min.x,
               (double)m->bounds_min.y, (double)m->bounds_min.z, (double)m->bounds_max.x,
               (double)m->bounds_max.y, (double)m->bounds_max.z);
    else
        printf("  nothing of it can be drawn: its scene holds no triangles\n");
}

static void print_model(const kd_model *m)
{
    printf("%s\n  made by %s\n", m->path,
           m->generator && *m->generator ? m->generator : "an unnamed program");
    printf("  %u nodes, %u meshes, %llu triangles, %u materials, %u images, %u skins, %u clips, %u lights, "
           "%u cameras\n",
           m->node_count, m->mesh_count, (unsigned long long)m->triangle_count, m->material_count,
           m->image_count, m->skin_count, m->clip_count, m->light_count, m->camera_count);
    print_bounds(m);
    for (const char *const *e = m->extensions_used; e && *e; e++)
        printf("  extension %s%s\n", *e, kd_model_reads_extension(*e) ? "" : ", not read");
    for (uint32_t i = 0; m->scenes[i]; i++)
        printf("  scene %u '%s'%s\n", i, m->scenes[i], i == m->scene ? ", the one shown here" : "");
    for (uint32_t i = 0; m->variants[i]; i++)
        printf("  variant %u '%s'\n", i, m->variants[i]);
    for (uint32_t i = 0; i < m->image_count; i++)
        printf("  image %u '%s': %ux%u\n", i, m->images[i].name ? m->images[i].name : "", m->images[i].width,
               m->images[i].height);
    print_meshes(m);
    print_materials(m);
    print_clips(m);
    print_lights_and_cameras(m);
    print_nodes(m);
    for (uint32_t i = 0; i < m->warning_count; i++)
        printf("  warning: %s\n", m->warnings[i]);
}

kd_status app_info_print(const char *path)
{
    kd_model *model;
    if (kd_path_has_extension(path, ".kvox"))
        return app_voxel_info(path);
    if (!kd_path_has_extension(path, ".gltf") && !kd_path_has_extension(path, ".glb"))
        return kd_fail(KD_USAGE, "%s: unknown kind of file; give a .gltf or .glb model or a .kvox file",
                       path);
    kd_status status = kd_model_load_with(path, &(kd_model_options){.without_triangles = true}, &model);
    if (status != KD_OK)
        return status;
    print_model(model);
    kd_model_destroy(model);
    return KD_OK;
}
