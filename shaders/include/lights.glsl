#ifndef KD_INCLUDE_LIGHTS_GLSL
#define KD_INCLUDE_LIGHTS_GLSL

/* The lights of this frame and their shadow maps. Resources "lights.uniform" (kd_lighting.view to
 * KD_BIND_VIEW, .lights to KD_BIND_LIGHTS) and "shadow.maps" (.shadow_directional and .shadow_spot to
 * KD_UNIT_SHADOW_*). */

#include "shaders/include/view.glsl"

layout(std140, binding = KD_BIND_LIGHTS) uniform kd_lights_block { kd_lights_params kd_lights; };
layout(binding = KD_UNIT_SHADOW_DIRECTIONAL) uniform sampler2DArrayShadow shadow_directional;
layout(binding = KD_UNIT_SHADOW_SPOT) uniform sampler2DArrayShadow shadow_spot;

const float LIGHT_DIRECTIONAL = 0.0;
const float LIGHT_POINT = 1.0;
const float LIGHT_SPOT = 2.0;
const float ULP = 1.0 / 16777216.0; /* of numbers next to 1, depths among them */

uint light_count() { return kd_lights.count.x; }
/* Directional lights come first. */
uint light_directional_count() { return uint(kd_lights.kinds.x); }
bool light_is_directional(uint i) { return i < light_directional_count(); }

float light_range_window(float d2, float range)
{
    float r = d2 / (range * range);
    return range > 0.0 ? clamp(1.0 - r * r, 0.0, 1.0) : 1.0;
}

/* Irradiance on a surface at p that faces the light [W/m^2], without shadow; `to_light` has unit length.
 * Source  KHR_lights_punctual: inverse square, range window, spot falloff */
vec3 light_sample(uint i, vec3 p_ws, out vec3 to_light)
{
    vec4 direction = kd_lights.light[i].direction_ws;
    vec4 color = kd_lights.light[i].color;
    if (direction.w == LIGHT_DIRECTIONAL) {
        to_light = -direction.xyz;
        return color.rgb;
    }
    vec4 position = kd_lights.light[i].position_ws;
    vec3 d = position.xyz - p_ws;
    float d2 = max(dot(d, d), kd_lights.kinds.y);
    to_light = d * inversesqrt(d2);
    float e = light_range_window(d2, position.w) / d2;
    if (direction.w == LIGHT_SPOT) {
        float cone = clamp(-dot(direction.xyz, to_light) * color.w + kd_lights.light[i].shadow.w, 0.0, 1.0);
        e *= cone * cone;
    }
    return color.rgb * e;
}

/* Where a point falls in the light's shadow maps. */
struct shadow_place {
    vec3 uvz;        /* 0 … 1 */
    float layer;
    float texel_ws;  /* edge of a texel at the point [m] */
    float step_ws;   /* what rounding may take off the map's depth at the point [m] */
    int matrix;      /* -1: in no map */
};

shadow_place shadow_place_directional(int first, int count, float layer, vec3 p_ws)
{
    shadow_place o = shadow_place(vec3(0.0), 0.0, 0.0, 0.0, -1);
    float margin = 2.0 / float(kd_lights.count.z); /* so that the filter and the bias stay inside */
    for (int c = 0; c < count; c++) {
        vec3 uvz = (kd_lights.shadow_matrix[first + c] * vec4(p_ws, 1.0)).xyz;
        if (all(lessThan(abs(uvz.xy - 0.5), vec2(0.5 - margin)))) {
            vec2 scale = kd_lights.cascade_texel_ws[first + c].xy;
            o = shadow_place(uvz, layer + float(c), scale.x, 4.0 * ULP * scale.y, first + c);
            break;
        }
    }
    return o;
}

float largest(vec3 p) { return max(abs(p.x), max(abs(p.y), abs(p.z))); }

/* Rounding of a spot's depth [m] at p, the distance d ahead: depth is a - b / d, and b the difference of the
 * rows that give depth and distance. */
float shadow_step_perspective(int matrix, vec3 p_ws, float d)
{
    mat4 m = kd_lights.shadow_matrix[matrix];
    vec3 forward = vec3(m[0][3], m[1][3], m[2][3]), row = vec3(m[0][2], m[1][2], m[2][2]);
    float b = dot(row, forward) * m[3][3] - m[3][2];
    return d * min(2.0 * ULP * (d + 2.0 * largest(p_ws)) / max(b, 1e-20), 0.1);
}

/* Edge of a texel [m] one metre in front of a spot map: the first row of bias * projection * view has the
 * length 0.5 / tan(half angle) once the bias' share of w is taken off. */
float shadow_texel_per_metre(int matrix)
{
    mat4 m = kd_lights.shadow_matrix[matrix];
    vec3 row = vec3(m[0][0], m[1][0], m[2][0]) - 0.5 * vec3(m[0][3], m[1][3], m[2][3]);
    return inversesqrt(dot(row, row)) / float(kd_lights.count.w);
}

shadow_place shadow_place_perspective(int matrix, float layer, vec3 p_ws)
{
    vec4 h = kd_lights.shadow_matrix[matrix] * vec4(p_ws, 1.0);
    vec3 uvz = h.xyz / h.w;
    bool inside = h.w > 0.0 && all(lessThan(abs(uvz.xy - 0.5), vec2(0.5)));
    return shadow_place(uvz, layer, h.w * shadow_texel_per_metre(matrix),
                        shadow_step_perspective(matrix, p_ws, h.w), inside ? matrix : -1);
}

/* The face of a cube, in GL's order, into which a direction points. */
int shadow_cube_face(vec3 d)
{
    vec3 a = abs(d);
    if (a.x >= a.y && a.x >= a.z)
        return d.x >= 0.0 ? 0 : 1;
    if (a.y >= a.z)
        return d.y >= 0.0 ? 2 : 3;
    return d.z >= 0.0 ? 4 : 5;
}

shadow_place shadow_find_directional(uint i, vec3 p_ws)
{
    vec4 shadow = kd_lights.light[i].shadow;
    int first = int(shadow.x);
    return shadow_place_directional(first, first < 0 ? 0 : int(shadow.y), shadow.z, p_ws);
}

shadow_place shadow_find_local(uint i, vec3 p_ws)
{
    vec4 shadow = kd_lights.light[i].shadow;
    int first = int(shadow.x);
    if (first < 0)
        return shadow_place(vec3(0.0), 0.0, 0.0, 0.0, -1);
    bool point = kd_lights.light[i].direction_ws.w == LIGHT_POINT;
    int face = point ? shadow_cube_face(p_ws - kd_lights.light[i].position_ws.xyz) : 0;
    return shadow_place_perspective(first + face, shadow.z + float(face), p_ws);
}

/* The place after the point has moved: same map, no new choice, so that a border cannot flip it. */
vec3 shadow_project(shadow_place place, vec3 p_ws)
{
    vec4 h = kd_lights.shadow_matrix[place.matrix] * vec4(p_ws, 1.0);
    return vec3(h.xy / h.w, clamp(h.z / h.w, 0.0, 1.0));
}

/* How far rounding may put a point below its surface [m]: that of its coordinates, and that of the camera's
 * depth it was made from, which is off along the view. */
float point_error(vec3 p_ws, vec3 n_ws)
{
    mat4 p = kd_view.projection;
    float z = dot(p_ws - kd_view.position_ws.xyz, kd_view.forward_ws.xyz);
    float depth_step = view_is_orthographic() ? 2.0 / abs(p[2][2]) : 2.0 * z * z / abs(p[3][2]);
    return ULP * (8.0 * largest(p_ws) + 3.0 * depth_step * abs(dot(n_ws, view_direction(p_ws))));
}

/* Lifts p off its surface so that the filter's texels do not shadow it. Four bilinear taps half a texel off
 * the middle reach texels up to 1.5 away on each axis, 2.1 on the diagonal. A point that far from p, at the
 * same depth in the map, lies under the surface by 2.1 * texel * sin(t) at most, t between the normal and
 * the map's axis: lifting by as much clears it. The constant part covers curvature; what rounding may have
 * done to the point and to the map comes on top. Where two walls meet, the texels reach the other wall too:
 * the filter's reach towards the light clears that one, whatever its normal, unless light grazes it. */
vec3 shadow_lift(vec3 p_ws, vec3 n_ws, vec3 axis_ws, vec3 to_light, shadow_place place)
{
    float cos_t = dot(n_ws, axis_ws);
    float lift = place.texel_ws * (0.3 + 2.1 * sqrt(max(1.0 - cos_t * cos_t, 0.0)));
    lift += place.step_ws + point_error(p_ws, n_ws);
    return p_ws + n_ws * lift + to_light * (2.1 * place.texel_ws);
}

/* The tent-weighted 3x3 filter by four bilinear taps. */
float shadow_filter(sampler2DArrayShadow maps, vec3 uvz, float layer, float edge)
{
    float h = 0.5 / edge;
    return 0.25 * (texture(maps, vec4(uvz.xy + vec2(-h, -h), layer, uvz.z)) +
                   texture(maps, vec4(uvz.xy + vec2(h, -h), layer, uvz.z)) +
                   texture(maps, vec4(uvz.xy + vec2(-h, h), layer, uvz.z)) +
                   texture(maps, vec4(uvz.xy + vec2(h, h), layer, uvz.z)));
}

/* light_shadow for one kind of light: loops that know the kind are cheaper on drivers that run both sides of
 * a branch. */
float light_shadow_directional(uint i, vec3 p_ws, vec3 n_ws)
{
    shadow_place place = shadow_find_directional(i, p_ws);
    vec3 axis_ws = kd_lights.light[i].direction_ws.xyz;
    if (place.matrix < 0 || dot(n_ws, axis_ws) >= 0.0)
        return place.matrix < 0 ? 1.0 : 0.0;
    vec3 uvz = shadow_project(place, shadow_lift(p_ws, n_ws, axis_ws, -axis_ws, place));
    return shadow_filter(shadow_directional, uvz, place.layer, float(kd_lights.count.z));
}

float light_shadow_local(uint i, vec3 p_ws, vec3 n_ws)
{
    shadow_place place = shadow_find_local(i, p_ws);
    vec3 to_light = normalize(kd_lights.light[i].position_ws.xyz - p_ws);
    if (place.matrix < 0 || dot(n_ws, to_light) <= 0.0)
        return place.matrix < 0 ? 1.0 : 0.0;
    mat4 m = kd_lights.shadow_matrix[place.matrix];
    vec3 axis_ws = vec3(m[0][3], m[1][3], m[2][3]); /* the row that gives w is the map's forward axis */
    vec3 uvz = shadow_project(place, shadow_lift(p_ws, n_ws, axis_ws, to_light, place));
    return shadow_filter(shadow_spot, uvz, place.layer, float(kd_lights.count.w));
}

/* Share of the light that reaches p, 0 … 1; n is the mesh's own normal. Outside every map: lit. */
float light_shadow(uint i, vec3 p_ws, vec3 n_ws)
{
    if (light_is_directional(i))
        return light_shadow_directional(i, p_ws, n_ws);
    return light_shadow_local(i, p_ws, n_ws);
}

/* The same for a voxel: one bilinear tap, the point lifted by offset_m along the normal (its own half
 * diagonal, say) and by a texel towards the light. */
float light_shadow_voxel(uint i, vec3 p_ws, vec3 n_ws, float offset_m)
{
    vec3 p = p_ws + n_ws * offset_m;
    if (light_is_directional(i)) {
        shadow_place place = shadow_find_directional(i, p);
        if (place.matrix < 0)
            return 1.0;
        vec3 uvz = shadow_project(place, p - kd_lights.light[i].direction_ws.xyz * place.texel_ws);
        return texture(shadow_directional, vec4(uvz.xy, place.layer, uvz.z));
    }
    shadow_place place = shadow_find_local(i, p);
    if (place.matrix < 0)
        return 1.0;
    vec3 to_light = normalize(kd_lights.light[i].position_ws.xyz - p);
    vec3 uvz = shadow_project(place, p + to_light * place.texel_ws);
    return texture(shadow_spot, vec4(uvz.xy, place.layer, uvz.z));
}

#endif
