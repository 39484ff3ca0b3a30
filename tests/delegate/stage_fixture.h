// Stages given as text, brought to a recording renderer through the adapter.

#ifndef COHORT_TEST_STAGE_FIXTURE_H
#define COHORT_TEST_STAGE_FIXTURE_H

#include "cohort/stage_adapter.h"
#include "fake_renderer.h"

typedef struct StageFixture {
    CohortDelegate *delegate;
    CohortRenderIndex *index;
    CohortAdapter *adapter;
    char path[64];
} StageFixture;

// Opens `body` (after "#usda 1.0") and syncs. False with *err set when anything fails.
bool stage_fixture_open(StageFixture *f, const char *body, const CohortAdapterOptions *options,
                        CohortError *err);
// Also asserts that nothing of the delegate is left in memory.
void stage_fixture_close(StageFixture *f);

// Executes a pass with a color buffer of a size and waits for its end, so that the camera is set.
void stage_fixture_render(StageFixture *f, uint32_t width, uint32_t height);

// The recorded object of a mesh by path, NULL if there is none.
const FakeObject *fake_mesh(const char *path);

// Whether the report has an entry for that prim and name.
bool stage_fixture_reports(StageFixture *f, const char *prim_path, const char *name);

// A quad and a triangle list used by many stages: "def Mesh "name" { ... extra ... }".
#define TRIANGLE(name, extra) \
    "def Mesh \"" name "\" { int[] faceVertexCounts = [3]\n int[] faceVertexIndices = [0,1,2]\n" \
    "point3f[] points = [(0,0,0),(1,0,0),(0,1,0)]\n" extra "\n}\n"

#endif
