#ifndef KD_TESTS_SHADOW_FIXTURE_H
#define KD_TESTS_SHADOW_FIXTURE_H

/* For tests of which shadow maps are drawn: what a frame did, and its maps against those of a world made
 * anew. */

#include "systems/shadow/internal.h"
#include "tests/render_fixture.h"

/* Pixels of a directional map, to which light_shadow_size must be set, and of a local one. */
enum { SHADOW_EDGE = 256, SHADOW_LOCAL_EDGE = 128 };

static inline shadow_state *shadow_state_of(const render *r)
{
    return kd_singleton(r->world, kd_lighting)->internal;
}

/* Both arrays, one after the other. */
static inline float *shadow_read_maps(const render *r, size_t *count)
{
    const kd_lighting *l = kd_singleton(r->world, kd_lighting);
    const shadow_state *s = shadow_state_of(r);
    size_t sun = (size_t)SHADOW_EDGE * SHADOW_EDGE * s->maps[true].layers;
    size_t spot = (size_t)SHADOW_LOCAL_EDGE * SHADOW_LOCAL_EDGE * s->maps[false].layers;
    assert_true(s->maps[true].edge == SHADOW_EDGE && s->maps[false].edge == SHADOW_LOCAL_EDGE);
    float *out = malloc((sun + spot) * sizeof *out);
    assert_non_null(out);
    kd_gpu_read_texture(r->gpu, l->shadow_directional, 0, out, sun * sizeof *out);
    kd_gpu_read_texture(r->gpu, l->shadow_spot, 0, out + sun, spot * sizeof *out);
    *count = sun + spot;
    return out;
}

/* Assert that the maps are, byte for byte, those of the first frame of a world that `make` fills. */
static inline void shadow_expect_like_fresh(render *r, void (*make)(render *fresh, const void *state),
                                            const void *state)
{
    render *fresh;
    size_t count, fresh_count, differing = 0, covered = 0;
    float *maps = shadow_read_maps(r, &count);
    kd_gpu_make_current(r->gpu, false);
    render_setup((void **)&fresh);
    make(fresh, state);
    render_frame(fresh, "fresh");
    float *expected = shadow_read_maps(fresh, &fresh_count);
    render_teardown((void **)&fresh);
    kd_gpu_make_current(r->gpu, true);
    kd_log_set_sink(render_log, r);
    assert_int_equal(count, fresh_count);
    for (size_t i = 0; i < count; i++) {
        differing += memcmp(&maps[i], &expected[i], sizeof maps[i]) != 0;
        covered += expected[i] < 1;
    }
    free(maps);
    free(expected);
    assert_true(covered > 1000); /* else there was nothing to compare */
    if (differing != 0)
        fail_msg("%zu of %zu texels differ from those of a fresh world", differing, count);
}

#endif
