#ifndef KD_GPU_INTERNAL_H
#define KD_GPU_INTERNAL_H

/* What the files of this module share: the pools behind the handles, cached GL state and the rings of a
 * frame. Invariant: a cached binding names what GL has bound, or id 0 for unknown; whoever deletes an object
 * clears its cache. */

#include <stdarg.h>

#include "runtime/core/clock.h"
#include "runtime/core/log.h"
#include "runtime/gpu/context.h"
#include "runtime/gpu/gl.h"
#include "runtime/gpu/gpu.h"

enum {
    GPU_FRAMES = 3, /* frames of uniforms that the GPU may lag behind */
    GPU_TIMER_FRAMES = KD_GPU_TIMER_FRAMES,
    GPU_MAX_STORAGE = 32, /* bindings, one bit each in masks; higher ones are refused */
    GPU_MAX_TEXTURES = 32,
    GPU_MAX_NAME = 48,
    GPU_MAX_COMPLAINTS = 32 /* misuse found in frame code repeats every frame: log the first ones only */
};

/* ---- handle pools ---- */

/* Items of one kind in an array that grows; an id is generation << 20 | index + 1. Slots are reused,
 * generations tell. */
typedef struct gpu_pool {
    char *items;
    uint16_t *generations; /* odd: alive */
    uint32_t *free_slots;
    size_t item_size;
    uint32_t count, capacity, free_count;
} gpu_pool;

/** Take a zeroed slot. Returns its id, 0 when memory is out. */
uint32_t gpu_pool_add(gpu_pool *pool, void **item);
/** Find an item. Returns NULL for id 0 and for ids that were removed. */
void *gpu_pool_find(const gpu_pool *pool, uint32_t id);
void gpu_pool_remove(gpu_pool *pool, uint32_t id);
/** Walk what is alive: pass 0, then the last id. Returns 0 at the end. */
uint32_t gpu_pool_next(const gpu_pool *pool, uint32_t id);
void gpu_pool_fini(gpu_pool *pool);

/* ---- objects ---- */

typedef struct gpu_buffer {
    GLuint gl;
    size_t size;
    kd_buffer_usage usage;
    char name[GPU_MAX_NAME];
} gpu_buffer;

typedef struct gpu_texture {
    GLuint gl;
    GLenum target;
    kd_texture_kind kind;
    kd_texture_format format;
    uint32_t width, height, depth, levels;
    size_t bytes;
    char name[GPU_MAX_NAME];
} gpu_texture;

/* What a program was made of, to make it anew. */
typedef struct gpu_recipe {
    char *compute, *vertex, *geometry, *fragment; /* NULL: it has none */
    char **defines;                               /* NULL-terminated */
    uint64_t hash;                                /* of the whole source of every stage */
} gpu_recipe;

typedef struct gpu_program {
    GLuint gl;        /* of several programs, when they are made of the same texts */
    uint64_t made_of; /* the hash of the texts that it was made of */
    bool compute;
    uint32_t storage; /* mask of the storage bindings that it uses */
    gpu_recipe recipe;
    char name[GPU_MAX_NAME];
} gpu_program;

typedef struct gpu_target {
    GLuint gl;
    uint32_t width, height, color_count;
    bool color_is_uint[KD_MAX_COLOR_TARGETS];
    bool has_depth;
    char name[GPU_MAX_NAME];
} gpu_target;

typedef struct gpu_area {
    GLsync fence;
    uint64_t tag, frame;
    size_t size;
} gpu_area;

#define GPU_MAX_AREAS 16
typedef struct gpu_readback {
    GLuint gl;
    const char *mapped; /* the whole ring, persistently */
    size_t area_bytes;
    uint32_t depth, first, count; /* areas in flight: first … first + count - 1, modulo depth */
    bool held;                    /* the area before first is lent to the caller */
    gpu_area areas[GPU_MAX_AREAS];
    char name[GPU_MAX_NAME];
} gpu_readback;

/* ---- rings ---- */

typedef struct gpu_retired {
    GLuint gl;
    uint64_t frame;
} gpu_retired;

typedef struct gpu_uniforms {
    GLuint gl;
    char *mapped;
    size_t frame_bytes, used, alignment, max_block;
    uint32_t slot;
    GLsync fences[GPU_FRAMES]; /* of the frame that last wrote the slot */
    gpu_retired retired[16];
    uint32_t retired_count;
} gpu_uniforms;

typedef struct gpu_timers {
    GLuint queries[GPU_TIMER_FRAMES][KD_GPU_TIMER_SLOTS];
    bool used[GPU_TIMER_FRAMES][KD_GPU_TIMER_SLOTS];
    uint64_t frames[GPU_TIMER_FRAMES]; /* number of the frame recorded there; UINT64_MAX: none */
    int64_t cpu_minus_gpu_ns;
} gpu_timers;

typedef struct gpu_storage_binding {
    uint32_t id;
    size_t offset, size;
} gpu_storage_binding;

struct kd_gpu {
    gpu_context context;
    gl_table gl;
    kd_gpu_info info;
    bool failed, debug;
    const struct kd_embedded_shader *shaders; /* of the caller; NULL: none */
    uint32_t complaints;
    size_t bytes;
    uint64_t frame;
    int max_storage_bindings, max_texture_units, max_image_units, max_texture_2d, max_layers, max_cube;
    int max_anisotropy; /* 1: the driver has none */
    int64_t max_groups[3];
    gpu_pool buffers, textures, programs, targets, readbacks;

    uint32_t program; /* id in use */
    gpu_storage_binding storage[GPU_MAX_STORAGE];
    uint32_t refused_storage; /* mask of bindings whose last bind was refused: what uses one does not run */
    uint32_t texture_units[GPU_MAX_TEXTURES];
    GLuint empty_vao, vao, bound_vao;
    kd_gpu_geometry geometry; /* that vao is set up for, if geometry_known */
    bool geometry_known;
    uint32_t enabled_attributes; /* bit mask of locations */
    GLuint blit_framebuffer;
    bool raster_ready; /* a target is bound, draws may come */

    gpu_uniforms uniforms;
    gpu_timers timers;
    void (*pass)(void *user, uint32_t program, const char *name); /* NULL: nobody asks */
    void *pass_user;
};

/* ---- shared helpers ---- */

/** Note a failure and log it: objects that cannot be made. */
void gpu_fail(kd_gpu *gpu, const char *format, ...) __attribute__((format(printf, 2, 3)));
/** Note a failure of frame code; only the first ones are logged. */
void gpu_complain(kd_gpu *gpu, const char *format, ...) __attribute__((format(printf, 2, 3)));
/** Forget errors that are pending, so that the next check speaks of the next call only. */
void gpu_drain_errors(kd_gpu *gpu);
void gpu_copy_name(char out[GPU_MAX_NAME], const char *name, const char *fallback);
void gpu_label(kd_gpu *gpu, GLenum kind, GLuint object, const char *name);

/* Each finds a living object, or complains in the name of `call` and returns NULL. */
gpu_buffer *gpu_get_buffer(kd_gpu *gpu, kd_gpu_buffer buffer, const char *call);
gpu_texture *gpu_get_texture(kd_gpu *gpu, kd_gpu_texture texture, const char *call);
gpu_program *gpu_get_program(kd_gpu *gpu, kd_gpu_program program, const char *call);
gpu_target *gpu_get_target(kd_gpu *gpu, kd_gpu_target target, const char *call);
gpu_readback *gpu_get_readback(kd_gpu *gpu, kd_gpu_readback readback, const char *call);

/** Check that offset … offset + size lies inside the buffer, or complain. */
bool gpu_range_fits(kd_gpu *gpu, const gpu_buffer *buffer, size_t offset, size_t size, const char *call);

/** How a texture format reads in GL. */
typedef struct gpu_format {
    GLenum internal, format, type;
    uint32_t texel_bytes;
    bool is_uint, is_depth, is_image, is_texel_buffer;
    const char *name;
} gpu_format;
const gpu_format *gpu_get_format(kd_texture_format format);
uint32_t gpu_level_size(uint32_t size, uint32_t level);
/** Bytes of one level with all its layers or slices, in the natural layout. */
size_t gpu_level_bytes(const gpu_texture *texture, uint32_t level);

/** Copy what a program is made of. Returns false when memory is out; nothing is held then. */
bool gpu_recipe_init(gpu_recipe *recipe, const kd_gpu_program_desc *desc);
void gpu_recipe_fini(gpu_recipe *recipe);
/** Hash (FNV-1a) what the sources are now. Returns false when one cannot be read: it is being written. */
bool gpu_recipe_hash(const kd_gpu *gpu, const gpu_recipe *recipe, uint64_t *hash);
/** Compile and link what a description names. Returns 0 after logging why. */
GLuint gpu_build_program(kd_gpu *gpu, const kd_gpu_program_desc *desc, const char *name);
/** Find the driver's object of another program that is made of the same texts. Returns 0 when there is none.
 */
GLuint gpu_find_program(kd_gpu *gpu, const gpu_recipe *recipe);
/** Delete the driver's object of a program unless others have the same. */
void gpu_release_program(kd_gpu *gpu, gpu_program *program);
/** Mask of the storage bindings that a program uses. */
uint32_t gpu_program_storage(kd_gpu *gpu, GLuint program);

/** Use a program unless it is in use. Returns false when it cannot be, with a complaint: here, or before when
 * the bind of a buffer that it uses was refused. */
bool gpu_use_program(kd_gpu *gpu, kd_gpu_program program, bool compute, const char *call);
void gpu_bind_vao(kd_gpu *gpu, GLuint vao);

/** Try one way to a context, without logging. */
kd_status gpu_open_one(const kd_gpu_desc *desc, kd_context_api api, kd_gpu **out, gpu_reason *reason);

bool gpu_uniforms_init(kd_gpu *gpu);
void gpu_uniforms_end_frame(kd_gpu *gpu);
void gpu_uniforms_fini(kd_gpu *gpu);
void gpu_timers_init(kd_gpu *gpu);
void gpu_timers_end_frame(kd_gpu *gpu);
void gpu_timers_fini(kd_gpu *gpu);
void gpu_release_readback(kd_gpu *gpu, gpu_readback *readback);

#endif
