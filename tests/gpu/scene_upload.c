/* What systems scene_upload and draw_upload leave on the GPU. */

#include "tests/stage_fixture.h"

static void assert_buffer(stage *s, kd_gpu_buffer buffer, const void *expected, size_t bytes)
{
    void *got = stage_read_all(s, buffer, bytes);
    assert_memory_equal(got, expected, bytes);
    free(got);
}

/* Attributes and indices of every mesh, and of every instance's copy. */
static void assert_attributes(stage *s)
{
    const kd_scene_store *store = kd_singleton(s->world, kd_scene_store);
    size_t bytes = KD_ATTRIBUTE_WORDS * sizeof(uint32_t);
    char *got = stage_read_all(s, store->attributes, store->vertex_count * bytes);
    uint32_t *indices = stage_read_all(s, store->indices, store->index_count * sizeof *indices);
    for (uint32_t m = 0; m < store->mesh_count; m++)
        for (uint32_t i = 0; i < store->meshes[m].primitive_count; i++) {
            const kd_store_primitive *p = &store->primitives[store->meshes[m].first_primitive + i];
            const kd_primitive_desc *desc = &store->meshes[m].desc->primitives[i];
            uint32_t *words = malloc(p->vertex_count * bytes);
            assert_non_null(words);
            scene_pack_attributes(desc, words);
            assert_memory_equal(got + p->base_vertex * bytes, words, p->vertex_count * bytes);
            assert_memory_equal(indices + p->first_index, desc->indices, p->index_count * sizeof *indices);
            free(words);
        }
    for (uint32_t d = 0; d < store->deformed_count; d++) {
        const kd_store_mesh *mesh = &store->meshes[store->deformed[d].mesh];
        for (uint32_t i = 0; i < mesh->primitive_count; i++) {
            const kd_store_primitive *from = &store->primitives[mesh->first_primitive + i];
            const kd_store_primitive *to =
                &store->deformed_primitives[store->deformed[d].first_primitive + i];
            assert_memory_equal(got + to->base_vertex * bytes, got + from->base_vertex * bytes,
                                from->vertex_count * bytes);
        }
    }
    free(got);
    free(indices);
}

static void streams_arrive_as_they_were_packed(void **state)
{
    stage *s = *state;
    const kd_scene_store *store = kd_singleton(s->world, kd_scene_store);
    for (uint32_t i = 0; i < 4; i++) { /* each adds to what is there, and the buffers grow */
        stage_spawn(s, fixture_character(2, 100 + 300 * i, 5 * (i % 2), 2 * (i / 2), 40 + i));
        stage_frame(s);
        deform_picture expected = deform_by_reference(s->world);
        assert_buffer(s, store->skins_buffer, expected.skins, store->skin_vertex_count * KD_SKIN_WORDS * 4u);
        assert_buffer(s, store->morphs, expected.morphs, store->morph_vertex_count * KD_MORPH_WORDS * 4u);
        for (uint32_t p = 0; p < store->primitive_count;
             p++) { /* at rest: the deform pass does not touch these */
            size_t at = store->primitives[p].base_vertex * (size_t)KD_GEOMETRY_WORDS;
            size_t bytes = store->primitives[p].vertex_count * KD_GEOMETRY_WORDS * sizeof(uint32_t);
            uint32_t *got = malloc(bytes);
            assert_non_null(got);
            kd_gpu_read_buffer(s->gpu, store->geometry, at * sizeof(uint32_t), got, bytes);
            assert_memory_equal(got, expected.geometry + at, bytes);
            free(got);
        }
        deform_picture_free(&expected);
        assert_attributes(s);
        assert_int_equal(store->uploaded_primitives, store->primitive_count);
    }
}

static void draw_list_arrives_as_it_is_on_the_cpu(void **state)
{
    stage *s = *state;
    kd_model *box = NULL;
    uint32_t number;
    kd_entity root;
    kd_material_desc material = kd_material_default();
    assert_int_equal(kd_model_make_shape(KD_SHAPE_BOX, (kd_vec3){1, 1, 1}, 0, &material, &box), KD_OK);
    assert_int_equal(kd_scene_add_model(s->world, box, &number), KD_OK);
    for (int round = 0; round < 3; round++) { /* the second and third grow the buffers */
        for (int i = 0; i < 30; i++) {
            assert_int_equal(kd_scene_instantiate(s->world, number, KD_NO_ENTITY, "box", &root), KD_OK);
            *kd_find_mut(s->world, root, kd_transform) =
                (kd_transform){{(float)i, 0, 0}, {0, 0, 0, 1}, {1, 2, i % 2 ? 4.0f : -4.0f}};
        }
        stage_frame(s);
        const kd_draw_list *list = kd_singleton(s->world, kd_draw_list);
        assert_int_equal(list->draw_count, 30 * (round + 1));
        assert_int_equal(list->batch_count, 2);
        struct kd_object *objects = stage_read_all(s, list->objects, list->object_count * sizeof *objects);
        kd_draw_indexed *args = stage_read_all(s, list->args, list->draw_count * sizeof *args);
        uint32_t *ids = stage_read_all(s, list->object_ids, list->object_count * sizeof *ids);
        for (uint32_t i = 0; i < list->draw_count; i++) {
            kd_entity e = list->draws[i].entity;
            assert_int_equal(ids[i], i);
            assert_int_equal(objects[i].info.z, e.index);
            assert_int_equal(objects[i].info.y, (i >= list->batches[1].first_draw ? KD_OBJECT_MIRRORED : 0));
            assert_memory_equal(objects[i].model_ws.m, kd_find(s->world, e, kd_world_transform)->matrix.m,
                                64);
            assert_float_equal(objects[i].normal_ws[1].y, 0.5f, 1e-6f); /* inverse of the scale 2 along y */
            assert_memory_equal(&args[i], &list->draws[i].args, sizeof args[i]);
        }
        free(objects);
        free(args);
        free(ids);
    }
}

static void textures_are_made_once_for_each_way_of_reading(void **state)
{
    stage *s = *state;
    static const uint8_t pixels[2 * 2 * 4] = {255, 0, 0,   255, 0,   255, 0,   255,
                                              0,   0, 255, 255, 255, 255, 255, 255};
    uint64_t random = 2;
    kd_model *model = fixture_model();
    kd_image *image = FIXTURE_NEW(model, kd_image, 1);
    *image = (kd_image){"image", 2, 2, pixels};
    kd_material_desc *materials = FIXTURE_NEW(model, kd_material_desc, 2);
    for (int i = 0; i < 2; i++) {
        materials[i] = kd_material_default();
        materials[i].base_color_map.image = 0;
        materials[i].metallic_roughness_map.image = 0;
    }
    kd_primitive_desc *primitive = FIXTURE_NEW(model, kd_primitive_desc, 1);
    *primitive = fixture_primitive(model, 9, 0, 0, &random);
    kd_mesh_desc *mesh = FIXTURE_NEW(model, kd_mesh_desc, 1);
    *mesh = (kd_mesh_desc){.name = "mesh", .primitive_count = 1, .primitives = primitive};
    fixture_nodes(model, 1)->mesh = 0;
    model->meshes = mesh;
    model->mesh_count = 1;
    model->materials = materials;
    model->material_count = 2;
    model->images = image;
    model->image_count = 1;
    stage_spawn(s, model);
    stage_frame(s);
    const kd_store_material *stored = kd_singleton(s->world, kd_scene_store)->materials + 1;
    assert_true(stored[0].maps[0].id != 0 && stored[0].maps[1].id != 0);
    assert_int_not_equal(stored[0].maps[0].id, stored[0].maps[1].id); /* sRGB and linear */
    assert_int_equal(stored[0].maps[0].id, stored[1].maps[0].id);
    assert_int_equal(stored[0].maps[1].id, stored[1].maps[1].id);
    assert_int_equal(stored[0].maps[2].id, 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        STAGED(streams_arrive_as_they_were_packed),
        STAGED(draw_list_arrives_as_it_is_on_the_cpu),
        STAGED(textures_are_made_once_for_each_way_of_reading),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
