#include "runtime/asset/mesh_build.h"

#include <math.h>

size_t mesh_unroll_bound(mesh_topology topology, size_t count)
{
    if (topology == MESH_LIST)
        return count / 3 * 3;
    return count < 3 ? 0 : (count - 2) * 3;
}

static size_t put_triangle(uint32_t *out, uint32_t a, uint32_t b, uint32_t c)
{
    if (a == b || b == c || a == c)
        return 0;
    out[0] = a;
    out[1] = b;
    out[2] = c;
    return 3;
}

size_t mesh_unroll(mesh_topology topology, const uint32_t *in, size_t count, uint32_t *out)
{
    size_t written = 0;
    if (topology == MESH_LIST) {
        written = count / 3 * 3;
        memcpy(out, in, written * sizeof *out);
        return written;
    }
    for (size_t i = 0; i + 2 < count; i++) {
        if (topology == MESH_FAN)
            written += put_triangle(out + written, in[i + 1], in[i + 2], in[0]);
        else
            written += put_triangle(out + written, in[i], in[i + 1 + (i & 1)], in[i + 2 - (i & 1)]);
    }
    return written;
}

/* Twice the triangle's area along its normal. Products of large models overflow in float, so this works in
 * double. */
static kd_vec3 face_vector(kd_vec3 a, kd_vec3 b, kd_vec3 c, bool *flat)
{
    double ux = (double)b.x - a.x, uy = (double)b.y - a.y, uz = (double)b.z - a.z;
    double vx = (double)c.x - a.x, vy = (double)c.y - a.y, vz = (double)c.z - a.z;
    double x = uy * vz - uz * vy, y = uz * vx - ux * vz, z = ux * vy - uy * vx;
    double length = sqrt(x * x + y * y + z * z);
    *flat = !(length > 0) || !isfinite(length);
    if (*flat)
        return (kd_vec3){0, 1, 0};
    return (kd_vec3){(float)(x / length), (float)(y / length), (float)(z / length)};
}

void mesh_flat_normals(const kd_vec3 *positions, size_t corner_count, kd_vec3 *normals)
{
    for (size_t i = 0; i + 2 < corner_count; i += 3) {
        bool flat;
        kd_vec3 n = face_vector(positions[i], positions[i + 1], positions[i + 2], &flat);
        normals[i] = normals[i + 1] = normals[i + 2] = n;
    }
}

/* Normalise without overflow or loss for any finite length. Returns false for a vector without direction. */
static bool unit(kd_vec3 *v)
{
    float largest = fmaxf(fmaxf(fabsf(v->x), fabsf(v->y)), fabsf(v->z));
    if (!(largest > 1e-30f) || !isfinite(largest))
        return false;
    kd_vec3 scaled = {v->x / largest, v->y / largest, v->z / largest};
    *v = kd_vec3_scale(scaled, 1 / kd_vec3_length(scaled));
    return true;
}

static void accumulate_faces(const kd_vec3 *positions, const uint32_t *indices, size_t index_count,
                             kd_vec3 *sums)
{
    for (size_t i = 0; i + 2 < index_count; i += 3) {
        kd_vec3 a = positions[indices[i]], b = positions[indices[i + 1]], c = positions[indices[i + 2]];
        kd_vec3 face = kd_vec3_cross(kd_vec3_sub(b, a), kd_vec3_sub(c, a));
        for (int k = 0; k < 3; k++)
            sums[indices[i + (size_t)k]] = kd_vec3_add(sums[indices[i + (size_t)k]], face);
    }
}

size_t mesh_mend_normals(const kd_vec3 *positions, const uint32_t *indices, size_t index_count,
                         kd_vec3 *normals, size_t vertex_count, kd_vec3 *scratch)
{
    size_t bad = 0;
    for (size_t i = 0; i < vertex_count; i++)
        if (!unit(&normals[i])) {
            normals[i] = (kd_vec3){0, 0, 0};
            bad++;
        }
    if (!bad)
        return 0;
    memset(scratch, 0, vertex_count * sizeof *scratch);
    accumulate_faces(positions, indices, index_count, scratch);
    for (size_t i = 0; i < vertex_count; i++)
        if (kd_vec3_dot(normals[i], normals[i]) == 0)
            normals[i] = unit(&scratch[i]) ? scratch[i] : (kd_vec3){0, 1, 0};
    return bad;
}

/* Duff et al. 2017, "Building an Orthonormal Basis, Revisited", listing 3: the first axis. */
static kd_vec3 any_tangent(kd_vec3 n)
{
    float sign = copysignf(1, n.z), a = -1 / (sign + n.z);
    kd_vec3 t = {1 + sign * n.x * n.x * a, sign * n.x * n.y * a, -sign * n.x};
    return kd_vec3_normalize(t, (kd_vec3){1, 0, 0});
}

static void accumulate_tangents(const kd_vec3 *positions, const kd_vec2 *uv, const uint32_t *indices,
                                size_t index_count, kd_vec3 *along_u, kd_vec3 *along_v)
{
    for (size_t i = 0; i + 2 < index_count; i += 3) {
        uint32_t a = indices[i], b = indices[i + 1], c = indices[i + 2];
        kd_vec3 p = kd_vec3_sub(positions[b], positions[a]), q = kd_vec3_sub(positions[c], positions[a]);
        float s1 = uv[b].x - uv[a].x, s2 = uv[c].x - uv[a].x, t1 = uv[b].y - uv[a].y, t2 = uv[c].y - uv[a].y;
        float det = s1 * t2 - s2 * t1;
        if (!isfinite(det) || det == 0)
            continue;
        /* Only the direction counts: the sign of the determinant instead of its inverse weights by area. */
        float sign = copysignf(1, det);
        kd_vec3 u = kd_vec3_scale(kd_vec3_sub(kd_vec3_scale(p, t2), kd_vec3_scale(q, t1)), sign);
        kd_vec3 v = kd_vec3_scale(kd_vec3_sub(kd_vec3_scale(q, s1), kd_vec3_scale(p, s2)), sign);
        for (int k = 0; k < 3; k++) {
            uint32_t corner = indices[i + (size_t)k];
            along_u[corner] = kd_vec3_add(along_u[corner], u);
            along_v[corner] = kd_vec3_add(along_v[corner], v);
        }
    }
}

void mesh_make_tangents(const kd_vec3 *positions, const kd_vec3 *normals, const kd_vec2 *uv,
                        const uint32_t *indices, size_t index_count, kd_vec4 *tangents, size_t vertex_count,
                        kd_vec3 *scratch)
{
    kd_vec3 *along_u = scratch, *along_v = scratch + vertex_count;
    memset(scratch, 0, 2 * vertex_count * sizeof *scratch);
    if (uv)
        accumulate_tangents(positions, uv, indices, index_count, along_u, along_v);
    for (size_t i = 0; i < vertex_count; i++) {
        kd_vec3 n = normals[i], t = along_u[i];
        bool known = unit(&t);
        if (known) {
            t = kd_vec3_sub(t, kd_vec3_scale(n, kd_vec3_dot(n, t)));
            known = kd_vec3_length(t) > 1e-4f && unit(&t); /* nearly along the normal: no direction left */
        }
        if (!known)
            t = any_tangent(n);
        float down =
            kd_vec3_dot(kd_vec3_cross(n, t), along_v[i]); /* v runs down the picture, green in it points up */
        tangents[i] = (kd_vec4){t.x, t.y, t.z, down > 0 ? -1.0f : 1.0f};
    }
}
