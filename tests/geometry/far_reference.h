// OpenSubdiv's other way to the limit surface, for tests: refinement down to level 10 and a patch
// table (Far), in double. The renderer goes through Bfr, in float.

#ifndef TEST_FAR_REFERENCE_H
#define TEST_FAR_REFERENCE_H

#include "cohort/scene.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct FarReference FarReference;

// Of a description that OpenSubdiv takes whole. NULL when it does not.
FarReference *far_reference_create(const CohortMeshDesc *desc);
void far_reference_destroy(FarReference *reference);

// Limit position at (u, v) of sub-face `sub` of a face, numbered as Ptex does. False where there is
// no surface.
bool far_reference_limit(const FarReference *reference, uint32_t face, uint32_t sub, double u,
                         double v, double out[3]);

#ifdef __cplusplus
}
#endif

#endif
