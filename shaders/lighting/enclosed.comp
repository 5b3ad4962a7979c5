// How far each local light is shut in by matter. Its shadow maps know where its light first lands, and the tree which way the
// surface there looks: a light inside of a wall or a box sees backs alone. What such a light would give to cells in which surfaces
// of opposite sides meet, its own prison's among them, is seen from outside where it must not be. One invocation a light.
layout(local_size_x = 64) in;

#include "shaders/include/linear.glsl"
#include "shaders/include/tree_params.glsl"
#include "shaders/include/svo_find.glsl"
#include "shaders/include/rank.glsl"
#include "shaders/include/leaf_block.glsl"
#include "shaders/include/lights.glsl"

layout(std140, binding = 0) uniform pass_block { uvec4 pass; }; // x: level of the leaf parents, y: capacity of the dynamic cells
layout(std430, binding = 1) readonly buffer leaves_block { uvec2 leaves[]; };
layout(std430, binding = 2) readonly buffer moving_block { uint moving[]; };
layout(std430, binding = 5) readonly buffer dynamic_block { uvec4 dynamic_cells[]; };
layout(std430, binding = 6) writeonly buffer open_block { float open[]; }; // of each light: 1 in the open, 0 shut in

const int RAYS = 6;           // of a map along an axis
const float MOST_BACKS = 0.8; // of what is seen: such a light is shut in; lamp shades are open above and below
const float FEW_BACKS = 0.5;
const float LEAST_BACKS = 0.25; // of all directions: what has two sides, as paper shades, is neither back nor front
const float CLEAR = 0.25;     // cosine from which on a normal says which side is seen

vec3 one_sided_normal(uint word) { return (word >> 31) != 0u ? vec3(0.0) : unpackSnorm4x8(word).xyz; }

// Normal of the leaf at a place; 0 where there is none or it has two sides.
vec3 normal_at(vec3 p_ws)
{
    for (uint c = 0u; c < tree.info.x; c++) {
        ivec3 cell = ivec3(floor((p_ws - tree.cascade[c].xyz) / tree.cascade[c].w));
        if (any(lessThan(cell, ivec3(0))) || any(greaterThanEqual(cell, ivec3(tree.info.y))))
            continue;
        uint code = cell_standing(c, cascade_first_bit(c) + morton_encode(cell_wrap(c, cell))), k = code & 7u;
        code >>= 3;
        uint number = find_node(pass.x, code);
        if (number == KD_EMPTY)
            return vec3(0.0);
        uint block = book[places.blocks.x + number], at = code >> 5, bits = pass.y != 0u ? moving[at] : 0u;
        vec3 sum = vec3(0.0);
        if (block_has(block, k)) {
            sum += one_sided_normal(leaves[block_slot(block, k)].y);
        }
        if ((bits >> (code & 31u) & 1u) != 0u) {
            uint rank = rank_below(moving[at + places.news.y], bits, code);
            if (rank < pass.y && (dynamic_cells[pass.y * 8u + (rank >> 2)][rank & 3u] >> k & 1u) != 0u) 
                sum += one_sided_normal(dynamic_cells[rank * 8u + k].y);
        }
        return sum;
    }
    return vec3(0.0);
}

// Backs and fronts that one map sees, by solid angle, and all that it looks at. What no surface stops counts as a front.
vec3 seen_by(int matrix, float layer, vec3 light_ws)
{
    mat4 m = kd_lights.shadow_matrix[matrix];
    shadow_axes axes = shadow_axes_of(matrix);
    vec3 right = axes.right / dot(axes.right, axes.right), up = axes.up / dot(axes.up, axes.up);
    float farthest = dot(vec3(m[0][2], m[1][2], m[2][2]), axes.forward), slope = shadow_depth_slope(matrix);
    int edge = int(kd_lights.count.w);
    vec3 seen = vec3(0.0);
    for (int i = 0; i < RAYS * RAYS; i++) {
        ivec2 texel = ivec2((2 * (i % RAYS) + 1) * edge, (2 * (i / RAYS) + 1) * edge) / (2 * RAYS);
        vec2 uv = (vec2(texel) + 0.5) / float(edge) - 0.5;
        vec3 ray = axes.forward + uv.x * right + uv.y * up;
        float held = texelFetch(shadow_spot, ivec3(texel, int(layer)), 0).r, length2 = dot(ray, ray);
        float angle = inversesqrt(length2 * length2 * length2);
        vec3 normal = held < 1.0 ? normal_at(light_ws + ray * (slope / max(farthest - held, 1e-9))) : vec3(0.0);
        float away = dot(normal, ray) * inversesqrt(length2);
        seen += angle * vec3(float(away > CLEAR), float(away < -CLEAR || held >= 1.0), 1.0);
    }
    return seen;
}

void main()
{
    uint i = linear_index();
    if (i >= light_count())
        return;
    vec4 shadow = kd_lights.light[i].shadow;
    vec3 seen = vec3(0.0);
    for (int k = 0; !light_is_directional(i) && int(shadow.x) >= 0 && k < int(shadow.y); k++)
        seen += seen_by(int(shadow.x) + k, shadow.z + float(k), kd_lights.light[i].position_ws.xyz);
    float backs = seen.x / max(seen.x + seen.y, 1e-9);
    open[i] = 1.0 - smoothstep(FEW_BACKS, MOST_BACKS, backs) * step(LEAST_BACKS * seen.z, seen.x);
}
