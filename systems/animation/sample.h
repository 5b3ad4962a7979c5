#ifndef KD_SYSTEMS_ANIMATION_SAMPLE_H
#define KD_SYSTEMS_ANIMATION_SAMPLE_H

#include "runtime/asset/model.h"

/** Evaluate a channel at a time; before the first and after the last key the value is held.
 *
 *  Shapes  out: limit floats at most are written, channel->width when limit is larger. Rotations are unit
 * quaternions Units   time_s since the start of the clip Source  glTF 2.0, appendix C (step, linear with
 * slerp the short way, cubic Hermite with tangents times the interval)
 */
void animation_sample(const kd_channel_desc *channel, float time_s, float *out, uint32_t limit);

/** Bring a time into the clip: round and round when it loops, else held at the ends.
 *
 *  Returns [0, duration) when looping, else [0, duration]; 0 for times that are not numbers
 */
float animation_wrap(double time_s, float duration_s, bool loop);

/** Let time in a clip pass. What rounding takes from it is kept in rest_s, so that an hour of steps is an hour.
 */
void animation_advance(float *time_s, float *rest_s, double step_s, float duration_s, bool loop);

#endif
