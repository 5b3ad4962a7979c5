/* The creature's triangles. The body comes from surface nets (Gibson 1998): one vertex in every grid cell
 * that the surface crosses, one quad round every grid edge that it crosses; vertices are then pulled onto the
 * zero level. */

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "samples/assets/walker.h"

/* Cubes round the whole bind pose; x is symmetric so that both halves match. */
enum { NX = 26, NY = 50, NZ = 44 }; /* at most */
typedef struct grid {
    int nx, ny, nz;
    double step;
    vec3 origin;
} grid;
static const grid fine = {NX, NY, NZ, 0.02, {-0.26, -0.03, -0.60}};
static const grid coarse = {11, 23, 19, 0.52 / 11, {-0.26, -0.03 - 0.52 / 11, -0.61}};

static void *grown(void *data, int *capacity, size_t size)
{
    *capacity = *capacity ? *capacity * 2 : 1024;
    data = realloc(data, (size_t)*capacity * size);
    if (!data) {
        fputs("kandil-assets: out of memory\n", stderr);
        exit(1);
    }
    return data;
}

int skin_mesh_add_vertex(skin_mesh *mesh, const skin_vertex *vertex)
{
    if (mesh->vertex_count == mesh->vertex_capacity)
        mesh->vertices = grown(mesh->vertices, &mesh->vertex_capacity, sizeof *mesh->vertices);
    mesh->vertices[mesh->vertex_count] = *vertex;
    return mesh->vertex_count++;
}

void skin_mesh_add_triangle(skin_mesh *mesh, int a, int b, int c)
{
    if (mesh->index_count + 3 > mesh->index_capacity)
        mesh->indices = grown(mesh->indices, &mesh->index_capacity, sizeof *mesh->indices);
    mesh->indices[mesh->index_count++] = (uint16_t)a;
    mesh->indices[mesh->index_count++] = (uint16_t)b;
    mesh->indices[mesh->index_count++] = (uint16_t)c;
}

void skin_mesh_free(skin_mesh *mesh)
{
    free(mesh->vertices);
    free(mesh->indices);
    free(mesh->quads);
    *mesh = (skin_mesh){0};
}

skin_vertex skin_vertex_make(vec3 p, vec3 n, vec3 color, const uint8_t joints[4], const double weights[4])
{
    skin_vertex v = {.position = {(float)p.x, (float)p.y, (float)p.z},
                     .normal = {(float)n.x, (float)n.y, (float)n.z}};
    const double rgb[3] = {color.x, color.y, color.z};
    for (int c = 0; c < 3; c++)
        v.color[c] = (uint8_t)(clamp01(rgb[c]) * 255 + 0.5);
    v.color[3] = 255;
    int rest = 65535;
    for (int k = 3; k >= 0; k--) { /* the largest comes first and takes what rounding leaves */
        int w = k ? (int)(weights[k] * 65535 + 0.5) : rest;
        rest -= w;
        v.weights[k] = (uint16_t)w;
        v.joints[k] = w ? joints[k] : 0;
    }
    return v;
}

typedef struct net {
    grid grid;
    double field[NX + 1][NY + 1][NZ + 1]; /* at the grid's corners */
    int vertex[NX][NY][NZ];               /* of each cell, or -1 */
} net;

static vec3 corner_position(const net *n, int x, int y, int z)
{
    return v_add(n->grid.origin, v_mul((vec3){x, y, z}, n->grid.step));
}

/* The mean of the points where the cell's edges cross the surface. Returns false if none does. */
static bool cell_center(const net *n, int x, int y, int z, vec3 *out)
{
    vec3 sum = {0, 0, 0};
    int count = 0;
    for (int a = 0; a < 8; a++)
        for (int bit = 1; bit < 8; bit *= 2) {
            if (a & bit)
                continue;
            int b = a | bit;
            double fa = n->field[x + (a & 1)][y + (a >> 1 & 1)][z + (a >> 2)];
            double fb = n->field[x + (b & 1)][y + (b >> 1 & 1)][z + (b >> 2)];
            if ((fa < 0) == (fb < 0))
                continue;
            vec3 pa = corner_position(n, x + (a & 1), y + (a >> 1 & 1), z + (a >> 2));
            vec3 pb = corner_position(n, x + (b & 1), y + (b >> 1 & 1), z + (b >> 2));
            sum = v_add(sum, v_mix(pa, pb, fa / (fa - fb)));
            count++;
        }
    if (count)
        *out = v_mul(sum, 1.0 / count);
    return count > 0;
}

static int add_body_vertex(skin_mesh *mesh, vec3 p, double step)
{
    for (int i = 0; i < 4; i++) {
        double d = walker_distance(p), limit = step / 2;
        d = d > limit ? limit : d < -limit ? -limit : d;
        p = v_sub(p, v_mul(walker_normal(p), d));
    }
    uint8_t joints[4];
    double weights[4];
    vec3 n = walker_normal(p);
    walker_weights(p, joints, weights);
    skin_vertex v = skin_vertex_make(p, n, walker_color(p, n), joints, weights);
    return skin_mesh_add_vertex(mesh, &v);
}

static vec3 position_of(const skin_mesh *mesh, int i)
{
    const float *p = mesh->vertices[i].position;
    return (vec3){(double)p[0], (double)p[1], (double)p[2]};
}

/* Split along the shorter diagonal. */
static void add_quad(skin_mesh *mesh, int a, int b, int c, int d)
{
    if (mesh->quad_count == mesh->quad_capacity)
        mesh->quads = grown(mesh->quads, &mesh->quad_capacity, sizeof *mesh->quads);
    memcpy(mesh->quads[mesh->quad_count++],
           (const uint16_t[]){(uint16_t)a, (uint16_t)b, (uint16_t)c, (uint16_t)d}, sizeof *mesh->quads);
    double ac = v_length(v_sub(position_of(mesh, a), position_of(mesh, c)));
    double bd = v_length(v_sub(position_of(mesh, b), position_of(mesh, d)));
    if (ac <= bd) {
        skin_mesh_add_triangle(mesh, a, b, c);
        skin_mesh_add_triangle(mesh, a, c, d);
    } else {
        skin_mesh_add_triangle(mesh, b, c, d);
        skin_mesh_add_triangle(mesh, b, d, a);
    }
}

/* The quad round the edge from corner (x,y,z) along `axis`, if the surface crosses it. */
static void add_edge_quad(const net *n, skin_mesh *mesh, const int at[3], int axis)
{
    int next[3] = {at[0], at[1], at[2]};
    next[axis]++;
    bool inside = n->field[at[0]][at[1]][at[2]] < 0;
    if (inside == (n->field[next[0]][next[1]][next[2]] < 0))
        return;
    int u = (axis + 1) % 3, v = (axis + 2) % 3, ring[4];
    for (int k = 0; k < 4; k++) {
        int cell[3] = {at[0], at[1], at[2]};
        cell[u] -= k == 0 || k == 3;
        cell[v] -= k < 2;
        ring[k] = n->vertex[cell[0]][cell[1]][cell[2]];
    }
    if (inside) /* the surface faces along the axis, and the ring is counter-clockwise seen from there */
        add_quad(mesh, ring[0], ring[1], ring[2], ring[3]);
    else
        add_quad(mesh, ring[3], ring[2], ring[1], ring[0]);
}

static void add_net_vertices(net *n, skin_mesh *mesh)
{
    for (int x = 0; x <= n->grid.nx; x++)
        for (int y = 0; y <= n->grid.ny; y++)
            for (int z = 0; z <= n->grid.nz; z++)
                n->field[x][y][z] = walker_distance(corner_position(n, x, y, z));
    for (int x = 0; x < n->grid.nx; x++)
        for (int y = 0; y < n->grid.ny; y++)
            for (int z = 0; z < n->grid.nz; z++) {
                vec3 p;
                n->vertex[x][y][z] =
                    cell_center(n, x, y, z, &p) ? add_body_vertex(mesh, p, n->grid.step) : -1;
            }
}

static void make_body(skin_mesh *mesh, const grid *cells)
{
    net *n = malloc(sizeof *n);
    if (!n) {
        fputs("kandil-assets: out of memory\n", stderr);
        exit(1);
    }
    n->grid = *cells;
    add_net_vertices(n, mesh);
    for (int x = 1; x < n->grid.nx; x++)
        for (int y = 1; y < n->grid.ny; y++)
            for (int z = 1; z < n->grid.nz; z++)
                for (int axis = 0; axis < 3; axis++)
                    add_edge_quad(n, mesh, (const int[]){x, y, z}, axis);
    free(n);
}

void walker_make_body(skin_mesh *mesh)
{
    make_body(mesh, &fine);
}

bool walker_on_ground(const skin_vertex *vertex)
{
    return vertex->position[1] < (float)(coarse.step / 3);
}

/* A limit surface lies inside its cage: pushing the cage out by a seventh of a cell makes up for most of it.
 */
void walker_make_cage(skin_mesh *mesh)
{
    make_body(mesh, &coarse);
    for (int i = 0; i < mesh->vertex_count; i++) {
        skin_vertex *v = &mesh->vertices[i];
        bool sole = walker_on_ground(v);
        for (int k = 0; k < 3; k++)
            v->position[k] += v->normal[k] * (float)(coarse.step / 7);
        v->position[1] = sole ? 0 : v->position[1];
    }
}

typedef struct sphere {
    vec3 center, axis; /* axis: from the centre through the pupil */
    double radius, pupil_turns;
} sphere;

enum { RINGS = 11, SECTORS = 16 };

/* Where vertex k of ring r stands among a sphere's vertices: the poles have a single one. */
static int sphere_vertex(int r, int k)
{
    return r == 0 ? 0 : r == RINGS - 1 ? 1 + (RINGS - 2) * SECTORS : 1 + (r - 1) * SECTORS + k % SECTORS;
}

static void add_sphere_triangles(skin_mesh *mesh, int base)
{
    for (int r = 0; r + 1 < RINGS; r++)
        for (int k = 0; k < SECTORS; k++) {
            int a = base + sphere_vertex(r, k), b = base + sphere_vertex(r, k + 1);
            int c = base + sphere_vertex(r + 1, k), d = base + sphere_vertex(r + 1, k + 1);
            if (a != b)
                skin_mesh_add_triangle(mesh, a, c, b);
            if (c != d)
                skin_mesh_add_triangle(mesh, b, c, d);
        }
}

/* Rings round the axis; the two rings at the pupil's rim stand close together, so that its edge is sharp. */
static void add_sphere(skin_mesh *mesh, const sphere *s)
{
    static const vec3 white = {0.9, 0.9, 0.88}, dark = {0.012, 0.010, 0.012};
    const double rim = s->pupil_turns;
    vec3 side = v_unit(v_cross((vec3){0, 1, 0}, s->axis)), up = v_cross(s->axis, side);
    int base = mesh->vertex_count;
    for (int r = 0; r < RINGS; r++) {
        double angle = r <= 2   ? rim * r / 2
                       : r == 3 ? rim + 0.004
                                : mix(rim, 0.5, (r - 3) / (double)(RINGS - 4));
        for (int k = 0; k < (r > 0 && r < RINGS - 1 ? SECTORS : 1); k++) {
            double c = cos_turns((double)k / SECTORS), d = sin_turns((double)k / SECTORS);
            vec3 n = v_add(v_mul(s->axis, cos_turns(angle)),
                           v_mul(v_add(v_mul(side, c), v_mul(up, d)), sin_turns(angle)));
            skin_vertex v = skin_vertex_make(v_add(s->center, v_mul(n, s->radius)), n, r <= 2 ? dark : white,
                                             (const uint8_t[]){HEAD, 0, 0, 0}, (const double[]){1, 0, 0, 0});
            skin_mesh_add_vertex(mesh, &v);
        }
    }
    add_sphere_triangles(mesh, base);
}

void walker_make_eyes(skin_mesh *mesh)
{
    for (int side = -1; side <= 1; side += 2) {
        add_sphere(
            mesh,
            &(sphere){{side * 0.078, 0.772, 0.125}, v_unit((vec3){side * 0.22, 0.06, 1}), 0.044, 0.105});
        /* All pupil: a nostril. */
        add_sphere(mesh,
                   &(sphere){{side * 0.030, 0.722, 0.232}, v_unit((vec3){side * 0.3, 0.4, 1}), 0.009, 0.40});
    }
}
