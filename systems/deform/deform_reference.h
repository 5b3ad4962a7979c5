#ifndef KD_SYSTEMS_DEFORM_DEFORM_REFERENCE_H
#define KD_SYSTEMS_DEFORM_DEFORM_REFERENCE_H

#include <string.h>

#include "runtime/core/math.h"
#include "shaders/shared/deform.h"
#include "shaders/shared/scene.h"

/* What the deform pass reads and writes, as in shaders/shared/scene.h. */
typedef struct deform_streams {
    uint32_t *geometry; /* KD_GEOMETRY_WORDS a vertex */
    const uint32_t *skins, *morphs;
    const kd_vec4 (*joints)[3];
    const uint32_t *words; /* weights of the items */
} deform_streams;

/** Do on the CPU what shaders/deform/deform.comp does with all vertices of one item. */
void deform_reference(const deform_streams *streams, const struct kd_deform_item *item);

/* Words of vertex streams, shaders/shared/scene.h. */
static inline float deform_float(uint32_t word)
{
    float f;
    memcpy(&f, &word, sizeof f);
    return f;
}

static inline float deform_snorm(uint32_t word, int half)
{
    float f = (float)(int16_t)(uint16_t)(word >> (16 * half)) / 32767.0f;
    return f < -1 ? -1 : f;
}

#endif
