// Gathers the light that arrives at one side of a dense cell, for the sides that select.comp has listed. The octree that the
// cones run through holds what leaves sent out with the entries of the frames before.
layout(local_size_x = 64) in;

#include "shaders/include/emitters.glsl"
#include "shaders/include/sky.glsl"
#include "shaders/include/bounce.glsl"
#include "shaders/include/morton.glsl"
#include "shaders/include/work_list.glsl"
#include "shaders/bounce/side_item.glsl"

layout(std140, binding = KD_BIND_PASS) uniform pass_block { kd_bounce_params pass; };
layout(std430, binding = 1) writeonly buffer bounce_block { uint entries[]; };

// Axes x, y, z to a frame whose z is the side's normal.
vec3 to_side(vec3 v, int side)
{
    vec3 turned = side < 2 ? v.zxy : side < 4 ? v.yzx : v;
    return (side & 1) == 0 ? turned : -turned;
}

// What bounces is spread over all that it lights, so its cones go with longer steps than those of pixels; not where thin walls
// must hold.
#ifdef KD_LEAK_STRICT
const float LONGER_STEPS = 1.0, CLOSED = 0.0;
#else
const float LONGER_STEPS = 1.4, CLOSED = 0.25;
#endif

vec3 gather(vec3 origin, int side, float span, uint variant)
{
    cone_settings settings = cone_settings(pass.cone.y, pass.cone.z, 0.0, 2.0, pass.far.x, CLOSED, 1.0), longer = settings;
    longer.step *= LONGER_STEPS;
    vec3 sum = vec3(0.0);
    int i = 0;
    do {
        vec4 cone = pass.cones[KD_CONE_SETS * i + int(variant)];
        vec3 direction = to_side(cone.xyz, side);
        cone_result r = cone_trace_wide(origin, direction, direction, pass.cone.x, 0.25 * span, longer);
        sum += cone.w * (r.radiance + r.transmittance * (pass.cone.w * tree.light.y) * sky_cone(direction, pass.cone.x * pass.far.x));
    } while (++i < KD_BOUNCE_CONES);
    vec3 normal = to_side(vec3(0.0, 0.0, 1.0), side);
    return sum + tree.light.y * emitters_light(sum * tree.light.z, origin, origin, normal, 0.25 * span, 0.1, 1u, variant, emitter_settings(settings));
}

void main()
{
    if (gl_GlobalInvocationID.x >= work_count)
        return;
    uint item = work_items[gl_GlobalInvocationID.x], code = side_item_code(item), cascade = code >> (3 * KD_DENSE_LOG2);
    int side = side_item_side(item);
    ivec3 cell = dense_unwrap(cascade, morton_decode(code & ((1u << (3 * KD_DENSE_LOG2)) - 1u)));
    ivec3 world_cell = bounce_world_cell(cascade, cell);
    float span = tree_finest_edge(int(cascade)), edge = tree.cascade[cascade].w * float(tree.info.y / KD_DENSE);
    vec3 centre = tree.cascade[cascade].xyz + (vec3(cell) + 0.5) * edge;
    uint variant = uint(world_cell.x + world_cell.y + world_cell.z) & 3u;
    vec3 light = gather(centre + to_side(vec3(0.0, 0.0, 0.5 * edge + span), side), side, span, variant);
    entries[bounce_first_entry(cascade, world_cell) + uint(side)] = rgb9e5_pack(light);
}
