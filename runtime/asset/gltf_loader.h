#ifndef KD_ASSET_GLTF_LOADER_H
#define KD_ASSET_GLTF_LOADER_H

/* One load in progress: the unchecked document on one side, the model being made on the other. Every
 * gltf_load_… step checks what it reads, and logs exactly one message when it fails. */

#include "runtime/asset/gltf_document.h"
#include "runtime/asset/model.h"

/* Everything a model may cost, files included: the loader's promise against runaway memory. */
#define GLTF_BYTES_MAX ((uint64_t)2 << 30)
/* What meshes and clips may unfold to from the bytes of the files: a quantised vertex of 8 bytes becomes some
 * 80, a shared index of 2 bytes a vertex of its own. Small files get a floor. So a file of some lines cannot
 * ask for gigabytes of zeros. */
#define GLTF_UNFOLD_FACTOR 100u
#define GLTF_UNFOLD_FLOOR  ((uint64_t)256 << 20)
/* GPU index arithmetic and voxel caches count vertices of a primitive in 32 bits with room to spare. */
#define GLTF_VERTICES_MAX (64u << 20)
/* Joint indices are 16 bits wide in the file format. */
#define GLTF_JOINTS_MAX 65535u
/* Weights of one mesh: the largest face rigs have some hundreds. */
#define GLTF_MORPHS_MAX 4096u
/* Warnings beyond these are counted in one last line. */
#define GLTF_WARNINGS_MAX 64u

/* An accessor whose bytes are known to lie inside their buffer. */
typedef struct gltf_span {
    const uint8_t *base;
    size_t stride; /* 0: all elements are one zero */
    uint32_t count;
    int component, width;
    bool normalized;
} gltf_span;

/* What the meshes keep for the checks of skins, beside each kd_primitive_desc. */
typedef struct gltf_mesh_facts {
    uint32_t max_joint; /* largest joint index with a weight, over all primitives */
    bool skinned;
} gltf_mesh_facts;

typedef struct gltf_loader {
    const char *path;
    kd_model_options options;
    kd_arena kept, scratch;     /* the model's memory; what ends with the load */
    kd_arena work;              /* what ends with a primitive */
    uint64_t bytes, work_bytes; /* given out, together against the limit */
    uint64_t limit;             /* GLTF_BYTES_MAX, from the meshes on perhaps less */
    uint64_t source_bytes;      /* of all files read */
    gltf_document doc;
    gltf_chunks chunks;
    kd_model *model;
    gltf_span *spans;       /* [accessor_count], base NULL until checked */
    uint32_t *image_of;     /* [doc.image_count] index in the model, KD_NONE: not in use */
    uint32_t *node_of;      /* [doc.node_count] index in the model, KD_NONE: in no scene */
    gltf_mesh_facts *facts; /* [doc.mesh_count] */
    uint32_t variant;       /* of the document, KD_NONE: none */
    const char **warnings;  /* [GLTF_WARNINGS_MAX + 1] */
    uint32_t warnings_dropped;
} gltf_loader;

/* ---- messages and memory ---- */

/** Log `PATH: …` as the one error message. Returns status. */
kd_status gltf_fail(gltf_loader *l, kd_status status, const char *format, ...)
    __attribute__((format(printf, 3, 4)));
/** Note a warning in the model. */
void gltf_warn(gltf_loader *l, const char *format, ...) __attribute__((format(printf, 2, 3)));
/** Give out zeroed memory; *out is NULL after an error. Errors KD_TOO_LARGE, KD_NO_MEMORY with a message. */
kd_status gltf_alloc(gltf_loader *l, kd_arena *arena, size_t count, size_t size, void *out);
/** Take back the work arena. */
void gltf_reset_work(gltf_loader *l);
/** Name a thing of the model: its own name, or "kind N". NULL when memory is out. */
const char *gltf_name(gltf_loader *l, const char *name, const char *kind, size_t index);
/** Narrow and check numbers; false if one is not finite as a float. */
bool gltf_floats(const double *from, size_t count, float *to);

/* ---- accessors ---- */

/** Check an accessor once and give its span. `where` names the user of it in messages. */
kd_status gltf_span_of(gltf_loader *l, int accessor, const char *where, gltf_span *out);
/** Read elements as floats: element first + i, or select[i] when select is given; missing components stay as
 * they are. Shapes out: count rows of row_floats. Errors KD_BAD_FORMAT for NaN and infinity. */
kd_status gltf_read_floats(gltf_loader *l, const gltf_span *span, const uint32_t *select, uint32_t count,
                           float *out, uint32_t row_floats, const char *where);
/** Read one component of an element of integers. */
uint32_t gltf_read_uint(const gltf_span *span, uint32_t element, int component);

/** Bytes of an element. Columns of a matrix start at multiples of four bytes; only floats are read from
 * matrices here. Returns 0 for an unknown type. */
uint32_t gltf_element_bytes(const gltf_accessor *a);
/** The bytes of a view; NULL when its buffer has none. */
const uint8_t *gltf_view_bytes(const gltf_loader *l, const gltf_view *view);

/* ---- materials ---- */

/** Give the model's index of a picture, loading it at first use. Errors as gltf_load_materials */
kd_status gltf_use_image(gltf_loader *l, size_t index, uint32_t *out);
/** Bring a factor into its range; outside is a slip of the exporter that the picture survives, with a
 * warning. */
float gltf_factor(gltf_loader *l, size_t material, const char *name, double value, float low, float high);
/** Read what extensions add to a material that is complete otherwise. Errors as gltf_load_materials */
kd_status gltf_load_lobes(gltf_loader *l, const gltf_material *m, size_t material, kd_material_desc *out);

/* ---- steps, in this order ---- */
kd_status gltf_load_buffers(gltf_loader *l);
kd_status gltf_load_materials(gltf_loader *l);
kd_status gltf_unpack_views(gltf_loader *l);
kd_status gltf_load_meshes(gltf_loader *l);
kd_status gltf_load_cameras(gltf_loader *l);
kd_status gltf_load_lights(gltf_loader *l);
kd_status gltf_load_nodes(gltf_loader *l);
kd_status gltf_load_skins(gltf_loader *l);
kd_status gltf_load_clips(gltf_loader *l);

/* ---- shared by steps ---- */

/** Add the copies that a node of the document asks for (EXT_mesh_gpu_instancing). */
kd_status gltf_count_instances(gltf_loader *l, uint32_t node, size_t *count);
/** Make them nodes below the model's node `parent`, at nodes[*used …], and take its mesh away. */
kd_status gltf_load_instances(gltf_loader *l, uint32_t node, uint32_t parent, kd_node_desc *nodes,
                              uint32_t *used);
/** Let the accessors of a primitive read what Draco has packed, if it has. */
kd_status gltf_unpack_primitive(gltf_loader *l, const gltf_primitive *p, const char *where);

/** Resolve a URI: a data URI is decoded, anything else is a file beside the model.
 *  Owns bytes lie in the scratch arena. Errors with a message naming `where`. */
kd_status gltf_load_uri(gltf_loader *l, const char *uri, const char *where, const uint8_t **bytes,
                        size_t *size);

#endif
