// A delegate with an index and a fake host, made anew for each test of a group. No test leaves
// memory of the delegate behind.

#ifndef COHORT_TEST_INDEX_FIXTURE_H
#define COHORT_TEST_INDEX_FIXTURE_H

#include "fake_host.h"
#include "fake_renderer.h"

extern CohortDelegate *delegate;
extern CohortRenderIndex *render_index;
extern FakeHost host;

// The setup and teardown of cmocka_unit_test_setup_teardown; not 0: failed.
int setup_index(void **state);
int teardown_index(void **state);

// Inserts a prim of the host; instancer NULL: drawn by itself.
void insert_prim(CohortPrimType type, const char *path, const char *instancer, uint32_t prototype);

// Syncs, which must succeed.
void sync_index(void);

#endif
