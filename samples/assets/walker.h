#ifndef SAMPLES_ASSETS_WALKER_H
#define SAMPLES_ASSETS_WALKER_H

/* The walking creature: a small two-legged dragon, 0.9 m tall, feet at y = 0, facing +z (its left is +x).
 * Joints and body parts are tables; the skin is the zero level of the parts' blended distance field. In the
 * bind pose no joint is turned, so that a joint's inverse bind matrix is a translation. */

#include "samples/assets/gltf.h"
#include "samples/assets/vec.h"

typedef enum walker_joint {
    ROOT,
    HIPS,
    SPINE,
    BELLY,
    CHEST,
    NECK,
    HEAD,
    EAR_L,
    EAR_R,
    ARM_L,
    HAND_L,
    ARM_R,
    HAND_R,
    THIGH_L,
    SHIN_L,
    FOOT_L,
    THIGH_R,
    SHIN_R,
    FOOT_R,
    TAIL_1,
    TAIL_2,
    TAIL_3,
    TAIL_4,
    WALKER_JOINTS
} walker_joint;

typedef struct joint_info {
    const char *name;
    int parent;    /* -1 for the root; parents come first */
    vec3 position; /* bind pose, model space [m] */
} joint_info;

extern const joint_info walker_joints[WALKER_JOINTS];

/** Measure the distance to the body's surface: negative inside, close to exact near the surface. [m] */
double walker_distance(vec3 p);
/** The direction in which that distance grows fastest, unit length. */
vec3 walker_normal(vec3 p);

/** Weigh the joints at a point of the surface: the four largest, sorted, sum 1. */
void walker_weights(vec3 p, uint8_t joints[4], double weights[4]);

/** Colour the surface, linear 0..1. */
vec3 walker_color(vec3 p, vec3 normal);

typedef struct skin_vertex {
    float position[3], normal[3];
    uint8_t color[4], joints[4];
    uint16_t weights[4]; /* sum 65535 */
} skin_vertex;

typedef struct skin_mesh {
    skin_vertex *vertices;
    uint16_t *indices;
    uint16_t (*quads)[4]; /* the body's triangles, in pairs */
    int vertex_count, index_count, quad_count, vertex_capacity, index_capacity, quad_capacity;
} skin_mesh;

/** Make the body's surface: closed, triangles counter-clockwise from outside. */
void walker_make_body(skin_mesh *mesh);
/** Tell whether a vertex of the cage belongs to a sole. */
bool walker_on_ground(const skin_vertex *vertex);
/** Make a low cage of the body, for a subdivision surface. */
void walker_make_cage(skin_mesh *mesh);
/** Make eyes and nostrils: spheres bound to the head. */
void walker_make_eyes(skin_mesh *mesh);
int skin_mesh_add_vertex(skin_mesh *mesh, const skin_vertex *vertex);
void skin_mesh_add_triangle(skin_mesh *mesh, int a, int b, int c);
void skin_mesh_free(skin_mesh *mesh);
/** Fill one vertex: colours and weights are rounded so that weights keep their exact sum. */
skin_vertex skin_vertex_make(vec3 position, vec3 normal, vec3 color, const uint8_t joints[4],
                             const double weights[4]);

typedef struct walker_pose {
    vec3 hips;                    /* position of the hips, model space */
    double belly;                 /* scale of the belly joint, across and along */
    quat rotation[WALKER_JOINTS]; /* local */
} walker_pose;

typedef struct walker_clip {
    const char *name;
    double duration_s;
    int keys;   /* evenly spaced, first at 0, last at the end */
    bool cubic; /* cubic spline with tangents from the motion itself; else linear */
    void (*pose)(double time_s, walker_pose *pose);
} walker_clip;

#define WALKER_CLIPS 3
extern const walker_clip walker_clips[WALKER_CLIPS];

#endif
