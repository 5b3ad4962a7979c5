/* Voxels that turn, bend and change shape: surfaces stay closed, and nothing of them is lost. */

#include "tests/voxel_fixture.h"

/* ---- what a frame's page voxels cover ---- */

typedef struct cover {
    uint32_t size[3];
    uint32_t *weight; /* of 256, a cell */
    uint8_t *wall;
} cover;

/* Sum of the shares of all page voxels of a layer in every cell of cascade 0. Every voxel keeps nearly all of
 * its 256: over all fractions, what dropped shares and rounding leave of it is at least 222 (at 17, 17, 127
 * of 256). */
static cover read_cover(voxel_world *v, int layer, uint32_t at_least)
{
    voxel_capture capture = voxel_read_source(v);
    uint32_t n = voxel_scene(v)->resolution;
    cover c = {
        .size = {n, n, n}, .weight = calloc((size_t)n * n * n, 4), .wall = calloc((size_t)n * n * n, 1)};
    assert_true(c.weight && c.wall);
    for (uint32_t s = 0; s < capture.source.layers[layer].slots; s++)
        for (uint32_t i = 0; i < capture.source.layers[layer].segments[s].count; i++) {
            const uint32_t *voxel = capture.source.layers[layer].voxels[s * KD_SEGMENT_VOXELS + i];
            uint32_t kept = 0;
            assert_int_not_equal(voxel[0], KD_NO_VOXEL); /* all of it is inside the cascade */
            for (uint32_t k = 0; k < 8; k++) {
                int32_t cell[3];
                svo_splat_cell(voxel, k, cell);
                uint32_t weight = svo_splat_weight(voxel, k);
                if (weight < KD_SPLAT_MIN_WEIGHT)
                    continue;
                assert_true(svo_owned(n, 0, cell));
                c.weight[((uint32_t)cell[2] * n + (uint32_t)cell[1]) * n + (uint32_t)cell[0]] += weight;
                kept += weight;
            }
            assert_in_range(kept, 222, 256);
        }
    for (size_t i = 0; i < (size_t)n * n * n; i++)
        c.wall[i] = c.weight[i] >= at_least;
    voxel_capture_free(&capture);
    return c;
}

static void free_cover(cover *c)
{
    free(c->weight);
    free(c->wall);
}

/* Cell of a point in the world. */
static size_t cell_of(voxel_world *v, kd_vec3 p)
{
    const kd_voxel_scene *scene = voxel_scene(v);
    size_t at = 0;
    for (int k = 2; k >= 0; k--)
        at = at * scene->resolution +
             (size_t)floorf(((&p.x)[k] - (&scene->origin_ws[0].x)[k]) / scene->span[0]);
    return at;
}

static bool is_closed_round(voxel_world *v, kd_vec3 inside, uint32_t at_least)
{
    cover c = read_cover(v, KD_LAYER_DYNAMIC, at_least);
    uint8_t *outside = calloc((size_t)c.size[0] * c.size[1] * c.size[2], 1);
    assert_non_null(outside);
    voxel_flood(c.wall, c.size, outside);
    assert_int_equal(c.wall[cell_of(v, inside)], 0);
    assert_int_equal(outside[0], 1);
    bool closed = !outside[cell_of(v, inside)];
    free(outside);
    free_cover(&c);
    return closed;
}

/* A cell with less than a sixth of a voxel lets light through; a closed surface has more everywhere. */
#define WALL 40

static void turn_without_holes(kd_shape shape, kd_vec3 size, kd_vec3 inside)
{
    uint64_t random = 5;
    voxel_world v = voxel_open((voxel_options){.span = 0.02f});
    kd_entity e = voxel_shape(&v, shape, size, NULL, voxel_at(0, 0, 0));
    voxel_frame(&v);
    for (int pose = 0; pose < 18; pose++) {
        kd_transform *t = kd_find_mut(v.world, e, kd_transform);
        t->rotation = fixture_quat(&random);
        t->position = fixture_vec3(&random, -0.05f, 0.05f);
        voxel_frame(&v);
        kd_mat4 m = kd_mat4_from_trs(t->position, t->rotation, (kd_vec3){1, 1, 1});
        if (!is_closed_round(&v, kd_mat4_point(&m, inside), WALL))
            fail_msg("pose %d has a hole", pose);
    }
    voxel_close(&v);
}

static void turning_box_has_no_hole(void **state)
{
    (void)state;
    turn_without_holes(KD_SHAPE_BOX, (kd_vec3){0.5f, 0.4f, 0.6f}, (kd_vec3){0, 0, 0});
}

static void turning_sphere_has_no_hole(void **state)
{
    (void)state;
    turn_without_holes(KD_SHAPE_SPHERE, (kd_vec3){0.6f, 0.6f, 0}, (kd_vec3){0, 0, 0});
}

static void turning_torus_has_no_hole(void **state)
{
    (void)state;
    turn_without_holes(KD_SHAPE_TORUS, (kd_vec3){0.9f, 0.3f, 0}, (kd_vec3){0.3f, 0, 0});
}

/* Scales up to the point at which a finer cache is made, uniform and not. */
static void scaled_box_has_no_hole(void **state)
{
    (void)state;
    voxel_world v = voxel_open((voxel_options){.span = 0.02f});
    kd_entity e = voxel_shape(&v, KD_SHAPE_BOX, (kd_vec3){0.4f, 0.4f, 0.4f}, NULL, voxel_at(0, 0, 0));
    voxel_frame(&v);
    static const float scales[] = {1.05f, 1.099f, 1.15f, 1.4f, 1.9f, 0.9f, 0.61f, 0.4f};
    for (int i = 0; i < 16; i++) {
        kd_transform *t = kd_find_mut(v.world, e, kd_transform);
        float s = scales[i / 2];
        t->scale = (kd_vec3){s, i % 2 ? s * 0.5f : s, s};
        t->rotation = (kd_quat){0.36f, 0.48f, 0, 0.8f};
        voxel_frame(&v);
        if (!is_closed_round(&v, (kd_vec3){0, 0, 0}, WALL))
            fail_msg("scale %g, %d: a hole", (double)s, i % 2);
    }
    voxel_close(&v);
}

/* ---- skinned ---- */

static kd_vec3 cached_position(const kd_voxel_chunk *chunk, uint32_t word)
{
    kd_vec3 p = chunk->origin;
    for (int k = 0; k < 3; k++)
        (&p.x)[k] += ((float)(word >> (10 * k) & 1023u) + 0.5f) * chunk->span;
    return p;
}

static kd_vec3 blend(const kd_joint_palette *palette, uint32_t first, const uint32_t words[3], kd_vec3 p)
{
    kd_vec3 out = {0, 0, 0};
    float sum = 0;
    for (int k = 0; k < 4; k++) {
        float w = (float)(words[2] >> (8 * k) & 255u);
        uint32_t joint = words[k / 2] >> (16 * (k % 2)) & 0xFFFFu;
        out = kd_vec3_add(out, kd_vec3_scale(kd_joint_point(palette->rows[first + joint], p), w));
        sum += w;
    }
    return kd_vec3_scale(out, 1 / sum);
}

/* Centre of mass of a splat: where the voxel stands, in cells of its cascade. */
static kd_vec3 splat_centre(const uint32_t voxel[3])
{
    kd_vec3 p;
    for (int k = 0; k < 3; k++)
        (&p.x)[k] = (float)(voxel[0] >> (10 * k) & 1023u) - 0.5f + (float)(voxel[1] >> (8 * k) & 255u) / 256;
    return p;
}

/* 8 of 256 are rounded off a share: a thirtieth of a cell, and rounding of positions besides. */
#define CENTRE_STEP 0.035f

static float furthest_from_blend(voxel_world *v, uint32_t *checked)
{
    const kd_voxel_scene *scene = voxel_scene(v);
    const kd_joint_palette *palette = kd_singleton(v->world, kd_joint_palette);
    voxel_capture capture = voxel_read_source(v);
    uint32_t *bindings =
        voxel_read(scene->cache_binding, 0, (size_t)scene->binding_places.end * KD_BINDING_WORDS * 4);
    const svo_reference_layer *pages = &capture.source.layers[KD_LAYER_DYNAMIC];
    float worst = 0;
    for (uint32_t s = 0; s < pages->slots; s++)
        for (uint32_t i = 0; i < pages->segments[s].count; i++) {
            const struct kd_voxel_segment *segment = &pages->segments[s];
            const kd_voxel_object *o = &scene->objects[segment->object];
            const kd_voxel_chunk *chunk = &scene->chunks[segment->chunk_cascade & 0xFFFFFFFu];
            const uint32_t *voxel = pages->voxels[s * KD_SEGMENT_VOXELS + i], n = segment->first + i;
            if (o->kind != KD_VOXEL_SKINNED)
                continue;
            const uint32_t *words =
                bindings + (size_t)KD_BINDING_WORDS * (chunk->first_binding + n - chunk->first);
            kd_vec3 p =
                blend(palette, o->first_matrix, words, cached_position(chunk, capture.source.shape[n][0]));
            kd_vec3 cell = kd_vec3_scale(kd_vec3_sub(p, scene->origin_ws[0]), 1 / scene->span[0]);
            kd_vec3 off = kd_vec3_sub(splat_centre(voxel), cell);
            worst = fmaxf(worst, fmaxf(fabsf(off.x), fmaxf(fabsf(off.y), fabsf(off.z))));
            ++*checked;
        }
    free(bindings);
    voxel_capture_free(&capture);
    return worst;
}

static void skinned_voxels_stand_where_their_joints_bring_them(void **state)
{
    (void)state;
    voxel_world v = voxel_open((voxel_options){.span = 0.02f});
    voxel_load(&v, "samples/assets/walker.gltf", voxel_at(0.1f, 0, 0.05f));
    v.frame->dt_s = 0.17f;
    for (int i = 0; i < 5; i++) {
        uint32_t checked = 0;
        voxel_frame(&v);
        float worst = furthest_from_blend(&v, &checked);
        assert_true(checked > 1000);
        assert_true(worst < CENTRE_STEP);
    }
    voxel_close(&v);
}

/* Free cells that the flood from outside does not reach. */
static size_t enclosed_cells(voxel_world *v, uint32_t at_least)
{
    cover c = read_cover(v, KD_LAYER_DYNAMIC, at_least);
    size_t count = (size_t)c.size[0] * c.size[1] * c.size[2], enclosed = 0;
    uint8_t *outside = calloc(count, 1);
    assert_non_null(outside);
    voxel_flood(c.wall, c.size, outside);
    for (size_t i = 0; i < count; i++)
        enclosed += !c.wall[i] && !outside[i];
    free(outside);
    free_cover(&c);
    return enclosed;
}

/* What the skin encloses at rest it encloses in every pose: a hole anywhere in a limb would empty that limb.
 */
static void walker_stays_closed_in_every_clip(void **state)
{
    (void)state;
    voxel_world v = voxel_open((voxel_options){.span = 0.016f});
    kd_entity walker = voxel_load(&v, "samples/assets/walker.gltf", voxel_at(0, 0, 0));
    kd_find_mut(v.world, walker, kd_animation)->clip = 0;
    voxel_frame(&v);
    size_t rest = enclosed_cells(&v, WALL);
    assert_true(rest > 1000);
    const kd_scene_store *store = kd_singleton(v.world, kd_scene_store);
    for (uint32_t clip = 0; clip < store->clip_count; clip++)
        for (int i = 0; i < 6; i++) {
            kd_animation *a = kd_find_mut(v.world, walker, kd_animation);
            a->clip = clip + 1;
            a->time_s = store->clips[clip].desc->duration * (float)i / 6;
            voxel_frame(&v);
            if (enclosed_cells(&v, WALL) < rest * 3 / 4)
                fail_msg("clip %s has a hole at %d sixths of its length", store->clips[clip].desc->name, i);
        }
    voxel_close(&v);
}

/* ---- morphing ---- */

/* A box whose only target moves its right side out by half its width. */
static kd_model *growing_box(void)
{
    static kd_vec3 deltas[24];
    static const kd_vec3 *targets[1] = {deltas};
    static float weights[1] = {0};
    kd_material_desc grey = voxel_matte(0.5f, 0.5f, 0.5f);
    kd_model *model;
    assert_int_equal(kd_model_make_shape(KD_SHAPE_BOX, (kd_vec3){0.5f, 0.5f, 0.5f}, 0, &grey, &model), KD_OK);
    kd_mesh_desc *mesh = (kd_mesh_desc *)(uintptr_t)model->meshes;
    kd_primitive_desc *p = (kd_primitive_desc *)(uintptr_t)mesh->primitives;
    assert_int_equal(p->vertex_count, 24);
    for (int i = 0; i < 24; i++)
        deltas[i] = (kd_vec3){p->positions[i].x > 0 ? 0.25f : 0, 0, 0};
    p->morph_count = mesh->morph_count = 1;
    p->morph_positions = targets;
    p->morph_normals = FIXTURE_NEW(model, const kd_vec3 *, 1);
    mesh->morph_weights = weights;
    return model;
}

static kd_entity morphing_entity(voxel_world *v)
{
    const kd_draw_list *list = kd_singleton(v->world, kd_draw_list);
    assert_true(list->draw_count > 0);
    return list->draws[0].entity;
}

/* Extent along x of the voxels' centres, in metres. */
static void extent_x(voxel_world *v, float *low, float *high)
{
    const kd_voxel_scene *scene = voxel_scene(v);
    voxel_capture capture = voxel_read_source(v);
    const svo_reference_layer *pages = &capture.source.layers[KD_LAYER_DYNAMIC];
    *low = INFINITY;
    *high = -INFINITY;
    for (uint32_t s = 0; s < pages->slots; s++)
        for (uint32_t i = 0; i < pages->segments[s].count; i++) {
            float x = scene->origin_ws[0].x +
                      splat_centre(pages->voxels[s * KD_SEGMENT_VOXELS + i]).x * scene->span[0];
            *low = fminf(*low, x);
            *high = fmaxf(*high, x);
        }
    voxel_capture_free(&capture);
}

static void morphing_voxels_follow_the_surface(void **state)
{
    (void)state;
    voxel_world v = voxel_open((voxel_options){.span = 0.02f});
    voxel_spawn(&v, growing_box(), voxel_at(0, 0, 0));
    voxel_frame(&v);
    for (int i = 0; i <= 4; i++) {
        float low, high, weight = (float)i / 4;
        kd_morph_weights *w = kd_find_mut(v.world, morphing_entity(&v), kd_morph_weights);
        assert_non_null(w);
        w->weights[0] = weight;
        voxel_frame(&v);
        extent_x(&v, &low, &high);
        assert_float_equal(low, -0.25f, CENTRE_STEP * 0.02f); /* they stand on the surface itself */
        assert_float_equal(high, 0.25f + 0.25f * weight, CENTRE_STEP * 0.02f);
        assert_int_equal(enclosed_cells(&v, WALL) > 1000, 1);
        assert_int_equal(voxel_scene(&v)->objects[0].kind, KD_VOXEL_ATTACHED);
    }
    voxel_close(&v);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(turning_box_has_no_hole),
        cmocka_unit_test(turning_sphere_has_no_hole),
        cmocka_unit_test(turning_torus_has_no_hole),
        cmocka_unit_test(scaled_box_has_no_hole),
        cmocka_unit_test(skinned_voxels_stand_where_their_joints_bring_them),
        cmocka_unit_test(walker_stays_closed_in_every_clip),
        cmocka_unit_test(morphing_voxels_follow_the_surface),
    };
    return VOXEL_GROUP(tests);
}
