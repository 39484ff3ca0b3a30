// Which material each face has.

#include "geometry/grid.h"
#include "geometry/mesh_internal.h"

bool co_mesh_build_materials(CoMeshBuild *build)
{
    const CohortMeshDesc *desc = build->desc;
    build->shading->material = desc->material;
    if (desc->subset_count == 0)
        return true;
    CO_MESH_CHECK(build, desc->subsets, COHORT_ERROR_ARGUMENT, "subsets are missing");
    uint32_t *material = co_mesh_keep(build, desc->face_count, sizeof *material);
    uint8_t *taken = co_mesh_scratch(build, desc->face_count, 1);
    CO_MESH_CHECK_MEMORY(build, material);
    CO_MESH_CHECK_MEMORY(build, taken);
    for (size_t f = 0; f < desc->face_count; f++)
        material[f] = desc->material;
    size_t bad = 0, twice = 0;
    for (size_t s = 0; s < desc->subset_count; s++) {
        const CohortSubsetDesc *subset = &desc->subsets[s];
        CO_MESH_CHECK(build, subset->faces || subset->face_count == 0, COHORT_ERROR_ARGUMENT,
                      "subset %zu has no face array", s);
        for (size_t k = 0; k < subset->face_count; k++) {
            int32_t face = subset->faces[k];
            if (face < 0 || (size_t)face >= desc->face_count) {
                bad++;
                continue;
            }
            twice += taken[face] && material[face] != subset->material;
            if (!taken[face])
                material[face] = subset->material;
            taken[face] = 1;
        }
    }
    if (bad)
        co_mesh_warn(build, "%zu subset faces are out of range and ignored", bad);
    if (twice)
        co_mesh_warn(build, "%zu faces are in several subsets: the first one counts", twice);
    build->shading->face_material = material;
    return true;
}

uint32_t co_mesh_tri_face(const CoMesh *mesh, uint32_t tri)
{
    return co_grid_face(mesh->shading, tri);
}

uint32_t co_mesh_face_material(const CoMesh *mesh, uint32_t face)
{
    const CoMeshShading *s = mesh->shading;
    return s->face_material ? s->face_material[face] : s->material;
}
