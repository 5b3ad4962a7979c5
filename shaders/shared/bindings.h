#ifndef KD_SHADERS_BINDINGS_H
#define KD_SHADERS_BINDINGS_H

/* Binding points that several features share. Storage bindings 0 … 7 and image units 0 … 7 are each pass's own.
 * GL guarantees 8 storage blocks a stage and 16 texture units a stage: count before adding. */

/* uniform blocks */
#define KD_BIND_PASS 0     /* parameters of one pass, declared by the pass */
#define KD_BIND_VIEW 1     /* kd_view_params */
#define KD_BIND_LIGHTS 2   /* kd_lights_params */
#define KD_BIND_TREE 3     /* kd_tree_params */
#define KD_BIND_MATERIAL 4 /* kd_material_params of the batch being drawn */
#define KD_BIND_SVO 5      /* kd_svo_places */
#define KD_BIND_EMITTERS 6 /* kd_emitters_params */
#define KD_BIND_SKY 7      /* kd_sky_params */

/* texture units */
#define KD_UNIT_BASE_COLOR 0 /* material maps, while drawing */
#define KD_UNIT_METALLIC_ROUGHNESS 1
#define KD_UNIT_NORMAL 2
#define KD_UNIT_EMISSIVE 3
#define KD_UNIT_OCCLUSION 4
#define KD_UNIT_GBUFFER_ALBEDO 0 /* the same units after drawing */
#define KD_UNIT_GBUFFER_NORMAL 1
#define KD_UNIT_GBUFFER_MATERIAL 2
#define KD_UNIT_GBUFFER_EMISSIVE 3
#define KD_UNIT_GBUFFER_DEPTH 4
#define KD_UNIT_SHADOW_DIRECTIONAL 5 /* sampler2DArray */
#define KD_UNIT_SHADOW_SPOT 6        /* sampler2DArray */
#define KD_UNIT_GI_DIFFUSE 7
#define KD_UNIT_GI_SPECULAR 8
#define KD_UNIT_GI_GUIDE 9     /* while gathering */
#define KD_UNIT_BLENDED 9      /* in the picture's sum */
#define KD_UNIT_GBUFFER_LAYERS 10
#define KD_UNIT_BLENDED_TINT 11
#define KD_UNIT_TREE_RADIANCE 10 /* sampler3D: the dense levels, six directions side by side */
#define KD_UNIT_TREE_DEPTH 18    /* sampler3D: their optical depths, three directions a texel */
#define KD_UNIT_TREE_INDEX 11    /* usamplerBuffer: node of every dense cell */
#define KD_UNIT_TREE_NODES 12    /* usamplerBuffer: node words of the sparse levels between dense cells and leaves */
#define KD_UNIT_TREE_LEAVES 13   /* usamplerBuffer: radiance and optical depth of leaves, eight siblings at a time */
#define KD_UNIT_TREE_DATA 14     /* usamplerBuffer: the same, filtered, of the sparse levels between */
#define KD_UNIT_BOUNCE 15        /* usamplerBuffer: shaders/shared/bounce.h */
#define KD_UNIT_SKY_MAP 16       /* sampler2D: equirectangular */
#define KD_UNIT_SKY_CONES 17     /* sampler3D: shaders/shared/sky.h */
#define KD_UNIT_PICTURE 18       /* sampler2D: radiance of the picture, row 0 on top */
#define KD_UNIT_MOTION 19        /* sampler2D: kd_gbuffer.motion */
#define KD_UNIT_BEFORE_DIFFUSE 20 /* while gathering: what was traced in the frame before */
#define KD_UNIT_BEFORE_SPECULAR 21
#define KD_UNIT_BEFORE_GUIDE 22

#endif
