// A delegate by itself for tests, which must leave nothing behind.

#ifndef TEST_DELEGATE_FIXTURE_H
#define TEST_DELEGATE_FIXTURE_H

#include "cohort/delegate.h"

#include "base/memory.h"

static CohortDelegate *delegate;

static inline int setup_delegate(void **state)
{
    (void)state;
    delegate = cohort_delegate_create(NULL);
    return delegate ? 0 : 1;
}

static inline int teardown_delegate(void **state)
{
    (void)state;
    cohort_delegate_destroy(delegate);
    delegate = NULL;
    return co_memory_live(CO_MEMORY_DELEGATE) == 0 ? 0 : 1;
}

#endif
