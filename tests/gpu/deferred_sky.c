/* Skies behind and over what is drawn: the background is the picture along each pixel's ray, and without
 * gathered light surfaces get the mean of what they face. */

#include "components/sky.h"
#include "tests/render_fixture.h"

enum { WIDTH = 32, HEIGHT = 16 };

static kd_entity add_sky(render *r, const float *rgb, kd_quat rotation)
{
    float *copy = malloc(WIDTH * HEIGHT * 3 * sizeof *copy);
    assert_non_null(copy);
    memcpy(copy, rgb, WIDTH * HEIGHT * 3 * sizeof *copy);
    kd_sky sky = {.intensity = 2, .image = kd_sky_add_image(r->world, (kd_sky_map){WIDTH, HEIGHT, copy})};
    return kd_spawn(r->world, (kd_value){&kd_sky_desc, &sky},
                    KD_VAL(kd_transform, {{0, 0, 0}, rotation, {1, 1, 1}}), KD_TAG(kd_world_transform));
}

/* Values that differ from texel to texel, alike at the seam. */
static void fill(float *rgb)
{
    for (int i = 0; i < WIDTH * HEIGHT; i++)
        for (int c = 0; c < 3; c++)
            rgb[i * 3 + c] = 0.1f + 0.05f * (float)((i * (3 + c)) % 7);
}

/* The sky is turned by 90 degrees about y: what the picture has along d lies along (d.z, d.y, -d.x) in the
 * world, so a ray w of the world reads it at (-w.z, w.y, w.x). */
static void background_is_the_picture(void **state)
{
    render *r = *state;
    static float rgb[WIDTH * HEIGHT * 3];
    const kd_sky_map map = {WIDTH, HEIGHT, rgb};
    fill(rgb);
    add_sky(r, rgb, (kd_quat){0, sqrtf(0.5f), 0, sqrtf(0.5f)});
    r->frame->settings.light_ambient = 0.25f;
    render_camera(r, (kd_vec3){3, 1, 2}, (kd_vec3){3, 1, 1}, 1.2f);
    render_frame(r, "sky");
    for (uint32_t y = 3; y < 120; y += 13)
        for (uint32_t x = 2; x < 160; x += 17) {
            float t = tanf(0.6f), u = ((float)x + 0.5f) / 80 - 1, v = 1 - ((float)y + 0.5f) / 60;
            kd_vec3 w = kd_vec3_normalize((kd_vec3){u * t * 4 / 3, v * t, -1}, (kd_vec3){0, 0, -1});
            kd_vec3 c = kd_sky_sample(&map, (kd_vec3){-w.z, w.y, w.x});
            kd_vec3 expected = {0.25f + 2 * c.x, 0.25f + 2 * c.y, 0.25f + 2 * c.z};
            render_expect(r, x, y, expected, 0.01f); /* texel weights have 8 bits */
        }
}

/* A gradient of one colour is the uniform sky of that radiance, on matte and on glossy surfaces. */
static void uniform_gradient_is_a_uniform_sky(void **state)
{
    render *r = *state;
    kd_material_desc matte = render_matte(0.7f), glossy = render_matte(0.9f);
    glossy.metallic = 1;
    glossy.roughness = 0.3f;
    render_shape(r, KD_SHAPE_SPHERE, (kd_vec3){1, 1, 1}, &matte, (kd_vec3){-0.6f, 0, 0}, RENDER_UPRIGHT,
                 RENDER_UNIT);
    render_shape(r, KD_SHAPE_SPHERE, (kd_vec3){1, 1, 1}, &glossy, (kd_vec3){0.6f, 0, 0}, RENDER_UPRIGHT,
                 RENDER_UNIT);
    render_camera(r, (kd_vec3){0, 0.5f, 4}, (kd_vec3){0, 0, 0}, 0.7f);
    r->frame->settings.light_ambient = 1.5f;
    render_frame(r, "ambient");
    size_t count = (size_t)r->frame->width * r->frame->height * 4;
    float *first = malloc(count * sizeof *first);
    assert_non_null(first);
    memcpy(first, r->hdr, count * sizeof *first);
    r->frame->settings.light_ambient = 0;
    const kd_vec3 half = {0.75f, 0.75f, 0.75f};
    kd_sky sky = {.zenith = half, .horizon = half, .ground = half, .intensity = 2};
    kd_entity e = kd_spawn(r->world, (kd_value){&kd_sky_desc, &sky},
                           KD_VAL(kd_transform, KD_TRANSFORM_IDENTITY), KD_TAG(kd_world_transform));
    render_frame(r, "gradient");
    for (size_t i = 0; i < count; i++)
        if (!(fabsf(r->hdr[i] - first[i]) <= 0.002f * first[i]))
            fail_msg("value %zu is %g, expected %g", i, (double)r->hdr[i], (double)first[i]);
    free(first);
    kd_destroy(r->world, e);
    render_frame(r, "gone");
    render_expect(r, 2, 2, (kd_vec3){0, 0, 0}, 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        RENDER_TEST(background_is_the_picture),
        RENDER_TEST(uniform_gradient_is_a_uniform_sky),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
