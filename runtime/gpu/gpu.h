#ifndef KD_GPU_GPU_H
#define KD_GPU_GPU_H

/* Buffers, textures, programs and passes over one OpenGL 4.5 core context.
 *
 * Five verbs: a desc starts as {0} where zero is the default; kd_gpu_make_* returns a handle (id 0 when it
 * failed, the reason logged), which may be used in frame code all the same: commands with a failed handle do
 * nothing and count as a failure that kd_gpu_failed() reports. Threading: all of it on the thread that made
 * the context current (the GPU lane). */

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "runtime/core/status.h"

typedef struct kd_gpu kd_gpu;
typedef struct kd_gpu_buffer {
    uint32_t id;
} kd_gpu_buffer;
typedef struct kd_gpu_texture {
    uint32_t id;
} kd_gpu_texture;
typedef struct kd_gpu_program {
    uint32_t id;
} kd_gpu_program;
typedef struct kd_gpu_target {
    uint32_t id;
} kd_gpu_target; /* framebuffer */
typedef struct kd_gpu_readback {
    uint32_t id;
} kd_gpu_readback;

/* ---- contexts ---- */
typedef enum kd_context_api {
    KD_CONTEXT_AUTO, /* window if asked for, else EGL device (GPU first), EGL surfaceless, EGL software
                        device, OSMesa */
    KD_CONTEXT_GLFW,
    KD_CONTEXT_EGL,        /* any of the three below, in this order */
    KD_CONTEXT_EGL_DEVICE, /* a hardware device */
    KD_CONTEXT_EGL_SURFACELESS,
    KD_CONTEXT_EGL_SOFTWARE, /* the software device */
    KD_CONTEXT_OSMESA,
    KD_CONTEXT_API_COUNT
} kd_context_api;

typedef struct kd_gpu_desc {
    kd_context_api api;
    bool window;                              /* a visible GLFW window */
    uint32_t width, height;                   /* of the window; 0 means 1280x720 */
    const char *title;                        /* NULL means "Kandil" */
    bool debug;                               /* GL debug output: errors are logged and counted as failures */
    const struct kd_embedded_shader *shaders; /* more than the build's (runtime/gpu/embedded.h), ended by an
                                                 empty row; must outlive the context. NULL: none */
} kd_gpu_desc;

/** Open a context, load GL and make it current on this thread. Errors KD_NO_CONTEXT, each way tried logged
 * with its reason. */
kd_status kd_gpu_open(const kd_gpu_desc *desc, kd_gpu **out);
void kd_gpu_close(kd_gpu *gpu);
/** Make the context current on this thread, or let it go from it (on false), so that another thread can take
 * it. Returns false when the library refuses, as while another thread has it. */
bool kd_gpu_make_current(kd_gpu *gpu, bool on);

typedef struct kd_gpu_info {
    const char *api; /* "egl-device", "egl-surfaceless", "egl-software", "osmesa", "glfw" */
    const char *renderer, *vendor, *version;
    bool software; /* llvmpipe, softpipe, swrast: timers lie, profile by finishing */
    int64_t max_ssbo_bytes;
    int64_t max_texels; /* of a buffer that is read as texels */
    int max_shared_bytes, max_invocations, max_texture_3d;
    int timestamp_bits;
    int storage_alignment, uniform_alignment; /* bytes; offsets of ranges that are bound must be multiples */
} kd_gpu_info;
const kd_gpu_info *kd_gpu_get_info(const kd_gpu *gpu);
size_t kd_gpu_bytes(const kd_gpu *gpu); /* buffers and textures alive */
/** What the objects of one name hold. */
typedef struct kd_gpu_memory_row {
    const char *name; /* valid until an object is made or destroyed */
    size_t bytes;
    uint32_t count;
} kd_gpu_memory_row;
/** List memory by name, largest first. Returns rows written. */
uint32_t kd_gpu_memory(const kd_gpu *gpu, kd_gpu_memory_row *rows, uint32_t capacity);
bool kd_gpu_failed(
    const kd_gpu *gpu); /* something has failed since the context was opened (and was logged) */

/** Forget what has failed: what it failed for was given up, and all else goes on. */
void kd_gpu_forgive(kd_gpu *gpu);

/* ---- buffers ---- */
typedef enum kd_buffer_usage {
    KD_BUFFER_STATIC, /* written once or by shaders */
    KD_BUFFER_STREAM, /* written by the CPU every frame through kd_gpu_write_buffer */
} kd_buffer_usage;
typedef struct kd_gpu_buffer_desc {
    size_t size;      /* bytes; must not be 0 */
    const void *data; /* NULL: contents undefined unless zeroed */
    bool zeroed;
    kd_buffer_usage usage;
    const char *name; /* for messages and memory statistics */
} kd_gpu_buffer_desc;
kd_gpu_buffer kd_gpu_make_buffer(kd_gpu *gpu, const kd_gpu_buffer_desc *desc);
void kd_gpu_destroy_buffer(kd_gpu *gpu, kd_gpu_buffer buffer); /* id 0 does nothing */
size_t kd_gpu_buffer_size(const kd_gpu *gpu, kd_gpu_buffer buffer);
void kd_gpu_write_buffer(kd_gpu *gpu, kd_gpu_buffer buffer, size_t offset, const void *data, size_t size);
void kd_gpu_fill_buffer(kd_gpu *gpu, kd_gpu_buffer buffer, size_t offset, size_t size,
                        uint32_t word); /* size % 4 == 0 */
void kd_gpu_copy_buffer(kd_gpu *gpu, kd_gpu_buffer from, size_t from_offset, kd_gpu_buffer to,
                        size_t to_offset, size_t size);
/** Read now; stalls until the GPU is done: for loading and tests, not for frames. */
void kd_gpu_read_buffer(kd_gpu *gpu, kd_gpu_buffer buffer, size_t offset, void *out, size_t size);
/** Grow: make a new buffer of at least `size` when the old one is smaller, copying `keep` bytes. */
kd_status kd_gpu_ensure_buffer(kd_gpu *gpu, kd_gpu_buffer *buffer, size_t size, size_t keep,
                               const char *name);

/* ---- textures ---- */
typedef enum kd_texture_kind {
    KD_TEXTURE_2D,
    KD_TEXTURE_2D_ARRAY,
    KD_TEXTURE_3D,
    KD_TEXTURE_CUBE
} kd_texture_kind;
typedef enum kd_texture_format {
    KD_RGBA8,
    KD_SRGBA8,
    KD_RGBA16F,
    KD_RGBA32F,
    KD_R11G11B10F,
    KD_R32UI,
    KD_RG32UI,
    KD_RGBA32UI,
    KD_R32F,
    KD_RG16F,
    KD_R16F,
    KD_RGB10A2,
    KD_R8,
    KD_RG8,
    KD_DEPTH32F,
    KD_DEPTH24,
    KD_RGBA16UI,
    KD_R8UI,
    KD_RG16UI,
    KD_R16UI,
    KD_RGB9E5, /* 9 bits a channel under a shared power of two; no image: write it through a view as KD_R32UI
                */
    KD_TEXTURE_FORMAT_COUNT
} kd_texture_format;
typedef enum kd_filter {
    KD_LINEAR,
    KD_NEAREST,
    KD_LINEAR_MIP, /* between levels too, along long footprints where the driver can */
    KD_SHADOW      /* linear with depth compare <= */
} kd_filter;
typedef enum kd_wrap { KD_CLAMP, KD_REPEAT, KD_MIRROR, KD_BORDER_ONE } kd_wrap;
typedef struct kd_gpu_texture_desc {
    kd_texture_kind kind;
    kd_texture_format format;
    uint32_t width, height, depth; /* depth: layers of an array, slices of a 3D texture; 0 means 1 */
    uint32_t levels;               /* 0 means 1; UINT32_MAX: the full chain */
    kd_filter filter;
    kd_wrap wrap_s, wrap_t, wrap_r;
    const void *data; /* level 0 in the format's natural layout, or NULL */
    bool generate_mips;
    const char *name;
} kd_gpu_texture_desc;
kd_gpu_texture kd_gpu_make_texture(kd_gpu *gpu, const kd_gpu_texture_desc *desc);
/** See what a texture holds in another format of as many bytes a texel. Of the desc format, filter, wrap_*
 * and name count. The view holds no memory; destroy it before the texture. */
kd_gpu_texture kd_gpu_make_texture_view(kd_gpu *gpu, kd_gpu_texture of, const kd_gpu_texture_desc *desc);
void kd_gpu_destroy_texture(kd_gpu *gpu, kd_gpu_texture texture);
void kd_gpu_write_texture(kd_gpu *gpu, kd_gpu_texture texture, uint32_t level, uint32_t layer,
                          const void *data, size_t size);
void kd_gpu_clear_texture(kd_gpu *gpu, kd_gpu_texture texture, uint32_t level,
                          const void *texel); /* NULL: zeros */
/** Copy one layer (slice, face; 0 of a 2D texture) of a level between textures of one format; the level has
 * one size in both. */
void kd_gpu_copy_texture(kd_gpu *gpu, kd_gpu_texture from, uint32_t from_layer, kd_gpu_texture to,
                         uint32_t to_layer, uint32_t level);
void kd_gpu_read_texture(kd_gpu *gpu, kd_gpu_texture texture, uint32_t level, void *out,
                         size_t size); /* stalls */
/** View a buffer as a texel buffer (samplerBuffer and kin). Bound with kd_gpu_bind_texture. */
kd_gpu_texture kd_gpu_make_texel_buffer(kd_gpu *gpu, kd_gpu_buffer buffer, kd_texture_format format);

/* ---- programs ---- */
typedef struct kd_gpu_program_desc {
    const char *compute;           /* path of the shader from the root: "shaders/svo/filter.comp" */
    const char *vertex, *fragment; /* or these two; fragment may be NULL for depth only */
    const char *geometry;          /* or NULL */
    const char *const *defines;    /* NULL-terminated "NAME value" strings, or NULL */
    const char *name;              /* NULL: the path */
} kd_gpu_program_desc;
/** Compile and link. `#include "shaders/…"` is resolved (once a file); messages read FILE:LINE of the GLSL
 * source. Sources come from the folder in KANDIL_SHADER_DIR when that is set, else from inside the program.
 */
kd_gpu_program kd_gpu_make_program(kd_gpu *gpu, const kd_gpu_program_desc *desc);
void kd_gpu_destroy_program(kd_gpu *gpu, kd_gpu_program program);
/** Compile every program anew whose source has changed: for whoever edits shaders. Handles stay; a program
 * that does not compile stays what it was, and that counts as no failure of the GPU. changed  called with the
 * path of each that was changed (of its fragment shader when it draws), may be NULL. *count  of these Errors
 * GPU when one could not be made; each is logged */
kd_status kd_gpu_reload_programs(kd_gpu *gpu, void (*changed)(void *user, const char *path), void *user,
                                 uint32_t *count);

/* ---- render targets ---- */
#define KD_MAX_COLOR_TARGETS 8
#define KD_ALL_LAYERS        UINT32_MAX /* a layer: all of them, a geometry shader picks by gl_Layer */
typedef struct kd_gpu_target_desc {
    kd_gpu_texture color[KD_MAX_COLOR_TARGETS]; /* id 0 ends the list */
    kd_gpu_texture depth;                       /* id 0: none */
    uint32_t layer;                             /* of array or cube textures (face); applies to all */
    uint32_t level;
    const char *name;
    uint32_t width, height; /* of a target without textures, which only rasterizes; else unused */
} kd_gpu_target_desc;
kd_gpu_target kd_gpu_make_target(kd_gpu *gpu, const kd_gpu_target_desc *desc);
void kd_gpu_destroy_target(kd_gpu *gpu, kd_gpu_target target);

/* ---- passes ---- */
/** Bind a whole buffer. What cannot be bound (a failed handle, more than max_ssbo_bytes) leaves the binding
 * empty, and dispatches and draws of programs that use it do nothing until it is bound again. */
void kd_gpu_bind_storage(kd_gpu *gpu, uint32_t binding, kd_gpu_buffer buffer);
void kd_gpu_bind_storage_range(kd_gpu *gpu, uint32_t binding, kd_gpu_buffer buffer, size_t offset,
                               size_t size);
/** Copy `size` bytes into a ring and bind them as uniform block `binding` for the draws and dispatches that
 * follow in this frame. */
void kd_gpu_bind_uniform(kd_gpu *gpu, uint32_t binding, const void *data, size_t size);
void kd_gpu_bind_uniform_buffer(kd_gpu *gpu, uint32_t binding, kd_gpu_buffer buffer, size_t offset,
                                size_t size);
void kd_gpu_bind_texture(kd_gpu *gpu, uint32_t unit, kd_gpu_texture texture);
typedef enum kd_image_access { KD_IMAGE_READ, KD_IMAGE_WRITE, KD_IMAGE_READ_WRITE } kd_image_access;
/** Bind all layers of a level. `format` may reinterpret texels of equal size; pass the texture's own
 * otherwise. */
void kd_gpu_bind_image(kd_gpu *gpu, uint32_t unit, kd_gpu_texture texture, uint32_t level,
                       kd_image_access access, kd_texture_format format);
void kd_gpu_dispatch(kd_gpu *gpu, kd_gpu_program program, uint32_t x, uint32_t y,
                     uint32_t z); /* groups; 0 does nothing */
/** Dispatch any number of groups in rows over x and y; the shader takes linear_index() of
 * shaders/include/linear.glsl and leaves out indices beyond its count: the last row may be longer. */
void kd_gpu_dispatch_linear(kd_gpu *gpu, kd_gpu_program program, uint32_t groups);
void kd_gpu_dispatch_indirect(kd_gpu *gpu, kd_gpu_program program, kd_gpu_buffer args, size_t offset);

typedef enum kd_cull { KD_CULL_BACK, KD_CULL_NONE, KD_CULL_FRONT } kd_cull;
typedef enum kd_blend {
    KD_BLEND_NONE,
    KD_BLEND_ALPHA,
    KD_BLEND_ADD,
    KD_BLEND_TINT /* target 0: colour + (1 - alpha) * what is there; target 1: the same, each colour its own
                     alpha */
} kd_blend;
typedef struct kd_gpu_raster {
    kd_gpu_target target;         /* id 0: the window */
    uint32_t x, y, width, height; /* rectangle drawn to and cleared; width or height 0: the target's own */
    bool depth_test, depth_write, depth_equal; /* less-or-equal test; depth_equal: equal test */
    kd_cull cull;
    kd_blend blend;
    bool depth_clamp;
    float depth_bias_slope, depth_bias_constant;
    bool clear_color, clear_depth;
    float color[4]; /* clear colour of every colour target; integer targets take it converted */
} kd_gpu_raster;
/** Bind a target and its state, clearing the rectangle as asked. Writes to KD_SRGBA8 are encoded from linear
 * values. */
void kd_gpu_begin_raster(kd_gpu *gpu, const kd_gpu_raster *raster);

/* One vertex layout per call: attributes that come from buffers, and the index buffer. */
#define KD_MAX_ATTRIBUTES 8
typedef enum kd_attribute_format {
    KD_ATTR_F32X1,
    KD_ATTR_F32X2,
    KD_ATTR_F32X3,
    KD_ATTR_F32X4,
    KD_ATTR_U32X1,
    KD_ATTR_UNORM8X4,
    KD_ATTR_SNORM8X4,
    KD_ATTR_SNORM16X2,
    KD_ATTR_SNORM16X4,
    KD_ATTR_F16X2
} kd_attribute_format;
typedef struct kd_gpu_attribute {
    kd_gpu_buffer buffer; /* id 0 ends the list */
    uint32_t location;
    kd_attribute_format format;
    uint32_t offset, stride; /* bytes */
    bool per_instance;
} kd_gpu_attribute;
typedef struct kd_gpu_geometry {
    kd_gpu_attribute attributes[KD_MAX_ATTRIBUTES];
    kd_gpu_buffer indices; /* u32; id 0: not indexed */
} kd_gpu_geometry;
/* The layout of an indirect draw, as GL defines it. */
typedef struct kd_draw_indexed {
    uint32_t index_count, instance_count, first_index;
    int32_t base_vertex;
    uint32_t base_instance;
} kd_draw_indexed;
void kd_gpu_draw_indexed(kd_gpu *gpu, kd_gpu_program program, const kd_gpu_geometry *geometry,
                         const kd_draw_indexed *draw);
void kd_gpu_draw_indirect(kd_gpu *gpu, kd_gpu_program program, const kd_gpu_geometry *geometry,
                          kd_gpu_buffer draws, size_t offset, uint32_t draw_count);
/** Draw `count` vertices without attributes (full-screen triangles, debug boxes by gl_VertexID). */
void kd_gpu_draw_procedural(kd_gpu *gpu, kd_gpu_program program, uint32_t count, uint32_t instances);
void kd_gpu_blit_to_window(kd_gpu *gpu, kd_gpu_texture texture, uint32_t width,
                           uint32_t height); /* flips so that row 0 is on top */

/* ---- order ---- */
/* What the next reader will do with data that shaders wrote; the union maps to one glMemoryBarrier. */
typedef enum kd_barrier {
    KD_BARRIER_STORAGE = 1, /* read or written as shader storage */
    KD_BARRIER_IMAGE = 2,   /* read or written as image */
    KD_BARRIER_TEXTURE = 4, /* sampled */
    KD_BARRIER_VERTEX = 8,  /* vertex attributes */
    KD_BARRIER_INDEX = 16,
    KD_BARRIER_INDIRECT = 32,
    KD_BARRIER_UNIFORM = 64,
    KD_BARRIER_TARGET = 128,        /* render target */
    KD_BARRIER_BUFFER_UPDATE = 256, /* written or read by copies and kd_gpu_write/read/fill_buffer */
    KD_BARRIER_TEXTURE_UPDATE = 512,
} kd_barrier;
void kd_gpu_barrier(kd_gpu *gpu, uint32_t barriers); /* 0 does nothing */
void kd_gpu_finish(kd_gpu *gpu);
void kd_gpu_push_group(kd_gpu *gpu, const char *name); /* names a pass for graphics debuggers */
void kd_gpu_pop_group(kd_gpu *gpu);
/** Call `pass` before every dispatch and draw, with a number and the name of its program. NULL: no more. */
void kd_gpu_set_pass_hook(kd_gpu *gpu, void (*pass)(void *user, uint32_t program, const char *name),
                          void *user);

/* ---- timestamps: a ring read some frames later ---- */
/** Put a timestamp into the stream under `slot` of this frame (0 … KD_GPU_TIMER_SLOTS-1). */
void kd_gpu_timestamp(kd_gpu *gpu, uint32_t slot);
/** End the frame: rotate the rings of uniforms, timestamps and readbacks. */
void kd_gpu_end_frame(kd_gpu *gpu);
/** Get the newest frame whose timestamps have arrived. Returns its number, or UINT64_MAX when none has. ns on
 * the CPU's monotonic clock; 0 for slots not used. Never stalls. */
uint64_t kd_gpu_read_timestamps(kd_gpu *gpu, uint64_t *ns, uint32_t slot_count);
/** The same of one frame. Returns false when its timestamps have not arrived, or are no longer kept. */
bool kd_gpu_read_frame_timestamps(kd_gpu *gpu, uint64_t frame, uint64_t *ns, uint32_t slot_count);
uint64_t kd_gpu_frame(const kd_gpu *gpu);
#define KD_GPU_TIMER_SLOTS  1024
#define KD_GPU_TIMER_FRAMES 8u /* of which timestamps are kept */

/* ---- readback without a stall ---- */
/** Make a ring of `depth` (0: 3) staging areas of `size` bytes. */
kd_gpu_readback kd_gpu_make_readback(kd_gpu *gpu, size_t size, uint32_t depth, const char *name);
void kd_gpu_destroy_readback(kd_gpu *gpu, kd_gpu_readback readback);
/** Queue a copy under the number `tag`. Errors KD_OUT_OF_RANGE when all areas are in flight. */
kd_status kd_gpu_readback_buffer(kd_gpu *gpu, kd_gpu_readback readback, kd_gpu_buffer from, size_t offset,
                                 size_t size, uint64_t tag);
kd_status kd_gpu_readback_texture(kd_gpu *gpu, kd_gpu_readback readback, kd_gpu_texture from, uint32_t level,
                                  uint64_t tag);
/** Take the oldest finished copy: NULL when none is ready (with wait: waits for it). Valid until the next
 * poll. */
const void *kd_gpu_readback_poll(kd_gpu *gpu, kd_gpu_readback readback, bool wait, uint64_t *tag,
                                 size_t *size);

/* ---- window (GLFW contexts) ---- */
bool kd_gpu_window_should_close(kd_gpu *gpu); /* also polls events */
void kd_gpu_window_size(kd_gpu *gpu, uint32_t *width, uint32_t *height);
void kd_gpu_window_present(kd_gpu *gpu);
void *kd_gpu_window_native(kd_gpu *gpu); /* GLFWwindow *, NULL when there is none */

/* ---- doctor ---- */
typedef struct kd_gpu_probe_row {
    kd_context_api api;
    bool works;
    char renderer[128], version[128];
    char note[256]; /* why it was skipped, or what to know: missing vendor library, device permissions … */
    int64_t max_ssbo_bytes;
    int timestamp_bits;
    bool timer_works; /* a timed pass read a plausible duration */
} kd_gpu_probe_row;
/** Try every way to a context (each in turn, opened and closed in a child process). Returns rows written.
 *  Threading: before a device is opened in this process, as a child inherits a driver's state but not its
 * threads. */
uint32_t kd_gpu_probe(kd_gpu_probe_row *rows, uint32_t capacity);
const char *kd_context_api_name(kd_context_api api);

#endif
