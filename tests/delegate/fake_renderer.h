// A stand-in for the renderer behind cohort/scene.h and cohort/render.h: it records what the
// delegate asks of it, renders a known pattern and fails or dawdles on request.

#ifndef COHORT_TEST_FAKE_RENDERER_H
#define COHORT_TEST_FAKE_RENDERER_H

#include "cohort/render.h"
#include "cohort/scene.h"

enum {
    FAKE_MAX = 256,
    FAKE_PATH = 128
};

typedef struct FakePrimvar {
    char name[32];
    CohortInterpolation interpolation;
    uint32_t components;
    size_t value_count, index_count;
    float first[4]; // value
} FakePrimvar;

typedef struct FakeObject {
    bool is_mesh, is_group;
    char path[FAKE_PATH];
    uint32_t level, material, subset_material, ptex_face_offset;
    CohortScheme scheme;
    size_t point_count, primvar_count, subset_faces;
    FakePrimvar primvars[8];
    float first_color[3]; // of displayColor
    float first_point[3];
    size_t instance_count;
    CohortInstanceDesc instances[64];
    float colors[64][3];
} FakeObject;

typedef struct FakeRenderer {
    // How it behaves.
    bool fail_set_mesh, fail_commit, fail_create, fail_round;
    long round_nanoseconds;
    uint64_t rounds_to_do;
    // What it saw.
    uint64_t saved_hash; // of the last film
    FakeObject objects[FAKE_MAX];
    uint32_t object_count, texture_count, material_count, light_count;
    CohortTextureDesc textures[FAKE_MAX];
    char texture_paths[FAKE_MAX][FAKE_PATH];
    CohortMaterialDesc materials[FAKE_MAX];
    CohortLookupDesc lookups[FAKE_MAX][16];
    CohortLightDesc lights[FAKE_MAX];
    CohortCameraDesc camera;
    CohortRenderSettings settings;
    CohortSceneCounts counts;
    uint64_t set_mesh_calls, set_group_calls, set_light_calls, set_material_calls, set_camera_calls,
        commits, renders_made, renders_live, edits_during_render, rounds_of_the_dead, saves,
        resumes;
} FakeRenderer;

extern FakeRenderer fake;

// Forgets everything; three quick rounds to do.
void fake_reset(void);

#endif
