// Statistics under Hydra's keys.

#include "base/memory.h"
#include "index/index.h"
#include "pass/render_thread.h"

#include <sys/resource.h>

static CohortSettingValue number(double value)
{
    return (CohortSettingValue){.type = COHORT_SETTING_DOUBLE, .number = value, .string = ""};
}

static CohortSettingValue integer(uint64_t value)
{
    return (CohortSettingValue){.type = COHORT_SETTING_INT,
                                .integer = value < INT64_MAX ? (int64_t)value : INT64_MAX,
                                .string = ""};
}

static CohortSettingValue text(const char *value)
{
    return (CohortSettingValue){.type = COHORT_SETTING_STRING, .string = value};
}

static uint64_t live_bytes(void)
{
    uint64_t total = 0;
    for (int tag = 0; tag < CO_MEMORY_TAG_COUNT; tag++)
        total += co_memory_live((CoMemoryTag)tag);
    return total;
}

static uint64_t peak_bytes(void)
{
    struct rusage usage;
    return getrusage(RUSAGE_SELF, &usage) == 0 ? (uint64_t)usage.ru_maxrss * 1024 : 0;
}

static const char *annotation(const CohortDelegate *delegate, const CoRenderProgress *p)
{
    if (!p->has_render)
        return "no render";
    if (p->error != COHORT_OK)
        return "failed";
    if (co_render_thread_is_done(delegate->thread))
        return "converged";
    return co_render_thread_is_running(delegate->thread) ? "rendering" : "stopped";
}

size_t cohort_delegate_stats(const CohortDelegate *delegate, CohortStat *out, size_t capacity)
{
    CoRenderProgress p;
    co_render_thread_progress(delegate->thread, &p);
    const CohortStat stats[] = {
        {"percentDone", number(100.0 * p.fraction)},
        {"fractionDone", number(p.fraction)},
        {"numCompletedSamples", integer(p.stats.samples_per_pixel)},
        {"totalClockTime", number(p.seconds)},
        {"loadClockTime", number(delegate->index ? delegate->index->load_seconds : 0.0)},
        {"totalMemory", integer(live_bytes())},
        {"peakMemory", integer(peak_bytes())},
        {"renderProgressAnnotation", text(annotation(delegate, &p))},
        {"rendererName", text("Cohort")},
        {"rendererVersion", text(cohort_version())},
        {"huskErrorStatus", integer((uint64_t)p.error)},
    };
    size_t count = sizeof stats / sizeof stats[0];
    for (size_t i = 0; i < count && i < capacity; i++)
        out[i] = stats[i];
    return count;
}

bool cohort_delegate_render_stats(const CohortDelegate *delegate, CohortRenderStats *out)
{
    CoRenderProgress p;
    co_render_thread_progress(delegate->thread, &p);
    if (p.has_render)
        *out = p.stats;
    return p.has_render;
}
