// A stage given as text, brought to a recording renderer through the adapter. One at a time.

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

extern StageFixture stage;

// Opens and syncs a stage of which `body` is what follows "#usda 1.0". To be short, a statement may
// end with ';' instead of a line, $triangle stands for the topology and points of a triangle, and
// $at(x,y,z) for a translation by that. options NULL: none. False with *err set when anything
// fails.
bool try_stage(const char *body, const CohortAdapterOptions *options, CohortError *err);

// The same; the test fails with it.
void open_stage(const char *body);
void open_stage_with(const char *body, const CohortAdapterOptions *options);

// A teardown. Asserts that nothing of the delegate is left in memory.
int close_stage(void **state);

// Executes a pass with a color buffer of a size and waits for its end, so that the camera is set.
void render_stage(uint32_t width, uint32_t height);

// The recorded object of a mesh by path, NULL if there is none.
const FakeObject *fake_mesh(const char *path);

// The instance in the root group whose object is the mesh at a path, NULL if there is none.
const CohortInstanceDesc *root_instance(const char *path);

// Whether it is there and its origin so.
bool is_at(const CohortInstanceDesc *instance, double x, double y, double z);

// Whether the report has an entry for that prim and name.
bool is_reported(const char *prim_path, const char *name);

#endif
