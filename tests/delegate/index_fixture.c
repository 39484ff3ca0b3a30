#include "index_fixture.h"

#include "base/memory.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>

#include <cmocka.h>

CohortDelegate *delegate;
CohortRenderIndex *render_index;
FakeHost host;

int setup_index(void **state)
{
    (void)state;
    fake_reset();
    fake_host_init(&host);
    delegate = cohort_delegate_create(NULL);
    render_index = cohort_render_index_create(delegate, NULL);
    return render_index ? 0 : 1;
}

int teardown_index(void **state)
{
    (void)state;
    cohort_delegate_destroy(delegate);
    return co_memory_live(CO_MEMORY_DELEGATE) == 0 ? 0 : 1;
}

void insert_prim(CohortPrimType type, const char *path, const char *instancer, uint32_t prototype)
{
    assert_true(cohort_render_index_insert(render_index, type, path, &host.scene, instancer,
                                           prototype, NULL));
}

void sync_index(void)
{
    CohortError err = {0};
    if (!cohort_render_index_sync(render_index, &err))
        fail_msg("%s", err.message);
    assert_int_equal(err.code, COHORT_OK);
}
