/* Bits, ranks, sums, levels: in the order of build.c, one plain loop for each of its passes. */
#include "systems/svo/reference.h"

#include <stdlib.h>
#include <string.h>

static uint32_t spread(uint32_t v)
{
    uint32_t out = 0;
    for (uint32_t i = 0; i < 10; i++)
        out |= (v >> i & 1u) << (3 * i);
    return out;
}

uint32_t svo_morton(uint32_t x, uint32_t y, uint32_t z)
{
    return spread(x) | spread(y) << 1 | spread(z) << 2;
}

void svo_morton_cell(uint32_t code, uint32_t cell[3])
{
    cell[0] = cell[1] = cell[2] = 0;
    for (uint32_t i = 0; i < 30; i++)
        cell[i % 3] |= (code >> i & 1u) << (i / 3);
}

uint32_t svo_splat_weight(const uint32_t voxel[KD_PAGE_WORDS], uint32_t i)
{
    uint32_t product = 1;
    for (uint32_t k = 0; k < 3; k++) {
        uint32_t far_share = voxel[1] >> (8 * k) & 255u;
        product *= (i >> k & 1u) ? far_share : 256 - far_share;
    }
    return product >> 16;
}

void svo_splat_cell(const uint32_t voxel[KD_PAGE_WORDS], uint32_t i, int32_t cell[3])
{
    for (uint32_t k = 0; k < 3; k++)
        cell[k] = (int32_t)(voxel[0] >> (10 * k) & 1023u) - 1 + (int32_t)(i >> k & 1u);
}

bool svo_owned(uint32_t resolution, uint32_t c, const int32_t cell[3])
{
    int32_t n = (int32_t)resolution;
    bool inside = true, finer = c > 0;
    for (int k = 0; k < 3; k++) {
        inside = inside && cell[k] >= 0 && cell[k] < n;
        finer = finer && cell[k] >= n / 4 && cell[k] < 3 * (n / 4);
    }
    return inside && !finer;
}

static uint32_t bit_count(uint32_t v)
{
    uint32_t n = 0;
    for (; v; v &= v - 1)
        n++;
    return n;
}

/* ---- layers ---- */

uint32_t svo_wrapped_code(uint32_t leaf_level, const int32_t origin[3], const int32_t cell[3])
{
    uint32_t mask = (1u << leaf_level) - 1, w[3];
    for (int k = 0; k < 3; k++)
        w[k] = (uint32_t)(cell[k] + origin[k]) & mask;
    return svo_morton(w[0], w[1], w[2]);
}

typedef void visit_cell(svo_reference *tree, uint32_t layer, uint32_t bit, uint32_t weight, const void *user);

/* Visit every cell that a page voxel leaves a mark in. */
static void visit_voxel(svo_reference *tree, const svo_reference_source *source, uint32_t layer, uint32_t c,
                        const uint32_t voxel[KD_PAGE_WORDS], visit_cell *visit, const void *user)
{
    for (uint32_t i = 0; i < 8; i++) {
        int32_t cell[3];
        uint32_t weight = svo_splat_weight(voxel, i);
        svo_splat_cell(voxel, i, cell);
        if (weight < KD_SPLAT_MIN_WEIGHT || !svo_owned(1u << tree->leaf_level, c, cell))
            continue;
        uint32_t code = svo_wrapped_code(tree->leaf_level, source->origin[c], cell);
        visit(tree, layer, (c << (3 * tree->leaf_level)) + code, weight, user);
    }
}

static void mark(svo_reference *tree, uint32_t layer, uint32_t bit, uint32_t weight, const void *user)
{
    (void)weight, (void)user;
    tree->masks[layer][bit >> 5] |= 1u << (bit & 31);
}

/* What one voxel adds, before the weight. */
typedef struct voxel_attributes {
    uint32_t albedo[3], emission[3], area;
    int32_t normal[3];
    bool double_sided;
} voxel_attributes;

static voxel_attributes load_attributes(const svo_reference_source *source,
                                        const struct kd_voxel_segment *segment, uint32_t i,
                                        const uint32_t voxel[KD_PAGE_WORDS])
{
    uint32_t color = source->color[segment->first + i];
    voxel_attributes a = {.double_sided = (color >> 24 & 1u) != 0, .area = color >> 25};
    const float *emissive = &source->objects[segment->object].emission.x;
    uint32_t share = source->shape[segment->first + i][1] >> 24;
    for (int k = 0; k < 3; k++) {
        uint32_t root = color >> (8 * k) & 255u;
        a.albedo[k] = (root * root * 1023u + 32512u) / 65025u;
        a.normal[k] = (int32_t)(int8_t)(uint8_t)(voxel[2] >> (8 * k) & 255u);
        a.emission[k] = ((uint32_t)(emissive[k] * (float)KD_EMISSION_ONE + 0.5f) * share + 127u) / 255u;
    }
    return a;
}

/* Turned so that its largest part is positive. */
static void normal_axis(const int32_t normal[3], int32_t axis[3])
{
    int largest = 0;
    for (int k = 1; k < 3; k++)
        if (abs(normal[k]) > abs(normal[largest]))
            largest = k;
    for (int k = 0; k < 3; k++)
        axis[k] = normal[largest] < 0 ? -normal[k] : normal[k];
}

static void add(svo_reference *tree, uint32_t layer, uint32_t bit, uint32_t weight, const void *user)
{
    const voxel_attributes *a = user;
    uint32_t below = tree->masks[layer][bit >> 5] & ((1u << (bit & 31)) - 1u);
    uint32_t *sum = tree->sums[layer][tree->ranks[layer][bit >> 5] + bit_count(below)];
    bool emissive = a->emission[0] || a->emission[1] || a->emission[2];
    int32_t axis[3];
    normal_axis(a->normal, axis);
    sum[0] += weight;
    for (int k = 0; k < 3; k++) {
        sum[1 + k] += a->albedo[k] * weight;
        sum[4 + k] += (uint32_t)(a->normal[k] * (int32_t)weight);
        sum[7 + k] += (a->emission[k] * weight + 128) >> 8;
        sum[13 + k] += (uint32_t)(axis[k] * (int32_t)weight);
    }
    sum[10] += a->double_sided ? weight : 0;
    sum[11] += emissive ? weight : 0;
    sum[12] += emissive ? a->area * weight : 0;
}

static void visit_layer(svo_reference *tree, const svo_reference_source *source, uint32_t layer, bool adding)
{
    const svo_reference_layer *pages = &source->layers[layer];
    for (uint32_t slot = 0; slot < pages->slots; slot++) {
        const struct kd_voxel_segment *segment = &pages->segments[slot];
        for (uint32_t i = 0; i < segment->count; i++) {
            const uint32_t *voxel = pages->voxels[slot * KD_SEGMENT_VOXELS + i];
            if (voxel[0] == KD_NO_VOXEL)
                continue;
            voxel_attributes a = adding ? load_attributes(source, segment, i, voxel) : (voxel_attributes){0};
            visit_voxel(tree, source, layer, segment->chunk_cascade >> 28, voxel, adding ? add : mark, &a);
        }
    }
}

static uint32_t rank_words(const uint32_t *mask, uint32_t words, uint32_t *ranks)
{
    uint32_t running = 0;
    for (uint32_t i = 0; i < words; i++) {
        ranks[i] = running;
        running += bit_count(mask[i]);
    }
    return running;
}

/* ---- packing ---- */

static uint32_t mean(uint32_t sum, uint32_t weight)
{
    return (sum + weight / 2) / weight;
}

static int32_t mean_signed(uint32_t sum, uint32_t weight)
{
    int32_t s = (int32_t)sum;
    return s < 0 ? -(int32_t)mean((uint32_t)-s, weight) : (int32_t)mean(sum, weight);
}

/* Returns the square of its length. */
static int32_t mean_normal(const uint32_t sum[3], uint32_t weight, int32_t normal[3])
{
    int32_t square = 0;
    for (int k = 0; k < 3; k++) {
        normal[k] = mean_signed(sum[k], weight);
        square += normal[k] * normal[k];
    }
    return square;
}

static uint32_t octahedral_pack(const int32_t n[3])
{
    uint32_t sum = (uint32_t)(abs(n[0]) + abs(n[1]) + abs(n[2]));
    int32_t u = (int32_t)mean((uint32_t)abs(n[0]) * 127, sum),
            v = (int32_t)mean((uint32_t)abs(n[1]) * 127, sum);
    int32_t x = n[2] < 0 ? 127 - v : u, y = n[2] < 0 ? 127 - u : v;
    return ((uint32_t)(n[0] < 0 ? -x : x) & 255u) | ((uint32_t)(n[1] < 0 ? -y : y) & 255u) << 8;
}

/* Normal, weight and whether it is thin: shaders/include/cell_pack.glsl. */
static uint32_t pack_normal(const uint32_t sum[KD_SUM_WORDS], uint32_t weight, uint32_t both_sides)
{
    enum { AGREED = 102 * 102, ONE_AXIS = 64 * 64 };
    uint32_t covers = ((weight < 256 ? weight : 256) * 127 + 128) >> 8, word = 0;
    int32_t normal[3], axis[3], length2 = mean_normal(sum + 4, weight, normal);
    int32_t axis2 = mean_normal(length2 < AGREED ? sum + 13 : sum + 4, weight, axis);
    bool thin = axis2 >= ONE_AXIS && (both_sides > 1 || 25 * length2 < 9 * axis2);
    for (int k = 0; k < 3; k++)
        word |= ((uint32_t)normal[k] & 255u) << (8 * k);
    return (thin ? octahedral_pack(axis) : word) | (covers ? covers : 1) << 24 | (uint32_t)thin << 31;
}

/* Three fractions numerator / denominator of one shared scale: 9 bits each and 5 bits of halvings. */
static uint32_t emission_weight(uint32_t weight, uint32_t emissive)
{
    uint32_t shared = weight < 256 ? weight : 256;
    shared = emissive > shared ? emissive : shared;
    return shared ? shared : 1;
}

static uint32_t pack_emission(const uint32_t sums[3], uint32_t weight)
{
    uint32_t one = (uint32_t)KD_EMISSION_ONE * weight;
    uint32_t top = sums[0], halvings = 0, spare = 0, word = 0;
    for (int k = 1; k < 3; k++)
        top = sums[k] > top ? sums[k] : top;
    if (!top)
        return 0;
    while (halvings < 31 && top * 256 <= one >> (halvings + 1))
        halvings++;
    while (one >> spare >= 1u << 22)
        spare++;
    for (int k = 0; k < 3; k++) {
        uint32_t m = mean(((sums[k] * 256 << halvings) >> spare) * 511, one >> spare);
        word |= (m < 511 ? m : 511) << (9 * k);
    }
    return word | halvings << 27;
}

static uint32_t pack_area(uint32_t area, uint32_t emissive, uint32_t shared_by)
{
    uint32_t packed = emissive ? mean(area, emissive) * shared_by : 0;
    return packed < 65535 ? packed : 65535;
}

static void pack_cell(const uint32_t sum[KD_SUM_WORDS], uint32_t cell[4])
{
    uint32_t weight = sum[0] ? sum[0] : 1, both_sides = mean(sum[10] * 3, weight);
    cell[0] =
        mean(sum[1], weight) | mean(sum[2], weight) << 10 | mean(sum[3], weight) << 20 | both_sides << 30;
    cell[1] = pack_normal(sum, weight, both_sides);
    uint32_t shared_by = emission_weight(sum[0], sum[11]);
    cell[2] = pack_emission(sum + 7, shared_by);
    cell[3] = pack_area(sum[12], sum[11], shared_by);
}

static kd_status build_layer(svo_reference *tree, const svo_reference_source *source, uint32_t layer)
{
    tree->masks[layer] = calloc(tree->layer_words, 4);
    tree->ranks[layer] = calloc(tree->layer_words, 4);
    if (!tree->masks[layer] || !tree->ranks[layer])
        return KD_NO_MEMORY;
    visit_layer(tree, source, layer, false);
    uint32_t count = rank_words(tree->masks[layer], tree->layer_words, tree->ranks[layer]);
    tree->cell_count[layer] = count;
    tree->sums[layer] = calloc((size_t)count + 1, sizeof *tree->sums[layer]);
    tree->cells[layer] = calloc((size_t)count + 1, sizeof *tree->cells[layer]);
    if (!tree->sums[layer] || !tree->cells[layer])
        return KD_NO_MEMORY;
    visit_layer(tree, source, layer, true);
    for (uint32_t i = 0; i < count; i++)
        pack_cell(tree->sums[layer][i], tree->cells[layer][i]);
    return KD_OK;
}

/* ---- levels ---- */

static bool has_children(const svo_reference *tree, uint32_t level, uint32_t code)
{
    uint32_t first = code * 8, word = first >> 5, shift = first & 31;
    uint32_t bits = level + 1 == tree->levels ? tree->masks[0][word] | tree->masks[1][word]
                                              : tree->level_masks[level + 1][word];
    return (bits >> shift & 255u) != 0;
}

static kd_status build_level(svo_reference *tree, uint32_t level)
{
    uint32_t words = tree->cascades << (3 * (level + KD_DENSE_LOG2) - 5), at = 0;
    uint32_t *mask = tree->level_masks[level] = calloc(words, 4);
    tree->level_ranks[level] = calloc(words, 4);
    tree->level_words[level] = words;
    if (!mask || !tree->level_ranks[level])
        return KD_NO_MEMORY;
    for (uint32_t code = 0; code < words * 32; code++)
        mask[code >> 5] |= (uint32_t)has_children(tree, level, code) << (code & 31);
    tree->node_count[level] = rank_words(mask, words, tree->level_ranks[level]);
    uint32_t *list = tree->lists[level] = calloc((size_t)tree->node_count[level] + 1, 4);
    if (!list)
        return KD_NO_MEMORY;
    for (uint32_t code = 0; code < words * 32; code++)
        if (mask[code >> 5] >> (code & 31) & 1u)
            list[at++] = code;
    return KD_OK;
}

static kd_status build_nodes(svo_reference *tree, uint32_t level)
{
    uint32_t next = 0;
    tree->nodes[level] = calloc((size_t)tree->node_count[level] + 1, sizeof *tree->nodes[level]);
    if (!tree->nodes[level])
        return KD_NO_MEMORY;
    for (uint32_t i = 0; i < tree->node_count[level]; i++)
        for (uint32_t k = 0; k < 8; k++) {
            uint32_t code = tree->lists[level][i] * 8 + k;
            bool there = (tree->level_masks[level + 1][code >> 5] >> (code & 31) & 1u) != 0;
            tree->nodes[level][i][k] = there ? next++ : KD_EMPTY;
        }
    return KD_OK;
}

static kd_status build_index(svo_reference *tree)
{
    size_t cells = (size_t)tree->cascades * KD_DENSE * KD_DENSE * KD_DENSE;
    tree->index = malloc(cells * 4);
    if (!tree->index)
        return KD_NO_MEMORY;
    memset(tree->index, 0xFF, cells * 4);
    for (uint32_t i = 0; i < tree->node_count[0]; i++) {
        uint32_t code = tree->lists[0][i], cascade = code >> (3 * KD_DENSE_LOG2), cell[3];
        svo_morton_cell(code & ((1u << (3 * KD_DENSE_LOG2)) - 1), cell);
        tree->index[((cascade * KD_DENSE + cell[2]) * KD_DENSE + cell[1]) * KD_DENSE + cell[0]] = i;
    }
    return KD_OK;
}

kd_status svo_reference_build(const svo_reference_source *source, svo_reference *out)
{
    *out = (svo_reference){.cascades = source->cascades,
                           .leaf_level = source->leaf_level,
                           .levels = source->leaf_level - KD_DENSE_LOG2,
                           .layer_words = source->cascades << (3 * source->leaf_level - 5)};
    kd_status status = build_layer(out, source, KD_LAYER_STATIC);
    if (!status)
        status = build_layer(out, source, KD_LAYER_DYNAMIC);
    for (uint32_t l = out->levels; l-- > 0 && !status;)
        status = build_level(out, l);
    for (uint32_t l = 0; l + 1 < out->levels && !status; l++)
        status = build_nodes(out, l);
    if (!status)
        status = build_index(out);
    if (status)
        svo_reference_free(out);
    return status;
}

void svo_reference_free(svo_reference *tree)
{
    for (uint32_t l = 0; l < KD_LAYER_COUNT; l++) {
        free(tree->masks[l]);
        free(tree->ranks[l]);
        free(tree->sums[l]);
        free(tree->cells[l]);
    }
    for (uint32_t l = 0; l < KD_MAX_NODE_LEVELS; l++) {
        free(tree->level_masks[l]);
        free(tree->level_ranks[l]);
        free(tree->lists[l]);
        free(tree->nodes[l]);
    }
    free(tree->index);
    *tree = (svo_reference){0};
}
