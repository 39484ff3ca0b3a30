#include "rays/schedule.h"

#define ROUND_SECONDS 10.0

CoScheduleStep co_schedule_next(CoRayBins *bins, bool has_camera_rays, CoRayRecords *out,
                                CohortError *err)
{
    if (!co_ray_bins_flush(bins, err) || !co_ray_bins_pop(bins, out, err))
        return CO_SCHEDULE_FAILED;
    if (out->count > 0)
        return CO_SCHEDULE_BATCH;
    if (has_camera_rays)
        return CO_SCHEDULE_CAMERA;
    if (!co_ray_bins_drain(bins, out, err))
        return CO_SCHEDULE_FAILED;
    return out->count > 0 ? CO_SCHEDULE_BATCH : CO_SCHEDULE_DONE;
}

uint64_t co_schedule_round(uint64_t taken, uint64_t target, uint64_t pixels, uint64_t last,
                           double seconds)
{
    if (taken >= target)
        return 0;
    uint64_t samples = last == 0 ? 1 : last;
    if (last > 0 && taken > last && seconds * 2.0 <= ROUND_SECONDS)
        samples = last * 2;
    uint64_t most = ((uint64_t)1 << 32) / pixels;
    if (most == 0)
        most = 1;
    if (samples > most)
        samples = most;
    return samples < target - taken ? samples : target - taken;
}
