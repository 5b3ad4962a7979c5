/* Programs: every stage's source is put together, compiled and linked at once; what the compiler says is
 * logged a line at a time under the path and line of the file that a person edits. */

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

uint64_t gpu_hash_text(uint64_t hash, const char *text)
{
    for (; *text; text++)
        hash = (hash ^ (unsigned char)*text) * 0x100000001b3u;
    return hash;
}

/* Returns 0 after logging why. */
static GLuint compile(kd_gpu *gpu, GLenum stage, const char *path, const char *const *defines, uint64_t *hash)
{
    const gl_table *gl = &gpu->gl;
    gpu_source source = {.more = gpu->shaders};
    if (!gpu_source_expand(&source, path, defines)) {
        gpu_fail(gpu, "%s", source.error);
        gpu_source_fini(&source);
        return 0;
    }
    const GLchar *text = source.text;
    *hash = gpu_hash_text(*hash, source.text);
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

GLuint gpu_build_program(kd_gpu *gpu, const kd_gpu_program_desc *desc, const char *name, uint64_t *hash)
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
    uint64_t text_hash = GPU_HASH;
    bool good = true;
    for (int i = 0; i < MAX_STAGES; i++) {
        if (!stages[i].path)
            continue;
        shaders[i] = compile(gpu, stages[i].stage, stages[i].path, desc->defines, &text_hash);
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
    if (hash)
        *hash = text_hash;
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

kd_gpu_program kd_gpu_make_program(kd_gpu *gpu, const kd_gpu_program_desc *desc)
{
    assert(gpu && desc && (desc->compute || desc->vertex));
    const char *path = desc->compute ? desc->compute : desc->fragment ? desc->fragment : desc->vertex;
    const char *name = desc->name ? desc->name : path;
    uint64_t hash;
    gpu_recipe recipe;
    gpu_program *program;
    GLuint gl = gpu_build_program(gpu, desc, name, &hash);
    if (!gl)
        return (kd_gpu_program){0};
    bool known = gpu_recipe_init(&recipe, desc, hash);
    uint32_t id = known ? gpu_pool_add(&gpu->programs, (void **)&program) : 0;
    if (!id) {
        if (known)
            gpu_recipe_fini(&recipe);
        gpu->gl.DeleteProgram(gl);
        gpu_fail(gpu, "program %s: no memory for its handle", name);
        return (kd_gpu_program){0};
    }
    program->gl = gl;
    program->compute = desc->compute != NULL;
    program->storage = gpu_program_storage(gpu, gl);
    program->recipe = recipe;
    gpu_copy_name(program->name, name, "program");
    gpu_label(gpu, GL_PROGRAM, gl, program->name);
    return (kd_gpu_program){id};
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
    gpu->gl.DeleteProgram(program->gl);
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
