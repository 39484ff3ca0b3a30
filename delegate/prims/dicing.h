// Subdivision levels by size on screen (Cook, Carpenter, Catmull, "The Reyes Image Rendering
// Architecture", 1987): each mesh is as fine as its longest edge of the cage asks for, where it is
// seen largest.
//
// Levels are a function of camera, image size, placements and cages: never of what was rendered
// before. One mesh has one level, so neighbors cannot come apart.

#ifndef CO_DELEGATE_DICING_H
#define CO_DELEGATE_DICING_H

#include "index/index.h"

// Views of the camera that the scene was last set to, for an image `width` pixels wide. Marks the
// meshes that are seen otherwise than when they were last set; they must be pulled again. Does
// nothing when the edge length is 0.
bool co_dicing_update(CohortRenderIndex *index, uint32_t width, CohortError *err);

// Notes where the cage of a mesh lies.
void co_dicing_measure(CoPrim *prim, const CohortMeshDesc *desc);

// The level of a mesh; 0 for those that have not been looked at yet.
uint32_t co_dicing_level(const CohortRenderIndex *index, const CoPrim *prim,
                         const CohortMeshDesc *desc);

void co_dicing_clear(CoDicing *dicing);

#endif
