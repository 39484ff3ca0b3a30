// What a committed mesh keeps for shading, and what its construction passes around.
//
// Terms: cage = the faces and points of the description; element = one value of a primvar;
// corner element = place of a face-local value (polygons: the face-vertex; subdivision: a point of
// the face's own grid, see grid.h); dropped = a face that gets no triangles but keeps its number.

#ifndef CO_GEOMETRY_MESH_INTERNAL_H
#define CO_GEOMETRY_MESH_INTERNAL_H

#include "base/error.h"
#include "base/memory.h"
#include "geometry/mesh.h"

// A list of allocations that live and die together.
typedef struct CoMeshBlock CoMeshBlock;

// `count` zeroed elements of `size` bytes, aligned to 64, or NULL when that does not fit in memory.
// Zero elements give a valid pointer to nothing.
void *co_mesh_block_alloc(CoMeshBlock **list, size_t count, size_t size);
void co_mesh_block_free(CoMeshBlock **list);
// One of them.
void co_mesh_block_drop(CoMeshBlock **list, const void *array);
size_t co_mesh_block_bytes(const CoMeshBlock *list);

// How triangles of a face are numbered and where their corners lie.
typedef enum CoGridKind {
    CO_GRID_POLYGON = 0, // n - 2 triangles per face, tri_corners
    CO_GRID_QUAD,        // 2^level squares a side; n-gons as n sub-quads (level 0: a fan)
    CO_GRID_TRIANGLE     // 4^level triangles per triangle (loop)
} CoGridKind;

typedef enum CoPrimvarKind {
    CO_PRIMVAR_CONSTANT = 0,
    CO_PRIMVAR_UNIFORM, // one element per cage face
    CO_PRIMVAR_POINT,   // one element per tessellated point
    CO_PRIMVAR_CORNER   // one element per corner element
} CoPrimvarKind;

typedef struct CoPrimvar {
    const char *name;
    CoPrimvarKind kind;
    uint32_t components;     // 1 to 4
    const float *values;     // elements of `components` floats, finite
    const uint32_t *indices; // element -> value, NULL: the element itself
} CoPrimvar;

// Of so many corner elements, which have a normal of their own, and where the first of these
// stands.
enum {
    CO_OWN_ELEMENTS = 64
};
typedef struct CoOwnNormals {
    uint32_t first, has[2];
} CoOwnNormals;

typedef struct CoMeshShading {
    CoMeshBlock *blocks; // owns every array here and in CoMesh
    CoGridKind grid;
    uint32_t level; // of the finest face
    bool left_handed;
    bool is_bilinear;
    const CoPatchTable *patches;   // of subdivided meshes, the mesh's
    const uint32_t *face_patch;    // [face_count] first patch; NULL: as per_face says, or one each
    const uint32_t *tri_face;      // polygons: [tri_count]
    const uint32_t *corner_first;  // [face_count] first corner element; NULL if nothing asks, or
    uint32_t corners_each;         // if all faces have as many: that
    const uint32_t *ptex_first;    // [face_count + 1] first Ptex face; NULL
    uint32_t ptex_each;            // if all faces have as many: that
    const uint32_t *tri_corners;   // polygon grids: [tri_count * 3] face-vertices
    const uint32_t *face_vertices; // polygon grids with n-gons above 4: [face-vertices] points
    const float *face_centers;     // with face_vertices: [face_count * 3] average of the vertices
    const CoPrimvar *primvars;
    uint32_t primvar_count;
    CoPrimvar normals;               // authored, of polygons; values NULL: none
    const uint32_t *limit_normals;   // of limit surfaces, see unit_code.h; NULL: none
    bool has_corner_normals;         // those are per corner element, not per point, but for
    const CoOwnNormals *own_normals; // elements that have none of their own; NULL: all have
    bool has_derived_normals;        // some are CO_UNIT_DERIVED
    uint32_t material;               // of faces in no subset
    const uint32_t *face_material;   // [face_count], NULL: all `material`
    uint32_t ptex_face_offset;
} CoMeshShading;

// Where the limit normal of a corner stands, which may be CO_UNIT_DERIVED.
static inline uint32_t co_mesh_normal_at(const CoMeshShading *s, uint32_t element, uint32_t point)
{
    if (!s->own_normals)
        return element;
    const CoOwnNormals *own = &s->own_normals[element / CO_OWN_ELEMENTS];
    uint64_t has = own->has[0] | (uint64_t)own->has[1] << 32;
    uint64_t bit = 1ull << element % CO_OWN_ELEMENTS;
    return has & bit ? own->first + (uint32_t)__builtin_popcountll(has & (bit - 1)) : point;
}

// Normal of the bilinear patch at (u, v).
static inline CoVec3 co_bilinear_normal(const CoVec3 q[4], float u, float v)
{
    CoVec3 du = co_lerp3(co_sub(q[1], q[0]), co_sub(q[2], q[3]), v);
    CoVec3 dv = co_lerp3(co_sub(q[3], q[0]), co_sub(q[2], q[1]), u);
    return co_normalize(co_cross(du, dv));
}

// A primvar of the description that passed its checks.
typedef struct CoPrimvarSource {
    const CohortPrimvarDesc *desc;
    CoPrimvar *primvar;   // name, kind and components set
    float *refined;       // values of a subdivision surface, where they vary over a face
    const float *control; // vertex primvars of those: one value per point
} CoPrimvarSource;

// One construction. The shading and scratch lists outlive no failure: mesh.c frees both.
typedef struct CoMeshBuild {
    const CohortMeshDesc *desc;
    const char *path; // never NULL
    CoMesh *mesh;
    CoMeshShading *shading;
    CoMeshBlock *scratch; // freed when the construction ends
    CoMeshWarnFn *warn;
    void *cookie;
    CohortError *err;
    uint32_t *face_first;  // [face_count + 1] first face-vertex, scratch
    uint8_t *face_dropped; // [face_count], scratch
    uint32_t dropped_count;
    bool has_broken_points; // some point is not finite
    CohortMeshDesc
        reachable; // the description with points out of reach as NaN, where there are some
    CoPrimvarSource *sources;
    uint32_t source_count;
} CoMeshBuild;

#define CO_MESH_CHECK(build, cond, code, ...) \
    do { \
        if (!(cond)) \
            return co_mesh_fail((build), CO_HERE, (code), __VA_ARGS__); \
    } while (0)
#define CO_MESH_CHECK_MEMORY(build, ptr) \
    CO_MESH_CHECK(build, (ptr) != NULL, COHORT_ERROR_OUT_OF_MEMORY, \
                  "out of memory while tessellating")

// Records a failure that names the prim; returns false.
bool co_mesh_fail(CoMeshBuild *build, const char *where, CohortErrorCode code, const char *format,
                  ...) __attribute__((format(printf, 4, 5)));
void co_mesh_warn(CoMeshBuild *build, const char *format, ...)
    __attribute__((format(printf, 2, 3)));

static inline void *co_mesh_keep(CoMeshBuild *build, size_t count, size_t size)
{
    return co_mesh_block_alloc(&build->shading->blocks, count, size);
}

static inline void *co_mesh_scratch(CoMeshBuild *build, size_t count, size_t size)
{
    return co_mesh_block_alloc(&build->scratch, count, size);
}

// mesh_check.c: validates the description, fills face_first and face_dropped, counts Ptex faces.
bool co_mesh_check(CoMeshBuild *build);
// True when the face uses a point that is not finite.
bool co_mesh_face_is_broken(const CoMeshBuild *build, size_t face);

// mesh_material.c: materials by face: the first subset that lists a face has it.
bool co_mesh_build_materials(CoMeshBuild *build);

// polygon.c: triangles, points and normals of a polygon mesh.
bool co_mesh_build_polygons(CoMeshBuild *build);

// subdivide.c: limit points, triangles, normals and refined primvars of a subdivision surface.
bool co_mesh_build_subdivision(CoMeshBuild *build);

// primvar.c: checks the primvars of the description (build->sources), then copies what needs no
// refinement; polygon meshes copy all.
bool co_mesh_check_primvars(CoMeshBuild *build);
bool co_mesh_copy_primvars(CoMeshBuild *build);
uint32_t co_primvar_element_count(const CoMeshBuild *build, CohortInterpolation interpolation);
// Value number of an element of the description, which passed its checks.
static inline size_t co_primvar_desc_value(const CohortPrimvarDesc *desc, size_t element)
{
    return desc->indices ? (size_t)desc->indices[element] : element;
}
// Value of a primvar at barycentrics, `components` floats.
void co_primvar_eval(const CoMesh *mesh, const CoPrimvar *primvar, uint32_t tri, float u, float v,
                     float *out);

#endif
