// OpenSubdiv behind C: a control mesh, its edges, and limit surfaces of its faces (Far and Bfr).
//
// Coordinates on a face: a quad (of Catmull-Clark and bilinear meshes) and a triangle (of Loop
// meshes) have sub = 0 and (u, v) with corners (0,0) (1,0) (1,1) (0,1), or (0,0) (1,0) (0,1). Other
// faces are split into as many sub-faces as they have vertices: sub-face k has (0,0) at vertex k,
// (1,0) in the middle of the edge that follows, (1,1) at the center of the face.
// Threads: a CoOsdMesh is read by any number of threads; a CoOsdSurface belongs to one at a time.

#ifndef CO_SHIMS_OSD_H
#define CO_SHIMS_OSD_H

#include "cohort/scene.h"

#ifdef __cplusplus
extern "C" {
#endif

// Face-varying data with its own topology.
typedef struct CoOsdChannel {
    const int32_t *indices; // one per face-vertex, in [0, value_count)
    int32_t value_count;
} CoOsdChannel;

// Everything in range; every face has 3 or more vertices (3 for Loop). Arrays need to live for the
// call only.
typedef struct CoOsdDesc {
    CohortScheme scheme; // not NONE
    CohortInterpolateBoundary interpolate_boundary;
    CohortFvarLinear fvar_linear;
    bool triangle_rule_smooth;
    int32_t vertex_count, face_count;
    const int32_t *face_vertex_counts, *face_vertex_indices;
    const int32_t *crease_pairs; // [crease_count * 2] vertices of an edge
    const float *crease_sharpnesses;
    int32_t crease_count;
    const int32_t *corners;
    const float *corner_sharpnesses;
    int32_t corner_count;
    const CoOsdChannel *channels;
    int32_t channel_count;
    uint32_t exact_level; // limit points of this level of subdivision are exact, not approximated
} CoOsdDesc;

typedef struct CoOsdMesh CoOsdMesh;
typedef struct CoOsdSurface CoOsdSurface;

typedef struct CoOsdCoord {
    uint32_t sub;
    float u, v;
} CoOsdCoord;

// NULL with the reason when OpenSubdiv refuses the topology, or when a vertex or face has more than
// 1000 edges (but for bilinear meshes). What it complains about without
// refusing goes to `warning` (its last sentence, "" if none). Destroy with co_osd_destroy.
CoOsdMesh *co_osd_create(const CoOsdDesc *desc, char warning[256], CohortError *err);
void co_osd_destroy(CoOsdMesh *mesh); // NULL is fine

uint32_t co_osd_edge_count(const CoOsdMesh *mesh);
void co_osd_edge_vertices(const CoOsdMesh *mesh, uint32_t edge, uint32_t vertices[2]);
// The face's edges: element k joins its vertices k and k + 1. The array lives with the mesh.
const int32_t *co_osd_face_edges(const CoOsdMesh *mesh, uint32_t face);
// *has: whether the face has a limit surface; boundary faces have none when boundaries are not
// interpolated.
bool co_osd_face_has_limit(const CoOsdMesh *mesh, uint32_t face, bool *has, CohortError *err);
// Whether somewhere two faces meet and yet have different limit normals.
bool co_osd_has_normal_seams(const CoOsdMesh *mesh);

CoOsdSurface *co_osd_surface_create(const CoOsdMesh *mesh, CohortError *err);
void co_osd_surface_destroy(CoOsdSurface *surface); // NULL is fine

// Takes the limit surface of a face that has one: of the vertices (channel -1) or of a channel.
bool co_osd_surface_begin(CoOsdSurface *surface, uint32_t face, int32_t channel, CohortError *err);

// Takes the control values, `components` floats each, of all vertices or of all values of the
// channel. *finite (may be NULL): whether all that influence the face are.
bool co_osd_surface_values(CoOsdSurface *surface, const float *values, uint32_t components,
                           bool *finite, CohortError *err);

// Limit values, `components` floats each; du and dv, derivatives by u and v, may both be NULL.
bool co_osd_surface_eval(CoOsdSurface *surface, const CoOsdCoord *coords, uint32_t count, float *p,
                         float *du, float *dv, CohortError *err);

// OpenSubdiv's version, "3.5.0"; static.
const char *co_osd_version(void);

#ifdef __cplusplus
}
#endif

#endif
