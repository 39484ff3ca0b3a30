#include "geometry/mesh_internal.h"

uint32_t co_mesh_tri_face(const CoMesh *mesh, uint32_t tri)
{
    return mesh->shading->unit_face[tri >> mesh->shading->unit_shift];
}

uint32_t co_mesh_face_material(const CoMesh *mesh, uint32_t face)
{
    const CoMeshShading *s = mesh->shading;
    return s->face_material ? s->face_material[face] : s->material;
}
