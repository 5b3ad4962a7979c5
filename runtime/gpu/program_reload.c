/* Programs made anew from sources that were edited while they are in use: each keeps what it was made of. */
#include <stdlib.h>
#include <string.h>

#include "runtime/gpu/internal.h"
#include "runtime/gpu/source.h"

/* ---- recipes ---- */

static bool copy_text(char **out, const char *text)
{
    *out = text ? strdup(text) : NULL;
    return *out || !text;
}

static bool copy_defines(gpu_recipe *recipe, const char *const *defines)
{
    size_t count = 0;
    while (defines && defines[count])
        count++;
    recipe->defines = calloc(count + 1, sizeof *recipe->defines);
    bool good = recipe->defines != NULL;
    for (size_t i = 0; i < count && good; i++)
        good = copy_text(&recipe->defines[i], defines[i]);
    return good;
}

bool gpu_recipe_init(gpu_recipe *recipe, const kd_gpu_program_desc *desc)
{
    *recipe = (gpu_recipe){0};
    if (copy_text(&recipe->compute, desc->compute) && copy_text(&recipe->vertex, desc->vertex) &&
        copy_text(&recipe->geometry, desc->geometry) && copy_text(&recipe->fragment, desc->fragment) &&
        copy_defines(recipe, desc->defines))
        return true;
    gpu_recipe_fini(recipe);
    return false;
}

void gpu_recipe_fini(gpu_recipe *recipe)
{
    free(recipe->compute);
    free(recipe->vertex);
    free(recipe->geometry);
    free(recipe->fragment);
    for (char **define = recipe->defines; define && *define; define++)
        free(*define);
    free((void *)recipe->defines);
    *recipe = (gpu_recipe){0};
}

/* ---- making anew ---- */

static kd_gpu_program_desc desc_of(const gpu_recipe *recipe)
{
    return (kd_gpu_program_desc){.compute = recipe->compute,
                                 .vertex = recipe->vertex,
                                 .geometry = recipe->geometry,
                                 .fragment = recipe->fragment,
                                 .defines = (const char *const *)recipe->defines};
}

static uint64_t hash_text(uint64_t hash, const char *text)
{
    for (; *text; text++)
        hash = (hash ^ (unsigned char)*text) * 0x100000001b3u;
    return hash;
}

bool gpu_recipe_hash(const kd_gpu *gpu, const gpu_recipe *recipe, uint64_t *hash)
{
    const char *paths[] = {recipe->compute, recipe->vertex, recipe->geometry, recipe->fragment};
    bool good = true;
    *hash = 0xcbf29ce484222325u;
    for (size_t i = 0; i < sizeof paths / sizeof *paths && good; i++) {
        gpu_source source = {.more = gpu->shaders};
        if (!paths[i])
            continue;
        good = gpu_source_expand(&source, paths[i], (const char *const *)recipe->defines);
        *hash = good ? hash_text(*hash, source.text) : *hash;
        gpu_source_fini(&source);
    }
    return good;
}

/* The recipe has the hash of what is to be made. */
static kd_status reload(kd_gpu *gpu, gpu_program *program)
{
    bool failed = gpu->failed;
    kd_gpu_program_desc desc = desc_of(&program->recipe);
    GLuint made = gpu_find_program(gpu, &program->recipe);
    if (!made)
        made = gpu_build_program(gpu, &desc, program->name);
    gpu->failed = failed;
    if (!made)
        return KD_GPU;
    gpu->gl.UseProgram(0);
    gpu->program = 0;
    gpu_release_program(gpu, program);
    program->gl = made;
    program->made_of = program->recipe.hash;
    program->storage = gpu_program_storage(gpu, made);
    gpu_label(gpu, GL_PROGRAM, made, program->name);
    return KD_OK;
}

kd_status kd_gpu_reload_programs(kd_gpu *gpu, void (*changed)(void *user, const char *path), void *user,
                                 uint32_t *count)
{
    kd_status status = KD_OK;
    *count = 0;
    for (uint32_t id = 0; (id = gpu_pool_next(&gpu->programs, id)) != 0;) {
        gpu_program *program = gpu_pool_find(&gpu->programs, id);
        gpu_recipe *recipe = &program->recipe;
        uint64_t hash;
        if (!gpu_recipe_hash(gpu, recipe, &hash) || hash == recipe->hash)
            continue;
        recipe->hash = hash; /* what does not compile is not tried again until it changes */
        if (reload(gpu, program) != KD_OK) {
            status = KD_GPU;
            continue;
        }
        (*count)++;
        if (changed)
            changed(user, recipe->compute    ? recipe->compute
                          : recipe->fragment ? recipe->fragment
                                             : recipe->vertex);
    }
    return status;
}
