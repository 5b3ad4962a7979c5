/* A load from beginning to end: read, split, scan, parse, check and convert, measure. The model owns one
 * arena, which stands in the model itself. */

#include "runtime/asset/model.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "runtime/asset/gltf_loader.h"
#include "runtime/asset/model_bounds.h"
#include "runtime/asset/model_memory.h"
#include "runtime/core/file.h"
#include "runtime/core/nearest.h"

#define BLOCK_BYTES ((size_t)256 << 10)

/* ---- the head of the file ---- */

bool kd_model_reads_extension(const char *name)
{
    static const char *const supported[] = {"KHR_lights_punctual",
                                            "KHR_materials_emissive_strength",
                                            "KHR_texture_transform",
                                            "KHR_mesh_quantization",
                                            "KHR_materials_unlit",
                                            "KHR_draco_mesh_compression",
                                            "EXT_meshopt_compression",
                                            "EXT_texture_webp",
                                            "EXT_mesh_gpu_instancing",
                                            "KHR_node_visibility",
                                            "KHR_materials_variants",
                                            "KHR_animation_pointer",
                                            "KHR_materials_ior",
                                            "KHR_materials_specular",
                                            "KHR_materials_clearcoat",
                                            "KHR_materials_transmission",
                                            "KHR_materials_pbrSpecularGlossiness"};
    for (size_t i = 0; i < sizeof supported / sizeof *supported; i++)
        if (strcmp(name, supported[i]) == 0)
            return true;
    return false;
}

static kd_status check_required(gltf_loader *l)
{
    gltf_strings required = l->doc.extensions_required;
    for (size_t i = 0; i < required.count; i++)
        if (!kd_model_reads_extension(required.at[i]))
            return gltf_fail(l, KD_UNSUPPORTED,
                             "the model requires the extension '%.60s', which is not read "
                             "(extensionsRequired); export it without",
                             required.at[i]);
    return KD_OK;
}

static kd_status list_extensions(gltf_loader *l)
{
    gltf_strings used = l->doc.extensions_used;
    const char **names;
    kd_status status = gltf_alloc(l, &l->kept, used.count + 1, sizeof *names, &names);
    for (size_t i = 0; !status && i < used.count; i++) {
        names[i] = kd_arena_printf(&l->kept, "%s", used.at[i]);
        if (!kd_model_reads_extension(used.at[i]))
            gltf_warn(l, "the optional extension '%.60s' is not read", used.at[i]);
    }
    l->model->extensions_used = names;
    return status;
}

/* "2.1" may be read as 2.0 unless minVersion says otherwise (glTF 2.0, section 3.2). */
static kd_status check_version(gltf_loader *l)
{
    const char *version = l->doc.version, *min = l->doc.min_version;
    if (strncmp(version, "2.", 2) != 0)
        return gltf_fail(l, KD_UNSUPPORTED, "the file is glTF '%.20s' (asset.version); export it as glTF 2.0",
                         version);
    if (*min && strcmp(min, "2.0") != 0)
        return gltf_fail(l, KD_UNSUPPORTED,
                         "the file needs a reader of glTF '%.20s' (asset.minVersion); export it as glTF 2.0",
                         min);
    return KD_OK;
}

/* ---- steps ---- */

static kd_status parse_file(gltf_loader *l, uint8_t *bytes, size_t size)
{
    char error[256] = "";
    gltf_scan scan = {0};
    kd_status status = gltf_split(bytes, size, &l->chunks, error, sizeof error);
    if (!status)
        status = gltf_scan_json(l->chunks.json, l->chunks.json_size, &scan, error, sizeof error);
    if (!status)
        status =
            gltf_parse(l->chunks.json, l->chunks.json_size, &scan, &l->scratch, &l->doc, error, sizeof error);
    gltf_scan_fini(&scan);
    kd_status refused = status ? check_required(l) : KD_OK;
    if (refused)
        return refused;
    if (!status)
        return KD_OK;
    return gltf_fail(l, status, strchr(error, ';') ? "%s" : "%s; export the model again", error);
}

/* Names as the file has them, "kind N" for empty ones; NULL-terminated. */
static kd_status list_names(gltf_loader *l, gltf_strings from, const char *kind, const char *const **out)
{
    const char **names;
    kd_status status = gltf_alloc(l, &l->kept, from.count + 1, sizeof *names, &names);
    for (size_t i = 0; !status && i < from.count; i++) {
        names[i] = gltf_name(l, from.at[i], kind, i);
        if (!names[i])
            status = gltf_fail(l, KD_NO_MEMORY, "out of memory for names");
    }
    *out = names;
    return status;
}

/* Find what an option asks for by name. */
static kd_status choose(gltf_loader *l, const char *const *names, const char *kind, const char *wanted,
                        uint32_t *out)
{
    kd_nearest near = kd_nearest_to(wanted);
    for (uint32_t i = 0; names[i]; i++) {
        kd_nearest_offer(&near, names[i]);
        if (strcmp(names[i], wanted) == 0) {
            *out = i;
            return KD_OK;
        }
    }
    if (!names[0])
        return gltf_fail(l, KD_NOT_FOUND, "there is no %s '%.60s', the file has none; leave it out", kind,
                         wanted);
    return gltf_fail(l, KD_NOT_FOUND, "there is no %s '%.60s'; '%.60s' is one", kind, wanted,
                     near.best ? near.best : names[0]);
}

static kd_status choose_parts(gltf_loader *l)
{
    const kd_model_options *o = &l->options;
    kd_model *m = l->model;
    kd_status status = list_names(l, l->doc.scene_names, "scene", &m->scenes);
    if (!status)
        status = list_names(l, l->doc.variants, "variant", &m->variants);
    l->variant = KD_NONE;
    if (!status && o->variant)
        status = choose(l, m->variants, "variant", o->variant, &l->variant);
    m->scene = l->doc.default_scene == -1 ? l->doc.scene_count ? 0 : KD_NONE : (uint32_t)l->doc.default_scene;
    if (!status && o->scene)
        status = choose(l, m->scenes, "scene", o->scene, &m->scene);
    return status;
}

static kd_status make_tables(gltf_loader *l)
{
    kd_status status = gltf_alloc(l, &l->scratch, l->doc.accessor_count, sizeof *l->spans, &l->spans);
    if (!status)
        status = gltf_alloc(l, &l->scratch, l->doc.image_count, sizeof *l->image_of, &l->image_of);
    if (!status)
        status = gltf_alloc(l, &l->scratch, l->doc.node_count, sizeof *l->node_of, &l->node_of);
    if (status)
        return status;
    memset(l->image_of, 0xff, l->doc.image_count * sizeof *l->image_of);
    memset(l->node_of, 0xff, l->doc.node_count * sizeof *l->node_of);
    l->model->generator = gltf_name(l, l->doc.generator, "unknown generator", 0);
    return KD_OK;
}

static kd_status measure(gltf_loader *l)
{
    if (!model_measure(l->model, &l->scratch))
        return gltf_fail(
            l, KD_BAD_FORMAT,
            "the transforms carry vertices beyond what numbers hold (nodes); make the model smaller");
    if (!l->model->triangle_count && !l->options.without_triangles)
        return gltf_fail(l, KD_BAD_FORMAT,
                         "the model holds no triangles in its scene; there is nothing to draw");
    return KD_OK;
}

/* Files and pictures are in memory now: what follows unfolds them, in proportion to what they brought. */
static kd_status set_limit(gltf_loader *l)
{
    uint64_t limit = l->bytes + GLTF_UNFOLD_FLOOR + GLTF_UNFOLD_FACTOR * l->source_bytes;
    l->limit = limit < GLTF_BYTES_MAX ? limit : GLTF_BYTES_MAX;
    return KD_OK;
}

static kd_status convert(gltf_loader *l)
{
    static kd_status (*const steps[])(gltf_loader *) = {
        check_version,     check_required,    list_extensions,     choose_parts,
        make_tables,       gltf_load_buffers, gltf_load_materials, set_limit,
        gltf_unpack_views, gltf_load_meshes,  gltf_load_cameras,   gltf_load_lights,
        gltf_load_nodes,   gltf_load_skins,   gltf_load_clips,     measure,
    };
    kd_status status = KD_OK;
    for (size_t i = 0; !status && i < sizeof steps / sizeof *steps; i++)
        status = steps[i](l);
    if (!status && l->warnings_dropped) {
        const char *last = kd_arena_printf(&l->kept, "%u more warnings", l->warnings_dropped);
        if (last)
            l->warnings[l->model->warning_count++] = last;
    }
    return status;
}

/* ---- the model ---- */

/* Move the finished arena into the model it holds. */
static kd_model *seal(kd_arena *arena, kd_model *model)
{
    model_memory *inside = kd_arena_alloc(arena, sizeof *inside);
    if (!inside)
        return NULL;
    *inside = (model_memory){*arena, 1};
    model->internal = inside;
    return model;
}

static kd_status load_bytes(gltf_loader *l, uint8_t *bytes, size_t size)
{
    kd_status status = gltf_alloc(l, &l->kept, 1, sizeof *l->model, &l->model);
    if (!status)
        status = gltf_alloc(l, &l->kept, GLTF_WARNINGS_MAX + 1, sizeof *l->warnings, &l->warnings);
    if (status)
        return status;
    l->model->warnings = l->warnings;
    l->model->path = kd_arena_printf(&l->kept, "%s", l->path);
    status = parse_file(l, bytes, size);
    return status ? status : convert(l);
}

kd_status kd_model_load(const char *path, kd_model **out)
{
    return kd_model_load_with(path, &(kd_model_options){0}, out);
}

kd_status kd_model_load_with(const char *path, const kd_model_options *options, kd_model **out)
{
    *out = NULL;
    void *bytes;
    size_t size;
    kd_status status = kd_file_read(path, (size_t)GLTF_BYTES_MAX, &bytes, &size);
    if (status)
        return status;
    gltf_loader l = {
        .path = path, .options = *options, .bytes = size, .limit = GLTF_BYTES_MAX, .source_bytes = size};
    l.kept.block_bytes = l.scratch.block_bytes = l.work.block_bytes = BLOCK_BYTES;
    status = load_bytes(&l, bytes, size);
    if (!status) {
        *out = seal(&l.kept, l.model);
        if (!*out)
            status = gltf_fail(&l, KD_NO_MEMORY, "out of memory");
    }
    if (status)
        kd_arena_fini(&l.kept);
    kd_arena_fini(&l.scratch);
    kd_arena_fini(&l.work);
    free(bytes);
    return status;
}

void kd_model_destroy(kd_model *model)
{
    model_memory *memory = model ? model->internal : NULL;
    if (!memory || --memory->holders)
        return;
    kd_arena arena = memory->arena; /* the copy outlives the memory it stands in */
    kd_arena_fini(&arena);
}

kd_model *kd_model_share(kd_model *model)
{
    ((model_memory *)model->internal)->holders++;
    return model;
}
