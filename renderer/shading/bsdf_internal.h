// What the makers of BSDFs share.

#ifndef CO_SHADING_BSDF_INTERNAL_H
#define CO_SHADING_BSDF_INTERNAL_H

#include "shading/bsdf.h"

// Sets s, t, n and ng from any normals, zero and not finite ones included.
void co_bsdf_set_frame(CoBsdf *bsdf, CoVec3 ns, CoVec3 ng, CoVec3 wo);

// Sets `reflected` and the lobe probabilities from the lobes' reflectances towards wo; last.
void co_bsdf_set_selection(CoBsdf *bsdf, CoVec3 wo);

#endif
