// Subdivision in four steps: the cage as OpenSubdiv takes it (subdivide_cage.c), how fine its edges
// and faces become (subdivide_rates.c), the layout of points and triangles (subdivide.c,
// subdivide_patch.c), and limit values at the points (subdivide_eval.c).
//
// Points lie in this order: one per vertex of the cage; those inside each edge, from its first to
// its second vertex; those inside each face. The lowest live face at a vertex or edge owns its
// points and evaluates them once; all faces refer to them by index. Terms: live = has a limit
// surface and is not dropped; level = log2 of the segments of an edge; a face has the level of its
// finest edge.

#ifndef CO_GEOMETRY_SUBDIVIDE_H
#define CO_GEOMETRY_SUBDIVIDE_H

#include "geometry/mesh_internal.h"
#include "shims/osd.h"

typedef struct CoSubdivision {
    CoMeshBuild *build;
    CoOsdMesh *osd;
    CoGridKind grid;
    // Levels, the finest at first as asked for. Uniform: all arrays are NULL.
    uint32_t level;
    uint8_t *edge_level, *face_level;
    uint32_t *edge_point; // [edges] first point inside
    // The cage without faces OpenSubdiv cannot take. All scratch or the description's.
    uint32_t face_count, fv_count;
    const int32_t *counts, *indices;
    const uint32_t *cage_face; // [face_count] face of the description, NULL: the same
    const uint32_t *cage_fv;   // [fv_count] face-vertex of the description, NULL: the same
    uint32_t *first;           // [face_count + 1] first face-vertex
    CoOsdChannel *channels;    // one per face-varying source, in order
    // Layout.
    uint32_t *face_point;               // [face_count] first point inside
    uint32_t *first_tri, *corner_first; // [faces of the description]
    uint32_t *face_patch;               // [face_count] first patch
    uint32_t patch_count;
    bool has_split;   // some live face has sub-quads or fan triangles
    bool has_whole;   // some has not
    uint8_t *is_live; // [face_count]
    uint32_t *vertex_owner, *edge_owner;
    uint32_t point_count, corner_count;
    bool has_normal_seams;
    bool is_finite;        // all points are
    CoVec3 box_lo, box_hi; // of them
    float *points;         // [point_count * 3]
    uint32_t *normals; // unit codes per point, or per corner element where there are seams; NULL
                       // for bilinear
} CoSubdivision;

static inline uint32_t co_subdivision_cage_face(const CoSubdivision *s, uint32_t face)
{
    return s->cage_face ? s->cage_face[face] : face;
}

static inline bool co_subdivision_is_split(const CoSubdivision *s, uint32_t face)
{
    return s->grid == CO_GRID_QUAD && s->counts[face] != 4;
}

// Quads are one patch, n-gons as many as they have vertices.
static inline uint32_t co_subdivision_patch_count(const CoSubdivision *s, uint32_t face)
{
    return co_subdivision_is_split(s, face) ? (uint32_t)s->counts[face] : 1;
}

static inline uint32_t co_subdivision_edge_level(const CoSubdivision *s, uint32_t edge)
{
    return s->edge_level ? s->edge_level[edge] : s->level;
}

static inline uint32_t co_subdivision_face_level(const CoSubdivision *s, uint32_t face)
{
    return s->face_level ? s->face_level[face] : s->level;
}

// First point inside an edge; there are 2^level - 1.
static inline uint32_t co_subdivision_edge_point(const CoSubdivision *s, uint32_t edge)
{
    return s->edge_point ? s->edge_point[edge]
                         : (uint32_t)s->build->desc->point_count + edge * ((1u << s->level) - 1);
}

// Point number i (1 to 2^level - 1) on edge k of a face, counted from the face's vertex k.
uint32_t co_subdivision_face_edge_point(const CoSubdivision *s, uint32_t face, uint32_t k,
                                        uint32_t i);

// subdivide_cage.c
bool co_subdivision_make_cage(CoSubdivision *s);
bool co_subdivision_make_osd(CoSubdivision *s);

// subdivide_rates.c: levels as the description wants them. Needs the edges.
uint32_t co_subdivision_finest(const CohortMeshDesc *desc);
bool co_subdivision_make_rates(CoSubdivision *s);

// subdivide_patch.c
bool co_subdivision_make_patches(CoSubdivision *s);

// subdivide_words.c: whether there is a shorter form of the words that the table's kernels can do
// with; room for the words, zeroed, NULL when out of memory; and that form, or the words if they
// are less, into the table.
bool co_subdivision_is_short(const CoPatchTable *table);
uint32_t *co_subdivision_alloc_words(CoMeshBuild *build, const CoPatchTable *table,
                                     bool is_scratch);
bool co_subdivision_shorten_words(CoMeshBuild *build, CoPatchTable *table, const uint32_t *words);

// subdivide_normals.c: what eval has found per corner element, kept where faces do not share it.
bool co_subdivision_share_normals(CoSubdivision *s);

// subdivide_eval.c: fills points, normals and the values of all refined primvars. Needs the layout.
bool co_subdivision_eval(CoSubdivision *s);

#endif
