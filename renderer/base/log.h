// Messages for people, by room. Silent until the program sets a sink (cohort_log_set).

#ifndef CO_BASE_LOG_H
#define CO_BASE_LOG_H

#include "cohort/base.h"

// Sends one formatted line to the sink. Threads: any.
void co_log(const char *channel, CohortSeverity severity, const char *format, ...)
    __attribute__((format(printf, 3, 4)));

#endif
