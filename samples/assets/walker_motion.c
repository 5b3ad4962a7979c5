/* The creature's motion: idle, walk and jump as functions of time. Feet are placed first, in model space; the
 * legs follow by two-bone inverse kinematics, solved without trigonometry. */

#include "samples/assets/walker.h"

static const vec3 ahead = {0, 0, 1};

static vec3 bone(walker_joint from, walker_joint to)
{
    return v_sub(walker_joints[to].position, walker_joints[from].position);
}

static void pose_reset(walker_pose *pose)
{
    pose->hips = walker_joints[HIPS].position;
    pose->belly = 1;
    for (int j = 0; j < WALKER_JOINTS; j++)
        pose->rotation[j] = (quat){0, 0, 0, 1};
}

/* The knee between hip `h` and ankle `a`, bent towards `forward`; moves an ankle out of reach nearer. */
static vec3 place_knee(vec3 h, vec3 *a, double upper, double lower, vec3 forward)
{
    vec3 leg = v_sub(*a, h);
    double d = v_length(leg), reach = (upper + lower) * 0.999;
    if (d > reach) {
        leg = v_mul(leg, reach / d);
        *a = v_add(h, leg);
        d = reach;
    }
    double along = (upper * upper - lower * lower + d * d) / (2 * d);
    double height_sq = upper * upper - along * along;
    vec3 axis = v_mul(leg, 1 / d);
    vec3 out = v_unit(v_sub(forward, v_mul(axis, v_dot(forward, axis))));
    return v_add(h, v_add(v_mul(axis, along), v_mul(out, height_sq > 0 ? sqrt(height_sq) : 0)));
}

/* Bend one leg so that the foot stands at `ankle` (model space), turned by `pitch_deg` (toes down is
 * positive). */
static void pose_leg(walker_pose *pose, walker_joint thigh, vec3 ankle, double pitch_deg)
{
    walker_joint shin = thigh + 1, foot = thigh + 2;
    quat hips = pose->rotation[HIPS];
    vec3 h = v_add(pose->hips, q_rotate(hips, bone(HIPS, thigh)));
    vec3 upper = bone(thigh, shin), lower = bone(shin, foot);
    vec3 side = {walker_joints[thigh].position.x > 0 ? 0.12 : -0.12, 0,
                 0}; /* knees point a little outwards */
    vec3 knee = place_knee(h, &ankle, v_length(upper), v_length(lower), q_rotate(hips, v_add(ahead, side)));
    quat thigh_ms = q_mul(q_between(v_unit(q_rotate(hips, upper)), v_unit(v_sub(knee, h))), hips);
    quat shin_ms = q_mul(q_between(v_unit(q_rotate(thigh_ms, lower)), v_unit(v_sub(ankle, knee))), thigh_ms);
    pose->rotation[thigh] = q_mul(q_inverse(hips), thigh_ms);
    pose->rotation[shin] = q_mul(q_inverse(thigh_ms), shin_ms);
    pose->rotation[foot] = q_mul(q_inverse(shin_ms), q_euler(pitch_deg, 0, 0));
}

/* A foot whose ball is at `offset` from where it stands in the bind pose; it turns about the ball. */
static void pose_foot(walker_pose *pose, walker_joint thigh, vec3 offset, double pitch_deg)
{
    vec3 from_ball = {0, 0.07, -0.10}; /* from the ball of the foot on the floor to the ankle */
    vec3 ball = v_add(v_sub(walker_joints[thigh + 2].position, from_ball), offset);
    pose_leg(pose, thigh, v_add(ball, q_rotate(q_euler(pitch_deg, 0, 0), from_ball)), pitch_deg);
}

static void pose_tail(walker_pose *pose, double phase, double yaw_deg, double pitch_deg)
{
    for (int k = 0; k < 4; k++)
        pose->rotation[TAIL_1 + k] =
            q_euler(pitch_deg, yaw_deg * (0.7 + 0.2 * k) * sin_turns(phase - 0.12 * k), 0);
}

/* ---- walk: one second, two steps. A foot stands for the first 60 % of its cycle and is carried back at a
 * constant 0.40 m/s, which is the speed at which the creature has to be moved for its feet not to slide. ----
 */
#define STAND       0.60
#define HALF_STRIDE 0.12

static void walk_foot(walker_pose *pose, walker_joint thigh, double phase)
{
    double u = phase - floor(phase), toe_off = 38 * smooth(STAND - 0.22, STAND + 0.02, u);
    if (u < STAND) {
        pose_foot(pose, thigh, (vec3){0, 0, mix(HALF_STRIDE, -HALF_STRIDE, u / STAND)}, toe_off);
        return;
    }
    double s = (u - STAND) / (1 - STAND), lift = sin_turns(s / 2);
    double pitch = toe_off * (1 - smooth(0.0, 0.6, s)) - 14 * smooth(0.45, 0.8, s) * (1 - smooth(0.85, 1, s));
    /* The swing leaves and meets the floor with the floor's own speed: cubic from -half to +half stride. */
    double v = -2 * HALF_STRIDE * (1 - STAND) / STAND, ss = s * s;
    double z = HALF_STRIDE * (-1 + 2 * ss * (3 - 2 * s)) + v * (s - 3 * ss + 2 * ss * s);
    pose_foot(pose, thigh, (vec3){0, 0.075 * lift * lift + 0.012 * lift, z}, pitch);
}

static void pose_walk(double time_s, walker_pose *pose)
{
    pose_reset(pose);
    double u = time_s, swing = cos_turns(u - 0.02);        /* 1 when the left foot is in front */
    double weight = sin_turns(u + 0.02);                   /* 1 when the left leg carries */
    double bob = -0.022 - 0.016 * cos_turns(2 * u - 0.04); /* lowest when both feet stand */
    pose->hips = v_add(pose->hips, (vec3){0.020 * weight, bob, 0.008 * cos_turns(2 * u)});
    pose->rotation[HIPS] = q_euler(5, -7 * swing, 4 * weight);
    pose->rotation[SPINE] = q_euler(2, 6 * swing, -4 * weight);
    pose->rotation[CHEST] = q_euler(1, 8 * swing, -3 * weight);
    pose->rotation[NECK] = q_euler(-3, -4 * swing, 1.5 * weight);
    pose->rotation[HEAD] = q_euler(-4 + 3 * cos_turns(2 * u + 0.1), -3 * swing, 3 * weight);
    pose->rotation[EAR_L] = q_euler(9 * sin_turns(2 * u + 0.05), 0, -5 * cos_turns(2 * u));
    pose->rotation[EAR_R] = q_euler(9 * sin_turns(2 * u + 0.05), 0, 5 * cos_turns(2 * u));
    pose->rotation[ARM_L] = q_euler(10 + 30 * swing, 0, -6);
    pose->rotation[ARM_R] = q_euler(10 - 30 * swing, 0, 6);
    pose->rotation[HAND_L] = q_euler(-8 + 12 * cos_turns(u - 0.1), 0, 0);
    pose->rotation[HAND_R] = q_euler(-8 - 12 * cos_turns(u - 0.1), 0, 0);
    pose_tail(pose, u + 0.1, 13, -3 + 3 * cos_turns(2 * u));
    walk_foot(pose, THIGH_L, u);
    walk_foot(pose, THIGH_R, u + 0.5);
}

/* ---- idle: two seconds; breathes twice, looks left and right once ---- */
static void pose_idle(double time_s, walker_pose *pose)
{
    pose_reset(pose);
    double u = time_s / 2, breath = sin_turns(time_s), look = sin_turns(u);
    pose->belly = 1.025 + 0.025 * breath;
    pose->hips = v_add(pose->hips, (vec3){0.008 * look, -0.012 - 0.004 * breath, 0});
    pose->rotation[CHEST] = q_euler(-2 * breath, 4 * look, 0);
    pose->rotation[NECK] = q_euler(1.5 * breath, 14 * look, 0);
    pose->rotation[HEAD] = q_euler(3 * cos_turns(2 * u), 20 * look, 7 * cos_turns(u));
    pose->rotation[EAR_L] = q_euler(6 * cos_turns(2 * u), 0, -4 * breath);
    pose->rotation[EAR_R] = q_euler(6 * cos_turns(2 * u), 0, 4 * breath);
    pose->rotation[ARM_L] = q_euler(3 * breath, 0, -4 + 2 * breath);
    pose->rotation[ARM_R] = q_euler(3 * breath, 0, 4 - 2 * breath);
    pose_tail(pose, u + 0.15, 16, -2);
    pose_foot(pose, THIGH_L, (vec3){0, 0, 0}, 0);
    pose_foot(pose, THIGH_R, (vec3){0, 0, 0}, 0);
}

/* ---- jump: one second. It crouches, leaves the floor at 0.32 s, lands at 0.72 s and straightens up. The 0.4
 * s in the air make a height of g t^2 / 8 = 0.196 m. ---- */
#define LEAVE 0.32
#define LAND  0.72

static void pose_jump(double time_s, walker_pose *pose)
{
    pose_reset(pose);
    double t = time_s, air = clamp01((t - LEAVE) / (LAND - LEAVE)), rise = 4 * 0.196 * air * (1 - air);
    double crouch = smooth(0.02, 0.2, t) * (1 - smooth(0.2, LEAVE, t));
    crouch += 0.9 * smooth(LAND - 0.02, LAND + 0.1, t) * (1 - smooth(LAND + 0.1, 0.98, t));
    double flight = smooth(LEAVE - 0.06, LEAVE + 0.08, t) * (1 - smooth(LAND - 0.06, LAND + 0.06, t));
    double tuck = smooth(LEAVE, LEAVE + 0.14, t) * (1 - smooth(LAND - 0.14, LAND, t));
    pose->hips = v_add(pose->hips, (vec3){0, rise - 0.10 * crouch, -0.03 * crouch});
    pose->rotation[HIPS] = q_euler(16 * crouch - 4 * flight, 0, 0);
    pose->rotation[SPINE] = q_euler(12 * crouch - 5 * flight, 0, 0);
    pose->rotation[CHEST] = q_euler(8 * crouch - 5 * flight, 0, 0);
    pose->rotation[NECK] = q_euler(-14 * crouch, 0, 0);
    pose->rotation[HEAD] = q_euler(-14 * crouch - 8 * flight, 0, 0);
    pose->rotation[EAR_L] = q_euler(-10 * crouch, 0, 14 * crouch - 22 * flight);
    pose->rotation[EAR_R] = q_euler(-10 * crouch, 0, -14 * crouch + 22 * flight);
    pose->rotation[ARM_L] = q_euler(35 * crouch - 60 * flight, 0, 38 * flight - 8 * crouch);
    pose->rotation[ARM_R] = q_euler(35 * crouch - 60 * flight, 0, -38 * flight + 8 * crouch);
    pose_tail(pose, 0, 0, 10 * crouch - 12 * flight);
    vec3 offset = {0, rise + 0.06 * tuck, 0.02 * tuck};
    pose_foot(pose, THIGH_L, offset, 22 * tuck);
    pose_foot(pose, THIGH_R, offset, 22 * tuck);
}

const walker_clip walker_clips[WALKER_CLIPS] = {
    {"idle", 2.0, 13, true, pose_idle},
    {"walk", 1.0, 25, false, pose_walk},
    {"jump", 1.0, 25, false, pose_jump},
};
