/* Leaves and nodes. Cells are named by their numbers in the world, so that neither wrapping nor the place of
 * the cascades matters to a reader. */
#include <stdlib.h>
#include <string.h>

#include "components/svo.h"
#include "components/voxel_scene.h"
#include "runtime/app/voxel_bench/dump.h"
#include "runtime/app/voxel_bench/unpack.h"
#include "runtime/core/half.h"
#include "runtime/core/log.h"
#include "systems/svo/reference.h"

/* ---- cells ---- */

/* World number of a cell of a level that is `shift` steps above the leaves, from its code. */
static uint32_t world_cell(const kd_voxel_scene *scene, uint32_t log2_size, uint32_t shift, uint32_t code,
                           int32_t out[3])
{
    uint32_t c = code >> (3 * log2_size), wrapped[3];
    svo_morton_cell(code & ((1u << (3 * log2_size)) - 1), wrapped);
    for (int k = 0; k < 3; k++) {
        int32_t origin = scene->origin_cells[c][k] >> shift;
        out[k] = origin + (int32_t)((wrapped[k] - (uint32_t)origin) & ((1u << log2_size) - 1));
    }
    return c;
}

/* Which parents something moves in, by rank: their mask, the ranks of its words, and which of the eight cells
 * move. Zeros when nothing does. */
static uint32_t *read_moving(const dump *d, const kd_svo *svo)
{
    size_t bytes = (size_t)kd_svo_parent_words(svo) * 8, room = kd_svo_moving_room(svo);
    uint32_t *moving = calloc(1, bytes + room * 4);
    if (!moving) {
        (void)kd_fail(KD_NO_MEMORY, "--dump: out of memory for %zu bytes", bytes + room * 4);
        return NULL;
    }
    if (svo->has_moving)
        kd_gpu_read_buffer(d->rig->gpu, svo->moving, 0, moving, bytes);
    if (room)
        kd_gpu_read_buffer(d->rig->gpu, svo->dynamic_cells, kd_svo_moving_words(svo), moving + bytes / 4,
                           room * 4);
    return moving;
}

/* Rank of a leaf parent among those in which something moves; KD_EMPTY: it is none of them, or there is no
 * room. */
static uint32_t moving_rank(const uint32_t *moving, const kd_svo *svo, uint32_t parent)
{
    uint32_t words = kd_svo_parent_words(svo), word = moving[parent >> 5];
    uint32_t below = word & ((1u << (parent & 31)) - 1);
    uint32_t rank = moving[words + (parent >> 5)] + (uint32_t)__builtin_popcount(below);
    return word >> (parent & 31) & 1u && rank < kd_svo_moving_room(svo) ? rank : KD_EMPTY;
}

/* Which of its eight cells move, a bit each. */
static uint32_t moving_cells(const uint32_t *moving, const kd_svo *svo, uint32_t parent)
{
    uint32_t rank = moving_rank(moving, svo, parent);
    return rank == KD_EMPTY ? 0 : moving[2 * kd_svo_parent_words(svo) + rank];
}

/* ---- leaves ---- */

typedef struct leaf_row {
    uint32_t cascade;
    int32_t cell[3];
    uint32_t layers; /* 1 static, 2 dynamic, 3 both */
    float weight, albedo[3], emission[3], normal[3], depth, radiance[3], other;
} leaf_row;

static const dump_column leaf_columns[] = {
    {"cascade", "<u4"},    {"x", "<i4"},          {"y", "<i4"},          {"z", "<i4"},
    {"layers", "<u4"},     {"weight", "<f4"},     {"albedo_r", "<f4"},   {"albedo_g", "<f4"},
    {"albedo_b", "<f4"},   {"emission_r", "<f4"}, {"emission_g", "<f4"}, {"emission_b", "<f4"},
    {"normal_x", "<f4"},   {"normal_y", "<f4"},   {"normal_z", "<f4"},   {"depth", "<f4"},
    {"radiance_r", "<f4"}, {"radiance_g", "<f4"}, {"radiance_b", "<f4"}, {"other", "<f4"},
    {NULL, NULL},
};

/* All that leaves are made of, read back. */
typedef struct leaf_source {
    uint32_t *blocks, *moving, *codes, *albedo, *emission, *cells, *leaves;
    bool glows; /* otherwise there is no emission */
} leaf_source;

static void free_leaves(leaf_source *s)
{
    uint32_t *held[] = {s->blocks, s->moving, s->codes, s->albedo, s->emission, s->cells, s->leaves};
    for (size_t i = 0; i < sizeof held / sizeof *held; i++)
        free(held[i]);
}

static bool read_leaves(const dump *d, const kd_svo *svo, leaf_source *s)
{
    size_t parents = (size_t)svo->node_capacity * 4, slots = svo->leaf_room;
    uint32_t top = svo->leaf_level - 1 - KD_DENSE_LOG2;
    *s = (leaf_source){
        .blocks = dump_read(d, svo->book, (size_t)svo->places.blocks.x * 4, parents),
        .moving = read_moving(d, svo),
        .codes = dump_read(d, svo->book, (size_t)(&svo->places.codes.x)[top] * 4, parents),
        .albedo = dump_read(d, svo->static_albedo, 0, slots * 4),
        .emission = dump_read(d, svo->static_emission, 0, svo->glows ? slots * 8 : 4),
        .glows = svo->glows,
        .cells = dump_read(d, svo->dynamic_cells, 0, (size_t)svo->dynamic_room * 8 * 16),
        .leaves = dump_read(d, svo->leaves, 0, slots * 8 + (size_t)kd_svo_moving_room(svo) * 64),
    };
    return s->blocks && s->moving && s->codes && s->albedo && s->emission && s->cells && s->leaves;
}

/* Add a layer's cell to the row: means by weight, as light sees them. */
static void add_cell(leaf_row *row, const uint32_t words[4])
{
    float albedo[3], emission[3], weight, sum;
    unpack_cell(words, albedo, emission, &weight);
    sum = row->weight + weight / 256;
    for (int k = 0; k < 3 && sum > 0; k++) {
        row->albedo[k] = (row->albedo[k] * row->weight + albedo[k] * weight / 256) / sum;
        row->emission[k] = fmaxf(row->emission[k], emission[k]);
    }
    row->weight = sum;
}

static void add_static(leaf_row *row, const leaf_source *s, uint32_t slot)
{
    uint32_t words[4] = {s->albedo[slot], s->leaves[2 * (size_t)slot + 1]};
    if (s->glows)
        memcpy(words + 2, s->emission + 2 * (size_t)slot, 8);
    row->layers |= 1;
    add_cell(row, words);
}

static void put_leaf(dump *d, const kd_voxel_scene *scene, const kd_svo *svo, const leaf_source *s,
                     uint32_t number, uint32_t k)
{
    uint32_t code = s->codes[number] * 8 + k, slot = kd_svo_block_slot(svo, s->blocks[number], k);
    uint32_t rank = moving_rank(s->moving, svo, code >> 3);
    bool still = slot != KD_EMPTY, moving = moving_cells(s->moving, svo, code >> 3) >> k & 1u;
    leaf_row row = {0};
    if (!still && !moving)
        return;
    if (still)
        add_static(&row, s, slot);
    if (moving) {
        row.layers |= 2;
        add_cell(&row, s->cells + 4 * ((size_t)rank * 8 + k));
    }
    const uint32_t none[2] = {0}, *leaf = none;
    if (rank != KD_EMPTY)
        leaf = s->leaves + 2 * ((size_t)svo->leaf_room + 8 * rank + k);
    else if (still)
        leaf = s->leaves + 2 * (size_t)slot;
    row.cascade = world_cell(scene, svo->leaf_level, 0, code, row.cell);
    unpack_leaf_normal(leaf[1], row.normal);
    row.depth = unpack_leaf_depth(leaf[1]);
    row.other = unpack_leaf_other(leaf[1]);
    unpack_rgb9e5(leaf[0], row.radiance);
    for (int i = 0; i < 3; i++) {
        row.radiance[i] *= scene->stored_unit > 0 ? scene->stored_unit : 1;
        row.emission[i] *= scene->brightest_emission;
    }
    dump_row(d, &row, sizeof row);
}

kd_status dump_leaves(dump *d)
{
    const kd_voxel_scene *scene = kd_singleton(d->rig->world, kd_voxel_scene);
    const kd_svo *svo = kd_singleton(d->rig->world, kd_svo);
    leaf_source s;
    kd_status status = dump_begin(d, "leaves.bin");
    if (status != KD_OK)
        return status;
    if (!read_leaves(d, svo, &s)) {
        kd_file_out_cancel(&d->file);
        status = KD_NO_MEMORY;
    } else {
        for (uint32_t n = 0; n < svo->node_capacity; n++)
            for (uint32_t k = 0; k < 8 && s.codes[n] != KD_EMPTY; k++)
                put_leaf(d, scene, svo, &s, n, k);
        status = dump_end(d, "leaves.bin", leaf_columns);
    }
    free_leaves(&s);
    return status;
}

/* ---- nodes ---- */

typedef struct node_row {
    uint32_t level, cascade;
    int32_t cell[3];
    uint32_t number, children[8]; /* numbers on the next level; of leaves 8 number + k; KD_EMPTY: none */
    float depth[6], radiance[3];
} node_row;

static const dump_column node_columns[] = {
    {"level", "<u4"},      {"cascade", "<u4"},    {"x", "<i4"},          {"y", "<i4"},
    {"z", "<i4"},          {"number", "<u4"},     {"child_0", "<u4"},    {"child_1", "<u4"},
    {"child_2", "<u4"},    {"child_3", "<u4"},    {"child_4", "<u4"},    {"child_5", "<u4"},
    {"child_6", "<u4"},    {"child_7", "<u4"},    {"depth_px", "<f4"},   {"depth_nx", "<f4"},
    {"depth_py", "<f4"},   {"depth_ny", "<f4"},   {"depth_pz", "<f4"},   {"depth_nz", "<f4"},
    {"radiance_r", "<f4"}, {"radiance_g", "<f4"}, {"radiance_b", "<f4"}, {NULL, NULL},
};

typedef struct node_source {
    uint32_t *blocks, *moving, *codes, *nodes, *data;
    uint32_t *atlas, *depths; /* dense levels, rgb9e5 */
} node_source;

static void free_nodes(node_source *s)
{
    free(s->blocks);
    free(s->moving);
    free(s->codes);
    free(s->nodes);
    free(s->data);
    free(s->atlas);
    free(s->depths);
}

static uint32_t *read_dense(const dump *d, kd_gpu_texture texture, uint32_t slices)
{
    size_t bytes = (size_t)KD_DENSE * KD_DENSE * slices * 4;
    uint32_t *texels = malloc(bytes);
    if (texels)
        kd_gpu_read_texture(d->rig->gpu, texture, 0, texels, bytes);
    else
        (void)kd_fail(KD_NO_MEMORY, "--dump: out of memory for %zu bytes", bytes);
    return texels;
}

static bool read_nodes(const dump *d, const kd_svo *svo, uint32_t levels, node_source *s)
{
    size_t nodes = kd_gpu_buffer_size(d->rig->gpu, svo->nodes), data = kd_svo_data_first(svo, levels);
    *s = (node_source){
        .blocks = dump_read(d, svo->book, (size_t)svo->places.blocks.x * 4, (size_t)svo->node_capacity * 4),
        .moving = read_moving(d, svo),
        .nodes = dump_read(d, svo->nodes, 0, nodes),
        .data = dump_read(d, svo->data, 0, data * 8),
        .atlas = read_dense(d, svo->atlas, KD_ATLAS_SLICES(svo->cascades, 6)),
        .depths = read_dense(d, svo->depths, KD_ATLAS_SLICES(svo->cascades, 2))};
    return s->blocks && s->moving && s->nodes && s->data && s->atlas && s->depths;
}

/* A dense cell from the atlas: depth by direction, and the mean of what these see. */
static void load_dense(node_row *row, const node_source *s, uint32_t code)
{
    uint32_t wrapped[3], c = code >> (3 * KD_DENSE_LOG2);
    float light[3] = {0}, depths = 0;
    svo_morton_cell(code & ((1u << (3 * KD_DENSE_LOG2)) - 1), wrapped);
    for (uint32_t i = 0; i < 6; i++) {
        size_t slice = wrapped[2] + (c * 6 + i) * KD_ATLAS_BLOCK + 1,
               in_slice = wrapped[1] * KD_DENSE + wrapped[0];
        size_t of_depth = wrapped[2] + (c * 2 + (i & 1)) * KD_ATLAS_BLOCK + 1;
        float seen[3], met[3];
        unpack_rgb9e5(s->depths[of_depth * KD_DENSE * KD_DENSE + in_slice], met);
        unpack_rgb9e5(s->atlas[slice * KD_DENSE * KD_DENSE + in_slice], seen);
        row->depth[i] = met[i >> 1];
        depths += row->depth[i];
        for (int k = 0; k < 3; k++)
            light[k] += seen[k];
    }
    for (int k = 0; k < 3 && depths > 0; k++)
        row->radiance[k] = light[k] / depths;
}

static void load_sparse(node_row *row, const node_source *s, size_t entry)
{
    const uint32_t *word = s->data + 2 * entry;
    unpack_rgb9e5(word[0], row->radiance);
    for (int i = 0; i < 6; i++)
        row->depth[i] = unpack_node_depth(word[1], i);
}

static void load_children(node_row *row, const node_source *s, const kd_svo *svo, uint32_t l, uint32_t code)
{
    bool leaf_parent = svo->leaf_level - KD_DENSE_LOG2 == l + 1;
    uint32_t moves = leaf_parent ? moving_cells(s->moving, svo, code) : 0;
    for (uint32_t k = 0; k < 8; k++) {
        if (!leaf_parent)
            row->children[k] = s->nodes[(&svo->places.child.x)[l] + (size_t)row->number * 8 + k];
        else if (kd_svo_block_slot(svo, s->blocks[row->number], k) != KD_EMPTY || (moves >> k & 1u))
            row->children[k] = row->number * 8 + k;
        else
            row->children[k] = KD_EMPTY;
    }
}

static void put_node(dump *d, const kd_voxel_scene *scene, const kd_svo *svo, const node_source *s,
                     uint32_t l, uint32_t number)
{
    uint32_t code = s->codes[number], log2_size = KD_DENSE_LOG2 + l;
    float unit = scene->stored_unit > 0 ? scene->stored_unit : 1;
    node_row row = {.level = l, .number = number};
    row.cascade = world_cell(scene, log2_size, svo->leaf_level - log2_size, code, row.cell);
    if (l == 0)
        load_dense(&row, s, code);
    else
        load_sparse(&row, s, (size_t)kd_svo_data_first(svo, l) + number);
    load_children(&row, s, svo, l, code);
    for (int k = 0; k < 3; k++)
        row.radiance[k] *= unit;
    dump_row(d, &row, sizeof row);
}

static kd_status put_level(dump *d, const kd_voxel_scene *scene, const kd_svo *svo, node_source *s,
                           uint32_t l)
{
    uint32_t room = svo->node_room[l];
    s->codes = dump_read(d, svo->book, (size_t)(&svo->places.codes.x)[l] * 4, (size_t)room * 4);
    if (!s->codes)
        return KD_NO_MEMORY;
    for (uint32_t n = 0; n < room; n++)
        if (s->codes[n] != KD_EMPTY)
            put_node(d, scene, svo, s, l, n);
    free(s->codes);
    s->codes = NULL;
    return KD_OK;
}

kd_status dump_nodes(dump *d)
{
    const kd_voxel_scene *scene = kd_singleton(d->rig->world, kd_voxel_scene);
    const kd_svo *svo = kd_singleton(d->rig->world, kd_svo);
    uint32_t levels = svo->leaf_level - KD_DENSE_LOG2;
    node_source s;
    kd_status status = dump_begin(d, "nodes.bin");
    if (status != KD_OK)
        return status;
    status = read_nodes(d, svo, levels, &s) ? KD_OK : KD_NO_MEMORY;
    for (uint32_t l = 0; l < levels && status == KD_OK; l++)
        status = put_level(d, scene, svo, &s, l);
    if (status == KD_OK)
        status = dump_end(d, "nodes.bin", node_columns);
    else
        kd_file_out_cancel(&d->file);
    free_nodes(&s);
    return status;
}
