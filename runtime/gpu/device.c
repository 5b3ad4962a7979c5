/* Opening a device: each way to a context is tried in order until one gives OpenGL 4.5 core; the reasons of
 * those that failed are kept for one message. Then the limits are read and the state is set that no pass ever
 * changes. */

#include <assert.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "runtime/gpu/internal.h"

#ifdef NDEBUG
enum { DEBUG_BUILD = 0 };
#else
enum { DEBUG_BUILD = 1 };
#endif

static bool open_context(const kd_gpu_desc *desc, kd_context_api api, gpu_context *out, gpu_reason *reason)
{
    switch (api) {
    case KD_CONTEXT_GLFW: return gpu_context_open_glfw(desc, out, reason);
    case KD_CONTEXT_OSMESA: return gpu_context_open_osmesa(desc, out, reason);
    case KD_CONTEXT_EGL_DEVICE:
    case KD_CONTEXT_EGL_SURFACELESS:
    case KD_CONTEXT_EGL_SOFTWARE: return gpu_context_open_egl(desc, api, out, reason);
    default: return false;
    }
}

static const char *get_string(const kd_gpu *gpu, GLenum what)
{
    const GLubyte *text = gpu->gl.GetString(what);
    return text ? (const char *)text : "unknown";
}

static int get_int(const kd_gpu *gpu, GLenum what)
{
    GLint value = 0;
    gpu->gl.GetIntegerv(what, &value);
    return value;
}

static int64_t get_int64(const kd_gpu *gpu, GLenum what)
{
    GLint64 value = 0;
    gpu->gl.GetInteger64v(what, &value);
    return value;
}

static bool has_extension(const kd_gpu *gpu, const char *name)
{
    int count = get_int(gpu, GL_NUM_EXTENSIONS);
    for (int i = 0; i < count; i++)
        if (strcmp((const char *)gpu->gl.GetStringi(GL_EXTENSIONS, (GLuint)i), name) == 0)
            return true;
    return false;
}

/* OpenGL 4.6 has it, 4.5 as an extension under either name. Software renderers walk the footprint texel by
 * texel, even where a compute shader names the level itself and there is none: a map could take minutes. */
static int anisotropy_of(const kd_gpu *gpu)
{
    bool has = has_extension(gpu, "GL_ARB_texture_filter_anisotropic") ||
               has_extension(gpu, "GL_EXT_texture_filter_anisotropic");
    return has && !gpu->info.software ? get_int(gpu, GL_MAX_TEXTURE_MAX_ANISOTROPY) : 1;
}

static void read_limits(kd_gpu *gpu)
{
    kd_gpu_info *info = &gpu->info;
    *info = (kd_gpu_info){
        .api = kd_context_api_name(gpu->context.api),
        .renderer = get_string(gpu, GL_RENDERER),
        .vendor = get_string(gpu, GL_VENDOR),
        .version = get_string(gpu, GL_VERSION),
        .max_ssbo_bytes = get_int64(gpu, GL_MAX_SHADER_STORAGE_BLOCK_SIZE),
        .max_texels = get_int64(gpu, GL_MAX_TEXTURE_BUFFER_SIZE),
        .max_shared_bytes = get_int(gpu, GL_MAX_COMPUTE_SHARED_MEMORY_SIZE),
        .max_invocations = get_int(gpu, GL_MAX_COMPUTE_WORK_GROUP_INVOCATIONS),
        .max_texture_3d = get_int(gpu, GL_MAX_3D_TEXTURE_SIZE),
    };
    info->software = strstr(info->renderer, "llvmpipe") || strstr(info->renderer, "softpipe") ||
                     strstr(info->renderer, "swrast") || strstr(info->renderer, "SWR");
    gpu->gl.GetQueryiv(GL_TIMESTAMP, GL_QUERY_COUNTER_BITS, &info->timestamp_bits);
    info->storage_alignment = get_int(gpu, GL_SHADER_STORAGE_BUFFER_OFFSET_ALIGNMENT);
    info->uniform_alignment = get_int(gpu, GL_UNIFORM_BUFFER_OFFSET_ALIGNMENT);
    gpu->max_storage_bindings = get_int(gpu, GL_MAX_SHADER_STORAGE_BUFFER_BINDINGS);
    if (gpu->max_storage_bindings > GPU_MAX_STORAGE)
        gpu->max_storage_bindings = GPU_MAX_STORAGE;
    gpu->max_texture_units = get_int(gpu, GL_MAX_COMBINED_TEXTURE_IMAGE_UNITS);
    gpu->max_image_units = get_int(gpu, GL_MAX_IMAGE_UNITS);
    gpu->max_texture_2d = get_int(gpu, GL_MAX_TEXTURE_SIZE);
    gpu->max_layers = get_int(gpu, GL_MAX_ARRAY_TEXTURE_LAYERS);
    gpu->max_cube = get_int(gpu, GL_MAX_CUBE_MAP_TEXTURE_SIZE);
    gpu->max_anisotropy = anisotropy_of(gpu);
    for (GLuint axis = 0; axis < 3; axis++) {
        GLint groups = 0;
        gpu->gl.GetIntegeri_v(GL_MAX_COMPUTE_WORK_GROUP_COUNT, axis, &groups);
        gpu->max_groups[axis] = groups;
    }
}

static void APIENTRY on_message(GLenum source, GLenum type, GLuint id, GLenum severity, GLsizei length,
                                const GLchar *message, const void *user)
{
    /* The user pointer is const in GL's signature only. */
    kd_gpu *gpu = (kd_gpu *)(uintptr_t)user;
    (void)id;
    (void)length;
    bool serious = severity == GL_DEBUG_SEVERITY_HIGH || severity == GL_DEBUG_SEVERITY_MEDIUM;
    bool error = type == GL_DEBUG_TYPE_ERROR || type == GL_DEBUG_TYPE_UNDEFINED_BEHAVIOR;
    /* Compilers speak through their info log, which is reported with the names of the files. */
    if (serious && error && source != GL_DEBUG_SOURCE_SHADER_COMPILER)
        gpu_complain(gpu, "OpenGL: %s", message);
}

static void set_constant_state(kd_gpu *gpu)
{
    const gl_table *gl = &gpu->gl;
    if (gpu->debug) {
        gl->Enable(GL_DEBUG_OUTPUT);
        gl->Enable(GL_DEBUG_OUTPUT_SYNCHRONOUS);
        gl->DebugMessageCallback(on_message, gpu);
        gl->DebugMessageControl(GL_DONT_CARE, GL_DEBUG_TYPE_PERFORMANCE, GL_DONT_CARE, 0, NULL, GL_FALSE);
    }
    gl->PixelStorei(GL_PACK_ALIGNMENT, 1);
    gl->PixelStorei(GL_UNPACK_ALIGNMENT, 1);
    gl->Enable(GL_TEXTURE_CUBE_MAP_SEAMLESS);
    gl->FrontFace(GL_CCW);
    gl->CreateVertexArrays(1, &gpu->empty_vao);
    gl->CreateVertexArrays(1, &gpu->vao);
    gl->CreateFramebuffers(1, &gpu->blit_framebuffer);
}

static void init_pools(kd_gpu *gpu)
{
    gpu->buffers.item_size = sizeof(gpu_buffer);
    gpu->textures.item_size = sizeof(gpu_texture);
    gpu->programs.item_size = sizeof(gpu_program);
    gpu->targets.item_size = sizeof(gpu_target);
    gpu->readbacks.item_size = sizeof(gpu_readback);
}

static bool check_context(kd_gpu *gpu, gpu_reason *reason)
{
    const char *missing = gl_load(&gpu->gl, gpu->context.lookup);
    if (missing) {
        snprintf(reason->text, sizeof reason->text, "the driver lacks %s", missing);
        return false;
    }
    int version = get_int(gpu, GL_MAJOR_VERSION) * 10 + get_int(gpu, GL_MINOR_VERSION);
    read_limits(gpu);
    if (version < 45)
        snprintf(reason->text, sizeof reason->text, "%.100s is OpenGL %d.%d, 4.5 is needed",
                 gpu->info.renderer, version / 10, version % 10);
    else if (gpu->context.hardware_only && gpu->info.software)
        snprintf(reason->text, sizeof reason->text, "the device gave the software renderer %.150s",
                 gpu->info.renderer);
    else
        return true;
    return false;
}

kd_status gpu_open_one(const kd_gpu_desc *desc, kd_context_api api, kd_gpu **out, gpu_reason *reason)
{
    kd_gpu *gpu = calloc(1, sizeof *gpu);
    kd_gpu_desc one = *desc;
    one.debug |= DEBUG_BUILD;
    if (!gpu)
        return KD_NO_MEMORY;
    if (!open_context(&one, api, &gpu->context, reason)) {
        free(gpu);
        return KD_NO_CONTEXT;
    }
    gpu->debug = one.debug;
    gpu->shaders = one.shaders;
    init_pools(gpu);
    if (!check_context(gpu, reason)) {
        gpu->context.close(&gpu->context);
        free(gpu);
        return KD_NO_CONTEXT;
    }
    set_constant_state(gpu);
    gpu_timers_init(gpu);
    if (!gpu_uniforms_init(gpu)) {
        snprintf(reason->text, sizeof reason->text, "no memory for the ring of uniforms");
        kd_gpu_close(gpu);
        return KD_NO_CONTEXT;
    }
    *out = gpu;
    return KD_OK;
}

static uint32_t list_ways(const kd_gpu_desc *desc, kd_context_api ways[KD_CONTEXT_API_COUNT])
{
    uint32_t count = 0;
    bool any = desc->api == KD_CONTEXT_AUTO;
    if (any && desc->window) {
        ways[count++] = KD_CONTEXT_GLFW;
    } else if (any || desc->api == KD_CONTEXT_EGL) {
        ways[count++] = KD_CONTEXT_EGL_DEVICE;
        ways[count++] = KD_CONTEXT_EGL_SURFACELESS;
        ways[count++] = KD_CONTEXT_EGL_SOFTWARE;
        if (any)
            ways[count++] = KD_CONTEXT_OSMESA;
    } else {
        ways[count++] = desc->api;
    }
    return count;
}

kd_status kd_gpu_open(const kd_gpu_desc *desc, kd_gpu **out)
{
    assert(desc && out && (unsigned)desc->api < KD_CONTEXT_API_COUNT);
    kd_context_api ways[KD_CONTEXT_API_COUNT];
    char tried[1600] = "";
    size_t used = 0;
    *out = NULL;
    if (desc->window && desc->api != KD_CONTEXT_AUTO && desc->api != KD_CONTEXT_GLFW)
        return kd_fail(KD_NO_CONTEXT, "a window needs a GLFW context, not %s; drop one of the two",
                       kd_context_api_name(desc->api));
    uint32_t count = list_ways(desc, ways);
    for (uint32_t i = 0; i < count; i++) {
        gpu_reason reason = {""};
        kd_status status = gpu_open_one(desc, ways[i], out, &reason);
        if (status == KD_OK)
            return KD_OK;
        if (status == KD_NO_MEMORY)
            return kd_fail(status, "no memory for a GPU device");
        int length = snprintf(tried + used, sizeof tried - used, "%s%s: %s", i ? ", " : "",
                              kd_context_api_name(ways[i]), reason.text);
        used += length > 0 && (size_t)length < sizeof tried - used ? (size_t)length : 0;
    }
    return kd_fail(
        KD_NO_CONTEXT,
        "no usable OpenGL 4.5 context (%s); install a driver such as Mesa's, and see `kandil doctor`", tried);
}

static void delete_objects(kd_gpu *gpu)
{
    for (uint32_t id = 0; (id = gpu_pool_next(&gpu->readbacks, id)) != 0;)
        gpu_release_readback(gpu, gpu_pool_find(&gpu->readbacks, id));
    for (uint32_t id = 0; (id = gpu_pool_next(&gpu->targets, id)) != 0;)
        kd_gpu_destroy_target(gpu, (kd_gpu_target){id});
    for (uint32_t id = 0; (id = gpu_pool_next(&gpu->programs, id)) != 0;)
        kd_gpu_destroy_program(gpu, (kd_gpu_program){id});
    for (uint32_t id = 0; (id = gpu_pool_next(&gpu->textures, id)) != 0;)
        kd_gpu_destroy_texture(gpu, (kd_gpu_texture){id});
    for (uint32_t id = 0; (id = gpu_pool_next(&gpu->buffers, id)) != 0;)
        kd_gpu_destroy_buffer(gpu, (kd_gpu_buffer){id});
    gpu_uniforms_fini(gpu);
    gpu_timers_fini(gpu);
    gpu->gl.DeleteFramebuffers(1, &gpu->blit_framebuffer);
    gpu->gl.DeleteVertexArrays(1, &gpu->vao);
    gpu->gl.DeleteVertexArrays(1, &gpu->empty_vao);
    if (gpu->debug)
        gpu->gl.DebugMessageCallback(NULL, NULL);
}

void kd_gpu_close(kd_gpu *gpu)
{
    if (!gpu)
        return;
    /* Another device may be current: its objects have the same numbers. */
    if (gpu->context.make_current(&gpu->context, true))
        delete_objects(gpu);
    gpu->context.close(&gpu->context);
    gpu_pool_fini(&gpu->readbacks);
    gpu_pool_fini(&gpu->targets);
    gpu_pool_fini(&gpu->programs);
    gpu_pool_fini(&gpu->textures);
    gpu_pool_fini(&gpu->buffers);
    free(gpu);
}

bool kd_gpu_make_current(kd_gpu *gpu, bool on)
{
    if (gpu->context.make_current(&gpu->context, on))
        return true;
    gpu_complain(gpu, "the %s context cannot be made current; another thread may have it", gpu->info.api);
    return false;
}

const kd_gpu_info *kd_gpu_get_info(const kd_gpu *gpu)
{
    return &gpu->info;
}

size_t kd_gpu_bytes(const kd_gpu *gpu)
{
    return gpu->bytes;
}

bool kd_gpu_failed(const kd_gpu *gpu)
{
    return gpu->failed;
}

void kd_gpu_forgive(kd_gpu *gpu)
{
    gpu->failed = false;
}

uint64_t kd_gpu_frame(const kd_gpu *gpu)
{
    return gpu->frame;
}

const char *kd_context_api_name(kd_context_api api)
{
    static const char *const names[KD_CONTEXT_API_COUNT] = {
        [KD_CONTEXT_AUTO] = "auto",
        [KD_CONTEXT_GLFW] = "glfw",
        [KD_CONTEXT_EGL] = "egl",
        [KD_CONTEXT_EGL_DEVICE] = "egl-device",
        [KD_CONTEXT_EGL_SURFACELESS] = "egl-surfaceless",
        [KD_CONTEXT_EGL_SOFTWARE] = "egl-software",
        [KD_CONTEXT_OSMESA] = "osmesa",
    };
    return (unsigned)api < KD_CONTEXT_API_COUNT ? names[api] : "unknown";
}
