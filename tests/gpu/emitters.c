/* What glows becomes a list of emitters: their power is that of the surface, whatever voxels it falls on. */
#include "components/emitters.h"
#include "shaders/shared/emitters.h"
#include "tests/voxel_fixture.h"

typedef struct emitter_sums {
    uint32_t count;
    double power, area; /* of all: red radiance times area, area */
} emitter_sums;

static struct kd_emitters_params *read_list(voxel_world *v)
{
    return voxel_read(kd_singleton(v->world, kd_emitters)->list, 0, sizeof(struct kd_emitters_params));
}

static emitter_sums read_sums(voxel_world *v)
{
    struct kd_emitters_params *list = read_list(v);
    emitter_sums sums = {.count = list->info.x};
    for (uint32_t i = 0; i < sums.count; i++) {
        sums.power += (double)list->emitter[i].power.x;
        sums.area += (double)list->emitter[i].power.w;
    }
    free(list);
    return sums;
}

static voxel_world open_world(uint32_t resolution)
{
    return voxel_open((voxel_options){
        .resolution = resolution, .cascades = 1, .span = 2.56f / (float)resolution, .lit = true});
}

static kd_material_desc glowing(float radiance)
{
    kd_material_desc m = voxel_matte(0, 0, 0);
    m.emissive = (kd_vec3){radiance, radiance, radiance};
    return m;
}

static kd_transform turned(kd_vec3 at, kd_vec3 axis, float degrees)
{
    kd_transform t = voxel_at(at.x, at.y, at.z);
    float half = degrees * 0.0087266463f, s = sinf(half);
    t.rotation = (kd_quat){axis.x * s, axis.y * s, axis.z * s, cosf(half)};
    return t;
}

/* Sheets that end between voxels: the cells at their rims are covered in part. 2 % for what the area of a
 * voxel is rounded to; cells of slanted sheets differ, and those of more than a face are cut off. */
static void power_is_that_of_the_surface(void **state)
{
    (void)state;
    const struct {
        kd_vec3 axis;
        float degrees;
        double tolerance;
    } cases[] = {{{1, 0, 0}, 0, 0.02}, {{1, 0, 0}, 30, 0.05}, {{0, 0, 1}, 45, 0.05}, {{1, 0, 0}, 90, 0.02}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        voxel_world v = open_world(128);
        kd_material_desc m = glowing(4);
        voxel_shape(&v, KD_SHAPE_PLANE, (kd_vec3){0.33f, 1, 0.47f}, &m,
                    turned((kd_vec3){0.103f, 0.051f, -0.207f}, cases[i].axis, cases[i].degrees));
        voxel_frame(&v);
        emitter_sums sums = read_sums(&v);
        assert_in_range(sums.count, 1, KD_MAX_EMITTERS);
        double exact = 4 * 0.33 * 0.47;
        if (fabs(sums.power / exact - 1) > cases[i].tolerance)
            fail_msg("turned by %g: power %g, exact %g", (double)cases[i].degrees, sums.power, exact);
        voxel_close(&v);
    }
}

/* A moving voxel is shared out over up to eight cells, less shares too small to mark: 4 % in the mean. */
static void power_is_kept_while_it_moves(void **state)
{
    (void)state;
    voxel_world v = open_world(256);
    kd_material_desc m = glowing(2);
    kd_entity box = voxel_shape(&v, KD_SHAPE_BOX, (kd_vec3){0.3f, 0.3f, 0.3f}, &m, voxel_at(0, 0, 0));
    for (int i = 0; i < 4; i++) {
        voxel_frame(&v);
        assert_float_equal((float)(read_sums(&v).power / (2 * 6 * 0.09)), 1, 0.06f);
        kd_find_mut(v.world, box, kd_transform)->position.y += 0.0043f;
        kd_find_mut(v.world, box, kd_transform)->position.x += 0.0021f;
    }
    kd_destroy(v.world, box);
    voxel_frame(&v);
    assert_int_equal(read_sums(&v).count, 0);
    voxel_close(&v);
}

/* Two boxes apart: every emitter has the radiance of one, a dim one beside a bright one too. */
static void dim_lamp_keeps_its_radiance_beside_a_bright_one(void **state)
{
    (void)state;
    voxel_world v = open_world(128);
    kd_material_desc bright = glowing(10), dim = glowing(0.5f);
    voxel_shape(&v, KD_SHAPE_BOX, (kd_vec3){0.2f, 0.2f, 0.2f}, &bright, voxel_at(-0.7f, 0, 0));
    voxel_shape(&v, KD_SHAPE_BOX, (kd_vec3){0.2f, 0.2f, 0.2f}, &dim, voxel_at(0.7f, 0, 0));
    voxel_frame(&v);
    struct kd_emitters_params *list = read_list(&v);
    assert_in_range(list->info.x, 2, KD_MAX_EMITTERS);
    for (uint32_t i = 0; i < list->info.x; i++) {
        const struct kd_emitter *e = &list->emitter[i];
        float radiance = e->place.x < 0 ? 10 : 0.5f;
        assert_float_equal(e->power.x / e->power.w, radiance, 0.05f * radiance);
    }
    free(list);
    voxel_close(&v);
}

/* Walls that glow all round light by cones: none is far enough to be a lamp. */
static void glowing_room_is_no_lamp(void **state)
{
    (void)state;
    voxel_world v = open_world(128);
    kd_material_desc m = glowing(1);
    const struct {
        kd_vec3 at, axis;
        float degrees;
    } walls[6] = {{{0, -0.3f, 0}, {1, 0, 0}, 0},   {{0, 0.3f, 0}, {1, 0, 0}, 180},
                  {{-0.3f, 0, 0}, {0, 0, 1}, -90}, {{0.3f, 0, 0}, {0, 0, 1}, 90},
                  {{0, 0, -0.3f}, {1, 0, 0}, 90},  {{0, 0, 0.3f}, {1, 0, 0}, -90}};
    for (int i = 0; i < 6; i++)
        voxel_shape(&v, KD_SHAPE_PLANE, (kd_vec3){0.6f, 1, 0.6f}, &m,
                    turned(walls[i].at, walls[i].axis, walls[i].degrees));
    voxel_frame(&v);
    assert_int_equal(read_sums(&v).count, 0);
    voxel_close(&v);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(power_is_that_of_the_surface),
        cmocka_unit_test(power_is_kept_while_it_moves),
        cmocka_unit_test(dim_lamp_keeps_its_radiance_beside_a_bright_one),
        cmocka_unit_test(glowing_room_is_no_lamp),
    };
    return VOXEL_GROUP(tests);
}
