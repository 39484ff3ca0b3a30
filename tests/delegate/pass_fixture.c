#include "pass_fixture.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <string.h>

#include <cmocka.h>

CohortRenderPass *pass;
CohortRenderBuffer *color, *ids;
CohortAovBinding bindings[2];
CohortRenderPassState pass_state;

int setup_pass(void **state)
{
    if (setup_index(state) != 0)
        return 1;
    pass = cohort_render_pass_create(render_index, NULL);
    color = cohort_render_buffer_create(delegate, 4, 3, COHORT_FORMAT_FLOAT32_VEC4, NULL);
    ids = cohort_render_buffer_create(delegate, 4, 3, COHORT_FORMAT_INT32, NULL);
    bindings[0] = (CohortAovBinding){"color", color};
    bindings[1] = (CohortAovBinding){"primId", ids};
    pass_state =
        (CohortRenderPassState){.camera = "/camera", .bindings = bindings, .binding_count = 2};
    return !cohort_render_index_insert(render_index, COHORT_PRIM_CAMERA, "/camera", &host.scene,
                                       NULL, 0, NULL) ||
           !cohort_render_index_insert(render_index, COHORT_PRIM_MESH, "/mesh", &host.scene, NULL,
                                       0, NULL);
}

int teardown_pass(void **state)
{
    int failures = teardown_index(state);
    assert_int_equal(fake.renders_live, 0);
    assert_int_equal(fake.edits_during_render, 0);
    return failures;
}

void execute_pass(void)
{
    CohortError err = {0};
    assert_true(cohort_render_pass_execute(pass, &pass_state, &err));
}

CohortStat stat_of(const char *key)
{
    CohortStat stats[32];
    size_t count = cohort_delegate_stats(delegate, stats, 32);
    for (size_t i = 0; i < count; i++)
        if (strcmp(stats[i].key, key) == 0)
            return stats[i];
    fail_msg("no statistic %s", key);
    return stats[0];
}
