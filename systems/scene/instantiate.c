/* Entities from a registered model: one for each node, below one new root. */

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "components/animation.h"
#include "components/camera.h"
#include "components/light.h"
#include "components/transform.h"
#include "runtime/core/log.h"
#include "systems/scene/internal.h"
#include "systems/scene/scene.h"

#define MAX_NODE_VALUES 8
#define INFINITE_FAR_M  1000 /* glTF allows cameras without a far plane; the picture's depth wants one */

/* What instantiating one model carries along. */
typedef struct builder {
    kd_world *world;
    kd_scene_store *store;
    scene_internal *in;
    const kd_store_model *entry;
    const kd_model *model;
    uint32_t first_node;   /* store node entities */
    uint32_t *first_joint; /* store joint entities, of each skin of the model */
} builder;

uint32_t scene_add_deformed(kd_scene_store *s, uint32_t mesh_number, bool with_skin)
{
    scene_internal *in = s->internal;
    const kd_store_mesh *mesh = &s->meshes[mesh_number];
    uint32_t number = scene_take(&in->deformed, &s->deformed_count, 1);
    uint32_t first =
        scene_take(&in->deformed_primitives, &s->deformed_primitive_count, mesh->primitive_count);
    bool again = number < in->uploaded_deformed;
    s->deformed[number] =
        (kd_store_deformed){.mesh = mesh_number, .first_primitive = first, .waiting = again};
    in->waiting_deformed += again;
    for (uint32_t i = 0; i < mesh->primitive_count; i++) {
        kd_store_primitive p = s->primitives[mesh->first_primitive + i];
        if (scene_primitive_deforms(&p, with_skin))
            p.base_vertex = scene_take(&in->vertices, &s->vertex_count, scene_primitive_vertices(&p));
        s->deformed_primitives[first + i] = p;
    }
    return number + 1; /* as the component wants it */
}

static kd_morph_weights default_weights(const kd_node_desc *node, const kd_store_mesh *mesh)
{
    kd_morph_weights out = {.count = mesh->morph_count};
    const float *from = node->morph_weights ? node->morph_weights : mesh->desc->morph_weights;
    uint32_t given = node->morph_weights ? node->morph_count : mesh->desc->morph_count;
    for (uint32_t i = 0; from && i < out.count && i < given; i++)
        out.weights[i] = from[i];
    return out;
}

static kd_light light_of(const kd_model_light *desc)
{
    return (kd_light){.type = (uint32_t)desc->type,
                      .color = desc->color,
                      .intensity = desc->intensity,
                      .range = desc->range,
                      .inner_cone = desc->inner_cone,
                      .outer_cone = desc->outer_cone};
}
_Static_assert((int)KD_DIRECTIONAL == (int)KD_LIGHT_DIRECTIONAL && (int)KD_POINT == (int)KD_LIGHT_POINT &&
                   (int)KD_SPOT == (int)KD_LIGHT_SPOT,
               "light kinds of files and components are numbered alike");

static kd_camera camera_of(const kd_model_camera *desc)
{
    return (kd_camera){.orthographic = desc->orthographic,
                       .fov_y = desc->fov_y,
                       .y_mag = desc->y_mag,
                       .z_near = desc->z_near,
                       .z_far = desc->z_far > desc->z_near ? desc->z_far : desc->z_near + INFINITE_FAR_M};
}

/* The values of one node, kept together while the entity is made. */
typedef struct node_parts {
    kd_transform transform;
    kd_local_matrix matrix;
    kd_mesh_instance mesh;
    kd_skin_instance skin;
    kd_morph_weights weights;
    kd_light light;
    kd_camera camera;
    kd_value values[MAX_NODE_VALUES];
    uint32_t count;
} node_parts;

static void add_value(node_parts *parts, const kd_component_desc *desc, const void *value)
{
    parts->values[parts->count++] = (kd_value){desc, value};
}

static void mesh_parts(builder *b, const kd_node_desc *node, node_parts *parts)
{
    uint32_t number = b->entry->first_mesh + node->mesh;
    const kd_store_mesh *mesh = &b->store->meshes[number];
    bool with_skin = mesh->skinned && node->skin != KD_NONE;
    bool deforms = with_skin || mesh->morph_count;
    parts->mesh = (kd_mesh_instance){
        .mesh = number, .deformed = deforms ? scene_add_deformed(b->store, number, with_skin) : 0};
    add_value(parts, &kd_mesh_instance_desc, &parts->mesh);
    if (with_skin) {
        parts->skin = (kd_skin_instance){.skin = b->entry->first_skin + node->skin,
                                         .first_joint = b->first_joint[node->skin]};
        add_value(parts, &kd_skin_instance_desc, &parts->skin);
    }
    if (mesh->morph_count) {
        parts->weights = default_weights(node, mesh);
        add_value(parts, &kd_morph_weights_desc, &parts->weights);
    }
}

static kd_entity spawn_node(builder *b, const kd_node_desc *node)
{
    node_parts parts = {.count = 0};
    if (node->has_matrix) {
        parts.matrix = (kd_local_matrix){node->matrix};
        add_value(&parts, &kd_local_matrix_desc, &parts.matrix);
    } else {
        parts.transform = (kd_transform){node->translation, node->rotation, node->scale};
        add_value(&parts, &kd_transform_desc, &parts.transform);
    }
    add_value(&parts, &kd_world_transform_desc, NULL);
    if (node->mesh != KD_NONE)
        mesh_parts(b, node, &parts);
    if (node->light != KD_NONE) {
        parts.light = light_of(&b->model->lights[node->light]);
        add_value(&parts, &kd_light_desc, &parts.light);
    }
    if (node->camera != KD_NONE) {
        parts.camera = camera_of(&b->model->cameras[node->camera]);
        add_value(&parts, &kd_camera_desc, &parts.camera);
    }
    kd_entity e = kd_spawn_values(b->world, parts.values, parts.count);
    if (parts.mesh.deformed)
        b->store->deformed[parts.mesh.deformed - 1].entity = e;
    return e;
}

static kd_status build_nodes(builder *b, kd_entity root)
{
    for (uint32_t i = 0; i < b->model->node_count; i++) {
        const kd_node_desc *node = &b->model->nodes[i];
        kd_entity e = spawn_node(b, node);
        b->store->node_entities[b->first_node + i] = e;
        kd_entity parent =
            node->parent == KD_NONE ? root : b->store->node_entities[b->first_node + node->parent];
        if (!e.generation || kd_set_parent(b->world, e, parent) != KD_OK ||
            kd_set_name(b->world, e, node->name) != KD_OK)
            return KD_NO_MEMORY;
    }
    for (uint32_t i = 0; i < b->model->skin_count; i++)
        for (uint32_t j = 0; j < b->model->skins[i].joint_count; j++)
            b->store->joint_entities[b->first_joint[i] + j] =
                b->store->node_entities[b->first_node + b->model->skins[i].joints[j]];
    return KD_OK;
}

/* Room for everything the nodes will add, so that nothing fails half-way but the world itself. */
static kd_status reserve_instance(builder *b)
{
    kd_scene_store *s = b->store;
    uint64_t joints = s->joint_entity_count, deformed = s->deformed_count, vertices = s->vertex_count;
    uint64_t deformed_primitives = s->deformed_primitive_count;
    for (uint32_t i = 0; i < b->model->skin_count; i++)
        joints += b->model->skins[i].joint_count;
    for (uint32_t i = 0; i < b->model->node_count; i++) {
        if (b->model->nodes[i].mesh == KD_NONE)
            continue;
        const kd_store_mesh *mesh = &s->meshes[b->entry->first_mesh + b->model->nodes[i].mesh];
        if (!mesh->morph_count && !mesh->skinned)
            continue;
        deformed++;
        deformed_primitives += mesh->primitive_count;
        for (uint32_t p = 0; p < mesh->primitive_count; p++)
            vertices += scene_primitive_vertices(&s->primitives[mesh->first_primitive + p]);
    }
    if (vertices >= INT32_MAX)
        return KD_TOO_LARGE;
    bool room =
        SCENE_RESERVE(s->joint_entities, b->in->joint_capacity, joints) &&
        SCENE_RESERVE(s->node_entities, b->in->node_capacity,
                      (uint64_t)s->node_entity_count + b->model->node_count) &&
        SCENE_RESERVE(b->in->instances, b->in->instance_capacity, b->in->instance_count + 1ull) &&
        SCENE_RESERVE(s->deformed, b->in->deformed_capacity, deformed) &&
        SCENE_RESERVE(s->deformed_primitives, b->in->deformed_primitive_capacity, deformed_primitives);
    return room ? KD_OK : KD_NO_MEMORY;
}

static kd_entity spawn_root(builder *b, uint32_t model)
{
    const kd_animation animation = {.clip = b->entry->first_clip + 1,
                                    .speed = 1,
                                    .loop = true,
                                    .model = model + 1,
                                    .first_node = b->first_node};
    const kd_value values[] = {
        {&kd_transform_desc, NULL}, {&kd_world_transform_desc, NULL}, {&kd_animation_desc, &animation}};
    return kd_spawn_values(b->world, values, b->model->clip_count ? 3 : 2);
}

/* Places for the entities of nodes and joints; the joints of all skins stand one skin after the other. */
static bool place_entities(builder *b)
{
    kd_scene_store *s = b->store;
    uint32_t joints = 0;
    b->first_joint = malloc((b->model->skin_count + (size_t)1) * sizeof *b->first_joint);
    if (!b->first_joint)
        return false;
    for (uint32_t i = 0; i < b->model->skin_count; i++) {
        b->first_joint[i] = joints;
        joints += b->model->skins[i].joint_count;
    }
    uint32_t first = scene_take(&b->in->joints, &s->joint_entity_count, joints);
    for (uint32_t i = 0; i < b->model->skin_count; i++)
        b->first_joint[i] += first;
    b->first_node = scene_take(&b->in->nodes, &s->node_entity_count, b->model->node_count);
    if (joints) /* a store without skins has no list */
        memset(s->joint_entities + first, 0, joints * sizeof *s->joint_entities);
    if (b->model->node_count)
        memset(s->node_entities + b->first_node, 0, b->model->node_count * sizeof *s->node_entities);
    b->in->instances[b->in->instance_count++] =
        (scene_instance){{b->first_node, b->model->node_count}, {first, joints}};
    return true;
}

static kd_status build(builder *b, uint32_t model, kd_entity parent, const char *name, kd_entity *top)
{
    kd_status status = reserve_instance(b);
    if (status == KD_OK && !place_entities(b))
        status = KD_NO_MEMORY;
    if (status != KD_OK)
        return status;
    *top = spawn_root(b, model);
    status = top->generation ? kd_set_name(b->world, *top, name) : KD_NO_MEMORY;
    if (status == KD_OK && parent.generation)
        status = kd_set_parent(b->world, *top, parent);
    return status == KD_OK ? build_nodes(b, *top) : status;
}

kd_status kd_scene_instantiate(kd_world *w, uint32_t model, kd_entity parent, const char *name,
                               kd_entity *root)
{
    kd_scene_store *s = scene_store_get(w);
    *root = KD_NO_ENTITY;
    if (!s || model >= s->model_count)
        return kd_fail(s ? KD_OUT_OF_RANGE : KD_NO_MEMORY, "no model %u is registered with the scene", model);
    builder b = {.world = w, .store = s, .in = s->internal, .entry = &s->models[model]};
    b.model = b.entry->model;
    kd_status status = build(&b, model, parent, name, root);
    free(b.first_joint);
    if (status == KD_OK)
        return KD_OK;
    kd_destroy(w, *root);
    *root = KD_NO_ENTITY;
    return kd_fail(status, "%s: the instance could not be made: %s", b.model->path ? b.model->path : "model",
                   kd_status_text(status));
}

kd_entity scene_next_below(const kd_world *w, kd_entity root, kd_entity e)
{
    kd_entity next = kd_first_child(w, e);
    while (!next.generation && !kd_entity_equal(e, root)) {
        next = kd_next_sibling(w, e);
        e = kd_get_parent(w, e);
    }
    return next;
}

void kd_scene_override_material(kd_world *w, kd_entity root, uint32_t material)
{
    for (kd_entity e = root; e.generation; e = scene_next_below(w, root, e)) {
        kd_mesh_instance *instance = kd_find_mut(w, e, kd_mesh_instance);
        if (instance)
            instance->material = material + 1;
    }
}

static kd_status unknown_clip(const kd_model *model, const char *clip)
{
    char list[768] = "";
    size_t used = 0;
    for (uint32_t i = 0; i < model->clip_count && used + 8 < sizeof list; i++) {
        int n = snprintf(list + used, sizeof list - used, "%s'%s'", i ? ", " : "", model->clips[i].name);
        used += n > 0 ? (size_t)n : 0;
    }
    if (used >= sizeof list)
        memcpy(list + sizeof list - 4, "...", 4);
    return kd_fail(KD_NOT_FOUND, "%s: no clip '%s' (animation); it has %s",
                   model->path ? model->path : "model", clip, list);
}

static kd_status no_clips(kd_world *w, kd_entity root, const char *clip)
{
    char number[32];
    const char *name = kd_get_name(w, root);
    snprintf(number, sizeof number, "entity %u", root.index);
    return kd_fail(KD_NOT_FOUND, "%s: no clip '%s' (animation); it has no clips",
                   name && *name ? name : number, clip);
}

kd_status kd_scene_find_clip(kd_world *w, kd_entity root, const char *clip, uint32_t *number, float *length_s)
{
    const kd_scene_store *s = scene_store_get(w);
    const kd_animation *a = kd_find(w, root, kd_animation);
    if (!s || !a || !a->model || a->model > s->model_count)
        return no_clips(w, root, clip ? clip : "");
    const kd_store_model *entry = &s->models[a->model - 1];
    uint32_t found = 0;
    while (clip && *clip && found < entry->model->clip_count &&
           strcmp(entry->model->clips[found].name, clip) != 0)
        found++;
    if (found == entry->model->clip_count)
        return unknown_clip(entry->model, clip);
    *number = entry->first_clip + found + 1;
    *length_s = entry->model->clips[found].duration;
    return KD_OK;
}

kd_status kd_scene_play(kd_world *w, kd_entity root, const char *clip, bool loop, float speed, float blend_s)
{
    uint32_t number;
    float length_s;
    kd_status status = kd_scene_find_clip(w, root, clip, &number, &length_s);
    if (status != KD_OK)
        return status;
    kd_animation *a = kd_find_mut(w, root, kd_animation);
    a->previous_clip = a->clip;
    a->previous_time_s = a->time_s;
    a->previous_speed = a->paused ? 0 : a->speed;
    a->previous_loop = a->loop;
    a->blend_s = a->blend_left_s = blend_s > 0 ? blend_s : 0;
    a->clip = number;
    a->time_s = speed < 0 ? length_s : 0;
    a->speed = speed;
    a->loop = loop;
    a->paused = false;
    return KD_OK;
}
