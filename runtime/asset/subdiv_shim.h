#ifndef KD_ASSET_SUBDIV_SHIM_H
#define KD_ASSET_SUBDIV_SHIM_H

/* OpenSubdiv behind C: a checked cage in, limit stencils out. Only subdiv_shim.cpp speaks C++ with it. */

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "runtime/core/status.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef enum subdiv_boundary {
    SUBDIV_BOUNDARY_NONE,
    SUBDIV_EDGE_ONLY,
    SUBDIV_EDGE_AND_CORNER
} subdiv_boundary;
typedef enum subdiv_uv_rule {
    SUBDIV_UV_SMOOTH,
    SUBDIV_UV_CORNERS_ONLY,
    SUBDIV_UV_CORNERS_PLUS1,
    SUBDIV_UV_CORNERS_PLUS2,
    SUBDIV_UV_BOUNDARIES,
    SUBDIV_UV_LINEAR
} subdiv_uv_rule;

/* A sharpness of this or more never rounds off (OpenSubdiv and USD agree on the number). */
#define SUBDIV_INFINITELY_SHARP 10.0f

/* A control mesh. Every index is in range, every face has three corners at least and no vertex twice, no edge
 * has more than two faces: whoever fills it has checked. */
typedef struct subdiv_cage {
    bool loop; /* Loop's scheme on triangles, else Catmull-Clark */
    subdiv_boundary boundary;
    subdiv_uv_rule uv_rule;
    int vertex_count, face_count, corner_count; /* corners: of all faces together */
    const int *face_sizes;                      /* [face_count] */
    const int *corners;                         /* [corner_count] vertices */
    int crease_count, sharp_corner_count;
    const int *creases; /* [crease_count] pairs of vertices that share an edge */
    const float *crease_sharpness;
    const int *sharp_corners; /* vertices */
    const float *corner_sharpness;
    int uv_count;
    const int *uv_corners; /* [corner_count], NULL: no texture coordinates */
} subdiv_cage;

/* The edges of the cage and what the rules made of them. */
typedef struct subdiv_topology {
    int edge_count;
    const int *corner_edges;     /* [corner_count] edge from a corner to the next one of its face */
    const int *edge_vertices;    /* [edge_count] pairs */
    const uint8_t *edge_sharp;   /* infinitely sharp: two surfaces meet, each with its own normal */
    const uint8_t *vertex_sharp; /* likewise */
    const uint8_t *face_hole;    /* has no surface */
} subdiv_topology;

/* Rows of weights: row r reads entries first[r] … first[r + 1]. The value is the sum of weight * control
 * value. */
typedef struct subdiv_rows {
    size_t row_count, entry_count;
    const uint32_t *first; /* [row_count + 1] */
    const int *index;
    const float *weight, *du, *dv;
} subdiv_rows;

typedef struct subdiv subdiv;

/* Levels that creases which round off are followed; a sharper one is treated as if it were as sharp as this.
 */
#define SUBDIV_ISOLATION_MAX 6
/* Levels round the corners of surfaces whose boundaries round them. */
#define SUBDIV_ISOLATION_CORNER 9

/** Levels of refinement at which all points of a grid of that level are exact. */
int subdiv_isolation(const subdiv_cage *cage, int level);

/** Read a cage's topology.
 *
 *  isolation  levels by which the surface is refined round creases and irregular vertices; points that the
 * grid of that level holds are exact Returns    NULL, with `error` in words, when OpenSubdiv refuses the cage
 * or memory is out Owns       the caller ends it with subdiv_close
 */
subdiv *subdiv_open(const subdiv_cage *cage, int isolation, char *error, size_t error_size);
void subdiv_close(subdiv *s);
const subdiv_topology *subdiv_topology_of(const subdiv *s);

/** Count the patches of a face: its corners for Catmull-Clark faces that are not quads, else 1. */
static inline int subdiv_patches(const subdiv_cage *cage, int face)
{
    return !cage->loop && cage->face_sizes[face] != 4 ? cage->face_sizes[face] : 1;
}
/** Count the segments along a patch's side. Corner patches reach half-way along an edge. */
static inline int subdiv_segments(const subdiv_cage *cage, int face, int level)
{
    return subdiv_patches(cage, face) > 1 ? 1 << (level - 1) : 1 << level;
}

/** Make the stencils of grids over all patches of faces that are no holes, one patch after another, u
 * fastest: (n + 1) squared rows, for Loop those with i + j <= n. A quad's corners stand at (0,0) (1,0) (1,1)
 * (0,1); a corner patch has its vertex at (0,0), the middle of the following edge at (1,0), the face's at
 * (1,1); a triangle (0,0) (1,0) (0,1).
 *
 *  level  at least 1
 *  uv     of texture coordinates instead of vertices
 *  Owns   the rows live until the next call for the same kind, and subdiv_close
 *  Errors KD_NO_MEMORY, KD_UNSUPPORTED with `error` in words
 */
kd_status subdiv_stencils(subdiv *s, int level, bool uv, subdiv_rows *out, char *error, size_t error_size);

#ifdef __cplusplus
}
#endif

#endif
