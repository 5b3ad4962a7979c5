#ifndef SAMPLES_ASSETS_GENERATE_H
#define SAMPLES_ASSETS_GENERATE_H

#include <stdbool.h>

/** Write cornell.gltf and cornell.bin into `folder`. Returns false after a message on standard error. */
bool cornell_write(const char *folder);

/** Write walker.gltf and walker.bin into `folder`. Returns false after a message on standard error. */
bool walker_write(const char *folder);

/** Write drop.gltf and drop.bin into `folder`. Returns false after a message on standard error. */
bool drop_write(const char *folder);

#endif
