// Gathers the light that arrives at one side of a dense cell, for the sides that select.comp has listed. The octree that the
// cones run through holds what leaves sent out with the entries of the frames before.
layout(local_size_x = 64) in;

#include "shaders/include/emitters.glsl"
#include "shaders/include/sky.glsl"
#include "shaders/include/bounce.glsl"
#include "shaders/include/frame.glsl"
#include "shaders/include/morton.glsl"
#include "shaders/include/work_list.glsl"
#include "shaders/bounce/side_item.glsl"
#include "shaders/bounce/side_place.glsl"

layout(std140, binding = KD_BIND_PASS) uniform pass_block { kd_bounce_params pass; };
layout(std430, binding = 1) writeonly buffer bounce_block { uint entries[]; };

// What bounces is spread over all that it lights, so its cones go with longer steps than those of pixels; not where thin walls
// must hold.
#ifdef KD_LEAK_STRICT
const float LONGER_STEPS = 1.0, CLOSED = 0.0;
#else
const float LONGER_STEPS = 1.4, CLOSED = 0.1;
#endif

// Voxels between the surface and where its cones start.
const float LIFT = 2.5;

vec3 gather(side_place place, float span, uint variant)
{
    cone_settings settings = cone_settings(pass.cone.y, pass.cone.z, 0.0, 2.0, pass.far.x, CLOSED, 1.0), longer = settings;
    longer.step *= LONGER_STEPS;
    vec3 sum = vec3(0.0), origin = place.p_ws + (LIFT * span) * place.normal;
    mat3 frame = frame_round(place.normal);
    int i = 0;
    do {
        vec4 cone = pass.cones[KD_CONE_SETS * i + int(variant)];
        vec3 direction = frame * cone.xyz;
        cone_result r = cone_trace_wide(origin, direction, direction, pass.cone.x, 0.25 * span, longer);
        sum += cone.w * (r.radiance + r.transmittance * (pass.cone.w * tree.light.y) * sky_cone(direction, pass.cone.x * pass.far.x));
    } while (++i < KD_BOUNCE_CONES);
    return sum + tree.light.y * emitters_light(sum * tree.light.z, place.p_ws, origin, place.normal, 0.25 * span, 0.1, 1u, variant,
                                               emitter_settings(settings));
}

void main()
{
    if (gl_GlobalInvocationID.x >= work_count)
        return;
    uint item = work_items[gl_GlobalInvocationID.x], code = side_item_code(item), cascade = code >> (3 * KD_DENSE_LOG2);
    int side = side_item_side(item);
    ivec3 cell = dense_unwrap(cascade, morton_decode(code & ((1u << (3 * KD_DENSE_LOG2)) - 1u)));
    ivec3 world_cell = bounce_world_cell(cascade, cell);
    uint variant = uint(world_cell.x + world_cell.y + world_cell.z) & 3u;
    vec3 axis = vec3(equal(ivec3(side >> 1), ivec3(0, 1, 2))) * ((side & 1) == 0 ? 1.0 : -1.0);
    vec3 light = gather(side_place_of(int(cascade), cell, axis), tree_finest_edge(int(cascade)), variant);
    entries[bounce_first_entry(cascade, world_cell) + uint(side)] = rgb9e5_pack(light);
}
