#ifndef KD_INCLUDE_LIGHTS_GLSL
#define KD_INCLUDE_LIGHTS_GLSL

/* The lights of this frame and their shadow maps. Resources "lights.uniform" (kd_lighting.view to
 * KD_BIND_VIEW, .lights to KD_BIND_LIGHTS) and "shadow.maps" (.shadow_directional and .shadow_spot to
 * KD_UNIT_SHADOW_*). */

#include "shaders/include/view.glsl"

layout(std140, binding = KD_BIND_LIGHTS) uniform kd_lights_block { kd_lights_params kd_lights; };
layout(binding = KD_UNIT_SHADOW_DIRECTIONAL) uniform sampler2DArray shadow_directional;
layout(binding = KD_UNIT_SHADOW_SPOT) uniform sampler2DArray shadow_spot;

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
    float per_metre; /* depth that a metre along the map's axis is there */
    int matrix;      /* -1: in no map */
};
const shadow_place SHADOW_NOWHERE = shadow_place(vec3(0.0), 0.0, 0.0, 0.0, 0.0, -1);

shadow_place shadow_place_directional(int first, int count, float layer, vec3 p_ws)
{
    shadow_place o = SHADOW_NOWHERE;
    float margin = 2.0 / float(kd_lights.count.z); /* so that the filter stays inside */
    for (int c = 0; c < count; c++) {
        vec3 uvz = (kd_lights.shadow_matrix[first + c] * vec4(p_ws, 1.0)).xyz;
        if (all(lessThan(abs(uvz.xy - 0.5), vec2(0.5 - margin)))) {
            vec2 scale = kd_lights.cascade_texel_ws[first + c].xy;
            o = shadow_place(uvz, layer + float(c), scale.x, 4.0 * ULP * scale.y, 0.5 / scale.y, first + c);
            break;
        }
    }
    return o;
}

float largest(vec3 p) { return max(abs(p.x), max(abs(p.y), abs(p.z))); }

/* The axes of a spot map as its matrix holds them: forward has unit length, and what lies ahead by w falls at
 * u = 0.5 + dot(right, ahead) / w. */
struct shadow_axes {
    vec3 right, up, forward;
};
shadow_axes shadow_axes_of(int matrix)
{
    mat4 m = kd_lights.shadow_matrix[matrix];
    vec3 forward = vec3(m[0][3], m[1][3], m[2][3]);
    return shadow_axes(vec3(m[0][0], m[1][0], m[2][0]) - 0.5 * forward,
                       vec3(m[0][1], m[1][1], m[2][1]) - 0.5 * forward, forward);
}

/* A spot's depth is a - b / w at the distance w ahead: b is the difference of the rows that give depth and
 * distance. */
float shadow_depth_slope(int matrix)
{
    mat4 m = kd_lights.shadow_matrix[matrix];
    vec3 forward = vec3(m[0][3], m[1][3], m[2][3]), row = vec3(m[0][2], m[1][2], m[2][2]);
    return max(dot(row, forward) * m[3][3] - m[3][2], 1e-20);
}

shadow_place shadow_place_perspective(int matrix, float layer, vec3 p_ws)
{
    vec4 h = kd_lights.shadow_matrix[matrix] * vec4(p_ws, 1.0);
    vec3 uvz = h.xyz / h.w, right = shadow_axes_of(matrix).right;
    if (!(h.w > 0.0 && all(lessThan(abs(uvz.xy - 0.5), vec2(0.5)))))
        return SHADOW_NOWHERE;
    float b = shadow_depth_slope(matrix);
    float step = h.w * min(2.0 * ULP * (h.w + 2.0 * largest(p_ws)) / b, 0.1);
    float texel = h.w * inversesqrt(dot(right, right)) / float(kd_lights.count.w);
    return shadow_place(uvz, layer, texel, step, b / (h.w * h.w), matrix);
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
        return SHADOW_NOWHERE;
    bool point = kd_lights.light[i].direction_ws.w == LIGHT_POINT;
    int face = point ? shadow_cube_face(p_ws - kd_lights.light[i].position_ws.xyz) : 0;
    return shadow_place_perspective(first + face, shadow.z + float(face), p_ws);
}

/* How far rounding may put a point below its surface [m]: that of its coordinates, and that of the camera's
 * depth it was made from, which is off along the view. */
float point_error(vec3 p_ws, vec3 n_ws)
{
    mat4 p = kd_view.projection;
    float z = dot(p_ws - kd_view.position_ws.xyz, kd_view.forward_ws.xyz);
    float depth_step = view_is_orthographic() ? 2.0 / abs(p[2][2]) : 2.0 * z * z / abs(p[3][2]);
    return ULP * (8.0 * largest(p_ws) + 12.0 * depth_step * abs(dot(n_ws, view_direction(p_ws))));
}

/* The plane of a surface as its map sees it, so that each texel is compared with the plane's depth at the
 * texel's own middle: a plane then shades itself nowhere, however light grazes it, and its shadows begin where
 * they should. */
struct shadow_plane {
    float depth;   /* at the point, less what rounding may be */
    vec2 slope;    /* depth a texel */
    float leeway;  /* depth a texel of distance by which a texel may lie nearer to the light */
};

/* Where two walls meet, texels near a point of one hold the other, which comes towards the light by up to twice
 * as much as it goes aside unless light grazes it. */
const float SHADOW_LEEWAY = 3.0;
/* How far rounding may move a point in its map [texels]. */
const float SHADOW_SLOPE_ERROR = 0.02;

shadow_plane shadow_plane_of(shadow_place place, vec2 slope, float cosine, vec3 p_ws, vec3 n_ws)
{
    float error = place.step_ws + point_error(p_ws, n_ws) / max(cosine, 0.01);
    float turned = SHADOW_SLOPE_ERROR * (abs(slope.x) + abs(slope.y));
    return shadow_plane(place.uvz.z - place.per_metre * error - turned, slope,
                        SHADOW_LEEWAY * place.texel_ws * place.per_metre);
}

shadow_plane shadow_plane_directional(shadow_place place, vec3 p_ws, vec3 n_ws, vec3 axis_ws)
{
    mat4 m = kd_lights.shadow_matrix[place.matrix];
    float scale = place.texel_ws * float(kd_lights.count.z); /* metres that the map is wide */
    vec2 across = scale * vec2(dot(n_ws, vec3(m[0][0], m[1][0], m[2][0])), dot(n_ws, vec3(m[0][1], m[1][1], m[2][1])));
    float along = dot(n_ws, axis_ws); /* below 0: it faces the light */
    vec2 slope = place.texel_ws * place.per_metre * across / max(-along, 0.005);
    return shadow_plane_of(place, slope, -along, p_ws, n_ws);
}

/* n.x = k from the light, and x = w * ((u - 0.5) right / |right|^2 + … + forward): 1 / w, and with it depth, is
 * linear in u and v. */
shadow_plane shadow_plane_perspective(shadow_place place, vec3 p_ws, vec3 n_ws, vec3 light_ws)
{
    shadow_axes axes = shadow_axes_of(place.matrix);
    vec3 d = p_ws - light_ws;
    float away = length(d), k = min(dot(n_ws, d), -0.005 * away);
    vec2 across = vec2(dot(n_ws, axes.right), dot(n_ws, axes.up)) / dot(axes.right, axes.right);
    vec2 slope = -shadow_depth_slope(place.matrix) / k * across / float(kd_lights.count.w);
    return shadow_plane_of(place, slope, -k / away, p_ws, n_ws);
}

/* Which of the four texels at `offset` from the point (in texels, one to the right and one above besides) let
 * light pass; in the order of textureGather: above, above right, right, the texel itself. */
vec4 shadow_open(vec4 held, vec2 offset, shadow_plane plane)
{
    vec4 x = offset.x + vec4(0.0, 1.0, 1.0, 0.0), y = offset.y + vec4(1.0, 1.0, 0.0, 0.0);
    vec4 depth = plane.depth + plane.slope.x * x + plane.slope.y * y - plane.leeway * max(abs(x), abs(y));
    return step(min(depth, 1.0), held);
}

/* Bilinear over the four texels round the point. */
float shadow_filter(sampler2DArray maps, shadow_place place, shadow_plane plane, float edge)
{
    vec2 at = place.uvz.xy * edge - 0.5, base = floor(at), f = at - base;
    vec4 open = shadow_open(textureGather(maps, vec3((base + 1.0) / edge, place.layer)), -f, plane);
    return dot(open, vec4(1.0 - f.x, f.x, f.x, 1.0 - f.x) * vec4(f.y, f.y, 1.0 - f.y, 1.0 - f.y));
}

/* light_shadow for one kind of light: loops that know the kind are cheaper on drivers that run both sides of
 * a branch. n is the triangle's own normal. */
float light_shadow_directional(uint i, vec3 p_ws, vec3 n_ws)
{
    shadow_place place = shadow_find_directional(i, p_ws);
    vec3 axis_ws = kd_lights.light[i].direction_ws.xyz;
    if (place.matrix < 0 || dot(n_ws, axis_ws) >= 0.0)
        return place.matrix < 0 ? 1.0 : 0.0;
    return shadow_filter(shadow_directional, place, shadow_plane_directional(place, p_ws, n_ws, axis_ws),
                         float(kd_lights.count.z));
}

float light_shadow_local(uint i, vec3 p_ws, vec3 n_ws)
{
    shadow_place place = shadow_find_local(i, p_ws);
    vec3 light_ws = kd_lights.light[i].position_ws.xyz;
    if (place.matrix < 0 || dot(n_ws, light_ws - p_ws) <= 0.0)
        return place.matrix < 0 ? 1.0 : 0.0;
    return shadow_filter(shadow_spot, place, shadow_plane_perspective(place, p_ws, n_ws, light_ws),
                         float(kd_lights.count.w));
}

/* Share of the light that reaches p, 0 … 1. Outside every map: lit. */
float light_shadow(uint i, vec3 p_ws, vec3 n_ws)
{
    if (light_is_directional(i))
        return light_shadow_directional(i, p_ws, n_ws);
    return light_shadow_local(i, p_ws, n_ws);
}

/* The same depth for four texels round a place, bilinear. */
float shadow_filter_small(sampler2DArray maps, shadow_place place, float edge)
{
    vec2 at = place.uvz.xy * edge - 0.5, base = floor(at), f = at - base;
    vec4 open = step(vec4(clamp(place.uvz.z, 0.0, 1.0)), textureGather(maps, vec3((base + 1.0) / edge, place.layer)));
    return dot(open, vec4(1.0 - f.x, f.x, f.x, 1.0 - f.x) * vec4(f.y, f.y, 1.0 - f.y, 1.0 - f.y));
}

float shadow_lifted(sampler2DArray maps, shadow_place place, float edge)
{
    place.uvz.z -= place.texel_ws * place.per_metre;
    return place.matrix < 0 ? 1.0 : shadow_filter_small(maps, place, edge);
}

/* The same for a voxel, whose surface has no plane: p is lifted along the normal by the caller, and its depth by
 * a texel towards the light. */
float light_shadow_voxel_directional(uint i, vec3 p_ws)
{
    return shadow_lifted(shadow_directional, shadow_find_directional(i, p_ws), float(kd_lights.count.z));
}
float light_shadow_voxel_local(uint i, vec3 p_ws)
{
    return shadow_lifted(shadow_spot, shadow_find_local(i, p_ws), float(kd_lights.count.w));
}

#endif
