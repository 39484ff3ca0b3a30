// A host with one triangle per mesh path, for tests of the index and the pass.

#ifndef COHORT_TEST_FAKE_HOST_H
#define COHORT_TEST_FAKE_HOST_H

#include "cohort/delegate.h"

typedef struct FakeHost {
    CohortSceneDelegate scene; // give this to insert
    uint64_t mesh_pulls, transform_pulls, light_pulls, camera_pulls, instancer_pulls,
        material_pulls;
    bool fail_mesh, invisible;
    double x; // translation of everything, at time 0
    const char *material;
    const CohortMaterialNetwork *network;
    CohortInstancerSource instancer;
    CohortCameraSource camera;
    double focal_length;
} FakeHost;

void fake_host_init(FakeHost *host);

#endif
