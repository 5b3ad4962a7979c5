/* Key-frame evaluation as glTF 2.0 defines it in appendix C. */

#include "systems/animation/sample.h"

#include <math.h>
#include <string.h>

float animation_wrap(double time_s, float duration_s, bool loop)
{
    double d = duration_s;
    if (!(d > 0) || !isfinite(time_s))
        return 0;
    if (!loop)
        return time_s < 0 ? 0 : time_s > d ? duration_s : (float)time_s;
    double t = fmod(time_s, d);
    float wrapped = (float)(t < 0 ? t + d : t);
    return wrapped < duration_s ? wrapped : 0; /* rounding may have reached the end, which is the start */
}

void animation_advance(float *time_s, float *rest_s, double step_s, float duration_s, bool loop)
{
    double exact = (double)*time_s + (double)*rest_s + step_s, d = duration_s;
    bool held = !loop && !(exact >= 0 && exact <= d), valid = d > 0 && isfinite(exact);
    *time_s = animation_wrap(exact, duration_s, loop);
    *rest_s = valid && !held ? (float)remainder(exact - (double)*time_s, d) : 0;
}

/* The last key at or before the time, by bisection; the caller has excluded times outside the keys. */
static uint32_t key_before(const kd_channel_desc *channel, float time_s)
{
    uint32_t low = 0, high = channel->key_count - 1;
    while (high - low > 1) {
        uint32_t middle = low + (high - low) / 2;
        if (channel->times[middle] <= time_s)
            low = middle;
        else
            high = middle;
    }
    return low;
}

static const float *key_value(const kd_channel_desc *channel, uint32_t key)
{
    size_t width = channel->width;
    return channel->interpolation == KD_INTERPOLATE_CUBIC ? channel->values + (key * 3u + 1u) * width
                                                          : channel->values + key * width;
}

static kd_quat quat_from(const float *v)
{
    return (kd_quat){v[0], v[1], v[2], v[3]};
}

static void put_quat(float *out, kd_quat q)
{
    const float values[4] = {q.x, q.y, q.z, q.w};
    memcpy(out, values, sizeof values);
}

static void sample_linear(const kd_channel_desc *channel, uint32_t key, float u, float *out, uint32_t count)
{
    const float *a = key_value(channel, key), *b = key_value(channel, key + 1);
    if (channel->path == KD_PATH_ROTATION)
        put_quat(out, kd_quat_slerp(quat_from(a), quat_from(b), u));
    else
        for (uint32_t i = 0; i < count; i++)
            out[i] = a[i] + (b[i] - a[i]) * u;
}

static void sample_cubic(const kd_channel_desc *channel, uint32_t key, float u, float interval_s, float *out,
                         uint32_t count)
{
    const float *a = key_value(channel, key), *b = key_value(channel, key + 1);
    const float *leaving = a + channel->width, *arriving = b - channel->width;
    float u2 = u * u, u3 = u2 * u;
    for (uint32_t i = 0; i < count; i++)
        out[i] = (2 * u3 - 3 * u2 + 1) * a[i] + (u3 - 2 * u2 + u) * interval_s * leaving[i] +
                 (3 * u2 - 2 * u3) * b[i] + (u3 - u2) * interval_s * arriving[i];
    if (channel->path == KD_PATH_ROTATION)
        put_quat(out, kd_quat_normalize(quat_from(out)));
}

static void hold(const kd_channel_desc *channel, uint32_t key, float *out, uint32_t count)
{
    memcpy(out, key_value(channel, key), count * sizeof *out);
    if (channel->path == KD_PATH_ROTATION)
        put_quat(out, kd_quat_normalize(quat_from(out)));
}

void animation_sample(const kd_channel_desc *channel, float time_s, float *out, uint32_t limit)
{
    uint32_t count = channel->width < limit ? channel->width : limit;
    uint32_t last = channel->key_count - 1;
    if (time_s <= channel->times[0]) {
        hold(channel, 0, out, count);
    } else if (time_s >= channel->times[last]) {
        hold(channel, last, out, count);
    } else {
        uint32_t key = key_before(channel, time_s);
        float interval_s = channel->times[key + 1] - channel->times[key];
        float u = (time_s - channel->times[key]) / interval_s;
        if (channel->interpolation == KD_INTERPOLATE_STEP)
            hold(channel, key, out, count);
        else if (channel->interpolation == KD_INTERPOLATE_LINEAR)
            sample_linear(channel, key, u, out, count);
        else
            sample_cubic(channel, key, u, interval_s, out, count);
    }
}
