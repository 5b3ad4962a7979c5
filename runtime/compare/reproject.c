/* A picture as it would be a frame later if nothing but the view and the things in it had moved: each pixel
 * is looked up where its surface was. What remains between that and the later picture is flicker. */

#include <math.h>
#include <stdbool.h>

#include "runtime/compare/compare.h"

/* Of depth, by which two texels of one surface differ at most; of normals, the least cosine. Motion by less
 * than a hundredth of a pixel is taken for none: half floats know no better, and interpolating would only
 * blur. */
static const float same_depth = 0.05f, same_normal = 0.8f, whole_pixel = 0.01f;

static bool same_surface(const kd_surfaces *before, size_t i, const kd_surfaces *now, size_t j)
{
    float a = before->depth[i], b = now->depth[j], cosine = 0;
    if (a > KD_NO_DEPTH || b > KD_NO_DEPTH)
        return a > KD_NO_DEPTH && b > KD_NO_DEPTH;
    for (int k = 0; k < 3; k++)
        cosine += before->normal[k][i] * now->normal[k][j];
    return fabsf(a - b) <= same_depth * fminf(a, b) && cosine >= same_normal;
}

/* A place between texels: the four nearest ones along an axis, the border's repeated. */
typedef struct place {
    uint32_t texel[4];
    float sharp[4], soft[4]; /* weights: of a cubic that blurs least; of the inner two alone */
} place;

/* Source  Catmull, Rom 1974, A Class of Local Interpolating Splines */
static bool place_at(float at, uint32_t size, place *out)
{
    float whole = roundf(at);
    if (fabsf(at - whole) < whole_pixel)
        at = whole;
    if (!(at >= 0 && at <= (float)(size - 1)))
        return false;
    int low = (int)at;
    float t = at - (float)low;
    for (int k = 0; k < 4; k++) {
        int texel = low - 1 + k;
        out->texel[k] = texel < 0 ? 0 : texel < (int)size ? (uint32_t)texel : size - 1;
    }
    out->sharp[0] = t * (t * (1 - 0.5f * t) - 0.5f);
    out->sharp[1] = 1 + t * t * (1.5f * t - 2.5f);
    out->sharp[2] = t * (0.5f + t * (2 - 1.5f * t));
    out->sharp[3] = t * t * (0.5f * t - 0.5f);
    out->soft[0] = out->soft[3] = 0;
    out->soft[1] = 1 - t;
    out->soft[2] = t;
    return true;
}

/* Add up the texels round a place that show pixel j's surface. Returns the sum of their weights. */
static float gather(const kd_surfaces *before, const float *rgb, const kd_surfaces *now, size_t j,
                    uint32_t width, const place *x, const place *y, bool sharp, float sum[3])
{
    float total = 0;
    sum[0] = sum[1] = sum[2] = 0;
    for (size_t k = 0; k < 16; k++) {
        size_t u = k % 4, v = k / 4, i = (size_t)y->texel[v] * width + x->texel[u];
        float weight = sharp ? x->sharp[u] * y->sharp[v] : x->soft[u] * y->soft[v];
        if (weight == 0)
            continue;
        if (!same_surface(before, i, now, j)) {
            if (sharp)
                return 0;
            continue;
        }
        total += weight;
        for (size_t c = 0; c < 3; c++)
            sum[c] += weight * rgb[i * 3 + c];
    }
    return total;
}

/* Take the mean of the texels round a place that show pixel j's surface, sharply where all of them do. False:
 * less than half of them do. */
static bool look_up(const kd_surfaces *before, const float *rgb, const kd_surfaces *now, size_t j,
                    uint32_t width, uint32_t height, float out[3])
{
    place x, y;
    if (!place_at((float)(j % width) + now->motion[0][j], width, &x) ||
        !place_at((float)(j / width) + now->motion[1][j], height, &y))
        return false;
    float total = gather(before, rgb, now, j, width, &x, &y, true, out);
    if (total == 0)
        total = gather(before, rgb, now, j, width, &x, &y, false, out);
    for (int c = 0; c < 3; c++)
        out[c] = total > 0 ? fmaxf(out[c] / total, 0) : 0;
    return total >= 0.5f;
}

size_t kd_reproject(const kd_surfaces *before, const float *before_rgb, const kd_surfaces *now,
                    const float *now_rgb, uint32_t width, uint32_t height, float *out, uint8_t *seen)
{
    size_t count = 0;
    for (size_t j = 0; j < (size_t)width * height; j++) {
        seen[j] = look_up(before, before_rgb, now, j, width, height, out + j * 3) ? 1 : 0;
        count += (size_t)seen[j];
        for (size_t c = 0; c < 3 && !seen[j]; c++)
            out[j * 3 + c] = now_rgb[j * 3 + c];
    }
    return count;
}

double kd_mean_seen(const float *map, const uint8_t *seen, size_t count)
{
    double sum = 0;
    size_t pixels = 0;
    for (size_t i = 0; i < count; i++) {
        sum += seen[i] ? (double)map[i] : 0;
        pixels += seen[i];
    }
    return pixels ? sum / (double)pixels : 0;
}
