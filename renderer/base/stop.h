// A wish to stop: an int of the host's that any thread or signal handler makes other than 0, and
// that long work looks at now and then.

#ifndef CO_BASE_STOP_H
#define CO_BASE_STOP_H

#include "base/error.h"

// Whether the flag is up. NULL never is.
static inline bool co_is_stopped(const volatile int *stop)
{
    return stop && __atomic_load_n(stop, __ATOMIC_RELAXED) != 0;
}

// Leaves the function with `false` and COHORT_ERROR_CANCELLED when the flag is up.
#define CO_CHECK_STOP(stop, err) \
    CO_CHECK(!co_is_stopped(stop), err, COHORT_ERROR_CANCELLED, "stopped")

#endif
