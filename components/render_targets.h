#ifndef KD_COMPONENTS_RENDER_TARGETS_H
#define KD_COMPONENTS_RENDER_TARGETS_H

/* Singletons: the textures by which the systems that make a picture meet. Each is (re)made by the system
 * named when the picture's size changes. Textures are bound to the units of shaders/shared/bindings.h. */

#include "runtime/ecs/world.h"
#include "runtime/gpu/gpu.h"

/* Resource "gbuffer", system geometry. Read in shaders through shaders/include/gbuffer.glsl. Row 0 is the
 * bottom of the picture here and in kd_gi_targets; resolve turns it round. */
typedef struct kd_gbuffer {
    kd_gpu_texture albedo, normal, material, emissive, depth;
    kd_gpu_texture layers; /* id 0: no material of the scene has more than metallic-roughness */
    kd_gpu_target target;
    kd_gpu_texture blended; /* resource "blended", system blend. RGBA16F: rgb light of the blended surfaces in
                               front, a share of what is behind that they hide; id 0: none in this frame */
    kd_gpu_texture blended_hidden; /* RGBA16F: the same share by colour; id 0: equal for all */
    kd_gpu_texture motion; /* RG16F: pixels from here to where the surface was a frame ago, y upwards; id 0
                              unless layers are filmed */
    uint32_t width, height;
} kd_gbuffer;
KD_COMPONENT_DECLARE(kd_gbuffer);

/* Resource "shadow.maps", system shadow; "lights.uniform", system lights. Read through
 * shaders/include/lights.glsl. */
typedef struct kd_lighting {
    kd_gpu_buffer view;                             /* kd_view_params, uniform block KD_BIND_VIEW */
    kd_gpu_buffer lights;                           /* kd_lights_params, uniform block KD_BIND_LIGHTS */
    kd_gpu_texture shadow_directional, shadow_spot; /* depth arrays, units KD_UNIT_SHADOW_* */
    uint32_t light_count, directional_count;        /* directional lights come first */
    uint32_t ranged_count;                          /* local lights whose range ends */
    uint32_t version; /* another when lights, their maps or the view that these are for differ */
    void *internal;
} kd_lighting;
KD_COMPONENT_DECLARE(kd_lighting);

/* Resource "gi", system gather, full picture size. */
typedef struct kd_gi_targets {
    kd_gpu_texture diffuse; /* RGBA16F: rgb irradiance / pi arriving at the pixel's surface, a: ambient
                               visibility 0 … 1 */
    kd_gpu_texture
        specular; /* RGBA16F: rgb radiance arriving along the mirror direction, filtered by roughness */
    kd_gpu_buffer
        samples;  /* resource "gi.samples": samples taken, KD_CONE_COUNTERS in shaders/shared/gather.h */
    bool counted; /* this frame's were */
    uint32_t width, height;
    float unit; /* what both are multiplied by to be light: 1, or a power of two under bright lamps */
} kd_gi_targets;
KD_COMPONENT_DECLARE(kd_gi_targets);

/* Resource "picture", system resolve. */
typedef struct kd_picture {
    kd_gpu_texture hdr; /* RGBA16F linear radiance of the chosen view, row 0 on top */
    kd_gpu_texture ldr; /* RGBA8, sRGB encoded, row 0 on top: what is saved and shown */
    uint32_t width, height;
    uint32_t shown_width, shown_height; /* of ldr and of the two below: smaller where kd_film supersamples */
    kd_gpu_texture mean; /* RGBA32F linear radiance of a filmed frame so far; id 0: hdr is the frame */
    kd_gpu_texture deep; /* RGBA16UI: ldr in 16 bits; id 0: nobody asked for it */
} kd_picture;
KD_COMPONENT_DECLARE(kd_picture);

/* Resources "tree.*", the voxel systems. `uniform` is block KD_BIND_TREE; textures go to KD_UNIT_TREE_*. */
typedef struct kd_tree {
    kd_gpu_buffer uniform;
    kd_gpu_texture radiance, depth, index, nodes, leaves, data;
    uint32_t cascade_count, resolution, dense_resolution;
    bool strict; /* `light.leak=strict` when the tree was made */
    float span_m[4];
    uint64_t leaf_cells, node_count; /* of a recent frame: counts come back without a wait */
    uint64_t static_voxels, dynamic_voxels, cached_voxels, resident_voxels;
    uint64_t cascade_voxels[4], cascade_nodes[4], cascade_bytes[4];
} kd_tree;
KD_COMPONENT_DECLARE(kd_tree);

#endif
