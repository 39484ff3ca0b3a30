// A path vertex: a hit brought into the render frame, with its material's answers.

#ifndef CO_INTEGRATE_VERTEX_H
#define CO_INTEGRATE_VERTEX_H

#include "integrate/material.h"
#include "integrate/render_data.h"

// Placement of the instance path a worker met last, and the triangle: sorted hits mostly share
// both.
typedef struct CoPlacementMemo {
    CoPlacement placement;
    CoAffine abs_to_world, abs_to_object; // for error bounds
    uint32_t instance;                    // COHORT_INVALID_ID: nothing yet
    bool has_triangle;
    CoTriangle triangle;
    CoVec3 ng; // of the triangle, render frame
    const CoMaterial *material;
    bool has_display;
    int display_primvar; // of the mesh, -1: the color below
    int opacity_primvar; // its displayOpacity, -1: opaque
    CoVec3 display;
} CoPlacementMemo;

typedef struct CoVertex {
    CoShadeHit hit;               // object space
    const CoMaterial *material;   // NULL: Lambertian with displayColor
    const CoPlacement *placement; // the memo's
    CoVec3 p, start;              // render frame; start: CoSurface.start
    CoVec3 ng, ns;                // unit, render frame, as the mesh is oriented
    CoVec3 wo;                    // towards where the ray came from
    float width;                  // footprint's diameter here, scene units
    const CoPlacementMemo *memo;
} CoVertex;

// Fills everything but hit.texels, which the caller sets before. Valid until the memo's next use.
// Of the ray, origin, width and spread are read; its direction stands in the hit.
void co_vertex_make(const CohortScene *scene, CoPlacementMemo *memo, const CoHitRecord *hit,
                    const CoRay *ray, CoVertex *out);

// Where rays that leave on the side of ng start: far enough out that they cannot meet the surface
// they leave because of rounding in the hit or in the way back into the mesh's space.
CoVec3 co_vertex_origin(const CoVertex *vertex, CoVec3 ng);

// The BSDF of the vertex; emissive receives what the surface sends towards wo.
void co_vertex_bsdf(const CohortScene *scene, const CoVertex *vertex, CoBsdf *out,
                    CoVec3 *emissive);

// Whether rays may go straight through.
bool co_vertex_may_pass(const CoVertex *vertex);

// What the surface lets straight through, 0 to 1 per channel, given its BSDF.
CoVec3 co_vertex_transmittance(const CoVertex *vertex, const CoBsdf *bsdf);

// primId of the placement: the innermost that is not -1.
int32_t co_placement_prim_id(const CohortScene *scene, const CoPlacement *placement);

#endif
