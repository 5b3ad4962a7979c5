/* The creature's shape: rounded parts joined by a polynomial smooth minimum (Quilez, "smooth minimum"). Each
 * part belongs to a joint, so that the same table gives the surface, the skin weights and most of the
 * colours. */

#include <string.h>

#include "samples/assets/walker.h"

/* clang-format off */
const joint_info walker_joints[WALKER_JOINTS] = {
    [ROOT] = {"root", -1, {0, 0, 0}},
    [HIPS] = {"hips", ROOT, {0, 0.36, -0.02}},
    [SPINE] = {"spine", HIPS, {0, 0.42, -0.02}},
    [BELLY] = {"belly", SPINE, {0, 0.42, 0.02}},
    [CHEST] = {"chest", SPINE, {0, 0.51, -0.01}},
    [NECK] = {"neck", CHEST, {0, 0.58, 0.0}},
    [HEAD] = {"head", NECK, {0, 0.66, 0.02}},
    [EAR_L] = {"ear_l", HEAD, {0.085, 0.80, -0.01}},
    [EAR_R] = {"ear_r", HEAD, {-0.085, 0.80, -0.01}},
    [ARM_L] = {"arm_l", CHEST, {0.105, 0.535, 0.02}},
    [HAND_L] = {"hand_l", ARM_L, {0.19, 0.455, 0.055}},
    [ARM_R] = {"arm_r", CHEST, {-0.105, 0.535, 0.02}},
    [HAND_R] = {"hand_r", ARM_R, {-0.19, 0.455, 0.055}},
    [THIGH_L] = {"thigh_l", HIPS, {0.085, 0.34, -0.015}},
    [SHIN_L] = {"shin_l", THIGH_L, {0.097, 0.20, 0.035}},
    [FOOT_L] = {"foot_l", SHIN_L, {0.097, 0.07, -0.015}},
    [THIGH_R] = {"thigh_r", HIPS, {-0.085, 0.34, -0.015}},
    [SHIN_R] = {"shin_r", THIGH_R, {-0.097, 0.20, 0.035}},
    [FOOT_R] = {"foot_r", SHIN_R, {-0.097, 0.07, -0.015}},
    [TAIL_1] = {"tail_1", HIPS, {0, 0.36, -0.11}},
    [TAIL_2] = {"tail_2", TAIL_1, {0, 0.29, -0.23}},
    [TAIL_3] = {"tail_3", TAIL_2, {0, 0.235, -0.35}},
    [TAIL_4] = {"tail_4", TAIL_3, {0, 0.225, -0.46}},
};

/* An ellipsoid (centre a, radii b) or a cone with round ends (from a with radius ra to b with radius rb).
 * `blend` is the width over which it melts into what comes before it. A part with a twin is mirrored in x. */
typedef struct body_part {
    walker_joint joint, twin; /* twin: the joint of the mirrored part, or ROOT */
    bool ellipsoid;
    vec3 a, b;
    double ra, rb, blend;
} body_part;

static const body_part parts[] = {
    {HIPS, ROOT, true, {0, 0.365, -0.035}, {0.135, 0.115, 0.13}, 0, 0, 0.05},
    {BELLY, ROOT, true, {0, 0.42, 0.02}, {0.150, 0.130, 0.135}, 0, 0, 0.06},
    {SPINE, ROOT, true, {0, 0.45, -0.03}, {0.125, 0.110, 0.105}, 0, 0, 0.05},
    {CHEST, ROOT, true, {0, 0.53, -0.005}, {0.112, 0.090, 0.100}, 0, 0, 0.06},
    {NECK, ROOT, false, {0, 0.57, 0.0}, {0, 0.66, 0.025}, 0.080, 0.078, 0.05},
    {HEAD, ROOT, true, {0, 0.735, 0.035}, {0.150, 0.122, 0.135}, 0, 0, 0.05},
    {HEAD, ROOT, true, {0, 0.695, 0.15}, {0.092, 0.062, 0.092}, 0, 0, 0.06},
    {EAR_L, EAR_R, false, {0.085, 0.80, -0.005}, {0.135, 0.895, -0.045}, 0.040, 0.016, 0.03},
    {ARM_L, ARM_R, false, {0.095, 0.54, 0.015}, {0.185, 0.46, 0.05}, 0.046, 0.034, 0.03},
    {HAND_L, HAND_R, false, {0.185, 0.46, 0.05}, {0.178, 0.415, 0.135}, 0.034, 0.038, 0.01},
    {THIGH_L, THIGH_R, false, {0.085, 0.34, -0.015}, {0.097, 0.20, 0.035}, 0.092, 0.062, 0.03},
    {SHIN_L, SHIN_R, false, {0.097, 0.20, 0.035}, {0.097, 0.07, -0.015}, 0.060, 0.048, 0.02},
    {FOOT_L, FOOT_R, true, {0.099, 0.040, 0.035}, {0.064, 0.048, 0.105}, 0, 0, 0.03},
    {TAIL_1, ROOT, false, {0, 0.36, -0.11}, {0, 0.29, -0.23}, 0.095, 0.072, 0.06},
    {TAIL_2, ROOT, false, {0, 0.29, -0.23}, {0, 0.235, -0.35}, 0.070, 0.052, 0.02},
    {TAIL_3, ROOT, false, {0, 0.235, -0.35}, {0, 0.225, -0.46}, 0.051, 0.036, 0.02},
    {TAIL_4, ROOT, false, {0, 0.225, -0.46}, {0, 0.285, -0.56}, 0.035, 0.015, 0.02},
    /* The crest: from the forehead down the back to the tail. */
    {HEAD, ROOT, false, {0, 0.83, 0.02}, {0, 0.895, -0.03}, 0.030, 0.014, 0.02},
    {HEAD, ROOT, false, {0, 0.775, -0.07}, {0, 0.815, -0.14}, 0.032, 0.014, 0.02},
    {NECK, ROOT, false, {0, 0.65, -0.03}, {0, 0.69, -0.115}, 0.032, 0.014, 0.02},
    {CHEST, ROOT, false, {0, 0.54, -0.07}, {0, 0.575, -0.155}, 0.036, 0.015, 0.02},
    {SPINE, ROOT, false, {0, 0.45, -0.10}, {0, 0.485, -0.19}, 0.038, 0.015, 0.02},
    {TAIL_1, ROOT, false, {0, 0.375, -0.17}, {0, 0.415, -0.25}, 0.034, 0.014, 0.02},
    {TAIL_2, ROOT, false, {0, 0.300, -0.29}, {0, 0.335, -0.355}, 0.028, 0.013, 0.02},
    {TAIL_3, ROOT, false, {0, 0.250, -0.41}, {0, 0.285, -0.465}, 0.022, 0.012, 0.02},
};
/* clang-format on */
enum { PART_COUNT = sizeof parts / sizeof *parts, CREST_FIRST = PART_COUNT - 8 };

static double ellipsoid_distance(vec3 p, vec3 radii)
{
    vec3 unit = {p.x / radii.x, p.y / radii.y, p.z / radii.z};
    vec3 slope = {unit.x / radii.x, unit.y / radii.y, unit.z / radii.z};
    double k = v_length(unit), s = v_length(slope);
    return s > 0 ? k * (k - 1) / s : -radii.y;
}

static double part_distance(const body_part *part, vec3 p)
{
    if (part->ellipsoid)
        return ellipsoid_distance(v_sub(p, part->a), part->b);
    vec3 axis = v_sub(part->b, part->a);
    double t = clamp01(v_dot(v_sub(p, part->a), axis) / v_dot(axis, axis));
    return v_length(v_sub(p, v_mix(part->a, part->b, t))) - mix(part->ra, part->rb, t);
}

static double smooth_min(double a, double b, double width)
{
    double h = clamp01(0.5 + 0.5 * (b - a) / width);
    return mix(b, a, h) - width * h * (1 - h);
}

static vec3 mirrored(vec3 p)
{
    return (vec3){-p.x, p.y, p.z};
}

double walker_distance(vec3 p)
{
    double d = part_distance(&parts[0], p);
    for (int i = 1; i < PART_COUNT; i++) {
        d = smooth_min(d, part_distance(&parts[i], p), parts[i].blend);
        if (parts[i].twin != ROOT)
            d = smooth_min(d, part_distance(&parts[i], mirrored(p)), parts[i].blend);
    }
    return d > -p.y ? d : -p.y; /* flat soles */
}

vec3 walker_normal(vec3 p)
{
    const double e = 0.002; /* a tenth of the grid's step: smooths the seams of the blend, keeps the shape */
    return v_unit(
        (vec3){walker_distance((vec3){p.x + e, p.y, p.z}) - walker_distance((vec3){p.x - e, p.y, p.z}),
               walker_distance((vec3){p.x, p.y + e, p.z}) - walker_distance((vec3){p.x, p.y - e, p.z}),
               walker_distance((vec3){p.x, p.y, p.z + e}) - walker_distance((vec3){p.x, p.y, p.z - e})});
}

/* A joint's pull falls from 1 on its part's surface to 0 at `reach`, and rises a little inside. */
static double pull(double distance)
{
    const double reach = 0.06;
    double w = 1 - distance / reach;
    return w <= 0 ? 0 : w > 1.7 ? 1.7 * 1.7 : w * w;
}

static void keep_largest(const double pulls[WALKER_JOINTS], uint8_t joints[4], double weights[4])
{
    double sum = 0;
    bool taken[WALKER_JOINTS] = {false};
    for (int k = 0; k < 4; k++) {
        int best = 0;
        for (int j = 1; j < WALKER_JOINTS; j++)
            if (!taken[j] && (taken[best] || pulls[j] > pulls[best]))
                best = j;
        taken[best] = true;
        weights[k] = pulls[best];
        joints[k] = weights[k] > 0 ? (uint8_t)best : 0; /* an unused slot names joint 0, as glTF asks */
        sum += weights[k];
    }
    for (int k = 0; k < 4; k++)
        weights[k] /= sum;
}

void walker_weights(vec3 p, uint8_t joints[4], double weights[4])
{
    double pulls[WALKER_JOINTS] = {0};
    /* Left limbs do not pull at the right half: a leg that swings must not drag the other thigh along. */
    double left = smooth(-0.03, 0.03, p.x), right = 1 - left;
    for (int i = 0; i < PART_COUNT; i++) {
        bool pair = parts[i].twin != ROOT;
        double w = pull(part_distance(&parts[i], p)) * (pair ? left : 1);
        if (w > pulls[parts[i].joint])
            pulls[parts[i].joint] = w;
        if (pair) {
            w = pull(part_distance(&parts[i], mirrored(p))) * right;
            if (w > pulls[parts[i].twin])
                pulls[parts[i].twin] = w;
        }
    }
    keep_largest(pulls, joints, weights);
}

static double crest_distance(vec3 p)
{
    double d = 1;
    for (int i = CREST_FIRST; i < PART_COUNT; i++) {
        double one = part_distance(&parts[i], p);
        d = one < d ? one : d;
    }
    return d;
}

/* 1 between b and c, fading to 0 at a and d. */
static double between(double a, double b, double c, double d, double x)
{
    return smooth(a, b, x) * smooth(d, c, x);
}

vec3 walker_color(vec3 p, vec3 normal)
{
    static const vec3 orange = {0.80, 0.24, 0.035}, rust = {0.42, 0.075, 0.015}, cream = {0.92, 0.74, 0.48};
    static const vec3 teal = {0.03, 0.42, 0.40}, blush = {0.90, 0.22, 0.14}, claw = {0.20, 0.07, 0.03};
    vec3 m = {p.x < 0 ? -p.x : p.x, p.y, p.z};
    vec3 color = orange;
    /* Stripes across back and tail, fading out towards the sides. */
    double bands = smooth(0.15, 0.65, sin_turns((p.z * 0.8 - p.y * 0.6) / 0.105));
    color =
        v_mix(color, rust, bands * smooth(-0.1, 0.55, normal.y - 1.2 * normal.z) * smooth(0.0, -0.06, p.z));
    /* Pale belly, throat and under side of the tail. */
    double front =
        smooth(0.35, 0.8, normal.z) * smooth(0.13, 0.09, m.x) * between(0.27, 0.31, 0.56, 0.62, p.y);
    double under = smooth(-0.15, -0.6, normal.y) * smooth(0.10, 0.06, m.x) * smooth(-0.08, -0.16, p.z);
    double muzzle = between(0.60, 0.63, 0.685, 0.715, p.y) * smooth(0.05, 0.12, p.z) * smooth(0.14, 0.1, m.x);
    color = v_mix(color, cream, clamp01(front + under + muzzle));
    vec3 cheek = v_sub(m, (vec3){0.115, 0.705, 0.115});
    color = v_mix(color, blush, 0.8 * smooth(0.045, 0.015, v_length(cheek)));
    color = v_mix(color, rust, smooth(0.855, 0.885, p.y) * smooth(0.06, 0.09, m.x)); /* ear tips */
    color = v_mix(color, claw, smooth(0.105, 0.125, p.z) * smooth(0.07, 0.04, p.y)); /* toes */
    double hand = smooth(0.125, 0.15, p.z) * smooth(0.13, 0.15, m.x) * smooth(0.5, 0.48, p.y);
    color = v_mix(color, cream, hand);
    return v_mix(color, teal,
                 smooth(0.010, 0.002, crest_distance(p)) * smooth(-0.05, 0.2, normal.y - normal.z));
}
