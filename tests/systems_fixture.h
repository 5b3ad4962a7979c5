#ifndef KD_TESTS_SYSTEMS_FIXTURE_H
#define KD_TESTS_SYSTEMS_FIXTURE_H

/* For tests of scene, animation, hierarchy and deform: models made in memory, random numbers that are the
 * same each run, and the shared assets where they are at hand. */

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "components/animation.h"
#include "components/deform.h"
#include "components/frame.h"
#include "components/mesh_instance.h"
#include "components/scene_store.h"
#include "components/transform.h"
#include "runtime/asset/model_memory.h"
#include "runtime/core/file.h"
#include "runtime/core/log.h"
#include "runtime/ecs/system.h"
#include "runtime/jobs/jobs.h"

/* ---- random numbers: Steele, Lea, Flood 2014, SplitMix64 ---- */

static inline uint32_t fixture_random(uint64_t *state)
{
    uint64_t z = *state += 0x9E3779B97F4A7C15u;
    z = (z ^ z >> 30) * 0xBF58476D1CE4E5B9u;
    z = (z ^ z >> 27) * 0x94D049BB133111EBu;
    return (uint32_t)((z ^ z >> 31) >> 32);
}

static inline float fixture_float(uint64_t *state, float low, float high)
{
    return low + (high - low) * (float)(fixture_random(state) >> 8) / 16777216.0f;
}

static inline kd_vec3 fixture_vec3(uint64_t *state, float low, float high)
{
    float x = fixture_float(state, low, high), y = fixture_float(state, low, high);
    return (kd_vec3){x, y, fixture_float(state, low, high)};
}

static inline kd_vec3 fixture_unit(uint64_t *state)
{
    kd_vec3 v = fixture_vec3(state, -1, 1);
    return kd_vec3_normalize(v, (kd_vec3){0, 1, 0});
}

static inline kd_quat fixture_quat(uint64_t *state)
{
    kd_vec3 axis = fixture_unit(state);
    float half = fixture_float(state, -1.5f, 1.5f), s = sinf(half);
    return (kd_quat){axis.x * s, axis.y * s, axis.z * s, cosf(half)};
}

/* ---- models made in memory: everything stands in the model's own arena, as kd_model_destroy expects ---- */

static inline kd_model *fixture_model(void)
{
    kd_arena start = {0};
    model_memory *memory = KD_ARENA_NEW(&start, model_memory, 1);
    kd_model *model = KD_ARENA_NEW(&start, kd_model, 1);
    *memory = (model_memory){start, 1};
    model->path = "made";
    model->internal = memory;
    return model;
}

#define FIXTURE_NEW(model, type, count)                                                                      \
    KD_ARENA_NEW(&((model_memory *)(model)->internal)->arena, type, count)

static inline kd_node_desc *fixture_nodes(kd_model *model, uint32_t count)
{
    kd_node_desc *nodes = FIXTURE_NEW(model, kd_node_desc, count);
    for (uint32_t i = 0; i < count; i++)
        nodes[i] = (kd_node_desc){.name = "node",
                                  .parent = KD_NONE,
                                  .rotation = {0, 0, 0, 1},
                                  .scale = {1, 1, 1},
                                  .mesh = KD_NONE,
                                  .skin = KD_NONE,
                                  .camera = KD_NONE,
                                  .light = KD_NONE};
    model->nodes = nodes;
    model->node_count = count;
    return nodes;
}

/* Random triangles; with joints, weights and morph targets where asked for. */
static inline kd_primitive_desc fixture_primitive(kd_model *model, uint32_t vertices, uint32_t joints,
                                                  uint32_t morphs, uint64_t *random)
{
    kd_vec3 *positions = FIXTURE_NEW(model, kd_vec3, vertices),
            *normals = FIXTURE_NEW(model, kd_vec3, vertices);
    kd_vec4 *tangents = FIXTURE_NEW(model, kd_vec4, vertices),
            *weights = FIXTURE_NEW(model, kd_vec4, vertices);
    uint16_t(*slots)[4] = (uint16_t(*)[4])FIXTURE_NEW(model, uint16_t, 4 * vertices);
    uint32_t *indices = FIXTURE_NEW(model, uint32_t, 3 * vertices);
    kd_primitive_desc p = {.material = KD_NONE, .vertex_count = vertices, .index_count = 3 * vertices};
    p.bounds_min = (kd_vec3){INFINITY, INFINITY, INFINITY};
    p.bounds_max = (kd_vec3){-INFINITY, -INFINITY, -INFINITY};
    for (uint32_t v = 0; v < vertices; v++) {
        positions[v] = fixture_vec3(random, -2, 2);
        normals[v] = fixture_unit(random);
        kd_vec3 t = fixture_unit(random);
        tangents[v] = (kd_vec4){t.x, t.y, t.z, fixture_random(random) & 1 ? 1 : -1};
        float w[4] = {fixture_float(random, 0.1f, 1), fixture_float(random, 0, 1),
                      fixture_float(random, 0, 0.5f),
                      fixture_random(random) & 1 ? fixture_float(random, 0, 0.2f) : 0};
        float sum = w[0] + w[1] + w[2] + w[3];
        weights[v] = (kd_vec4){w[0] / sum, w[1] / sum, w[2] / sum, w[3] / sum};
        for (int k = 0; k < 4; k++)
            slots[v][k] = (uint16_t)(joints ? fixture_random(random) % joints : 0);
        for (int k = 0; k < 3; k++)
            indices[3 * v + (uint32_t)k] = fixture_random(random) % vertices;
        p.bounds_min = (kd_vec3){fminf(p.bounds_min.x, positions[v].x), fminf(p.bounds_min.y, positions[v].y),
                                 fminf(p.bounds_min.z, positions[v].z)};
        p.bounds_max = (kd_vec3){fmaxf(p.bounds_max.x, positions[v].x), fmaxf(p.bounds_max.y, positions[v].y),
                                 fmaxf(p.bounds_max.z, positions[v].z)};
    }
    kd_vec3 **dp = FIXTURE_NEW(model, kd_vec3 *, morphs + 1),
            **dn = FIXTURE_NEW(model, kd_vec3 *, morphs + 1);
    for (uint32_t t = 0; t < morphs; t++) {
        dp[t] = FIXTURE_NEW(model, kd_vec3, vertices);
        dn[t] = t % 3 == 2 ? NULL : FIXTURE_NEW(model, kd_vec3, vertices); /* some targets bring no normals */
        for (uint32_t v = 0; v < vertices; v++) {
            dp[t][v] = fixture_vec3(random, -0.5f, 0.5f);
            if (dn[t])
                dn[t][v] = fixture_vec3(random, -0.5f, 0.5f);
        }
    }
    p.positions = positions;
    p.normals = normals;
    p.tangents = tangents;
    p.indices = indices;
    p.joints = joints ? (const uint16_t(*)[4])slots : NULL;
    p.weights = joints ? weights : NULL;
    p.morph_count = morphs;
    p.morph_positions = (const kd_vec3 *const *)dp;
    p.morph_normals = (const kd_vec3 *const *)dn;
    return p;
}

/* One mesh of `parts` primitives on node `joints`, skinned by nodes 0 … joints-1, which hang on random
 * earlier ones. */
static inline kd_model *fixture_character(uint32_t parts, uint32_t vertices, uint32_t joints, uint32_t morphs,
                                          uint64_t seed)
{
    uint64_t random = seed;
    kd_model *model = fixture_model();
    kd_node_desc *nodes = fixture_nodes(model, joints + 1);
    kd_mat4 *inverse_bind = FIXTURE_NEW(model, kd_mat4, joints + 1);
    uint32_t *numbers = FIXTURE_NEW(model, uint32_t, joints + 1);
    for (uint32_t j = 0; j < joints; j++) {
        nodes[j].parent = j ? fixture_random(&random) % j : KD_NONE;
        nodes[j].translation = fixture_vec3(&random, -1, 1);
        nodes[j].rotation = fixture_quat(&random);
        nodes[j].scale = fixture_vec3(&random, 0.7f, 1.3f);
        inverse_bind[j] = kd_mat4_from_trs(fixture_vec3(&random, -1, 1), fixture_quat(&random),
                                           fixture_vec3(&random, 0.5f, 1.5f));
        numbers[j] = j;
    }
    nodes[joints].mesh = 0;
    nodes[joints].skin = joints ? 0 : KD_NONE;
    nodes[joints].translation = (kd_vec3){1, 2, 3};
    kd_primitive_desc *primitives = FIXTURE_NEW(model, kd_primitive_desc, parts);
    for (uint32_t i = 0; i < parts; i++)
        primitives[i] = fixture_primitive(model, vertices + 7 * i, joints, morphs, &random);
    kd_mesh_desc *mesh = FIXTURE_NEW(model, kd_mesh_desc, 1);
    *mesh = (kd_mesh_desc){
        .name = "mesh", .primitive_count = parts, .primitives = primitives, .morph_count = morphs};
    kd_skin_desc *skin = FIXTURE_NEW(model, kd_skin_desc, 1);
    *skin = (kd_skin_desc){
        .name = "skin", .joint_count = joints, .joints = numbers, .inverse_bind = inverse_bind};
    model->meshes = mesh;
    model->mesh_count = 1;
    model->skins = skin;
    model->skin_count = joints ? 1 : 0;
    return model;
}

/* ---- shared assets ---- */

/* Load one, or leave with 77 where the folder is not there. */
static inline kd_model *fixture_asset(const char *name)
{
    char path[512];
    kd_model *model = NULL;
    snprintf(path, sizeof path, "%s/../shared/assets/%s", KD_SOURCE_DIR, name);
    if (!kd_file_exists(path)) {
        fprintf(stderr, "skipped: %s is not at hand\n", path);
        exit(77);
    }
    assert_int_equal(kd_model_load(path, &model), KD_OK);
    return model;
}

#endif
