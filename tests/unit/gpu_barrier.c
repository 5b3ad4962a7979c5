/* Barriers are wrong without a sign on most drivers, so the bits that reach GL are recorded. */

#include "runtime/gpu/internal.h"
#include "tests/gpu_fixture.h"

static GLbitfield recorded;
static int calls;

static void APIENTRY record(GLbitfield bits)
{
    recorded = bits;
    calls++;
}

static void barrier_maps_each_bit(void **state)
{
    const GLbitfield bits[] = {
        GL_SHADER_STORAGE_BARRIER_BIT, GL_SHADER_IMAGE_ACCESS_BARRIER_BIT,
        GL_TEXTURE_FETCH_BARRIER_BIT,  GL_VERTEX_ATTRIB_ARRAY_BARRIER_BIT,
        GL_ELEMENT_ARRAY_BARRIER_BIT,  GL_COMMAND_BARRIER_BIT,
        GL_UNIFORM_BARRIER_BIT,        GL_FRAMEBUFFER_BARRIER_BIT,
        GL_BUFFER_UPDATE_BARRIER_BIT,  GL_TEXTURE_UPDATE_BARRIER_BIT,
    };
    GLbitfield all = 0;
    kd_gpu *gpu = *state;
    gpu->gl.MemoryBarrier = record;
    for (uint32_t i = 0; i < 10; i++) {
        kd_gpu_barrier(gpu, 1u << i);
        assert_int_equal(recorded, bits[i]);
        all |= bits[i];
    }
    kd_gpu_barrier(gpu, 0x3ff);
    assert_int_equal(recorded, all);
    assert_int_equal(calls, 11); /* the union is one call */
    kd_gpu_barrier(gpu, 0);
    assert_int_equal(calls, 11);
}

int main(void)
{
    const struct CMUnitTest tests[] = {FIXTURE_TEST(barrier_maps_each_bit)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
