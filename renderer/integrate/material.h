// What materials ask of textures at a hit, and what they make of the answers.

#ifndef CO_INTEGRATE_MATERIAL_H
#define CO_INTEGRATE_MATERIAL_H

#include "integrate/scene_data.h"
#include "shading/bsdf.h"

// A hit on its way through shading.
typedef struct CoShadeHit {
    const CoMesh *mesh;
    uint32_t tri;
    float u, v;
    CoSurface surface;        // object space
    const float (*texels)[4]; // one per lookup of the material, before scale and bias
} CoShadeHit;

// A row-major 3x3 times a color.
static inline CoVec3 co_color_apply(const float m[9], CoVec3 c)
{
    return co_vec3(m[0] * c.x + m[1] * c.y + m[2] * c.z, m[3] * c.x + m[4] * c.y + m[5] * c.z,
                   m[6] * c.x + m[7] * c.y + m[8] * c.z);
}

// The texture lookup one node makes at a hit. width: footprint diameter on the surface, object
// space, 0 = full resolution.
void co_material_lookup(const CohortScene *scene, const CoLookupSource *source, const CoMesh *mesh,
                        uint32_t tri, float u, float v, const CoSurface *surface, float width,
                        CoLookup *out);

void co_material_evaluate(const CoMaterial *material, const CoShadeHit *hit, CoPreviewSurface *out);
float co_material_opacity(const CoMaterial *material, const CoShadeHit *hit);

// The tangent-space normal and its frame (dpds, dpdt in object space); false: there is none.
bool co_material_normal(const CoMaterial *material, const CoShadeHit *hit, CoVec3 *n_tangent,
                        CoTexCoord *frame);

#endif
