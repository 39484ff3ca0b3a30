// Subdivision levels by size on screen (Cook, Carpenter, Catmull, "The Reyes Image Rendering
// Architecture", 1987): each edge of a cage is as fine as its length in pixels asks for, where it
// comes nearest to the camera, and a face inside as where it does itself: in the placement where
// that is most. Of more than CO_DICING_PLACES the others count by a bound of how large they are
// seen. What is not in the picture is coarser.
//
// Levels are a function of camera, image size, placements and cages: never of what was rendered
// before. An edge has one level whatever the faces beside it have, so neighbors cannot come apart.

#ifndef CO_DELEGATE_DICING_H
#define CO_DELEGATE_DICING_H

#include "index/index.h"

// Views of the camera that the scene was last set to, for an image `width` pixels wide. Marks the
// meshes that are seen otherwise than when they were last set; they must be pulled again. Does
// nothing when the edge length is 0.
bool co_dicing_update(CohortRenderIndex *index, uint32_t width, CohortError *err);

// Notes where the cage of a mesh lies.
void co_dicing_measure(CoPrim *prim, const CohortMeshDesc *desc);

// Gives a description the levels of its edges and faces; none to meshes that have not been looked
// at yet. The arrays are the pull's. False when out of memory.
bool co_dicing_set_levels(const CohortRenderIndex *index, const CoPrim *prim, CohortPull *pull,
                          CohortMeshDesc *desc);

void co_dicing_clear(CoDicing *dicing);

// Private to dicing.c and dicing_levels.c. Pixels that a unit of length across the line of sight
// is, so far from the camera.
double co_dicing_pixels_at(const CoDicing *d, double distance);
void co_dicing_to_world(const double m[4][4], const double p[3], double out[3]);
// 1, or less where a sphere (world) lies outside of the picture.
double co_dicing_share(const CoDicing *d, const double center[3], double radius);

#endif
