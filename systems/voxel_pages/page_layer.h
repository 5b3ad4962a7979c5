#ifndef KD_SYSTEMS_VOXEL_PAGES_PAGE_LAYER_H
#define KD_SYSTEMS_VOXEL_PAGES_PAGE_LAYER_H

#include "components/pose_access.h"
#include "components/voxel_scene.h"

/* The pages of one layer on the GPU: segments that come and go ask in lists, the GPU hands out the slots. */

/* A growing list that keeps its memory between frames. */
typedef struct page_list {
    void *items;
    uint32_t count, capacity;
} page_list;

/** Room for one more item of `size` bytes; NULL without memory. */
void *page_list_push(page_list *list, size_t size);

typedef struct segment_request {
    struct kd_voxel_segment segment;
    uint32_t id, spare[3];
} segment_request;

typedef struct page_layer {
    kd_gpu_buffer slots; /* slot of every segment id */
    uint32_t id_count;
    page_list in, out;     /* segment_request, uint32_t ids */
    page_list free_ids;    /* ids to use again */
    uint32_t spare_frames; /* in a row in which more than half of the pages were spare */
    bool said_short;       /* that not all of it has pages */
} page_layer;

/* What all layers share. */
typedef struct page_programs {
    kd_gpu_program allocate, free, bounds;
    kd_gpu_buffer requests;
    kd_texel_view shape_view;
} page_programs;

/** Errors KD_GPU */
kd_status page_programs_init(page_programs *programs, kd_gpu *gpu);
void page_programs_fini(page_programs *programs, kd_gpu *gpu);

/** Pages for so many segments. */
uint32_t page_layer_needs(const kd_voxel_pages *pages);

/** Give back what `out` lists and allocate what `in` lists, with pages made as needed; both are empty then.
 * Segments for which there is no page stay without a slot, in the shaders' eyes too. */
void page_layer_update(page_layer *layer, page_programs *programs, kd_gpu *gpu, kd_voxel_scene *scene,
                       kd_voxel_layer which);

/** Give the layer's buffers back; no segment has a slot then. */
void page_layer_clear(page_layer *layer, kd_gpu *gpu, kd_voxel_pages *pages);

void page_layer_fini(page_layer *layer, kd_gpu *gpu, kd_voxel_pages *pages);

/** A buffer that the CPU writes, of at least `size` bytes; contents are not kept. */
bool page_stream_ensure(kd_gpu *gpu, kd_gpu_buffer *buffer, size_t size, const char *name);

#endif
