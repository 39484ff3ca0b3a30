// Pulling dirty prims from their scene delegates into the renderer's scene.
//
// Each function pulls one prim and edits the scene; the render must be down. What cannot be used is
// reported and left out: they return false only when memory is at an end.

#ifndef CO_DELEGATE_SYNC_H
#define CO_DELEGATE_SYNC_H

#include "index/index.h"

// The sample at time 0, else the nearest; the earlier of two as near.
size_t co_sync_nearest(const double *first_time, size_t count, size_t stride);

// Reports why a prim was left out and returns whether the sync may go on: not when memory is at an
// end, be it for another reason that the host left it out.
bool co_sync_refuse(CohortRenderIndex *index, const CoPrim *prim, const CohortPull *pull,
                    const char *what, CohortError *reason, CohortError *err);

// Before a prim is pulled: what was lost for want of memory until then was said.
void co_sync_begin(CohortRenderIndex *index, const CoPrim *prim);

// Whether nothing that was pulled of it since, or said of it, was lost.
bool co_sync_is_whole(CohortRenderIndex *index, const CoPrim *prim, const CohortPull *pull,
                      CohortError *err);

// Pulls transform and visibility if their bits are set; *changed is raised when one differs.
bool co_sync_placement(CohortRenderIndex *index, CoPrim *prim, CohortPull *pull, bool *changed,
                       CohortError *err);

bool co_sync_material(CohortRenderIndex *index, CoPrim *prim, CohortPull *pull, CohortError *err);
bool co_sync_mesh(CohortRenderIndex *index, CoPrim *prim, CohortPull *pull, CohortError *err);
bool co_sync_light(CohortRenderIndex *index, CoPrim *prim, CohortPull *pull, CohortError *err);
bool co_sync_camera(CohortRenderIndex *index, CoPrim *prim, CohortPull *pull, CohortError *err);

// Sets the groups of all dirty containers.
bool co_sync_groups(CohortRenderIndex *index, CohortError *err);

// The renderer's camera for an image of a size (pixels), after the conform policy. Padding of *out
// is zeroed: equal cameras are equal bytes.
void co_camera_desc(const CoPrim *prim, const CohortRenderPassState *state, uint32_t width,
                    uint32_t height, CohortCameraDesc *out);

// The texture of the scene for a description; equal ones are one. INVALID when it cannot be made.
uint32_t co_sync_texture(CohortRenderIndex *index, const CohortTextureDesc *desc, CohortError *err);

#endif
