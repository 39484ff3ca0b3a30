#include "base/log.h"

#include <pthread.h>
#include <stdarg.h>
#include <stdio.h>

static struct {
    CohortLogFn *fn;
    void *cookie;
    CohortSeverity most_detailed;
    pthread_mutex_t lock;
} sink = {.lock = PTHREAD_MUTEX_INITIALIZER};

void cohort_log_set(CohortLogFn *fn, void *cookie, CohortSeverity most_detailed)
{
    sink.fn = fn;
    sink.cookie = cookie;
    sink.most_detailed = most_detailed;
}

const char *cohort_version(void)
{
    return COHORT_VERSION;
}

void co_log(const char *channel, CohortSeverity severity, const char *format, ...)
{
    if (!sink.fn || severity > sink.most_detailed)
        return;
    char text[1024];
    va_list args;
    va_start(args, format);
    vsnprintf(text, sizeof text, format, args);
    va_end(args);
    pthread_mutex_lock(&sink.lock);
    sink.fn(sink.cookie, channel, severity, text);
    pthread_mutex_unlock(&sink.lock);
}
