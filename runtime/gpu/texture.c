/* Textures with immutable storage, and views of buffers as texel buffers. Rows are packed without padding. */

#include <assert.h>
#include <string.h>

#include "runtime/gpu/internal.h"

/* Columns: GL's sized format, client format and type, bytes a texel, then what it is and where it may be
 * bound. */
static const gpu_format formats[KD_TEXTURE_FORMAT_COUNT] = {
    [KD_RGBA8] = {GL_RGBA8, GL_RGBA, GL_UNSIGNED_BYTE, 4, 0, 0, 1, 1, "RGBA8"},
    [KD_SRGBA8] = {GL_SRGB8_ALPHA8, GL_RGBA, GL_UNSIGNED_BYTE, 4, 0, 0, 0, 0, "SRGBA8"},
    [KD_RGBA16F] = {GL_RGBA16F, GL_RGBA, GL_HALF_FLOAT, 8, 0, 0, 1, 1, "RGBA16F"},
    [KD_RGBA32F] = {GL_RGBA32F, GL_RGBA, GL_FLOAT, 16, 0, 0, 1, 1, "RGBA32F"},
    [KD_R11G11B10F] = {GL_R11F_G11F_B10F, GL_RGB, GL_UNSIGNED_INT_10F_11F_11F_REV, 4, 0, 0, 1, 0,
                       "R11G11B10F"},
    [KD_R32UI] = {GL_R32UI, GL_RED_INTEGER, GL_UNSIGNED_INT, 4, 1, 0, 1, 1, "R32UI"},
    [KD_RG32UI] = {GL_RG32UI, GL_RG_INTEGER, GL_UNSIGNED_INT, 8, 1, 0, 1, 1, "RG32UI"},
    [KD_RGBA32UI] = {GL_RGBA32UI, GL_RGBA_INTEGER, GL_UNSIGNED_INT, 16, 1, 0, 1, 1, "RGBA32UI"},
    [KD_R32F] = {GL_R32F, GL_RED, GL_FLOAT, 4, 0, 0, 1, 1, "R32F"},
    [KD_RG16F] = {GL_RG16F, GL_RG, GL_HALF_FLOAT, 4, 0, 0, 1, 1, "RG16F"},
    [KD_R16F] = {GL_R16F, GL_RED, GL_HALF_FLOAT, 2, 0, 0, 1, 1, "R16F"},
    [KD_RGB10A2] = {GL_RGB10_A2, GL_RGBA, GL_UNSIGNED_INT_2_10_10_10_REV, 4, 0, 0, 1, 0, "RGB10A2"},
    [KD_R8] = {GL_R8, GL_RED, GL_UNSIGNED_BYTE, 1, 0, 0, 1, 1, "R8"},
    [KD_RG8] = {GL_RG8, GL_RG, GL_UNSIGNED_BYTE, 2, 0, 0, 1, 1, "RG8"},
    [KD_DEPTH32F] = {GL_DEPTH_COMPONENT32F, GL_DEPTH_COMPONENT, GL_FLOAT, 4, 0, 1, 0, 0, "DEPTH32F"},
    [KD_DEPTH24] = {GL_DEPTH_COMPONENT24, GL_DEPTH_COMPONENT, GL_UNSIGNED_INT, 4, 0, 1, 0, 0, "DEPTH24"},
    [KD_RGBA16UI] = {GL_RGBA16UI, GL_RGBA_INTEGER, GL_UNSIGNED_SHORT, 8, 1, 0, 1, 1, "RGBA16UI"},
    [KD_R8UI] = {GL_R8UI, GL_RED_INTEGER, GL_UNSIGNED_BYTE, 1, 1, 0, 1, 1, "R8UI"},
    [KD_RG16UI] = {GL_RG16UI, GL_RG_INTEGER, GL_UNSIGNED_SHORT, 4, 1, 0, 1, 1, "RG16UI"},
    [KD_R16UI] = {GL_R16UI, GL_RED_INTEGER, GL_UNSIGNED_SHORT, 2, 1, 0, 1, 1, "R16UI"},
    [KD_RGB9E5] = {GL_RGB9_E5, GL_RGB, GL_UNSIGNED_INT_5_9_9_9_REV, 4, 0, 0, 0, 0, "RGB9E5"},
};

const gpu_format *gpu_get_format(kd_texture_format format)
{
    assert((unsigned)format < KD_TEXTURE_FORMAT_COUNT);
    return &formats[format];
}

uint32_t gpu_level_size(uint32_t size, uint32_t level)
{
    uint32_t small = level < 32 ? size >> level : 0;
    return small ? small : 1;
}

static uint32_t level_depth(const gpu_texture *texture, uint32_t level)
{
    return texture->kind == KD_TEXTURE_3D ? gpu_level_size(texture->depth, level) : texture->depth;
}

size_t gpu_level_bytes(const gpu_texture *texture, uint32_t level)
{
    return (size_t)gpu_level_size(texture->width, level) * gpu_level_size(texture->height, level) *
           level_depth(texture, level) * gpu_get_format(texture->format)->texel_bytes;
}

static uint32_t full_chain(const gpu_texture *texture)
{
    uint32_t size = texture->width > texture->height ? texture->width : texture->height;
    uint32_t levels = 1;
    if (texture->kind == KD_TEXTURE_3D && texture->depth > size)
        size = texture->depth;
    while (size >>= 1)
        levels++;
    return levels;
}

/* Resolve the defaults of a desc. */
static gpu_texture describe(const kd_gpu_texture_desc *desc)
{
    static const GLenum targets[] = {GL_TEXTURE_2D, GL_TEXTURE_2D_ARRAY, GL_TEXTURE_3D, GL_TEXTURE_CUBE_MAP};
    gpu_texture texture = {.target = targets[desc->kind],
                           .kind = desc->kind,
                           .format = desc->format,
                           .width = desc->width ? desc->width : 1,
                           .height = desc->height ? desc->height : 1,
                           .depth = desc->depth ? desc->depth : 1,
                           .levels = desc->levels ? desc->levels : 1};
    if (desc->kind == KD_TEXTURE_2D)
        texture.depth = 1;
    if (desc->kind == KD_TEXTURE_CUBE)
        texture.depth = 6;
    if (desc->levels == UINT32_MAX)
        texture.levels = full_chain(&texture);
    gpu_copy_name(texture.name, desc->name, "texture");
    return texture;
}

/* Returns what is wrong, or NULL. */
static const char *check(const kd_gpu *gpu, const gpu_texture *texture)
{
    uint32_t side = (uint32_t)gpu->max_texture_2d, depth = (uint32_t)gpu->max_layers;
    if (texture->kind == KD_TEXTURE_3D)
        side = depth = (uint32_t)gpu->info.max_texture_3d;
    if (texture->kind == KD_TEXTURE_CUBE)
        side = (uint32_t)gpu->max_cube;
    if (texture->width > side || texture->height > side || texture->depth > depth)
        return "it is larger than the driver's limit";
    if (texture->kind == KD_TEXTURE_CUBE && texture->width != texture->height)
        return "the faces of a cube must be square";
    if (texture->levels > full_chain(texture))
        return "it has more levels than its size allows";
    return NULL;
}

static GLint wrap_mode(kd_wrap wrap)
{
    static const GLint modes[] = {GL_CLAMP_TO_EDGE, GL_REPEAT, GL_MIRRORED_REPEAT, GL_CLAMP_TO_BORDER};
    return modes[wrap];
}

/* Times that a footprint may be longer than wide before its pattern is blurred. */
#define MOST_ANISOTROPY 8

static void set_sampling(kd_gpu *gpu, const gpu_texture *texture, const kd_gpu_texture_desc *desc)
{
    static const GLfloat one[4] = {1, 1, 1, 1};
    const gl_table *gl = &gpu->gl;
    /* GL does not filter integers: a linear filter would make the texture incomplete. */
    bool nearest = desc->filter == KD_NEAREST || gpu_get_format(texture->format)->is_uint;
    bool mips = texture->levels > 1;
    /* Without MIPMAP in its name a filter ignores the level that textureLod asks for. */
    GLint min = nearest ? (mips ? GL_NEAREST_MIPMAP_NEAREST : GL_NEAREST)
                        : (mips ? GL_LINEAR_MIPMAP_NEAREST : GL_LINEAR);
    if (!nearest && mips && desc->filter == KD_LINEAR_MIP)
        min = GL_LINEAR_MIPMAP_LINEAR;
    if (min == GL_LINEAR_MIPMAP_LINEAR && gpu->max_anisotropy > 1)
        gl->TextureParameteri(texture->gl, GL_TEXTURE_MAX_ANISOTROPY,
                              gpu->max_anisotropy < MOST_ANISOTROPY ? gpu->max_anisotropy : MOST_ANISOTROPY);
    gl->TextureParameteri(texture->gl, GL_TEXTURE_MIN_FILTER, min);
    gl->TextureParameteri(texture->gl, GL_TEXTURE_MAG_FILTER, nearest ? GL_NEAREST : GL_LINEAR);
    gl->TextureParameteri(texture->gl, GL_TEXTURE_WRAP_S, wrap_mode(desc->wrap_s));
    gl->TextureParameteri(texture->gl, GL_TEXTURE_WRAP_T, wrap_mode(desc->wrap_t));
    gl->TextureParameteri(texture->gl, GL_TEXTURE_WRAP_R, wrap_mode(desc->wrap_r));
    gl->TextureParameterfv(texture->gl, GL_TEXTURE_BORDER_COLOR, one);
    if (desc->filter == KD_SHADOW) {
        gl->TextureParameteri(texture->gl, GL_TEXTURE_COMPARE_MODE, GL_COMPARE_REF_TO_TEXTURE);
        gl->TextureParameteri(texture->gl, GL_TEXTURE_COMPARE_FUNC, GL_LEQUAL);
    }
}

static void upload(kd_gpu *gpu, const gpu_texture *texture, uint32_t level, uint32_t layer, uint32_t layers,
                   const void *data)
{
    const gpu_format *format = gpu_get_format(texture->format);
    GLsizei width = (GLsizei)gpu_level_size(texture->width, level);
    GLsizei height = (GLsizei)gpu_level_size(texture->height, level);
    if (texture->kind == KD_TEXTURE_2D)
        gpu->gl.TextureSubImage2D(texture->gl, (GLint)level, 0, 0, width, height, format->format,
                                  format->type, data);
    else
        gpu->gl.TextureSubImage3D(texture->gl, (GLint)level, 0, 0, (GLint)layer, width, height,
                                  (GLsizei)layers, format->format, format->type, data);
}

static bool allocate(kd_gpu *gpu, gpu_texture *texture)
{
    const gpu_format *format = gpu_get_format(texture->format);
    GLsizei levels = (GLsizei)texture->levels, width = (GLsizei)texture->width,
            height = (GLsizei)texture->height;
    gpu_drain_errors(gpu);
    gpu->gl.CreateTextures(texture->target, 1, &texture->gl);
    if (texture->kind == KD_TEXTURE_2D || texture->kind == KD_TEXTURE_CUBE)
        gpu->gl.TextureStorage2D(texture->gl, levels, format->internal, width, height);
    else
        gpu->gl.TextureStorage3D(texture->gl, levels, format->internal, width, height,
                                 (GLsizei)texture->depth);
    if (gpu->gl.GetError() == GL_NO_ERROR)
        return true;
    gpu->gl.DeleteTextures(1, &texture->gl);
    return false;
}

/* Put a texture that GL has into the pool. */
static kd_gpu_texture keep(kd_gpu *gpu, const gpu_texture *texture)
{
    gpu_texture *kept;
    uint32_t id = gpu_pool_add(&gpu->textures, (void **)&kept);
    if (!id) {
        gpu->gl.DeleteTextures(1, &texture->gl);
        gpu_fail(gpu, "texture %s: no memory for its handle", texture->name);
        return (kd_gpu_texture){0};
    }
    *kept = *texture;
    gpu->bytes += texture->bytes;
    gpu_label(gpu, GL_TEXTURE, texture->gl, texture->name);
    return (kd_gpu_texture){id};
}

kd_gpu_texture kd_gpu_make_texture(kd_gpu *gpu, const kd_gpu_texture_desc *desc)
{
    assert(gpu && desc && desc->kind <= KD_TEXTURE_CUBE);
    gpu_texture texture = describe(desc);
    const char *wrong = check(gpu, &texture);
    for (uint32_t level = 0; !wrong && level < texture.levels; level++)
        texture.bytes += gpu_level_bytes(&texture, level);
    if (!wrong && !allocate(gpu, &texture))
        wrong = "the driver refused it";
    if (wrong) {
        gpu_fail(gpu, "texture %s: %s (%s, %u x %u x %u, %u levels, %zu bytes); ask for less", texture.name,
                 wrong, gpu_get_format(desc->format)->name, texture.width, texture.height, texture.depth,
                 texture.levels, texture.bytes);
        return (kd_gpu_texture){0};
    }
    set_sampling(gpu, &texture, desc);
    if (desc->data)
        upload(gpu, &texture, 0, 0, texture.depth, desc->data);
    if (desc->data && desc->generate_mips && texture.levels > 1)
        gpu->gl.GenerateTextureMipmap(texture.gl);
    return keep(gpu, &texture);
}

kd_gpu_texture kd_gpu_make_texture_view(kd_gpu *gpu, kd_gpu_texture of, const kd_gpu_texture_desc *desc)
{
    const gpu_texture *source = gpu_get_texture(gpu, of, "make_texture_view");
    const gpu_format *row = gpu_get_format(desc->format);
    if (!source)
        return (kd_gpu_texture){0};
    gpu_texture view = *source;
    view.format = desc->format;
    view.bytes = 0;
    gpu_copy_name(view.name, desc->name, "texture view");
    uint32_t layers = view.kind == KD_TEXTURE_3D ? 1 : view.depth;
    gpu_drain_errors(gpu);
    gpu->gl.GenTextures(1, &view.gl); /* a name alone: TextureView gives it its target */
    gpu->gl.TextureView(view.gl, view.target, source->gl, row->internal, 0, view.levels, 0, layers);
    if (gpu->gl.GetError() != GL_NO_ERROR) {
        gpu->gl.DeleteTextures(1, &view.gl);
        gpu_fail(gpu, "texture %s: the driver does not show %s as %s", view.name,
                 gpu_get_format(source->format)->name, row->name);
        return (kd_gpu_texture){0};
    }
    set_sampling(gpu, &view, desc);
    return keep(gpu, &view);
}

kd_gpu_texture kd_gpu_make_texel_buffer(kd_gpu *gpu, kd_gpu_buffer handle, kd_texture_format format)
{
    gpu_buffer *buffer = gpu_get_buffer(gpu, handle, "make_texel_buffer");
    const gpu_format *row = gpu_get_format(format);
    if (!buffer)
        return (kd_gpu_texture){0};
    if (!row->is_texel_buffer || (int64_t)(buffer->size / row->texel_bytes) > gpu->info.max_texels) {
        gpu_fail(gpu, "texel buffer %s: %s of %zu bytes (the limit is %lld texels)", buffer->name, row->name,
                 buffer->size, (long long)gpu->info.max_texels);
        return (kd_gpu_texture){0};
    }
    gpu_texture texture = {.target = GL_TEXTURE_BUFFER,
                           .format = format,
                           .width = (uint32_t)(buffer->size / row->texel_bytes),
                           .height = 1,
                           .depth = 1,
                           .levels = 1};
    gpu_copy_name(texture.name, buffer->name, "texel buffer");
    gpu->gl.CreateTextures(GL_TEXTURE_BUFFER, 1, &texture.gl);
    gpu->gl.TextureBuffer(texture.gl, row->internal, buffer->gl);
    return keep(gpu, &texture);
}

void kd_gpu_destroy_texture(kd_gpu *gpu, kd_gpu_texture handle)
{
    gpu_texture *texture = handle.id ? gpu_get_texture(gpu, handle, "destroy_texture") : NULL;
    if (!texture)
        return;
    for (uint32_t i = 0; i < GPU_MAX_TEXTURES; i++)
        if (gpu->texture_units[i] == handle.id)
            gpu->texture_units[i] = 0;
    gpu->bytes -= texture->bytes;
    gpu->gl.DeleteTextures(1, &texture->gl);
    gpu_pool_remove(&gpu->textures, handle.id);
}

/* Find a texture with storage of its own and such a level, or complain. */
static gpu_texture *get_level(kd_gpu *gpu, kd_gpu_texture handle, uint32_t level, const char *call)
{
    gpu_texture *texture = gpu_get_texture(gpu, handle, call);
    if (texture && (texture->target == GL_TEXTURE_BUFFER || level >= texture->levels)) {
        gpu_complain(gpu, "%s: texture %s has no level %u", call, texture->name, level);
        return NULL;
    }
    return texture;
}

void kd_gpu_write_texture(kd_gpu *gpu, kd_gpu_texture handle, uint32_t level, uint32_t layer,
                          const void *data, size_t size)
{
    gpu_texture *texture = get_level(gpu, handle, level, "write_texture");
    if (!texture)
        return;
    size_t layer_bytes = gpu_level_bytes(texture, level) / level_depth(texture, level);
    size_t layers = size / layer_bytes;
    if (!layers || size % layer_bytes || layer >= level_depth(texture, level) ||
        layers > level_depth(texture, level) - layer) {
        gpu_complain(gpu, "write_texture: %zu bytes from layer %u do not fit texture %s (%zu bytes a layer)",
                     size, layer, texture->name, layer_bytes);
        return;
    }
    upload(gpu, texture, level, layer, (uint32_t)layers, data);
}

void kd_gpu_clear_texture(kd_gpu *gpu, kd_gpu_texture handle, uint32_t level, const void *texel)
{
    gpu_texture *texture = get_level(gpu, handle, level, "clear_texture");
    if (!texture)
        return;
    const gpu_format *format = gpu_get_format(texture->format);
    gpu->gl.ClearTexImage(texture->gl, (GLint)level, format->format, format->type, texel);
}

void kd_gpu_copy_texture(kd_gpu *gpu, kd_gpu_texture from_handle, uint32_t from_layer,
                         kd_gpu_texture to_handle, uint32_t to_layer, uint32_t level)
{
    const gpu_texture *from = get_level(gpu, from_handle, level, "copy_texture");
    const gpu_texture *to = get_level(gpu, to_handle, level, "copy_texture");
    if (!from || !to)
        return;
    uint32_t width = gpu_level_size(from->width, level), height = gpu_level_size(from->height, level);
    if (from->format != to->format || from_layer >= level_depth(from, level) ||
        to_layer >= level_depth(to, level) || width != gpu_level_size(to->width, level) ||
        height != gpu_level_size(to->height, level)) {
        gpu_complain(gpu, "copy_texture: layer %u of %s does not fit layer %u of %s", from_layer, from->name,
                     to_layer, to->name);
        return;
    }
    gpu->gl.CopyImageSubData(from->gl, from->target, (GLint)level, 0, 0, (GLint)from_layer, to->gl,
                             to->target, (GLint)level, 0, 0, (GLint)to_layer, (GLsizei)width, (GLsizei)height,
                             1);
}

void kd_gpu_read_texture(kd_gpu *gpu, kd_gpu_texture handle, uint32_t level, void *out, size_t size)
{
    gpu_texture *texture = get_level(gpu, handle, level, "read_texture");
    if (!texture || size < gpu_level_bytes(texture, level)) {
        if (texture)
            gpu_complain(gpu, "read_texture: level %u of %s holds %zu bytes, there is room for %zu", level,
                         texture->name, gpu_level_bytes(texture, level), size);
        memset(out, 0, size);
        return;
    }
    const gpu_format *format = gpu_get_format(texture->format);
    gpu->gl.MemoryBarrier(GL_TEXTURE_UPDATE_BARRIER_BIT);
    gpu->gl.GetTextureImage(texture->gl, (GLint)level, format->format, format->type,
                            (GLsizei)(size < INT32_MAX ? size : INT32_MAX), out);
}
