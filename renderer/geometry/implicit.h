// UsdGeom's implicit shapes as polygon meshes.

#ifndef CO_GEOMETRY_IMPLICIT_H
#define CO_GEOMETRY_IMPLICIT_H

#include "base/arena.h"
#include "geometry/mesh.h"

// Attributes as in UsdGeom, in scene units. What a kind has no use for is not looked at.
typedef struct CoImplicitDesc {
    CoImplicit kind;
    int axis;             // cone, cylinder, capsule, plane: 0 x, 1 y, 2 z (UsdGeom's default)
    double radius_bottom; // sphere, cone, cylinder, capsule: radius at the lower end, or everywhere
    double radius_top;    // cylinder, capsule: at the upper end; UsdGeom's first versions: the same
    double height;        // cone, cylinder; capsule: without its caps
    double size;          // cube: edge
    double width, length; // plane: along x and y; axis y: x and z; axis x: z and y
} CoImplicitDesc;

// Fills *out with a mesh of scheme none around the origin: points, faces, and the face-varying
// primvars "st" and, on curved shapes, "normals". Curved shapes have 128 sides, whose vertices lie
// on the exact surface: they stand in for it to 3e-4 of the radius. Where UsdGeom leaves it open:
// st runs around the axis and from the lower to the upper pole by arc length, caps included; on a
// plane along width and length; on a cube over each face.
//   path   for messages, becomes out->path; not copied
//   arena  owns every array of *out
// A size that is negative or not finite is refused by name; a radius of 0 all over gives no faces.
bool co_implicit_mesh(const CoImplicitDesc *desc, const char *path, CoArena *arena,
                      CohortMeshDesc *out, CohortError *err);

#endif
