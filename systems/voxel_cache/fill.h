#ifndef KD_SYSTEMS_VOXEL_CACHE_FILL_H
#define KD_SYSTEMS_VOXEL_CACHE_FILL_H

#include <stdint.h>

#include "runtime/core/status.h"

/** Set every cell that cannot be reached from outside of the grid through cells that are not set, by faces.
 *
 *  Shapes  mask: one bit a cell, x + size[0] * (y + size[1] * z)
 *  Errors  KD_NO_MEMORY, KD_TOO_LARGE; nothing is changed
 *  Cost    the words of the mask and the ends of rows of free cells
 */
kd_status fill_enclosed(uint32_t *mask, const uint32_t size[3]);

#endif
