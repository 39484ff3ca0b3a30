// A committed mesh: tessellated once, points shared by index, with what shading asks of it.
//
// A mesh is tessellated from a CohortMeshDesc: subdivision surfaces through OpenSubdiv, uniformly
// or by edges of their own levels (each limit vertex evaluated once, edge interiors once in one
// direction, then face interiors), polygons triangulated. Triangles are numbered in face order: all
// of face 0, then face 1 ... so "tri" orders like (face, sub-triangle).
// Space: object. Threads: read-only after creation.

#ifndef CO_GEOMETRY_MESH_H
#define CO_GEOMETRY_MESH_H

#include "cohort/scene.h"
#include "geometry/patch.h"
#include "math/vec.h"

// Public to the accel room; the rest is private to geometry.
typedef struct CoMesh {
    const float *points;         // [point_count * 3], finite
    const uint32_t *indices;     // [tri_count * 3] into points, wound as authored; or
    const CoPatchTable *patches; // of subdivided meshes, which have no indices; else NULL
    uint32_t point_count, tri_count;
    uint32_t face_count;      // faces of the cage
    uint32_t ptex_face_count; // Ptex faces of the cage (n-gons count n times)
    CoVec3 box_min, box_max;
    bool is_flat;                  // of polygons, in one plane but for what points are rounded by
    size_t bytes;                  // all memory of the mesh
    struct CoMeshShading *shading; // private to geometry
} CoMesh;

// The three points of a triangle.
static inline void co_mesh_triangle(const CoMesh *mesh, uint32_t tri, uint32_t out[3])
{
    if (mesh->patches) {
        co_patch_triangle(mesh->patches, tri, out);
        return;
    }
    for (size_t c = 0; c < 3; c++)
        out[c] = mesh->indices[3 * (size_t)tri + c];
}

// Called for things repaired on the way; text lives for the call.
typedef void CoMeshWarnFn(void *cookie, const char *text);

// Tessellates. False with the reason when the description cannot be rendered (desc->path named).
// Non-finite points drop the faces that use them, with a warning. An empty mesh is fine (0
// triangles).
bool co_mesh_create(const CohortMeshDesc *desc, CoMesh *out, CoMeshWarnFn *warn, void *cookie,
                    CohortError *err);
void co_mesh_destroy(CoMesh *mesh);

// Where most bytes of a mesh go: what is left of mesh->bytes are primvars mostly.
typedef struct CoMeshMemory {
    size_t points, topology, normals; // topology: indices or patches
} CoMeshMemory;
void co_mesh_memory(const CoMesh *mesh, CoMeshMemory *out);

// Whether two meshes have the same triangles between the same points, wherever those are.
bool co_mesh_same_topology(const CoMesh *a, const CoMesh *b);

// What a hit point looks like, object space.
typedef struct CoSurface {
    CoVec3 p;       // on the triangle
    CoVec3 p_error; // bound of |computed - exact| per axis
    float reach;   // a ray that starts closer to the triangle than this may meet it again: error of
                   // the triangle test, which grows with the triangle
    CoVec3 start;  // p drawn in from the triangle's edges by a few times reach: where rays leave.
                   // From the very edge they could leave through the neighbor, at t = 0
    CoVec3 ng;     // unit geometric normal of the triangle, outward by the mesh's orientation
    CoVec3 ns;     // unit shading normal: limit normal, authored normals, or ng
    uint32_t face; // face of the cage
    uint32_t material;           // of the subset or the mesh
    uint32_t ptex_face;          // including ptex_face_offset
    float ptex_u, ptex_v;        // in that Ptex face
    CoVec3 ptex_dpdu, ptex_dpdv; // derivative of p by them
} CoSurface;

// Where a triangle lies in its cage face; grid.h finds it.
typedef struct CoGridPlace {
    uint32_t face;
    uint32_t valence;    // vertices of the face
    uint32_t patch;      // quad grids
    uint32_t sub;        // sub-quad or fan triangle, 0 in whole faces
    uint32_t n;          // squares (or loop triangles) a side; 0 in fans and polygons
    uint32_t i[3], j[3]; // grid point of each corner
} CoGridPlace;

// What all points of a triangle share: made once for hits that follow each other on it.
typedef struct CoTriangle {
    const CoMesh *mesh;
    uint32_t tri, material;
    CoGridPlace place;
    CoVec3 p[3], center;
    CoVec3 ng;   // as in CoSurface
    float reach; // as in CoSurface
} CoTriangle;
void co_triangle_make(const CoMesh *mesh, uint32_t tri, CoTriangle *out);

// (u, v): barycentrics of corners 1 and 2 of the triangle. All but the Ptex part.
void co_triangle_surface(const CoTriangle *triangle, float u, float v, CoSurface *out);

// Whether a triangle of a flat mesh is huge against `size`, the largest coordinate of rays that
// leave it: then the ray that met it knows better than barycentrics where that was. Not of others:
// near an edge they are left at a distance that covers which of two triangles is met.
bool co_triangle_is_vast(const CoTriangle *triangle, float size);

// Moves a surface there to the foot of q, object space.
void co_triangle_settle(const CoTriangle *triangle, const double q[3], float size, CoSurface *out);

// The Ptex part, of a surface that has the rest.
void co_triangle_ptex(const CoTriangle *triangle, float u, float v, CoSurface *out);

// All of it at once.
void co_mesh_surface(const CoMesh *mesh, uint32_t tri, float u, float v, CoSurface *out);

// Face of the cage a triangle lies in, and the material of a face (of its subset, or the mesh's).
uint32_t co_mesh_tri_face(const CoMesh *mesh, uint32_t tri);
uint32_t co_mesh_face_material(const CoMesh *mesh, uint32_t face);

// Index of a primvar by name, -1 if the mesh has none such.
int co_mesh_primvar_find(const CoMesh *mesh, const char *name);

// Value of a primvar; missing components are 0 (alpha 1).
void co_mesh_primvar(const CoMesh *mesh, int primvar, uint32_t tri, float u, float v, float out[4]);

// A 2-component primvar as texture coordinates with dp/ds and dp/dt over the triangle (zero vectors
// where the parametrisation is degenerate).
typedef struct CoTexCoord {
    float s, t;
    CoVec3 dpds, dpdt;
} CoTexCoord;
void co_mesh_texcoord(const CoMesh *mesh, int primvar, uint32_t tri, float u, float v,
                      CoTexCoord *out);

// UsdGeom's implicit shapes, made into meshes by implicit.h.
typedef enum CoImplicit {
    CO_IMPLICIT_SPHERE = 0,
    CO_IMPLICIT_CUBE,
    CO_IMPLICIT_CONE,
    CO_IMPLICIT_CYLINDER,
    CO_IMPLICIT_CAPSULE,
    CO_IMPLICIT_PLANE
} CoImplicit;

#endif
