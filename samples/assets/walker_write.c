/* The creature as glTF: one mesh of two primitives (hide, eyes), one skin, one animation a clip. */

#include <stdio.h>
#include <stdlib.h>

#include "samples/assets/generate.h"
#include "samples/assets/walker.h"

/* ---- mesh ---- */

/* Copy one field of every vertex into an array of its own and add it. */
static int add_attribute(gltf *g, const skin_mesh *mesh, size_t offset, size_t size, gltf_array array)
{
    bytes packed = {0};
    for (int i = 0; i < mesh->vertex_count; i++)
        bytes_add(&packed, (const char *)&mesh->vertices[i] + offset, size);
    array.data = packed.data;
    array.count = mesh->vertex_count;
    array.target = GLTF_VERTICES;
    int accessor = gltf_add_array(g, &array);
    bytes_free(&packed);
    return accessor;
}

#define ADD_FIELD(g, mesh, field, ...)                                                                       \
    add_attribute(g, mesh, offsetof(skin_vertex, field), sizeof(((skin_vertex *)0)->field),                  \
                  (gltf_array){__VA_ARGS__})

static void print_primitive(gltf *g, bytes *out, const skin_mesh *mesh, int material, const char *extras)
{
    int position = ADD_FIELD(g, mesh, position, .width = 3, .type = GLTF_F32, .bounds = true);
    int normal = ADD_FIELD(g, mesh, normal, .width = 3, .type = GLTF_F32);
    int color = ADD_FIELD(g, mesh, color, .width = 4, .type = GLTF_U8, .normalized = true);
    int joints = ADD_FIELD(g, mesh, joints, .width = 4, .type = GLTF_U8);
    int weights = ADD_FIELD(g, mesh, weights, .width = 4, .type = GLTF_U16, .normalized = true);
    int indices = gltf_add_array(g, &(gltf_array){.data = mesh->indices,
                                                  .count = mesh->index_count,
                                                  .width = 1,
                                                  .type = GLTF_U16,
                                                  .target = GLTF_INDICES});
    bytes_print(
        out,
        "{\"attributes\":{\"POSITION\":%d,\"NORMAL\":%d,\"COLOR_0\":%d,\"JOINTS_0\":%d,\"WEIGHTS_0\":%d},"
        "\"indices\":%d,\"material\":%d%s}",
        position, normal, color, joints, weights, indices, material, extras);
}

static bool is_sole(const skin_mesh *mesh, int quad)
{
    bool sole = true;
    for (int k = 0; k < 4; k++)
        sole &= walker_on_ground(&mesh->vertices[mesh->quads[quad][k]]);
    return sole;
}

/* An edge of a sole that no other sole shares is its rim. */
static bool is_rim(const skin_mesh *mesh, int a, int b)
{
    for (int q = 0; q < mesh->quad_count; q++)
        for (int k = 0; k < 4 && is_sole(mesh, q); k++)
            if (mesh->quads[q][k] == b && mesh->quads[q][(k + 1) % 4] == a)
                return false;
    return true;
}

/* The cage as docs/subdivision.md describes it; the rims of the soles are creased. */
static void print_cage(bytes *out, const skin_mesh *mesh)
{
    bytes sizes = {0}, corners = {0}, creases = {0}, lengths = {0}, sharpness = {0};
    for (int q = 0; q < mesh->quad_count; q++) {
        const uint16_t *quad = mesh->quads[q];
        bytes_print(&sizes, "%s4", q ? "," : "");
        bytes_print(&corners, "%s%d,%d,%d,%d", q ? "," : "", quad[0], quad[1], quad[2], quad[3]);
        for (int k = 0; k < 4 && is_sole(mesh, q); k++) {
            int a = quad[k], b = quad[(k + 1) % 4];
            if (!is_rim(mesh, a, b))
                continue;
            const char *comma = creases.size ? "," : "";
            bytes_print(&creases, "%s%d,%d", comma, a, b);
            bytes_print(&lengths, "%s2", comma);
            bytes_print(&sharpness, "%s2.5", comma);
        }
    }
    bytes_print(out,
                ",\n      \"extras\":{\"subdivisionScheme\":\"catmullClark\",\"level\":3,\n"
                "      \"faceVertexCounts\":[%s],\n      \"faceVertexIndices\":[%s],\n"
                "      \"creaseIndices\":[%s],\"creaseLengths\":[%s],\"creaseSharpnesses\":[%s]}",
                sizes.data, corners.data, creases.size ? creases.data : "", creases.size ? lengths.data : "",
                creases.size ? sharpness.data : "");
    bytes *const all[] = {&sizes, &corners, &creases, &lengths, &sharpness};
    for (int i = 0; i < 5; i++)
        bytes_free(all[i]);
}

static void add_mesh(gltf *g, bool cage)
{
    skin_mesh body = {0}, eyes = {0};
    bytes primitives = {0};
    bytes extras = {0};
    (cage ? walker_make_cage : walker_make_body)(&body);
    if (cage)
        print_cage(&extras, &body);
    walker_make_eyes(&eyes);
    print_primitive(g, &primitives, &body, 0, cage ? extras.data : "");
    bytes_print(&primitives, ",");
    print_primitive(g, &primitives, &eyes, 1, "");
    gltf_add(g, GLTF_MESHES, "{\"name\":\"walker\",\"primitives\":[%s]}", primitives.data);
    gltf_add(g, GLTF_MATERIALS,
             "{\"name\":\"hide\",\"pbrMetallicRoughness\":{\"metallicFactor\":0,\"roughnessFactor\":0.75}}");
    gltf_add(g, GLTF_MATERIALS,
             "{\"name\":\"eye\",\"pbrMetallicRoughness\":{\"metallicFactor\":0,\"roughnessFactor\":0.15}}");
    bytes_free(&primitives);
    bytes_free(&extras);
    skin_mesh_free(&body);
    skin_mesh_free(&eyes);
}

/* ---- skeleton: node j is joint j; the mesh's node comes last ---- */

static void add_nodes(gltf *g)
{
    for (int j = 0; j < WALKER_JOINTS; j++) {
        const joint_info *info = &walker_joints[j];
        bytes children = {0};
        for (int k = j + 1; k < WALKER_JOINTS; k++)
            if (walker_joints[k].parent == j)
                bytes_print(&children, "%s%d", children.size ? "," : ",\"children\":[", k);
        if (children.size)
            bytes_print(&children, "]");
        vec3 t =
            info->parent < 0 ? info->position : v_sub(info->position, walker_joints[info->parent].position);
        gltf_add(g, GLTF_NODES, "{\"name\":\"%s\",\"translation\":[%.9g,%.9g,%.9g]%s}", info->name,
                 (double)(float)t.x, (double)(float)t.y, (double)(float)t.z,
                 children.size ? children.data : "");
        bytes_free(&children);
    }
    int mesh_node = gltf_add(g, GLTF_NODES, "{\"name\":\"walker\",\"mesh\":0,\"skin\":0}");
    gltf_add(g, GLTF_SCENES, "{\"name\":\"walker\",\"nodes\":[%d,%d]}", ROOT, mesh_node);
}

static void add_skin(gltf *g)
{
    float inverse_bind[WALKER_JOINTS][16] = {{0}};
    bytes joints = {0};
    for (int j = 0; j < WALKER_JOINTS; j++) {
        vec3 p = walker_joints[j].position;
        float *m = inverse_bind[j];
        m[0] = m[5] = m[10] = m[15] = 1;
        m[12] = (float)(0 - p.x); /* not -p.x: a zero stays positive */
        m[13] = (float)(0 - p.y);
        m[14] = (float)(0 - p.z);
        bytes_print(&joints, "%s%d", j ? "," : "", j);
    }
    int matrices = gltf_add_array(
        g, &(gltf_array){.data = inverse_bind, .count = WALKER_JOINTS, .width = 16, .type = GLTF_F32});
    gltf_add(g, GLTF_SKINS,
             "{\"name\":\"walker\",\"skeleton\":%d,\"inverseBindMatrices\":%d,\"joints\":[%s]}", ROOT,
             matrices, joints.data);
    bytes_free(&joints);
}

/* ---- clips ---- */

enum {
    HIPS_MOVE = WALKER_JOINTS,
    BELLY_SCALE,
    CHANNEL_COUNT
}; /* channels below WALKER_JOINTS turn that joint */

static void channel_value(const walker_pose *pose, int channel, double out[4])
{
    vec3 base = walker_joints[ROOT].position;
    if (channel == HIPS_MOVE) {
        out[0] = pose->hips.x - base.x, out[1] = pose->hips.y - base.y, out[2] = pose->hips.z - base.z,
        out[3] = 0;
    } else if (channel == BELLY_SCALE) {
        out[0] = out[2] = pose->belly, out[1] = mix(1, pose->belly, 0.5), out[3] = 0;
    } else {
        quat q = q_unit(pose->rotation[channel]);
        double sign =
            q.w < 0 ? -1 : 1; /* no joint turns by more than a half turn: w >= 0 keeps the keys continuous */
        out[0] = sign * q.x, out[1] = sign * q.y, out[2] = sign * q.z, out[3] = sign * q.w;
    }
}

static void sample(const walker_clip *clip, double time_s, int channel, double out[4])
{
    walker_pose pose;
    clip->pose(time_s, &pose);
    channel_value(&pose, channel, out);
}

static void add_floats(bytes *out, const double *values, int count)
{
    for (int c = 0; c < count; c++) {
        float v = (float)values[c];
        bytes_add(out, &v, sizeof v);
    }
}

/* Every key's value; for a cubic clip in-tangent, value and out-tangent. Returns whether the channel moves at
 * all. */
static bool collect_keys(const walker_clip *clip, int channel, int width, bytes *out)
{
    bool moves = false;
    double first[4], value[4], before[4], after[4];
    const double h = 1.0 / 1024;
    sample(clip, 0, channel, first);
    for (int i = 0; i < clip->keys; i++) {
        double t = clip->duration_s * i / (clip->keys - 1), tangent[4];
        sample(clip, t, channel, value);
        sample(clip, t - h, channel, before);
        sample(clip, t + h, channel, after);
        for (int c = 0; c < width; c++) {
            tangent[c] = (after[c] - before[c]) / (2 * h);
            moves |= value[c] > first[c] + 1e-6 || value[c] < first[c] - 1e-6;
        }
        if (clip->cubic)
            add_floats(out, tangent, width);
        add_floats(out, value, width);
        if (clip->cubic)
            add_floats(out, tangent, width);
    }
    return moves;
}

static int add_times(gltf *g, const walker_clip *clip)
{
    bytes times = {0};
    for (int i = 0; i < clip->keys; i++)
        add_floats(&times, &(double){clip->duration_s * i / (clip->keys - 1)}, 1);
    int accessor = gltf_add_array(
        g,
        &(gltf_array){.data = times.data, .count = clip->keys, .width = 1, .type = GLTF_F32, .bounds = true});
    bytes_free(&times);
    return accessor;
}

/* Every joint gets its rotation in every clip, moving or not: clips then replace each other without
 * leftovers. A still one is written as a single key. */
static void add_channel(gltf *g, const walker_clip *clip, int channel, const int times[2], bytes *channels,
                        bytes *samplers)
{
    int width = channel < WALKER_JOINTS ? 4 : 3;
    int node = channel == HIPS_MOVE ? HIPS : channel == BELLY_SCALE ? BELLY : channel;
    const char *path = channel == HIPS_MOVE ? "translation" : channel == BELLY_SCALE ? "scale" : "rotation";
    bytes keys = {0};
    bool moves = collect_keys(clip, channel, width, &keys);
    bool cubic = clip->cubic && moves;
    const float *values = (const float *)(const void *)keys.data;
    gltf_array array = {
        .data = values, .count = clip->keys * (cubic ? 3 : 1), .width = width, .type = GLTF_F32};
    if (!moves) {
        array.data = clip->cubic ? values + width : values; /* past the first in-tangent */
        array.count = 1;
    }
    int output = gltf_add_array(g, &array), index = 0;
    for (size_t i = 0; i < samplers->size; i++)
        index += samplers->data[i] == '{';
    bytes_print(samplers, "%s{\"input\":%d,\"output\":%d,\"interpolation\":\"%s\"}", index ? "," : "",
                times[!moves], output,
                cubic   ? "CUBICSPLINE"
                : moves ? "LINEAR"
                        : "STEP");
    bytes_print(channels, "%s{\"sampler\":%d,\"target\":{\"node\":%d,\"path\":\"%s\"}}", index ? "," : "",
                index, node, path);
    bytes_free(&keys);
}

static void add_clip(gltf *g, const walker_clip *clip, int still_time)
{
    bytes channels = {0}, samplers = {0};
    int times[2] = {add_times(g, clip), still_time};
    for (int channel = HIPS; channel < CHANNEL_COUNT; channel++)
        add_channel(g, clip, channel, times, &channels, &samplers);
    gltf_add(g, GLTF_ANIMATIONS, "{\"name\":\"%s\",\n      \"channels\":[%s],\n      \"samplers\":[%s]}",
             clip->name, channels.data, samplers.data);
    bytes_free(&channels);
    bytes_free(&samplers);
}

static bool write_one(const char *folder, const char *name, bool cage)
{
    gltf g = {0};
    add_mesh(&g, cage);
    add_nodes(&g);
    add_skin(&g);
    float zero = 0;
    gltf_array still = {.data = &zero, .count = 1, .width = 1, .type = GLTF_F32, .bounds = true};
    int still_time = gltf_add_array(&g, &still);
    for (int c = 0; c < WALKER_CLIPS; c++)
        add_clip(&g, &walker_clips[c], still_time);
    bool ok = gltf_save(&g, folder, name);
    gltf_free(&g);
    return ok;
}

bool walker_write(const char *folder)
{
    return write_one(folder, "walker", false) && write_one(folder, "walker_cage", true);
}
