/* The subdivide pass on the walking cage: the surface of each frame against the CPU's sums over the posed
 * cage that the GPU itself left in the stream.
 *
 * Tolerance: sums of some twenty products of numbers of the creature's size (1 m), fused or not: 1e-5 of that
 * size. */

#include "tests/stage_fixture.h"

#define WALKER KD_SOURCE_DIR "/samples/assets/walker_cage.gltf"

static kd_vec3 position(const uint32_t *geometry, uint32_t vertex)
{
    kd_vec3 p;
    memcpy(&p, geometry + (size_t)vertex * KD_GEOMETRY_WORDS, sizeof p);
    return p;
}

static kd_vec3 direction(const uint32_t *w)
{
    return (kd_vec3){(float)(int16_t)(w[0] & 0xffff) / 32767, (float)(int16_t)(w[0] >> 16) / 32767,
                     (float)(int16_t)(w[1] & 0xffff) / 32767};
}

static kd_entity spawn_walker(stage *s)
{
    kd_model *model;
    const kd_model_options options = {.subdiv_level = 2};
    assert_int_equal(kd_model_load_with(WALKER, &options, &model), KD_OK);
    return stage_spawn(s, model);
}

/* Compare instance `number`'s surface with the CPU's; return how far it has gone from the rest pose at most.
 */
static float check_surface(stage *s, uint32_t number)
{
    const kd_scene_store *store = kd_singleton(s->world, kd_scene_store);
    const kd_store_deformed *deformed = &store->deformed[number];
    const kd_primitive_desc *desc = &store->meshes[deformed->mesh].desc->primitives[0];
    const kd_store_primitive *own = &store->deformed_primitives[deformed->first_primitive];
    const uint32_t n = desc->vertex_count, first = own->base_vertex;
    uint32_t *geometry =
        stage_read_all(s, store->geometry, (size_t)store->vertex_count * KD_GEOMETRY_WORDS * 4);
    kd_vec3 *cage = calloc(own->cage_count, sizeof *cage), *positions = calloc(n, sizeof *positions),
            *normals = calloc(n, sizeof *normals);
    kd_vec4 *tangents = calloc(n, sizeof *tangents);
    float moved = 0;
    uint32_t off = 0;
    assert_non_null(desc->subdivision);
    for (uint32_t v = 0; v < own->cage_count; v++)
        cage[v] = position(geometry, first + n + v);
    kd_subdivision_evaluate(desc->subdivision, n, cage, positions, normals, tangents);
    for (uint32_t v = 0; v < n; v++) {
        const uint32_t *at = geometry + (size_t)(first + v) * KD_GEOMETRY_WORDS;
        kd_vec3 p = position(geometry, first + v);
        assert_true(kd_vec3_length(kd_vec3_sub(p, positions[v])) <= 1e-5f);
        off += kd_vec3_length(kd_vec3_sub(direction(at + 3), normals[v])) > 1e-3f;
        off += kd_vec3_length(kd_vec3_sub(direction(at + 5),
                                          (kd_vec3){tangents[v].x, tangents[v].y, tangents[v].z})) > 1e-3f;
        moved = fmaxf(moved, kd_vec3_length(kd_vec3_sub(p, desc->positions[v])));
    }
    assert_int_equal(off, 0);
    free(geometry);
    free(cage);
    free(positions);
    free(normals);
    free(tangents);
    return moved;
}

static void the_surface_follows_its_posed_cage(void **state)
{
    stage *s = *state;
    kd_entity walker = spawn_walker(s);
    kd_animation *animation = kd_find_mut(s->world, walker, kd_animation);
    float most = 0;
    animation->paused = true;
    for (int frame = 0; frame < 3; frame++) {
        kd_find_mut(s->world, walker, kd_animation)->time_s = 0.3f * (float)frame;
        stage_frame(s);
        assert_non_null(strstr(s->ran, "subdivide "));
        most = fmaxf(most, check_surface(s, 0));
    }
    assert_true(most > 0.03f && most < 1); /* a walk swings the legs by some centimetres at least */
    stage_frame(s);
    assert_null(strstr(s->ran, "subdivide ")); /* nothing has moved: no work */
}

static void instances_go_apart_and_their_room_is_used_again(void **state)
{
    stage *s = *state;
    kd_entity first = spawn_walker(s), second;
    const kd_scene_store *store = kd_singleton(s->world, kd_scene_store);
    assert_int_equal(kd_scene_instantiate(s->world, 0, KD_NO_ENTITY, "second", &second), KD_OK);
    kd_find_mut(s->world, second, kd_transform)->position.x = 20;
    stage_frame(s);
    assert_true(check_surface(s, 0) < 1);
    float far = check_surface(s, 1);
    assert_true(far > 19 && far < 21);
    uint32_t vertices = store->vertex_count;
    kd_destroy(s->world, first);
    stage_frame(s);
    assert_int_equal(kd_scene_instantiate(s->world, 0, KD_NO_ENTITY, "third", &first), KD_OK);
    stage_frame(s);
    assert_int_equal(store->vertex_count, vertices);
    assert_true(check_surface(s, 0) < 1);
    check_surface(s, 1);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        STAGED(the_surface_follows_its_posed_cage),
        STAGED(instances_go_apart_and_their_room_is_used_again),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
