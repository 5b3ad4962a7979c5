/* Materials: the shaders' formulas, energy, opacity, textures; and that odd input stays harmless. */

#include "tests/reference_fixture.h"

static const kd_vec3 origin = {0, 0, 0};

/* ---- the lobe, in double, written from the specification ---- */

/* Isotropic GGX, height-correlated Smith, Schlick; radiance over irradiance of light from l times n.l. z is
 * the normal. */
static double reflectance(const double v[3], const double l[3], double roughness, double f0, double diffuse)
{
    double h[3] = {v[0] + l[0], v[1] + l[1], v[2] + l[2]},
           length = sqrt(h[0] * h[0] + h[1] * h[1] + h[2] * h[2]);
    double alpha = fmax(roughness, 0.04) * fmax(roughness, 0.04), a2 = alpha * alpha;
    double nh = h[2] / length, vh = (v[0] * h[0] + v[1] * h[1] + v[2] * h[2]) / length;
    double t = nh * nh * (a2 - 1) + 1, d = a2 / (FIXTURE_PI * t * t);
    double g = 0.5 / (l[2] * sqrt(v[2] * v[2] * (1 - a2) + a2) + v[2] * sqrt(l[2] * l[2] * (1 - a2) + a2));
    double f = f0 + (1 - f0) * pow(1 - vh, 5);
    return (f * d * g + (1 - f) * diffuse / FIXTURE_PI) * l[2];
}

/* What a sky of 1 becomes: the integral over all l, by the midpoint rule in the half vector's space, where
 * the lobe is smooth however narrow it is: tan(t) = alpha sqrt(u / (1 - u)) spreads points as the normals are
 * distributed. */
static double specular_albedo(double cosine, double roughness, double f0)
{
    const int n = 512;
    double alpha = fmax(roughness, 0.04) * fmax(roughness, 0.04),
           v[3] = {sqrt(1 - cosine * cosine), 0, cosine}, sum = 0;
    for (int i = 0; i < n; i++)
        for (int j = 0; j < n; j++) {
            double u = (i + 0.5) / n, phi = 2 * FIXTURE_PI * (j + 0.5) / n;
            double tangent = alpha * sqrt(u / (1 - u)), c = 1 / sqrt(1 + tangent * tangent),
                   s = sqrt(1 - c * c);
            double h[3] = {s * cos(phi), s * sin(phi), c}, vh = v[0] * h[0] + v[2] * h[2];
            double l[3] = {2 * vh * h[0] - v[0], 2 * vh * h[1], 2 * vh * h[2] - v[2]};
            double a2 = alpha * alpha, t = c * c * (a2 - 1) + 1, d = a2 / (FIXTURE_PI * t * t);
            if (vh > 0 && l[2] > 0) /* density of h is d c, of l that over 4 v.h */
                sum += reflectance(v, l, roughness, f0, 0) / (d * c / (4 * vh));
        }
    return sum / ((double)n * n);
}

/* The plane y = 0, seen through one pixel at `cosine` to its normal. */
static void look_at_plane(fixture *f, const kd_material_desc *material, float cosine)
{
    float sine = sqrtf(1 - cosine * cosine);
    fixture_shape(f, KD_SHAPE_PLANE, (kd_vec3){20, 1, 20}, material, FIXTURE_AT(0, 0, 0));
    fixture_camera(f, (kd_vec3){3 * sine, 3 * cosine, 0}, origin);
}

static void run_case(void (*body)(fixture *f, const float *p), const float *p)
{
    void *fresh;
    fixture_setup(&fresh);
    body(fresh, p);
    fixture_teardown(&fresh);
}

static void check_direct(fixture *f, const float *p)
{
    kd_material_desc m = fixture_material(0.6f, p[1], p[0]);
    f->desc.spp = 1;
    look_at_plane(f, &m, 0.8f);
    fixture_light(f, (kd_light){.type = KD_DIRECTIONAL, .color = {1, 1, 1}, .intensity = 2}, origin,
                  (kd_vec3){0.48f, -0.6f, 0.64f});
    double v[3] = {0.6, 0, 0.8}, l[3] = {-0.48, 0.64, 0.6}, metallic = (double)p[1];
    double f0 = 0.04 + (0.6 - 0.04) * metallic;
    fixture_expect(fixture_mean(f, KD_REFERENCE_DIRECT),
                   2 * reflectance(v, l, (double)p[0], f0, 0.6 * (1 - metallic)), 1e-3);
}

static void directional_light_follows_the_formula(void **state)
{
    (void)state;
    static const float cases[][2] = {{1, 0}, {0.5f, 0}, {0.3f, 1}, {0.7f, 0.5f}};
    for (size_t i = 0; i < 4; i++)
        run_case(check_direct, cases[i]);
}

/* A white metal under a sky of 1 returns what single scattering keeps, and never more than it gets. */
static void check_white_metal(fixture *f, const float *p)
{
    kd_material_desc m = fixture_material(1, 1, p[0]);
    f->desc.spp = 16384;
    f->frame->settings.light_ambient = 1;
    look_at_plane(f, &m, p[1]);
    double value = fixture_mean(f, KD_REFERENCE_FINAL);
    fixture_expect(value, specular_albedo((double)p[1], (double)p[0], 1), 0.004);
    assert_true(value <= 1.001);
    fixture_expect(fixture_mean(f, KD_REFERENCE_SPECULAR), value, 1e-5);
}

static void white_metal_keeps_the_energy_of_its_lobe(void **state)
{
    (void)state;
    static const float cases[][2] = {{0, 0.9f},    {0.1f, 0.3f}, {0.3f, 0.7f},
                                     {0.6f, 0.2f}, {1, 0.9f},    {1, 0.3f}};
    for (size_t i = 0; i < 6; i++)
        run_case(check_white_metal, cases[i]);
}

/* What the diffuse layer of albedo 1 returns: the same integral over directions spread by their cosine. */
static double diffuse_albedo(double cosine, double roughness, double f0)
{
    const int n = 512;
    double v[3] = {sqrt(1 - cosine * cosine), 0, cosine}, sum = 0;
    for (int i = 0; i < n; i++)
        for (int j = 0; j < n; j++) {
            double u = (i + 0.5) / n, phi = 2 * FIXTURE_PI * (j + 0.5) / n, r = sqrt(u);
            double l[3] = {r * cos(phi), r * sin(phi), sqrt(1 - u)};
            sum += (reflectance(v, l, roughness, f0, 1) - reflectance(v, l, roughness, f0, 0)) / l[2] *
                   FIXTURE_PI;
        }
    return sum / ((double)n * n);
}

/* A white dielectric. What Fresnel's term gives the lobe it takes from the diffuse layer, though by another
 * half vector: the two are not exactly 1 together, and the specification's formula is what counts. */
static void check_white_dielectric(fixture *f, const float *p)
{
    kd_material_desc m = fixture_material(1, 0, p[0]);
    double roughness = (double)p[0], cosine = (double)p[1];
    f->desc.spp = 16384;
    f->frame->settings.light_ambient = 1;
    look_at_plane(f, &m, p[1]);
    fixture_expect(fixture_mean(f, KD_REFERENCE_SPECULAR), specular_albedo(cosine, roughness, 0.04), 0.01);
    fixture_expect(fixture_mean(f, KD_REFERENCE_DIFFUSE), diffuse_albedo(cosine, roughness, 0.04), 0.004);
    assert_true(fixture_mean(f, KD_REFERENCE_FINAL) < 1.03);
}

static void white_dielectric_follows_the_formula(void **state)
{
    (void)state;
    static const float cases[][2] = {{0, 0.9f}, {0.4f, 0.5f}, {1, 0.5f}};
    for (size_t i = 0; i < 3; i++)
        run_case(check_white_dielectric, cases[i]);
}

/* ---- opacity ---- */

/* A blended sheet of opacity 0.25 and base colour 0 over an emitter of 4: three quarters pass. In the sheet's
 * shadow as much of a light arrives. */
static void blended_sheet_lets_its_share_through(void **state)
{
    fixture *f = *state;
    kd_material_desc sheet = fixture_material(0, 0, 1), glow = fixture_material(0, 0, 1);
    f->desc.lambert = true;
    f->desc.spp = 8192;
    sheet.alpha_mode = KD_ALPHA_BLEND;
    sheet.base_color.w = 0.25f;
    glow.emissive = (kd_vec3){4, 4, 4};
    fixture_shape(f, KD_SHAPE_PLANE, (kd_vec3){2, 1, 2}, &glow, FIXTURE_AT(0, 0, 0));
    fixture_shape(f, KD_SHAPE_PLANE, (kd_vec3){2, 1, 2}, &sheet, FIXTURE_AT(0, 1, 0));
    fixture_camera(f, (kd_vec3){0.2f, 3, 0.1f},
                   (kd_vec3){0.2f, 0, 0.1f}); /* off the edge between triangles */
    fixture_expect(fixture_mean(f, KD_REFERENCE_FINAL), 3, 0.01);
}

static void blended_sheet_dims_a_light_by_its_share(void **state)
{
    fixture *f = *state;
    kd_material_desc sheet = fixture_material(0, 0, 1), floor = fixture_material(1, 0, 1);
    f->desc.lambert = true;
    f->desc.spp = 1;
    f->desc.bounces = 0;
    sheet.alpha_mode = KD_ALPHA_BLEND;
    sheet.base_color.w = 0.25f;
    fixture_shape(f, KD_SHAPE_PLANE, (kd_vec3){2, 1, 2}, &floor, FIXTURE_AT(0, 0, 0));
    fixture_shape(f, KD_SHAPE_PLANE, (kd_vec3){1, 1, 1}, &sheet, FIXTURE_AT(1, 1, 0));
    fixture_camera(f, (kd_vec3){0, 3, 0}, origin);
    fixture_light(f, (kd_light){.type = KD_DIRECTIONAL, .color = {1, 1, 1}, .intensity = 1}, origin,
                  (kd_vec3){-1, -1, 0});
    fixture_expect(fixture_mean(f, KD_REFERENCE_DIRECT), 0.75 * sqrt(0.5) / FIXTURE_PI, 1e-5);
}

/* Glass without roughness over an emitter of 4, seen at a cosine of 0.8: Fresnel's term is 0.04 + 0.96 *
 * 0.2^5 = 0.0403, and what it leaves has the glass's colour. A lamp's light is tinted as much on its way to
 * the floor. */
static void glass_tints_what_it_lets_through(void **state)
{
    fixture *f = *state;
    kd_material_desc glass = fixture_material(0.5f, 0, 0), glow = fixture_material(0, 1, 1);
    f->desc.spp = 8192;
    f->desc.bounces = 1;
    glass.transmission = 1;
    glass.alpha_mode = KD_ALPHA_BLEND;
    glass.alpha_ignored = true;
    glow.emissive = (kd_vec3){4, 4, 4};
    fixture_shape(f, KD_SHAPE_PLANE, (kd_vec3){2, 1, 2}, &glow, FIXTURE_AT(0, 0, 0));
    fixture_shape(f, KD_SHAPE_PLANE, (kd_vec3){2, 1, 2}, &glass, FIXTURE_AT(0, 1, 0));
    fixture_camera(f, (kd_vec3){1.8f, 3, 0.1f}, (kd_vec3){0.3f, 1, 0.1f});
    fixture_expect(fixture_mean(f, KD_REFERENCE_FINAL), 4 * 0.5 * (1 - 0.0403), 0.03);
}

static void glass_tints_a_lamps_light(void **state)
{
    fixture *f = *state;
    kd_material_desc glass = fixture_material(0.5f, 0, 0), floor = fixture_material(1, 0, 1);
    f->desc.spp = 1;
    f->desc.bounces = 0;
    glass.transmission = 1;
    glass.alpha_mode = KD_ALPHA_BLEND;
    glass.alpha_ignored = true;
    fixture_shape(f, KD_SHAPE_PLANE, (kd_vec3){2, 1, 2}, &floor, FIXTURE_AT(0, 0, 0));
    fixture_shape(f, KD_SHAPE_PLANE, (kd_vec3){1, 1, 1}, &glass, FIXTURE_AT(1, 1, 0));
    fixture_camera(f, (kd_vec3){0, 3, 0}, origin);
    fixture_light(f, (kd_light){.type = KD_DIRECTIONAL, .color = {1, 1, 1}, .intensity = 1}, origin,
                  (kd_vec3){-1, -1, 0});
    double open = fixture_mean(f, KD_REFERENCE_DIRECT), fresnel = 0.04 + 0.96 * pow(1 - sqrt(0.5), 5);
    double v[3] = {0, 0, 1}, l[3] = {sqrt(0.5), 0, sqrt(0.5)};
    fixture_expect(open, 0.5 * (1 - fresnel) * reflectance(v, l, 1, 0.04, 1), 1e-3);
}

static void masked_sheet_is_there_or_not(void **state)
{
    fixture *f = *state;
    kd_material_desc sheet = fixture_material(0, 0, 1);
    f->desc.spp = 16;
    f->frame->settings.light_ambient = 1;
    sheet.alpha_mode = KD_ALPHA_MASK;
    sheet.alpha_cutoff = 0.5f;
    sheet.base_color.w = 0.49f;
    fixture_shape(f, KD_SHAPE_PLANE, (kd_vec3){2, 1, 2}, &sheet, FIXTURE_AT(0, 0, 0));
    fixture_camera(f, (kd_vec3){0, 3, 0}, origin);
    assert_true(fixture_mean(f, KD_REFERENCE_DEPTH) == 0);
    fixture_expect(fixture_mean(f, KD_REFERENCE_FINAL), 1, 1e-6);
}

/* ---- sides ---- */

/* The camera passes through the back of a one-sided sheet, be it mirrored, instanced or both, and sees its
 * front. */
static void camera_sees_no_backs(void **state)
{
    fixture *f = *state;
    kd_material_desc m = fixture_material(0.5f, 0, 1);
    kd_model *model;
    uint32_t number;
    m.double_sided = false;
    f->desc.spp = 1;
    assert_int_equal(kd_model_make_shape(KD_SHAPE_PLANE, (kd_vec3){1, 1, 1}, 0, &m, &model), KD_OK);
    assert_int_equal(kd_scene_add_model(f->world, model, &number), KD_OK);
    fixture_camera(f, (kd_vec3){0, 3, 0}, origin);
    for (uint32_t variant = 0; variant < 8; variant++) {
        bool back = variant & 1, mirrored = variant & 2, instanced = variant & 4;
        kd_entity one, two;
        assert_int_equal(kd_scene_instantiate(f->world, number, KD_NO_ENTITY, "one", &one), KD_OK);
        assert_int_equal(kd_scene_instantiate(f->world, number, KD_NO_ENTITY, "two", &two), KD_OK);
        kd_transform *t = kd_find_mut(f->world, one, kd_transform);
        t->rotation = back ? (kd_quat){1, 0, 0, 0} : (kd_quat){0, 0, 0, 1};
        t->scale.x = mirrored ? -1.0f : 1.0f;
        kd_find_mut(f->world, two, kd_transform)->position = (kd_vec3){50, 0, 0};
        if (!instanced)
            kd_destroy(f->world, two);
        double depth = fixture_mean(f, KD_REFERENCE_DEPTH);
        if (back ? depth != 0 : fabs(depth - 3) > 1e-4)
            fail_msg("back %d mirrored %d instanced %d: depth %g", back, mirrored, instanced, depth);
        kd_destroy(f->world, one);
        if (instanced)
            kd_destroy(f->world, two);
    }
}

/* The same boxes by instances and baked give the same picture up to rounding. */
static void instances_agree_with_baked_meshes(void **state)
{
    fixture *f = *state;
    kd_material_desc m = fixture_material(0.5f, 0, 1);
    kd_transform places[2] = {FIXTURE_AT(-0.6f, 0, 0), FIXTURE_AT(0.7f, 0.1f, -0.3f)};
    float kept[16 * 16 * 3];
    places[1].scale = (kd_vec3){0.5f, 1.5f, -1};
    places[1].rotation = fixture_look((kd_vec3){0.3f, 0.5f, -1});
    f->frame->width = f->frame->height = 16;
    f->frame->settings.light_ambient = 1;
    f->desc.spp = 64;
    fixture_camera(f, (kd_vec3){0, 1, 3}, origin);
    kd_entity own[2];
    for (int i = 0; i < 2; i++)
        own[i] = fixture_shape(f, KD_SHAPE_BOX, (kd_vec3){1, 1, 1}, &m, places[i]);
    memcpy(kept, fixture_trace(f, KD_REFERENCE_FINAL), sizeof kept);
    for (int i = 0; i < 2; i++)
        kd_destroy(f->world, own[i]);
    kd_model *model;
    uint32_t number;
    assert_int_equal(kd_model_make_shape(KD_SHAPE_BOX, (kd_vec3){1, 1, 1}, 0, &m, &model), KD_OK);
    assert_int_equal(kd_scene_add_model(f->world, model, &number), KD_OK);
    for (int i = 0; i < 2; i++) {
        kd_entity root;
        assert_int_equal(kd_scene_instantiate(f->world, number, KD_NO_ENTITY, "one", &root), KD_OK);
        *kd_find_mut(f->world, root, kd_transform) = places[i];
    }
    const float *now = fixture_trace(f, KD_REFERENCE_FINAL);
    double sum = 0;
    for (size_t i = 0; i < sizeof kept / sizeof *kept; i++)
        sum += fabs((double)now[i] - (double)kept[i]);
    assert_true(sum / (double)(sizeof kept / sizeof *kept) < 1e-3);
}

/* ---- odd input ---- */

static void finite_picture(fixture *f)
{
    const float *rgb = fixture_trace(f, KD_REFERENCE_FINAL);
    for (size_t i = 0; i < (size_t)f->info.width * f->info.height * 3; i++)
        assert_true(isfinite(rgb[i]) && rgb[i] >= 0);
    assert_int_equal(f->info.bad_samples, 0);
}

static void degenerate_scenes_stay_finite(void **state)
{
    fixture *f = *state;
    kd_material_desc m = fixture_material(1, 0, 0), mirror = fixture_material(1, 1, 0),
                     black = fixture_material(0, 0, 0);
    m.emissive = (kd_vec3){1, 1, 1};
    f->frame->width = f->frame->height = 16;
    f->frame->settings.light_ambient = 1;
    f->desc.spp = 16;
    finite_picture(f); /* nothing but sky; no camera */
    fixture_camera(f, (kd_vec3){0, 0, 3}, origin);
    kd_transform flat = FIXTURE_AT(0.2f, 0, 0), gone = FIXTURE_AT(0, 0, 0), tiny = FIXTURE_AT(0, 0.5f, 0);
    flat.scale = (kd_vec3){1, 0, 1};
    gone.scale = (kd_vec3){0, 0, 0};
    tiny.scale = (kd_vec3){1e-12f, 1e-12f, 1e-12f};
    fixture_shape(f, KD_SHAPE_BOX, (kd_vec3){1, 1, 1}, &m, flat);
    fixture_shape(f, KD_SHAPE_BOX, (kd_vec3){1, 1, 1}, &m, gone); /* emits, and has no area */
    fixture_shape(f, KD_SHAPE_SPHERE, (kd_vec3){1, 1, 1}, &m, tiny);
    fixture_shape(f, KD_SHAPE_SPHERE, (kd_vec3){1, 1, 1}, &mirror, FIXTURE_AT(-0.5f, 0, 0));
    fixture_shape(f, KD_SHAPE_SPHERE, (kd_vec3){1, 1, 1}, &black, FIXTURE_AT(0.5f, 0, 0));
    finite_picture(f);
    kd_light lamps[] = {
        {.type = KD_POINT, .color = {1, 1, 1}, .intensity = 1e6f},
        {.type = KD_POINT, .color = {1, 1, 1}, .intensity = 0},
        {.type = KD_SPOT, .color = {1, 1, 1}, .intensity = 1e6f, .inner_cone = 0, .outer_cone = 0},
        {.type = KD_DIRECTIONAL, .color = {0, 0, 0}, .intensity = 1e6f}};
    for (size_t i = 0; i < 4; i++) /* one in a wall's surface, one inside a sphere */
        fixture_light(f, lamps[i], i & 1 ? (kd_vec3){0.5f, 0, 0} : (kd_vec3){0.2f, 0, 0},
                      (kd_vec3){0, 0, -1});
    finite_picture(f);
}

static void camera_inside_a_solid_sees_out(void **state)
{
    fixture *f = *state;
    kd_material_desc m = fixture_material(0.5f, 0, 1);
    m.double_sided = false;
    f->desc.spp = 4;
    f->frame->settings.light_ambient = 1;
    fixture_shape(f, KD_SHAPE_BOX, (kd_vec3){1, 1, 1}, &m, FIXTURE_AT(0, 0, 0));
    fixture_camera(f, origin, (kd_vec3){0, 0, -1});
    fixture_expect(fixture_mean(f, KD_REFERENCE_FINAL), 1, 1e-6);
}

/* ---- the same every time ---- */

static void threads_and_passes_change_no_byte(void **state)
{
    fixture *f = *state;
    kd_material_desc m = fixture_material(0.7f, 0.3f, 0.4f);
    float kept[40 * 24 * 3];
    f->frame->width = 40;
    f->frame->height = 24;
    f->frame->settings.light_ambient = 1;
    f->desc.spp = 24;
    f->desc.seed = 7;
    fixture_shape(f, KD_SHAPE_TORUS, (kd_vec3){2, 0.6f, 2}, &m, FIXTURE_AT(0, 0, 0));
    fixture_camera(f, (kd_vec3){0, 1, 3}, origin);
    memcpy(kept, fixture_trace(f, KD_REFERENCE_FINAL), sizeof kept);
    for (uint32_t threads = 1; threads <= 5; threads += 2) {
        kd_jobs *two = f->jobs;
        f->jobs = kd_jobs_make(threads);
        assert_memory_equal(fixture_trace(f, KD_REFERENCE_FINAL), kept, sizeof kept);
        kd_jobs_destroy(f->jobs);
        f->jobs = two;
    }
    f->desc.seed = 8;
    assert_memory_not_equal(fixture_trace(f, KD_REFERENCE_FINAL), kept, sizeof kept);
}

static bool stop_at_once(void *user, uint32_t done, uint32_t spp, double ms)
{
    (void)ms;
    (void)spp;
    *(uint32_t *)user = done;
    return false;
}

static void an_interrupted_picture_keeps_its_samples(void **state)
{
    fixture *f = *state;
    kd_reference *r;
    uint32_t done = 0;
    float rgb[3];
    f->frame->settings.light_ambient = 1;
    f->desc.spp = 1000;
    f->desc.progress = stop_at_once;
    f->desc.user = &done;
    fixture_step(f);
    assert_int_equal(kd_reference_open(f->world, f->jobs, &f->desc, &r), KD_OK);
    assert_int_equal(kd_reference_render(r), KD_INTERRUPTED);
    assert_true(done >= 1 && done < 1000 && kd_reference_get_info(r).spp == done);
    kd_reference_read(r, KD_REFERENCE_FINAL, rgb);
    fixture_expect((double)rgb[1], 1, 1e-6);
    kd_reference_close(r);
}

/* Half the noise asked for takes fewer samples than allowed; the estimate then says so. */
static void tracing_ends_when_noise_is_low_enough(void **state)
{
    fixture *f = *state;
    kd_material_desc m = fixture_material(0.5f, 0, 1);
    f->desc.spp = 1 << 20;
    f->desc.noise = 1e-4;
    f->desc.lambert = true;
    m.emissive = (kd_vec3){1, 1, 1};
    f->frame->width = f->frame->height = 4;
    fixture_shape(f, KD_SHAPE_BOX, (kd_vec3){2, 2, 2}, &m, FIXTURE_AT(0, 0, 0));
    fixture_camera(f, origin, (kd_vec3){1, 0.3f, 0.2f});
    fixture_trace(f, KD_REFERENCE_FINAL);
    assert_true(f->info.spp < 1 << 20 && f->info.noise <= 1e-4 && f->info.noise > 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(directional_light_follows_the_formula),
        cmocka_unit_test(white_metal_keeps_the_energy_of_its_lobe),
        cmocka_unit_test(white_dielectric_follows_the_formula),
        FIXTURE_TEST(blended_sheet_lets_its_share_through),
        FIXTURE_TEST(blended_sheet_dims_a_light_by_its_share),
        FIXTURE_TEST(glass_tints_what_it_lets_through),
        FIXTURE_TEST(glass_tints_a_lamps_light),
        FIXTURE_TEST(masked_sheet_is_there_or_not),
        FIXTURE_TEST(camera_sees_no_backs),
        FIXTURE_TEST(instances_agree_with_baked_meshes),
        FIXTURE_TEST(degenerate_scenes_stay_finite),
        FIXTURE_TEST(camera_inside_a_solid_sees_out),
        FIXTURE_TEST(threads_and_passes_change_no_byte),
        FIXTURE_TEST(an_interrupted_picture_keeps_its_samples),
        FIXTURE_TEST(tracing_ends_when_noise_is_low_enough),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
