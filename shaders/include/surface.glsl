#ifndef KD_INCLUDE_SURFACE_GLSL
#define KD_INCLUDE_SURFACE_GLSL

/* A point of a visible surface, and how the G-buffer keeps it:
 *
 *   albedo    RGBA8    rgb: square root of the albedo, since dark tones need the steps; a: occlusion map
 *   normal    RGBA16UI xy: shading normal, zw: the triangle's own normal; octahedral, 16 bits each
 *   material  RGBA8    r: metallic, g: roughness, b: 1 when unlit, a: 1 where what is seen moves by itself
 *   emissive  RGBA16F  rgb: radiance, up to 65504; a: 0
 *   depth     32F      of the depth test; 1 where nothing was drawn
 *   layers    RGBA16UI with LAYERED only, two bytes a channel, the first one high: clear coat, its roughness;
 *                      square roots of f0 r, g; of f0 b, and f90; roughness, 0. Material g is then the
 *                      roughness of the sharpest reflection, the one that is traced
 *
 * Row 0 is the picture's bottom, as GL draws it; gl_FragCoord.xy, texelFetch and the GI targets agree. */

struct surface {
    vec3 position_ws;
    vec3 normal_ws;      /* normal map applied */
    vec3 face_normal_ws; /* of the triangle: for shadows and offsets */
    vec3 albedo;
    float metallic;
    float roughness;     /* perceptual, as in the file */
    vec3 emissive;       /* radiance */
    float occlusion;     /* of the material's map: 1 open */
    float depth;         /* 0 … 1 */
    bool hit;            /* false: background, nothing else is defined */
    bool unlit;          /* emissive holds the final colour */
#ifdef LAYERED
    vec3 f0;             /* what the dielectric reflects head-on */
    float f90;           /* at grazing view */
    float coat;          /* share under a clear coat */
    float coat_roughness;
    float transmission;  /* of blended surfaces alone */
    float traced_roughness; /* of the reflection that is gathered */
#endif
};

struct packed_surface {
    vec4 albedo;
    uvec4 normal;
    vec4 material;
    vec4 emissive;
#ifdef LAYERED
    uvec4 layers;
#endif
};

vec2 octahedral_sign(vec2 v) { return vec2(v.x >= 0.0 ? 1.0 : -1.0, v.y >= 0.0 ? 1.0 : -1.0); }

/* Unit vector to a point of the square 0 … 65535.
 * Source  Cigolle et al. 2014, A Survey of Efficient Representations for Independent Unit Vectors, 3 */
uvec2 octahedral_encode(vec3 n)
{
    vec2 p = n.xy / (abs(n.x) + abs(n.y) + abs(n.z));
    if (n.z < 0.0)
        p = (1.0 - abs(p.yx)) * octahedral_sign(p);
    return uvec2(clamp(p * 32767.0 + 32767.5, 0.0, 65534.5)); /* 32767 stands for 0: the axes are exact */
}

vec3 octahedral_decode(uvec2 e)
{
    vec2 p = (vec2(e) - 32767.0) / 32767.0;
    vec3 n = vec3(p, 1.0 - abs(p.x) - abs(p.y));
    if (n.z < 0.0)
        n.xy = (1.0 - abs(n.yx)) * octahedral_sign(n.xy);
    return normalize(n);
}

#ifdef LAYERED
uint byte_pair(float high, float low)
{
    return uint(clamp(high, 0.0, 1.0) * 255.0 + 0.5) << 8 | uint(clamp(low, 0.0, 1.0) * 255.0 + 0.5);
}
vec2 byte_split(uint pair) { return vec2(float(pair >> 8), float(pair & 255u)) / 255.0; }

uvec4 layers_pack(surface s)
{
    vec3 f0 = sqrt(s.f0);
    return uvec4(byte_pair(s.coat, s.coat_roughness), byte_pair(f0.r, f0.g), byte_pair(f0.b, s.f90), byte_pair(s.roughness, 0.0));
}

void layers_unpack(uvec4 layers, inout surface s)
{
    vec2 coat = byte_split(layers.x), f0 = byte_split(layers.y), f = byte_split(layers.z);
    s.coat = coat.x;
    s.coat_roughness = coat.y;
    s.f0 = vec3(f0, f.x) * vec3(f0, f.x);
    s.f90 = f.y;
    s.transmission = 0.0;
    s.traced_roughness = s.roughness;
    s.roughness = byte_split(layers.w).x;
}
#endif

packed_surface surface_pack(surface s)
{
    packed_surface o;
    o.albedo = vec4(sqrt(clamp(s.albedo, 0.0, 1.0)), s.occlusion);
    o.normal = uvec4(octahedral_encode(s.normal_ws), octahedral_encode(s.face_normal_ws));
    o.material = vec4(s.metallic, s.roughness, s.unlit ? 1.0 : 0.0, 0.0);
    o.emissive = vec4(clamp(s.emissive, 0.0, 65504.0), 0.0);
#ifdef LAYERED
    o.material.g = s.traced_roughness;
    o.layers = layers_pack(s);
#endif
    return o;
}

/* Position, depth and hit are the caller's. */
surface surface_unpack(packed_surface o)
{
    surface s;
    s.albedo = o.albedo.rgb * o.albedo.rgb;
    s.occlusion = o.albedo.a;
    s.normal_ws = octahedral_decode(o.normal.xy);
    s.face_normal_ws = octahedral_decode(o.normal.zw);
    s.metallic = o.material.r;
    s.roughness = o.material.g;
    s.unlit = o.material.b > 0.5;
    s.emissive = o.emissive.rgb;
#ifdef LAYERED
    layers_unpack(o.layers, s);
#endif
    return s;
}

#endif
