#ifndef KD_TESTS_DRACO_ENCODE_H
#define KD_TESTS_DRACO_ENCODE_H

#include <stddef.h>
#include <stdint.h>

#include "runtime/asset/model.h"

#ifdef __cplusplus
extern "C" {
#endif

/** Pack positions (Draco's id 0), normals (1) and uv (2) by the library's own encoder, 14, 10 and 12 bits.
 *  Returns the bytes, which the caller frees; NULL when the encoder refuses. */
uint8_t *draco_encode(const kd_primitive_desc *primitive, size_t *size);

#ifdef __cplusplus
}
#endif

#endif
