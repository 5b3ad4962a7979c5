// All diffuse cones in one march: each step samples one of them, in turn, so that the samples lie on a spiral round the normal.
// Every cone keeps what it has let through; with one transmittance for all, what is open beside a wall would close with it.
// A round of the march is as long as a step of a cone that is traced alone: fewer samples let light through walls. Whoever wants
// one sample a step as the source has it makes steps longer by the number of cones.
// Source: Yalciner 2016, section 4.6.

// Neighbouring pixels are at other cones of the set in the same step.
uint march_turn(int step, uint variant) { return (uint(step) + variant * gather.size.w / 4u) % gather.size.w; }

// v: what the sample of cone i at t gave, which stands for a round of the march, s long.
void march_step(inout cone_result all, inout float through[KD_MAX_CONES], float t, uint i, float weight, vec4 v, float s, float falloff)
{
    float lost = through[i] - cone_open_after(through[i], v, s), gained = weight * lost;
    if (v.a * s > CONE_LEAST_DEPTH)
        all.radiance += gained * (v.rgb / v.a);
    all.occlusion += gained / (1.0 + falloff * t);
    all.transmittance -= gained;
    through[i] -= lost;
    all.samples++;
}

// Where a march stands: how far, at which cone of the set, and what the next sample is taken of.
struct march_state {
    float t;
    uint turn;
    set_cone cone;
    cone_place at;
};

march_state march_at(float t, cone_result r, vec3 origin_ws, mat3 frame, uint variant, cone_settings settings)
{
    uint turn = march_turn(r.samples, variant);
    set_cone cone = cone_of_set(turn, variant, frame);
    return march_state(t, turn, cone, cone_place_at(t, r, origin_ws, cone.axis, gather.cone.x, settings));
}

// Returns what all cones together give, `through` what each lets pass. Loops as in cone_trace (shaders/include/cone.glsl).
cone_result march_cones(out float through[KD_MAX_CONES], vec3 origin_ws, mat3 frame, uint variant, float start, cone_settings settings)
{
    // Diameters grow with t, and so do steps: of each a share that makes a round as long as a cone's own step.
    float growth = 2.0 * gather.cone.x * settings.far * settings.step;
    float share = (pow(1.0 + growth, 1.0 / float(gather.size.w)) - 1.0) / growth;
    for (int i = 0; i < KD_MAX_CONES; i++)
        through[i] = 1.0;
    cone_result r = cone_begin();
    march_state m = march_at(start, r, origin_ws, frame, variant, settings);
    do {
        do {
            if (m.at.goes_on && m.at.sparse) {
                march_step(r, through, m.t, m.turn, m.cone.weight, cone_sample_sparse(r, m.at, m.cone.facing), m.at.stride, settings.falloff);
                m = march_at(m.t + share * m.at.stride, r, origin_ws, frame, variant, settings);
            }
        } while (m.at.goes_on && m.at.sparse);
        do {
            if (m.at.goes_on && !m.at.sparse) {
                march_step(r, through, m.t, m.turn, m.cone.weight, cone_sample_wide(r, m.at, m.cone.facing), m.at.stride, settings.falloff);
                m = march_at(m.t + share * m.at.stride, r, origin_ws, frame, variant, settings);
            }
        } while (m.at.goes_on && !m.at.sparse);
    } while (m.at.goes_on);
    return r;
}

// Every cone of the set, in turn. Returns irradiance, and how much of the hemisphere is open.
vec4 trace_set(vec3 origin_ws, mat3 frame, uint variant, float start)
{
    float through[KD_MAX_CONES];
    cone_result r = march_cones(through, origin_ws, frame, variant, start, settings());
    count_cone(0u, r.samples);
    vec3 sky = vec3(0.0);
    for (uint i = 0u; i < gather.size.w; i++) {
        set_cone cone = cone_of_set(i, variant, frame);
        sky += cone.weight * through[i] * sky_cone(cone.axis, gather.cone.x * gather.light.w);
    }
    return vec4(r.radiance * tree.light.z + sky, 1.0 - r.occlusion);
}
