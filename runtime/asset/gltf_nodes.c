/* The node graph. Every node has at most one parent, so that a walk from the roots meets each node once;
 * nodes that no walk meets would be a cycle. The model gets the nodes of its scene, parents first, and the
 * joints its skins need. */

#include <math.h>
#include <string.h>

#include "runtime/asset/gltf_loader.h"

static const gltf_node *node_at(const gltf_loader *l, uint32_t index)
{
    return &l->doc.nodes[index];
}

/* ---- the graph ---- */

static kd_status find_parents(gltf_loader *l, uint32_t *parents)
{
    for (uint32_t i = 0; i < l->doc.node_count; i++)
        parents[i] = KD_NONE;
    for (uint32_t i = 0; i < l->doc.node_count; i++) {
        gltf_ints children = node_at(l, i)->children;
        for (size_t c = 0; c < children.count; c++) {
            int child = children.at[c];
            if (child < 0 || (size_t)child >= l->doc.node_count)
                return gltf_fail(l, KD_BAD_FORMAT,
                                 "there is no node %d (nodes[%u].children[%zu]); export the model again",
                                 child, i, c);
            if (parents[child] != KD_NONE)
                return gltf_fail(
                    l, KD_BAD_FORMAT,
                    "node %d has two parents, %u and %u (nodes[%u].children); export the model again", child,
                    parents[child], i, i);
            parents[child] = i;
        }
    }
    return KD_OK;
}

/* A walk upwards that is longer than the number of nodes goes round. Each chain is walked once: `seen` holds
 * who came. */
static kd_status refuse_cycles(gltf_loader *l, const uint32_t *parents, uint32_t *seen)
{
    for (uint32_t i = 0; i < l->doc.node_count; i++)
        seen[i] = KD_NONE;
    for (uint32_t i = 0; i < l->doc.node_count; i++)
        for (uint32_t n = i; n != KD_NONE && seen[n] != i; n = parents[n]) {
            if (seen[n] != KD_NONE)
                break;
            seen[n] = i;
            if (parents[n] != KD_NONE && seen[parents[n]] == i)
                return gltf_fail(l, KD_BAD_FORMAT,
                                 "node %u is its own ancestor (nodes[%u].children); export the model again",
                                 n, parents[n]);
        }
    return KD_OK;
}

/* ---- the order in the model ---- */

typedef struct walk {
    uint32_t *order; /* [node_count] document indices in the model's order */
    uint32_t *stack; /* [node_count] */
    uint32_t count;
} walk;

/* Add a tree in the document's order, parents first. */
static void add_tree(gltf_loader *l, walk *w, uint32_t root)
{
    uint32_t depth = 0;
    if (l->node_of[root] != KD_NONE)
        return;
    w->stack[depth++] = root;
    while (depth) {
        uint32_t n = w->stack[--depth];
        l->node_of[n] = w->count;
        w->order[w->count++] = n;
        gltf_ints children = node_at(l, n)->children;
        for (size_t c = children.count; c-- > 0;)
            w->stack[depth++] = (uint32_t)children.at[c];
    }
}

static kd_status add_scene(gltf_loader *l, const uint32_t *parents, walk *w)
{
    if (l->model->scene == KD_NONE) {
        for (uint32_t i = 0; i < l->doc.node_count; i++)
            if (parents[i] == KD_NONE)
                add_tree(l, w, i);
        return KD_OK;
    }
    int scene = (int)l->model->scene;
    if (scene < 0 || (size_t)scene >= l->doc.scene_count)
        return gltf_fail(l, KD_BAD_FORMAT, "there is no scene %d (scene); export the model again", scene);
    gltf_ints roots = l->doc.scenes[scene];
    for (size_t i = 0; i < roots.count; i++) {
        int root = roots.at[i];
        if (root < 0 || (size_t)root >= l->doc.node_count)
            return gltf_fail(l, KD_BAD_FORMAT,
                             "there is no node %d (scenes[%d].nodes[%zu]); export the model again", root,
                             scene, i);
        if (parents[root] != KD_NONE)
            return gltf_fail(
                l, KD_BAD_FORMAT,
                "node %d is no root, it has a parent (scenes[%d].nodes[%zu]); export the model again", root,
                scene, i);
        add_tree(l, w, (uint32_t)root);
    }
    return KD_OK;
}

/* Joints may stand outside the scene: bring in their trees, to be posed but not drawn. */
static void add_joints(gltf_loader *l, const uint32_t *parents, walk *w)
{
    uint32_t drawn = w->count;
    for (uint32_t i = 0; i < drawn; i++) {
        int skin = node_at(l, w->order[i])->skin;
        if (skin < 0 || (size_t)skin >= l->doc.skin_count)
            continue;
        gltf_ints joints = l->doc.skins[skin].joints;
        for (size_t j = 0; j < joints.count; j++) {
            if (joints.at[j] < 0 || (size_t)joints.at[j] >= l->doc.node_count)
                continue; /* gltf_load_skins reports it */
            uint32_t n = (uint32_t)joints.at[j];
            if (l->node_of[n] != KD_NONE)
                continue;
            while (parents[n] != KD_NONE)
                n = parents[n];
            add_tree(l, w, n);
        }
    }
}

/* ---- transforms ---- */

static bool is_affine(const float *m)
{
    return m[3] == 0 && m[7] == 0 && m[11] == 0 && fabsf(m[15] - 1) < 1e-5f;
}

/* Shepperd 1978, "Quaternion from Rotation Matrix": start from the largest component. Columns a, b, c of unit
 * length. */
static kd_quat quat_from_columns(const double a[3], const double b[3], const double c[3])
{
    double trace = a[0] + b[1] + c[2], q[4];
    if (trace > a[0] && trace > b[1] && trace > c[2]) {
        double s = sqrt(1 + trace) * 2;
        q[0] = (b[2] - c[1]) / s, q[1] = (c[0] - a[2]) / s, q[2] = (a[1] - b[0]) / s, q[3] = s / 4;
    } else if (a[0] >= b[1] && a[0] >= c[2]) {
        double s = sqrt(1 + a[0] - b[1] - c[2]) * 2;
        q[0] = s / 4, q[1] = (b[0] + a[1]) / s, q[2] = (c[0] + a[2]) / s, q[3] = (b[2] - c[1]) / s;
    } else if (b[1] >= c[2]) {
        double s = sqrt(1 + b[1] - a[0] - c[2]) * 2;
        q[0] = (b[0] + a[1]) / s, q[1] = s / 4, q[2] = (c[1] + b[2]) / s, q[3] = (c[0] - a[2]) / s;
    } else {
        double s = sqrt(1 + c[2] - a[0] - b[1]) * 2;
        q[0] = (c[0] + a[2]) / s, q[1] = (c[1] + b[2]) / s, q[2] = s / 4, q[3] = (a[1] - b[0]) / s;
    }
    double length = sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
    return (kd_quat){(float)(q[0] / length), (float)(q[1] / length), (float)(q[2] / length),
                     (float)(q[3] / length)};
}

/* Split a matrix into translation, rotation and scale; false where there is shear or no volume. */
static bool decompose(const kd_mat4 *m, kd_node_desc *out)
{
    double column[3][3], length[3];
    for (int c = 0; c < 3; c++) {
        for (int r = 0; r < 3; r++)
            column[c][r] = m->m[c * 4 + r];
        length[c] =
            sqrt(column[c][0] * column[c][0] + column[c][1] * column[c][1] + column[c][2] * column[c][2]);
        if (!(length[c] > 1e-12))
            return false;
        for (int r = 0; r < 3; r++)
            column[c][r] /= length[c];
    }
    const double *a = column[0], *b = column[1], *c = column[2];
    double det = a[0] * (b[1] * c[2] - b[2] * c[1]) - a[1] * (b[0] * c[2] - b[2] * c[0]) +
                 a[2] * (b[0] * c[1] - b[1] * c[0]);
    if (det < 0) { /* a mirror: put it on x */
        length[0] = -length[0];
        for (int r = 0; r < 3; r++)
            column[0][r] = -column[0][r];
    }
    /* Files carry six or seven digits, so that products of unit columns are right to about 1e-6. */
    for (int i = 0; i < 3; i++) {
        const double *u = column[i], *v = column[(i + 1) % 3];
        if (fabs(u[0] * v[0] + u[1] * v[1] + u[2] * v[2]) > 1e-4)
            return false;
    }
    out->rotation = quat_from_columns(column[0], column[1], column[2]);
    out->scale = (kd_vec3){(float)length[0], (float)length[1], (float)length[2]};
    return true;
}

static kd_status load_matrix(gltf_loader *l, uint32_t index, kd_node_desc *out)
{
    const gltf_node *n = node_at(l, index);
    if (n->matrix.count != 16 || !gltf_floats(n->matrix.at, 16, out->matrix.m) || !is_affine(out->matrix.m))
        return gltf_fail(l, KD_BAD_FORMAT,
                         "the matrix is not 16 finite numbers with a last row of 0 0 0 1 (nodes[%u].matrix); "
                         "export the model again",
                         index);
    out->translation = (kd_vec3){out->matrix.m[12], out->matrix.m[13], out->matrix.m[14]};
    out->has_matrix = !decompose(&out->matrix, out);
    return KD_OK;
}

static kd_status load_part(gltf_loader *l, uint32_t index, const char *name, gltf_reals from, size_t count,
                           float *to)
{
    if (!from.count)
        return KD_OK;
    if (from.count != count || !gltf_floats(from.at, count, to))
        return gltf_fail(l, KD_BAD_FORMAT, "not %zu finite numbers (nodes[%u].%s); export the model again",
                         count, index, name);
    return KD_OK;
}

static kd_status load_transform(gltf_loader *l, uint32_t index, kd_node_desc *out)
{
    const gltf_node *n = node_at(l, index);
    out->rotation = (kd_quat){0, 0, 0, 1};
    out->scale = (kd_vec3){1, 1, 1};
    out->matrix = KD_MAT4_IDENTITY;
    if (n->matrix.count)
        return load_matrix(l, index, out);
    float t[3] = {0, 0, 0}, q[4] = {0, 0, 0, 1}, s[3] = {1, 1, 1};
    kd_status status = load_part(l, index, "translation", n->translation, 3, t);
    if (!status)
        status = load_part(l, index, "rotation", n->rotation, 4, q);
    if (!status)
        status = load_part(l, index, "scale", n->scale, 3, s);
    if (status)
        return status;
    float length = sqrtf(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
    if (!(length > 1e-6f) || !isfinite(length)) {
        gltf_warn(l, "nodes[%u].rotation: has no length and is taken as none", index);
        q[0] = q[1] = q[2] = 0;
        q[3] = length = 1;
    }
    out->translation = (kd_vec3){t[0], t[1], t[2]};
    out->rotation = (kd_quat){q[0] / length, q[1] / length, q[2] / length, q[3] / length};
    out->scale = (kd_vec3){s[0], s[1], s[2]};
    return KD_OK;
}

/* ---- what hangs on a node ---- */

static kd_status link(gltf_loader *l, uint32_t node, const char *what, int index, size_t count, uint32_t *out)
{
    *out = KD_NONE;
    if (index == -1)
        return KD_OK;
    if (index < 0 || (size_t)index >= count)
        return gltf_fail(l, KD_BAD_FORMAT,
                         "the %s it names is not there (nodes[%u].%s); export the model again", what, node,
                         what);
    *out = (uint32_t)index;
    return KD_OK;
}

static kd_status load_weights(gltf_loader *l, uint32_t index, kd_node_desc *out)
{
    gltf_reals from = node_at(l, index)->weights;
    out->morph_count = out->mesh == KD_NONE ? 0 : l->model->meshes[out->mesh].morph_count;
    if (!from.count || out->mesh == KD_NONE)
        return KD_OK;
    if (from.count != out->morph_count)
        return gltf_fail(l, KD_BAD_FORMAT,
                         "%zu weights for %u morph targets (nodes[%u].weights); export the model again",
                         from.count, out->morph_count, index);
    float *weights;
    kd_status status = gltf_alloc(l, &l->kept, from.count, sizeof *weights, &weights);
    if (!status && !gltf_floats(from.at, from.count, weights))
        status = gltf_fail(l, KD_BAD_FORMAT,
                           "a weight is not finite (nodes[%u].weights); export the model again", index);
    out->morph_weights = weights;
    return status;
}

static kd_status load_links(gltf_loader *l, uint32_t index, bool drawn, bool hidden, kd_node_desc *out)
{
    const gltf_node *n = node_at(l, index);
    kd_status status = link(l, index, "mesh", n->mesh, l->doc.mesh_count, &out->mesh);
    if (!status)
        status = link(l, index, "skin", n->skin, l->doc.skin_count, &out->skin);
    if (!status)
        status = link(l, index, "camera", n->camera, l->doc.camera_count, &out->camera);
    if (!status)
        status = link(l, index, "light", n->light, l->doc.light_count, &out->light);
    if (!status)
        status = load_weights(l, index, out);
    if (status)
        return status;
    if (!drawn)
        out->mesh = out->skin = out->camera = out->light = KD_NONE;
    if (hidden) /* cameras stay */
        out->mesh = out->skin = out->light = KD_NONE;
    if (out->skin != KD_NONE && (out->mesh == KD_NONE || !l->facts[out->mesh].skinned)) {
        gltf_warn(l, "nodes[%u].skin: the node has no mesh with joints and weights; the skin is left out",
                  index);
        out->skin = KD_NONE;
    }
    if (out->skin != KD_NONE && l->facts[out->mesh].max_joint >= l->doc.skins[out->skin].joints.count)
        return gltf_fail(
            l, KD_BAD_FORMAT,
            "meshes[%u] uses joint %u, but skins[%u] has %zu (nodes[%u]); export the model again", out->mesh,
            l->facts[out->mesh].max_joint, out->skin, l->doc.skins[out->skin].joints.count, index);
    return KD_OK;
}

static kd_status load_node(gltf_loader *l, uint32_t index, uint32_t parent, bool drawn, bool hidden,
                           kd_node_desc *out)
{
    out->name = gltf_name(l, node_at(l, index)->name, "node", index);
    if (!out->name)
        return gltf_fail(l, KD_NO_MEMORY, "out of memory for the node names");
    out->parent = parent == KD_NONE ? KD_NONE : l->node_of[parent];
    kd_status status = load_transform(l, index, out);
    return status ? status : load_links(l, index, drawn, hidden, out);
}

/* ---- in the model's order ---- */

/* A node is hidden by itself or by one above it. */
static kd_status load_listed(gltf_loader *l, const uint32_t *parents, const walk *w, uint32_t drawn,
                             kd_node_desc *nodes)
{
    bool *hidden;
    kd_status status = gltf_alloc(l, &l->scratch, w->count, sizeof *hidden, &hidden);
    for (uint32_t i = 0; !status && i < w->count; i++) {
        uint32_t n = w->order[i], parent = parents[n];
        hidden[i] = node_at(l, n)->hidden || (parent != KD_NONE && hidden[l->node_of[parent]]);
        status = load_node(l, n, parent, i < drawn, hidden[i], &nodes[i]);
    }
    return status;
}

kd_status gltf_load_nodes(gltf_loader *l)
{
    uint32_t *parents, *seen;
    walk w = {0};
    kd_node_desc *nodes = NULL;
    size_t count = l->doc.node_count, copies = 0;
    kd_status status = gltf_alloc(l, &l->scratch, count, sizeof *parents, &parents);
    if (!status)
        status = gltf_alloc(l, &l->scratch, count, sizeof *seen, &seen);
    if (!status)
        status = gltf_alloc(l, &l->scratch, count, sizeof *w.order, &w.order);
    if (!status)
        status = find_parents(l, parents);
    if (!status)
        status = refuse_cycles(l, parents, seen);
    if (status)
        return status;
    w.stack = seen; /* done with: becomes the walk's stack */
    status = add_scene(l, parents, &w);
    if (status)
        return status;
    uint32_t drawn = w.count;
    add_joints(l, parents, &w);
    for (uint32_t i = 0; !status && i < drawn; i++)
        status = gltf_count_instances(l, w.order[i], &copies);
    if (!status)
        status = gltf_alloc(l, &l->kept, w.count + copies, sizeof *nodes, &nodes);
    if (!status)
        status = load_listed(l, parents, &w, drawn, nodes);
    uint32_t used = w.count;
    for (uint32_t i = 0; !status && copies && i < drawn; i++)
        status = gltf_load_instances(l, w.order[i], i, nodes, &used);
    l->model->nodes = nodes;
    l->model->node_count = used;
    return status;
}
