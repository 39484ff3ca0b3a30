// A pass over a mesh through a camera, made anew for each test of a group.

#ifndef COHORT_TEST_PASS_FIXTURE_H
#define COHORT_TEST_PASS_FIXTURE_H

#include "index_fixture.h"

extern CohortRenderPass *pass;
extern CohortRenderBuffer *color, *ids; // 4 x 3 pixels
extern CohortAovBinding bindings[2];    // of these
extern CohortRenderPassState pass_state;

// The setup and teardown of cmocka_unit_test_setup_teardown; not 0: failed. No test leaves a render
// behind, or edits the scene while there is one.
int setup_pass(void **state);
int teardown_pass(void **state);

// Executes the pass, which must succeed.
void execute_pass(void);

// A statistic of the delegate, which must be there.
CohortStat stat_of(const char *key);

#endif
