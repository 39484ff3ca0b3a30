// Lights, with transform and visibility.

#include "base/error.h"
#include "prims/sync.h"

#include <string.h>

bool co_sync_light(CohortRenderIndex *index, CoPrim *prim, CohortPull *pull, CohortError *err)
{
    if (prim->id == COHORT_INVALID_ID)
        prim->id = cohort_scene_new_light(index->scene, err);
    if (prim->id == COHORT_INVALID_ID)
        return false;
    bool changed = (prim->dirty &
                    (COHORT_DIRTY_PARAMS | COHORT_DIRTY_RESOURCE | COHORT_DIRTY_VISIBILITY)) != 0;
    if (!co_sync_placement(index, prim, pull, &changed, err))
        return false;
    if (!changed)
        return true;
    CohortError reason = {0};
    CohortLightDesc desc = cohort_light_default(COHORT_LIGHT_SPHERE);
    bool given = prim->scene->get_light &&
                 prim->scene->get_light(prim->scene->cookie, pull, prim->path, &desc, &reason);
    if (!given) {
        desc = cohort_light_default(COHORT_LIGHT_SPHERE);
        desc.hidden = true;
    }
    desc.path = prim->path;
    memcpy(desc.transform, prim->transform, sizeof desc.transform);
    desc.hidden = !given || !prim->is_visible || prim->is_nowhere ||
                  !index->delegate->settings.values[CO_SETTING_ENABLE_SCENE_LIGHTS].boolean;
    if (!index->delegate->settings.values[CO_SETTING_ENABLE_SHADOWS].boolean)
        desc.no_shadow = true;
    index->counts.lights_set++;
    index->needs_commit = true;
    if (cohort_scene_set_light(index->scene, prim->id, &desc, &reason) && given)
        return true;
    bool goes_on = co_sync_refuse(index, prim, pull, "Light", &reason, err);
    if (!goes_on)
        prim->dirty |= COHORT_DIRTY_PARAMS; // it has moved, but the next sync will not see that
    return goes_on;
}
