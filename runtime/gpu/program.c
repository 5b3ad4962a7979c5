/* Programs: equal ones share an object of the driver's, so that a scene that is loaded anew compiles nothing.
 * Else every stage's source is put together, compiled and linked at once; what the compiler says is logged a
 * line at a time under the path and line of the file that a person edits. */

#include <assert.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "runtime/gpu/internal.h"
#include "runtime/gpu/source.h"

enum { MAX_LOG_LINES = 12, MAX_STAGES = 3 };

static void log_line(const gpu_source *source, const char *line, size_t length, kd_log_level level)
{
    char text[700];
    gpu_source_translate(source, line, length, text, sizeof text);
    kd_log(level, "%s", text);
}

/* Log what the compiler or linker said. Returns the number of lines. */
static int log_lines(const gpu_source *source, const char *log, kd_log_level level)
{
    int lines = 0;
    while (*log && lines < MAX_LOG_LINES) {
        size_t length = strcspn(log, "\n");
        if (length && *log != '\r') {
            log_line(source, log, length, level);
            lines++;
        }
        log += length + (log[length] == '\n');
    }
    return lines;
}

static char *get_log(kd_gpu *gpu, GLuint object, bool is_program)
{
    const gl_table *gl = &gpu->gl;
    GLint length = 0;
    if (is_program)
        gl->GetProgramiv(object, GL_INFO_LOG_LENGTH, &length);
    else
        gl->GetShaderiv(object, GL_INFO_LOG_LENGTH, &length);
    char *log = calloc((size_t)(length > 0 ? length : 0) + 1, 1);
    if (log && length > 0 && is_program)
        gl->GetProgramInfoLog(object, length, NULL, log);
    else if (log && length > 0)
        gl->GetShaderInfoLog(object, length, NULL, log);
    return log;
}

/* Returns 0 after logging why. */
static GLuint compile(kd_gpu *gpu, GLenum stage, const char *path, const char *const *defines)
{
    const gl_table *gl = &gpu->gl;
    gpu_source source = {.more = gpu->shaders};
    if (!gpu_source_expand(&source, path, defines)) {
        gpu_fail(gpu, "%s", source.error);
        gpu_source_fini(&source);
        return 0;
    }
    const GLchar *text = source.text;
    GLint good = GL_FALSE;
    GLuint shader = gl->CreateShader(stage);
    gl->ShaderSource(shader, 1, &text, NULL);
    gl->CompileShader(shader);
    gl->GetShaderiv(shader, GL_COMPILE_STATUS, &good);
    char *log = get_log(gpu, shader, false);
    int lines = log ? log_lines(&source, log, good ? KD_LOG_DEBUG : KD_LOG_ERROR) : 0;
    if (!good && !lines)
        gpu_fail(gpu, "%s: the driver refused the shader without a reason", path);
    free(log);
    gpu_source_fini(&source);
    if (good)
        return shader;
    gpu->failed = true;
    gl->DeleteShader(shader);
    return 0;
}

static bool link_program(kd_gpu *gpu, GLuint program, const char *name)
{
    static const gpu_source no_files = {0};
    GLint good = GL_FALSE;
    gpu->gl.LinkProgram(program);
    gpu->gl.GetProgramiv(program, GL_LINK_STATUS, &good);
    if (good)
        return true;
    char *log = get_log(gpu, program, true);
    gpu_fail(gpu, "%s: the stages do not link", name);
    if (log)
        log_lines(&no_files, log, KD_LOG_ERROR);
    free(log);
    return false;
}

GLuint gpu_build_program(kd_gpu *gpu, const kd_gpu_program_desc *desc, const char *name)
{
    const struct {
        GLenum stage;
        const char *path;
    } graphics[MAX_STAGES] = {{GL_VERTEX_SHADER, desc->vertex},
                              {GL_GEOMETRY_SHADER, desc->geometry},
                              {GL_FRAGMENT_SHADER, desc->fragment}},
      compute[MAX_STAGES] = {{GL_COMPUTE_SHADER, desc->compute}},
      *stages = desc->compute ? compute : graphics;
    GLuint program = gpu->gl.CreateProgram(), shaders[MAX_STAGES] = {0};
    bool good = true;
    for (int i = 0; i < MAX_STAGES; i++) {
        if (!stages[i].path)
            continue;
        shaders[i] = compile(gpu, stages[i].stage, stages[i].path, desc->defines);
        good = good && shaders[i];
        if (shaders[i])
            gpu->gl.AttachShader(program, shaders[i]);
    }
    good = good && link_program(gpu, program, name);
    for (int i = 0; i < MAX_STAGES; i++) {
        if (!shaders[i])
            continue;
        gpu->gl.DetachShader(program, shaders[i]);
        gpu->gl.DeleteShader(shaders[i]);
    }
    if (!good)
        gpu->gl.DeleteProgram(program);
    return good ? program : 0;
}

uint32_t gpu_program_storage(kd_gpu *gpu, GLuint program)
{
    static const GLenum what = GL_BUFFER_BINDING;
    GLint count = 0;
    uint32_t mask = 0;
    gpu->gl.GetProgramInterfaceiv(program, GL_SHADER_STORAGE_BLOCK, GL_ACTIVE_RESOURCES, &count);
    for (GLint i = 0; i < count; i++) {
        GLint binding = 0;
        gpu->gl.GetProgramResourceiv(program, GL_SHADER_STORAGE_BLOCK, (GLuint)i, 1, &what, 1, NULL,
                                     &binding);
        if (binding >= 0 && binding < GPU_MAX_STORAGE)
            mask |= 1u << binding;
    }
    return mask;
}

/* ---- one object for programs of the same text ---- */

static bool same_text(const char *a, const char *b)
{
    return a == b || (a && b && strcmp(a, b) == 0);
}

GLuint gpu_find_program(kd_gpu *gpu, const gpu_recipe *recipe)
{
    for (uint32_t id = 0; (id = gpu_pool_next(&gpu->programs, id)) != 0;) {
        const gpu_program *program = gpu_pool_find(&gpu->programs, id);
        const gpu_recipe *other = &program->recipe;
        if (other != recipe && other->hash == recipe->hash && program->made_of == recipe->hash &&
            same_text(other->compute, recipe->compute) && same_text(other->vertex, recipe->vertex) &&
            same_text(other->geometry, recipe->geometry) && same_text(other->fragment, recipe->fragment))
            return program->gl;
    }
    return 0;
}

void gpu_release_program(kd_gpu *gpu, gpu_program *program)
{
    for (uint32_t id = 0; (id = gpu_pool_next(&gpu->programs, id)) != 0;) {
        const gpu_program *other = gpu_pool_find(&gpu->programs, id);
        if (other != program && other->gl == program->gl)
            return;
    }
    gpu->gl.DeleteProgram(program->gl);
}

/* ---- handles ---- */

static kd_gpu_program add(kd_gpu *gpu, const gpu_program *made)
{
    gpu_program *program;
    uint32_t id = gpu_pool_add(&gpu->programs, (void **)&program);
    if (id)
        *program = *made;
    return (kd_gpu_program){id};
}

kd_gpu_program kd_gpu_make_program(kd_gpu *gpu, const kd_gpu_program_desc *desc)
{
    assert(gpu && desc && (desc->compute || desc->vertex));
    const char *path = desc->compute ? desc->compute : desc->fragment ? desc->fragment : desc->vertex;
    const char *name = desc->name ? desc->name : path;
    gpu_program made = {.compute = desc->compute != NULL};
    kd_gpu_program handle = {0};
    gpu_copy_name(made.name, name, "program");
    bool known = gpu_recipe_init(&made.recipe, desc);
    if (known && gpu_recipe_hash(gpu, &made.recipe, &made.recipe.hash))
        made.gl = gpu_find_program(gpu, &made.recipe);
    bool shared = made.gl != 0;
    if (known && !shared)
        made.gl = gpu_build_program(gpu, desc, name);
    if (made.gl) {
        made.made_of = made.recipe.hash;
        made.storage = gpu_program_storage(gpu, made.gl);
        handle = add(gpu, &made);
    }
    if (handle.id) {
        if (!shared)
            gpu_label(gpu, GL_PROGRAM, made.gl, made.name);
        return handle;
    }
    if (made.gl && !shared)
        gpu->gl.DeleteProgram(made.gl);
    gpu_recipe_fini(&made.recipe);
    if (!known || made.gl)
        gpu_fail(gpu, "program %s: no memory for its handle", name);
    return handle;
}

void kd_gpu_destroy_program(kd_gpu *gpu, kd_gpu_program handle)
{
    gpu_program *program = handle.id ? gpu_get_program(gpu, handle, "destroy_program") : NULL;
    if (!program)
        return;
    if (gpu->program == handle.id) {
        gpu->gl.UseProgram(0);
        gpu->program = 0;
    }
    gpu_release_program(gpu, program);
    gpu_recipe_fini(&program->recipe);
    gpu_pool_remove(&gpu->programs, handle.id);
}

bool gpu_use_program(kd_gpu *gpu, kd_gpu_program handle, bool compute, const char *call)
{
    gpu_program *program = gpu_get_program(gpu, handle, call);
    if (!program)
        return false;
    if (program->compute != compute) {
        gpu_complain(gpu, "%s: program %s is of the other kind", call, program->name);
        return false;
    }
    if (program->storage & gpu->refused_storage)
        return false;
    if (gpu->program != handle.id) {
        gpu->gl.UseProgram(program->gl);
        gpu->program = handle.id;
    }
    if (gpu->pass)
        gpu->pass(gpu->pass_user, handle.id, program->name);
    return true;
}
