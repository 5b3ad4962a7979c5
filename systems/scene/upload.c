/* System scene_upload: takes what the store has gained since the last frame to the GPU. Runs after the script
 * phase's systems, so that what a script has spawned is drawn in the same frame; does not run at all when
 * nothing is new. */

#include <stdlib.h>
#include <string.h>

#include "components/animation.h"
#include "runtime/core/log.h"
#include "runtime/gpu/gpu.h"
#include "systems/scene/internal.h"

static bool upload_needed(kd_system_context *c)
{
    const kd_scene_store *s = kd_singleton(c->world, kd_scene_store);
    scene_internal *in = s->internal;
    if (in && in->trim_in && --in->trim_in == 0)
        in->trim_now = true;
    return in && (in->trim_now || in->something_left || in->waiting_deformed ||
                  in->uploaded_meshes < s->mesh_count || in->uploaded_materials < s->material_count ||
                  in->uploaded_deformed < s->deformed_count);
}

/* Grow by half at least, so that a scene that spawns one by one copies each byte a few times only. */
static void ensure(kd_gpu *gpu, kd_gpu_buffer *buffer, size_t size, const char *name)
{
    size_t old = buffer->id ? kd_gpu_buffer_size(gpu, *buffer) : 0;
    if (size == 0 && old == 0)
        size = 64; /* a buffer that can be bound stands even for what the scene has none of */
    if (size <= old)
        return;
    size_t target = old && size < old + old / 2 ? old + old / 2 : size;
    kd_status status = kd_gpu_ensure_buffer(gpu, buffer, target, old, name);
    if (status != KD_OK)
        kd_log(KD_LOG_ERROR, "no room for %zu bytes of %s on the GPU; use a smaller scene", target, name);
}

/* Cut a buffer to what is in use. Where that fails the larger one serves on. */
static void trim(kd_gpu *gpu, kd_gpu_buffer *buffer, size_t size, const char *name)
{
    if (size == 0 || size >= kd_gpu_buffer_size(gpu, *buffer))
        return;
    kd_gpu_buffer tight = kd_gpu_make_buffer(gpu, &(kd_gpu_buffer_desc){.size = size, .name = name});
    if (!tight.id)
        return;
    kd_gpu_copy_buffer(gpu, *buffer, 0, tight, 0, size);
    kd_gpu_destroy_buffer(gpu, *buffer);
    *buffer = tight;
}

static void trim_buffers(kd_gpu *gpu, kd_scene_store *s)
{
    const size_t word = sizeof(uint32_t);
    trim(gpu, &s->geometry, s->vertex_count * KD_GEOMETRY_WORDS * word, "scene geometry");
    trim(gpu, &s->attributes, s->vertex_count * KD_ATTRIBUTE_WORDS * word, "scene attributes");
}

static void ensure_buffers(kd_gpu *gpu, kd_scene_store *s)
{
    const size_t word = sizeof(uint32_t);
    ensure(gpu, &s->geometry, s->vertex_count * KD_GEOMETRY_WORDS * word, "scene geometry");
    ensure(gpu, &s->attributes, s->vertex_count * KD_ATTRIBUTE_WORDS * word, "scene attributes");
    ensure(gpu, &s->indices, s->index_count * word, "scene indices");
    ensure(gpu, &s->skins_buffer, s->skin_vertex_count * KD_SKIN_WORDS * word, "scene skins");
    ensure(gpu, &s->stencil_rows, s->stencil_row_count * sizeof(kd_stencil_row), "scene stencil rows");
    ensure(gpu, &s->stencils, s->stencil_count * sizeof(kd_stencil), "scene stencils");
    ensure(gpu, &s->morphs, s->morph_vertex_count * KD_MORPH_WORDS * word, "scene morph targets");
}

static void write_words(kd_gpu *gpu, kd_gpu_buffer buffer, uint32_t first, uint32_t count, uint32_t width,
                        const uint32_t *words)
{
    const size_t stride = width * sizeof(uint32_t);
    if (count)
        kd_gpu_write_buffer(gpu, buffer, first * stride, words, count * stride);
}

/* Upload what deforms: the vertices of a primitive, or those of its cage, which stand behind them. */
static void upload_vertices(kd_gpu *gpu, const kd_scene_store *s, const kd_store_primitive *p,
                            const kd_primitive_desc *desc, uint32_t morph_count, uint32_t behind,
                            uint32_t *words)
{
    uint32_t n = desc->vertex_count;
    scene_pack_geometry(desc, words);
    write_words(gpu, s->geometry, p->base_vertex + behind, n, KD_GEOMETRY_WORDS, words);
    if (p->first_skin_vertex != KD_NONE) {
        scene_pack_skin(desc, words);
        write_words(gpu, s->skins_buffer, p->first_skin_vertex + behind, n, KD_SKIN_WORDS, words);
    }
    for (uint32_t t = 0; t < morph_count; t++) {
        scene_pack_morph(desc, t, words);
        write_words(gpu, s->morphs, p->first_morph_vertex + morph_count * behind + t * n, n, KD_MORPH_WORDS,
                    words);
    }
}

/* Rows count stencils from the primitive's first; on the GPU they count from the first of all. */
static void upload_rows(kd_gpu *gpu, const kd_store_primitive *p, const kd_primitive_desc *desc,
                        kd_scene_store *s, uint32_t *words)
{
    const kd_subdivision *from = desc->subdivision;
    kd_stencil_row *rows = (kd_stencil_row *)(void *)words;
    memcpy(rows, from->rows, desc->vertex_count * sizeof *rows);
    for (uint32_t v = 0; v < desc->vertex_count; v++)
        rows[v].first += p->first_stencil;
    kd_gpu_write_buffer(gpu, s->stencil_rows, p->first_row * sizeof *rows, rows,
                        desc->vertex_count * sizeof *rows);
    kd_gpu_write_buffer(gpu, s->stencils, p->first_stencil * sizeof(kd_stencil), from->stencils,
                        from->stencil_count * sizeof(kd_stencil));
}

static void upload_primitive(kd_gpu *gpu, kd_scene_store *s, const kd_store_primitive *p,
                             const kd_primitive_desc *desc, uint32_t morph_count, uint32_t *words)
{
    upload_vertices(gpu, s, p, desc, morph_count, 0, words);
    scene_pack_attributes(desc, words);
    write_words(gpu, s->attributes, p->base_vertex, desc->vertex_count, KD_ATTRIBUTE_WORDS, words);
    write_words(gpu, s->indices, p->first_index, desc->index_count, 1, desc->indices);
    if (!desc->subdivision)
        return;
    upload_vertices(gpu, s, p, desc->subdivision->cage, morph_count, desc->vertex_count, words);
    upload_rows(gpu, p, desc, s, words);
}

static bool upload_mesh(kd_gpu *gpu, kd_scene_store *s, const kd_store_mesh *mesh)
{
    uint32_t largest = 1;
    for (uint32_t i = 0; i < mesh->primitive_count; i++)
        if (scene_primitive_vertices(&s->primitives[mesh->first_primitive + i]) > largest)
            largest = scene_primitive_vertices(&s->primitives[mesh->first_primitive + i]);
    uint32_t *words = malloc((size_t)largest * KD_GEOMETRY_WORDS * sizeof *words);
    if (!words)
        return false;
    for (uint32_t i = 0; i < mesh->primitive_count; i++)
        upload_primitive(gpu, s, &s->primitives[mesh->first_primitive + i], &mesh->desc->primitives[i],
                         mesh->morph_count, words);
    free(words);
    return true;
}

/* An instance's own vertices start as its mesh at rest; the attributes stay so for ever. */
static void copy_instance(kd_gpu *gpu, const kd_scene_store *s, const kd_store_deformed *deformed)
{
    const kd_store_mesh *mesh = &s->meshes[deformed->mesh];
    for (uint32_t i = 0; i < mesh->primitive_count; i++) {
        const kd_store_primitive *from = &s->primitives[mesh->first_primitive + i];
        const kd_store_primitive *to = &s->deformed_primitives[deformed->first_primitive + i];
        if (to->base_vertex == from->base_vertex || !to->vertex_count)
            continue;
        const size_t geometry = KD_GEOMETRY_WORDS * sizeof(uint32_t),
                     attribute = KD_ATTRIBUTE_WORDS * sizeof(uint32_t);
        kd_gpu_copy_buffer(gpu, s->geometry, from->base_vertex * geometry, s->geometry,
                           to->base_vertex * geometry, to->vertex_count * geometry);
        kd_gpu_copy_buffer(gpu, s->attributes, from->base_vertex * attribute, s->attributes,
                           to->base_vertex * attribute, to->vertex_count * attribute);
    }
}

static kd_wrap wrap_of(kd_wrap_mode mode)
{
    return mode == KD_WRAP_CLAMP ? KD_CLAMP : mode == KD_WRAP_MIRROR ? KD_MIRROR : KD_REPEAT;
}

/* One texture for each way an image is read: the sampler's state is the texture's. */
static kd_gpu_texture texture_ensure(kd_gpu *gpu, scene_internal *in, const kd_texture_ref *map, bool srgb)
{
    if (map->image >= in->image_count)
        return (kd_gpu_texture){0};
    for (uint32_t i = 0; i < in->texture_count; i++) {
        const scene_texture *t = &in->textures[i];
        if (t->image == map->image && t->srgb == srgb && t->nearest == map->nearest &&
            t->wrap_s == map->wrap_s && t->wrap_t == map->wrap_t)
            return t->texture;
    }
    if (!SCENE_RESERVE(in->textures, in->texture_capacity, in->texture_count + 1ull))
        return (kd_gpu_texture){0};
    const kd_image *image = in->images[map->image];
    kd_gpu_texture texture =
        kd_gpu_make_texture(gpu, &(kd_gpu_texture_desc){.kind = KD_TEXTURE_2D,
                                                        .format = srgb ? KD_SRGBA8 : KD_RGBA8,
                                                        .width = image->width,
                                                        .height = image->height,
                                                        .levels = map->nearest ? 1 : UINT32_MAX,
                                                        .filter = map->nearest ? KD_NEAREST : KD_LINEAR_MIP,
                                                        .wrap_s = wrap_of(map->wrap_s),
                                                        .wrap_t = wrap_of(map->wrap_t),
                                                        .data = image->rgba,
                                                        .generate_mips = !map->nearest,
                                                        .name = image->name});
    in->textures[in->texture_count++] =
        (scene_texture){map->image, map->wrap_s, map->wrap_t, srgb, map->nearest, texture};
    return texture;
}

static void upload_material(kd_gpu *gpu, scene_internal *in, kd_store_material *m)
{
    m->maps[0] = texture_ensure(gpu, in, &m->desc.base_color_map, true);
    m->maps[1] = texture_ensure(gpu, in, &m->desc.metallic_roughness_map, false);
    m->maps[2] = texture_ensure(gpu, in, &m->desc.normal_map, false);
    m->maps[3] = texture_ensure(gpu, in, &m->desc.emissive_map, true);
    m->maps[4] = texture_ensure(gpu, in, &m->desc.occlusion_map, false);
}

static void upload_run(kd_system_context *c)
{
    kd_scene_store *s = kd_singleton(c->world, kd_scene_store);
    scene_internal *in = s->internal;
    if (in->something_left)
        scene_give_back(s);
    if (in->trim_now)
        trim_buffers(c->gpu, s);
    in->trim_now = false;
    ensure_buffers(c->gpu, s);
    while (in->uploaded_meshes < s->mesh_count) {
        const kd_store_mesh *mesh = &s->meshes[in->uploaded_meshes];
        if (!upload_mesh(c->gpu, s, mesh)) {
            kd_log(KD_LOG_ERROR, "out of memory while a mesh goes to the GPU; it is tried again");
            return;
        }
        in->uploaded_meshes++;
        s->uploaded_primitives = mesh->first_primitive + mesh->primitive_count;
    }
    for (; in->uploaded_deformed < s->deformed_count; in->uploaded_deformed++)
        copy_instance(c->gpu, s, &s->deformed[in->uploaded_deformed]);
    for (uint32_t i = 0; in->waiting_deformed && i < s->deformed_count; i++) {
        if (!s->deformed[i].waiting)
            continue;
        copy_instance(c->gpu, s, &s->deformed[i]);
        s->deformed[i].waiting = false;
        in->waiting_deformed--;
    }
    for (; in->uploaded_materials < s->material_count; in->uploaded_materials++)
        upload_material(c->gpu, in, &s->materials[in->uploaded_materials]);
}

static void upload_fini(kd_system_context *c)
{
    kd_scene_store *s = kd_singleton(c->world, kd_scene_store);
    scene_internal *in = s->internal;
    kd_gpu_buffer *const buffers[] = {&s->geometry, &s->attributes,   &s->indices, &s->skins_buffer,
                                      &s->morphs,   &s->stencil_rows, &s->stencils};
    for (size_t i = 0; i < sizeof buffers / sizeof *buffers; i++) {
        kd_gpu_destroy_buffer(c->gpu, *buffers[i]);
        *buffers[i] = (kd_gpu_buffer){0};
    }
    if (!in)
        return;
    scene_give_back_fini(c->world, in);
    for (uint32_t i = 0; i < in->texture_count; i++)
        kd_gpu_destroy_texture(c->gpu, in->textures[i].texture);
    in->texture_count = 0;
    in->uploaded_meshes = in->uploaded_materials = in->uploaded_deformed = 0;
    s->uploaded_primitives = 0;
}

static kd_status upload_init(kd_system_context *c)
{
    kd_scene_store *store = scene_store_get(c->world);
    kd_status status = store ? scene_give_back_init(c->world, store->internal) : KD_NO_MEMORY;
    return status == KD_OK ? KD_OK : kd_fail(status, "out of memory for the scene store");
}

kd_status scene_register_upload(kd_schedule *s)
{
    return kd_schedule_add(s, &(kd_system_desc){
                                  .name = "scene_upload",
                                  .phase = KD_PHASE_ANIMATE,
                                  .where = KD_ON_GPU,
                                  .components = {KD_CHANGES(kd_scene_store), KD_USES(kd_mesh_instance),
                                                 KD_USES(kd_skin_instance), KD_USES(kd_animation)},
                                  .resources = {{"scene.vertices", KD_USE_COPY_READ | KD_USE_COPY_WRITE},
                                                {"scene.indices", KD_USE_COPY_WRITE},
                                                {"scene.static", KD_USE_COPY_WRITE}},
                                  .no_commands = true,
                                  .run = upload_run,
                                  .run_if = upload_needed,
                                  .init = upload_init,
                                  .fini = upload_fini,
                              });
}
