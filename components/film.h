#ifndef KD_COMPONENTS_FILM_H
#define KD_COMPONENTS_FILM_H

/* Singletons: how a frame of a film is made of more than one rendered picture, and what is kept for its
 * layers. Zeros: a frame is the picture as it was rendered. */

#include "runtime/core/math.h"
#include "runtime/ecs/world.h"
#include "runtime/gpu/gpu.h"

/* Written by the application. kd_frame's size is that of what is rendered. */
typedef struct kd_film {
    uint32_t supersample; /* rendered pixels a pixel of the frame is the mean of, along each axis; 0 as 1 */
    uint32_t sub_frames;  /* pictures that a frame is the mean of; 0 as 1 */
    uint32_t sub_frame;   /* the one being rendered, from 0; the last one shows the frame's own time */
    bool layers;          /* fill kd_film_layers */
    bool deep;            /* fill kd_picture.deep */
} kd_film;
KD_COMPONENT_DECLARE(kd_film);

/** Tell whether frames are anything but the picture as it was rendered. */
bool kd_film_on(const kd_film *film);
/** Tell whether the picture being rendered is the last of its frame. */
bool kd_film_is_last(const kd_film *film);
/** Get how many rendered pixels a pixel of the frame has along an axis. */
uint32_t kd_film_scale(const kd_film *film);

/* Resource "film.layers", system film_layers. Slices are KD_LAYER_* of shaders/shared/film.h. */
typedef struct kd_film_layers {
    kd_gpu_texture slices; /* 2D array, row 0 on top: RGBA16F, or RGBA32F when a frame has sub-frames */
    bool floats;           /* RGBA32F */
    uint32_t width, height;
} kd_film_layers;
KD_COMPONENT_DECLARE(kd_film_layers);

/* Resource "motion", system motion: where everything was in the frame before. */
typedef struct kd_motion {
    kd_gpu_buffer models;    /* mat4 by object */
    kd_gpu_buffer geometry;  /* as the store's geometry stream */
    kd_mat4 view_projection; /* of the camera then */
} kd_motion;
KD_COMPONENT_DECLARE(kd_motion);

#endif
