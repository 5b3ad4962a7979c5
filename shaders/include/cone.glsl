// Tracing one cone through the octree, front to back, as emission and absorption: over a step of length s through matter of
// optical depth d per metre and radiance S what is open of it, T, becomes T' (open_after in tree_node.glsl), and the light gained
// is (T - T') S.
//
// Programs may be compiled for other forms of sampling: KD_CONES_QUADRILINEAR interpolates between levels too, KD_CONES_PAPER
// takes the sample before for the other level; shaders/cone_trace/march.glsl has what else it means.

#include "shaders/include/tree.glsl"

#if !defined(KD_CONES_QUADRILINEAR) && !defined(KD_CONES_PAPER)
#define KD_CONES_TRILINEAR
#endif

// Cells are half as large as the cone is wide, since linear interpolation makes every cell reach over two edge lengths. With
// steps of half a diameter a sample then falls on every cell length, and the interpolated depths of a wall add up exactly.
const float CONE_SHARPNESS = 1.0;

// Near its start a cone covers all directions that it stands for; from this width on, in voxels, it grows like a narrower
// one. A wide cone's cells reach far beyond its edge, where they close gaps that light comes through, and a point's neighbours
// look into the directions between.
const float CONE_NEAR_WIDTH = 4.0;

// A cone is closed by this share of a wall's depth: what is found of a wall depends on where samples fall, as little as 0.84 where
// steps are 1.4 cells. A smaller share loses less light through walls, and closes more of what is half open.
const float CONE_WALL = 0.92;

// Cells of so many voxels and more are as large as rooms, whose walls cover them in part: light of a closed room would go out between
// them. The first sample of such a level stands for more of the way, in cells, than its step.
const int CONE_ROOM_LOD = 7;

// What a cone of which less than CONE_CLOSED is open has met is taken for all of it: it ends in the wall that it came to, and does
// not look for the rest in what lies behind. Leaves and the finest dense cells are denser: they reach over a voxel or two, so the
// place of a wall is known well enough, and a wall that a cone starts beside has less of its depth in front of it.
//
// `light.leak=strict`: matter is many times as dense, and a cone goes on until it would add nothing that is seen.
#ifdef KD_LEAK_STRICT
const float CONE_LEAST = 0.0001, CONE_DENSITY = 18.0 / FULL_DEPTH, CONE_NEAR_DENSITY = 1.0;
const float CONE_CLOSED = 0.0, CONE_AHEAD = 0.0, CONE_OVERLAP = 0.0;
#else
const float CONE_LEAST = 0.01, CONE_DENSITY = 1.0, CONE_NEAR_DENSITY = 2.0;
const float CONE_CLOSED = 0.05, CONE_AHEAD = 1.0, CONE_OVERLAP = 1.0;
#endif

// Narrow cones have far to go: longer steps, which find less of a wall, so matter is denser; denser still, and panels thinner than
// a voxel would take the light of what they carry.
const float CONE_NARROW_STEP = 1.6, CONE_NARROW_DENSITY = 1.1;

#ifdef KD_CONES_PAPER
const int CONE_MOST_SAMPLES = 4096; // those of all cones
#else
const int CONE_MOST_SAMPLES = 256;
#endif

struct cone_settings {
    float step;         // in diameters
    float max_distance; // m
    float falloff;      // of occlusion with distance, 1/m
    float least;        // least diameter, in voxels
    float far;          // width of the far part of the cone, of its opening; 1: a plain cone
    float closed;       // transmittance below which nothing gets through
    float density;      // of matter: steps longer than cells find less of a wall
};

struct cone_result {
    vec3 radiance;
    float transmittance;
    float occlusion;    // weighted by 1 / (1 + falloff t)
    int samples, lod;   // lod: of the last sample
    vec3 shown;         // radiance of what the last sample met,
    float gained;       // and how much of the cone that closed
#ifdef KD_CONES_PAPER
    vec4 before; // the last sample
#endif
};

cone_result cone_begin()
{
    cone_result r;
    r.radiance = vec3(0.0);
    r.transmittance = 1.0;
    r.occlusion = 0.0;
    r.samples = 0;
    r.lod = -1;
    r.shown = vec3(0.0);
    r.gained = 0.0;
#ifdef KD_CONES_PAPER
    r.before = vec4(0.0);
#endif
    return r;
}

// Where the next sample of a cone lies.
struct cone_place {
    vec3 p_ws;
    float diameter, stride;
    int cascade, lod;
    bool goes_on, sparse; // sparse: below the dense levels
#ifndef KD_CONES_TRILINEAR
    float level; // that the diameter asks for, between whole ones
#endif
};

cone_place cone_place_at(float t, cone_result so_far, vec3 origin_ws, vec3 direction, float tan_half, cone_settings settings)
{
    cone_place o;
    float span = tree.cascade[0].w, wide = 2.0 * tan_half * t;
    o.p_ws = origin_ws + direction * t;
    o.cascade = tree_cascade_at(o.p_ws, 0.5);
    o.goes_on = o.cascade < tree_cascades() && t <= settings.max_distance && so_far.transmittance >= CONE_LEAST && so_far.samples < CONE_MOST_SAMPLES;
    float own_span = span * float(1 << o.cascade), narrowed = max(min(wide, CONE_NEAR_WIDTH * own_span), settings.far * wide);
    o.diameter = max(narrowed, settings.least * own_span);
    o.stride = settings.step * o.diameter * (wide > CONE_NEAR_WIDTH * own_span && settings.far < 1.0 ? 1.6 : 1.0);
#ifdef KD_CONES_TRILINEAR
    o.lod = max(int(floor(log2(o.diameter / span) - CONE_SHARPNESS + 0.5)), tree_finest(o.cascade));
#else
    o.level = max(log2(o.diameter / span) - CONE_SHARPNESS, float(tree_finest(o.cascade)));
#ifdef KD_CONES_QUADRILINEAR
    o.lod = int(floor(o.level)); // and the level above
#else
    o.lod = int(floor(o.level + 0.5));
#endif
#endif
    o.sparse = tree_is_sparse(o.cascade, o.lod);
    return o;
}

// The sample at a place joined with another level, as the form of sampling has it. v: what its own level gave.
#if defined(KD_CONES_QUADRILINEAR)
// Between two levels, trilinear in both: 16 cells (brute force).
vec4 cone_join_levels(inout cone_result r, cone_place at, vec3 facing, vec4 v)
{
    float share = at.level - float(at.lod);
    if (share <= 0.0)
        return v;
    int above = at.lod + 1;
    vec4 coarse = tree_is_sparse(at.cascade, above) ? tree_sample_sparse(at.cascade, above, at.p_ws, facing)
                                                    : tree_sample_wide(at.cascade, above, at.p_ws, facing);
    return mix(v, coarse, share);
}
#elif defined(KD_CONES_PAPER)
// A level that is new stands between itself and the one below, of which the sample before this one was taken (Yalciner 2016,
// section 4.1).
vec4 cone_join_levels(inout cone_result r, cone_place at, vec3 facing, vec4 v)
{
    float share = r.lod >= 0 && r.lod < at.lod ? clamp(float(at.lod) - at.level, 0.0, 0.5) : 0.0;
    vec4 both = mix(v, r.before, share);
    r.before = v;
    r.lod = at.lod;
    return both;
}
#else
vec4 cone_join_levels(inout cone_result r, cone_place at, vec3 facing, vec4 v) { return v; }
#endif

vec4 cone_sample_sparse(inout cone_result r, cone_place at, vec3 facing)
{
    return CONE_NEAR_DENSITY * cone_join_levels(r, at, facing, tree_sample_sparse(at.cascade, at.lod, at.p_ws, facing));
}

vec4 cone_sample_wide(inout cone_result r, cone_place at, vec3 facing)
{
    vec4 v = cone_join_levels(r, at, facing, tree_sample_wide(at.cascade, at.lod, at.p_ws, facing));
    return at.lod > at.cascade + KD_SPARSE_LEVELS ? v : CONE_NEAR_DENSITY * v;
}

// What is open of a cone after what a sample stands for, s long.
float cone_open_after(float open, vec4 v, float s)
{
#ifdef KD_LEAK_STRICT
    return open * exp(-v.a * (s * CONE_DENSITY));
#else
    return open_after(open, v.a * (s * CONE_DENSITY), depth_residue(CONE_WALL * FULL_DEPTH));
#endif
}

// Depth of a step below which a sample is not asked for its light: what it closes is an error of rounding there, and light and
// depth are filtered on their own, so that their quotient may be any number. Light that bounces would grow without end by that.
const float CONE_LEAST_DEPTH = 1e-5;

// How much of its way a sample stands for.
float cone_stands_for(cone_result r, cone_place at)
{
    bool new_room = at.lod >= CONE_ROOM_LOD && at.lod > r.lod;
    return at.stride + (new_room ? CONE_OVERLAP * tree.cascade[0].w * exp2(float(at.lod)) : 0.0);
}

// v: what the sample at t gave.
//
// Interpolated matter begins half a cell in front of itself, and a ray that comes aslant would see a place too near by as much: so
// what a sample closed shows the radiance that the next one meets, as far as that closes as much.
void cone_step(inout cone_result r, inout float t, vec4 v, cone_place at, cone_settings settings)
{
    float s = cone_stands_for(r, at), open = cone_open_after(r.transmittance, v, s * settings.density), gained = r.transmittance - open;
    vec3 shown = v.a * s > CONE_LEAST_DEPTH ? v.rgb / v.a : r.shown;
    r.radiance += gained * shown + CONE_AHEAD * min(gained, r.gained) * (shown - r.shown);
    r.occlusion += gained / (1.0 + settings.falloff * t);
    r.shown = shown;
    r.gained = gained;
    float whole = open < settings.closed ? 1.0 / (1.0 - open) : 1.0;
    r.radiance *= whole;
    r.occlusion *= whole;
    r.transmittance = open < settings.closed ? 0.0 : open;
    r.lod = at.lod;
    r.samples++;
    t += at.stride;
}

// The sequence of distances depends on the aperture and the start alone, so all pixels of a surface change levels at the
// same steps, and no interpolation between levels is needed to keep it free of bands; inside a level it is linear.
//
// `facing` is the direction of which it is asked what side of matter is met: the axis for a narrow cone, another of its rays
// for a wide one.
//
// Software drivers run both sides of a branch, and what follows a `break` once more: so sparse and dense samples have loops
// of their own, which end at their ends.
cone_result cone_trace(vec3 origin_ws, vec3 direction, vec3 facing, float tan_half, float start, cone_settings settings)
{
    cone_result r = cone_begin();
    float t = start;
    cone_place at = cone_place_at(t, r, origin_ws, direction, tan_half, settings);
    do {
        do {
            if (at.goes_on && at.sparse) {
                cone_step(r, t, cone_sample_sparse(r, at, facing), at, settings);
                at = cone_place_at(t, r, origin_ws, direction, tan_half, settings);
            }
        } while (at.goes_on && at.sparse);
        do {
            if (at.goes_on && !at.sparse) {
                cone_step(r, t, cone_sample_wide(r, at, facing), at, settings);
                at = cone_place_at(t, r, origin_ws, direction, tan_half, settings);
            }
        } while (at.goes_on && !at.sparse);
    } while (at.goes_on);
    return r;
}

// What lies near the start of a cone: depths of dense cells round the place that its samples below them go by.
struct cone_near {
    vec3 forth, back; // for rays towards +x +y +z, and the other way
    float end;        // distance from which on samples are those of dense cells
};

// Of cones round a normal from one place.
cone_near cone_near_of(vec3 origin_ws, vec3 normal, float tan_half, float start, cone_settings settings)
{
    cone_result none = cone_begin();
    cone_near o = cone_near(vec3(1.0), vec3(1.0), start);
    cone_place at = cone_place_at(o.end, none, origin_ws, normal, tan_half, settings);
#ifdef KD_CONES_TRILINEAR
    int k = min(at.cascade, tree_cascades() - 1);
    ivec2 dense = tree_dense_of(k + KD_SPARSE_LEVELS);
    tree_texel t = tree_texel_at(dense.x, dense.y, origin_ws + normal * (0.9 * float(1 << KD_SPARSE_LEVELS) * tree.cascade[k].w));
    o.forth = tree_texel_depths(t, 0.0);
    o.back = tree_texel_depths(t, 1.0);
    do {
        if (at.goes_on && at.sparse) {
            o.end += at.stride;
            at = cone_place_at(o.end, none, origin_ws, normal, tan_half, settings);
        }
    } while (at.goes_on && at.sparse);
#endif
    return o;
}

// Where a cone has to begin: behind what is near when that is nothing in all axes of its ray.
float cone_start(cone_near near, vec3 facing, float start)
{
    vec3 met = mix(near.forth, near.back, lessThan(facing, vec3(0.0))) * abs(facing);
    return met.x + met.y + met.z > 0.0 ? start : near.end;
}

// The same of a cone that is not asked for detail below the dense cells: without the loop for it where leaves lie right below.
cone_result cone_trace_wide(vec3 origin_ws, vec3 direction, vec3 facing, float tan_half, float start, cone_settings settings)
{
#if KD_SPARSE_LEVELS == 1
    cone_result r = cone_begin();
    float t = start;
    cone_place at = cone_place_at(t, r, origin_ws, direction, tan_half, settings);
    do {
        if (at.goes_on) {
            at.lod = max(at.lod, at.cascade + KD_SPARSE_LEVELS);
            cone_step(r, t, cone_sample_wide(r, at, facing), at, settings);
            at = cone_place_at(t, r, origin_ws, direction, tan_half, settings);
        }
    } while (at.goes_on);
    return r;
#else
    return cone_trace(origin_ws, direction, facing, tan_half, start, settings);
#endif
}
