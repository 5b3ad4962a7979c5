/* The surface under a pixel, from what geometry.vert hands on and the material. */

#include "shaders/include/material.glsl"
#include "shaders/include/brdf.glsl"

in vec3 from_eye; /* world space, from the camera: precise where triangles are small in the picture */
in vec3 normal_ws;
in vec4 tangent_ws;
in vec4 uv;
in vec4 color;
flat in uint object_flags; /* KD_OBJECT_* */

/* Normal map into world space. The tangent is made orthogonal again: interpolation and shear bend it. */
vec3 shading_normal(vec3 n)
{
#if (MATERIAL_MAPS & 4)
    vec3 t = tangent_ws.xyz - n * dot(n, tangent_ws.xyz);
    float length2 = dot(t, t);
    if (length2 < 1e-12)
        return n;
    t *= inversesqrt(length2);
    vec3 m = material_normal(uv);
    return normalize(t * m.x + cross(n, t) * (tangent_ws.w * m.y) + n * max(m.z, 1e-3));
#else
    return n;
#endif
}

/* The triangle's own normal, to the side of the interpolated one. */
vec3 face_normal(vec3 n)
{
    vec3 face = cross(dFdx(from_eye), dFdy(from_eye));
    float length2 = dot(face, face);
    if (!(length2 > 0.0))
        return n;
    face *= inversesqrt(length2);
    return dot(face, n) < 0.0 ? -face : face;
}

/* `base`: colour and opacity, material_base_color(uv, color). Position and depth are the caller's. */
surface fragment_surface(vec4 base)
{
    float side = gl_FrontFacing == ((object_flags & KD_OBJECT_MIRRORED) != 0u) ? -1.0 : 1.0; /* seen from behind: turn to the viewer */
    vec3 n = normalize(normal_ws);
    vec2 metallic_roughness = material_surface(uv);
    surface s;
    s.unlit = kd_material.surface.w > 0.5;
    s.face_normal_ws = face_normal(n) * side;
    s.normal_ws = shading_normal(n) * side;
    s.albedo = s.unlit ? vec3(0.0) : base.rgb;
    s.metallic = metallic_roughness.x;
    s.roughness = metallic_roughness.y;
    s.emissive = s.unlit ? base.rgb : material_emissive(uv);
    s.occlusion = material_occlusion(uv);
#ifdef LAYERED
    s.f0 = kd_material.specular.rgb;
    s.f90 = kd_material.specular.a;
    s.coat = kd_material.lobes.x;
    s.coat_roughness = kd_material.lobes.y;
    s.transmission = kd_material.lobes.z;
    s.traced_roughness = s.coat > 0.0 ? min(s.coat_roughness, s.roughness) : s.roughness;
    if (!s.unlit)
        s.emissive *= 1.0 - brdf_coat(s, clamp(-dot(s.normal_ws, normalize(from_eye)), 0.0, 1.0));
#endif
    return s;
}
