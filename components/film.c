#include "components/film.h"

KD_COMPONENT_DEFINE_FLAGS(kd_film, "film", KD_COMPONENT_TRANSIENT,
                          KD_FIELD(kd_film, supersample, KD_U32, "pixels",
                                   "rendered pixels of a pixel along an axis"),
                          KD_FIELD(kd_film, sub_frames, KD_U32, NULL, "pictures of a frame"),
                          KD_FIELD(kd_film, sub_frame, KD_U32, NULL, "number of the one being rendered"));

KD_COMPONENT_DEFINE_FLAGS(kd_film_layers, "film_layers", KD_COMPONENT_TRANSIENT,
                          KD_FIELD(kd_film_layers, width, KD_U32, "pixels", "width of the layers"),
                          KD_FIELD(kd_film_layers, height, KD_U32, "pixels", "height of the layers"));

KD_COMPONENT_DEFINE_FLAGS(kd_motion, "motion", KD_COMPONENT_TRANSIENT,
                          KD_FIELD(kd_motion, view_projection, KD_MAT4, NULL, "camera of the frame before"));

bool kd_film_on(const kd_film *film)
{
    return film->supersample > 1 || film->sub_frames > 1 || film->layers || film->deep;
}

bool kd_film_is_last(const kd_film *film)
{
    return film->sub_frame + 1 >= film->sub_frames;
}

uint32_t kd_film_scale(const kd_film *film)
{
    return film->supersample ? film->supersample : 1;
}
