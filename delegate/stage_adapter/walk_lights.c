// Lights of a stage: those of native instances are the world's, those of PointInstancers are named.

#include "stage_adapter/walk.h"

#include <string.h>

bool co_is_light_type(const char *type)
{
    static const char *const types[] = {"RectLight", "DiskLight",   "SphereLight", "DistantLight",
                                        "DomeLight", "DomeLight_1", NULL};
    for (const char *const *t = types; *t; t++)
        if (strcmp(type, *t) == 0)
            return true;
    return false;
}

bool co_walk_add_light(CoWalk *walk, CoPlace place)
{
    CohortAdapter *a = walk->adapter;
    CoRecord record = {.kind = CO_RECORD_LIGHT,
                       .path = cohort_prim_path(place.prim),
                       .prim = place.prim,
                       .prototype = place.prototype};
    a->light_count++;
    return co_record_add(a, &record, COHORT_PRIM_LIGHT, walk->err) != NULL;
}

bool co_walk_has_lights(CohortAdapter *a, const CohortPrim *prim)
{
    if (co_is_light_type(cohort_prim_type(prim)))
        return true;
    if (co_is_point_instancer(prim))
        return false; // reported with it
    const CohortPrim *shown = cohort_prim_is_instance(prim) ? cohort_prim_prototype(prim) : NULL;
    uint32_t known =
        shown ? co_string_map_find(&a->lights_below, cohort_prim_path(shown)) : COHORT_INVALID_ID;
    if (known != COHORT_INVALID_ID)
        return known != 0;
    bool found = false;
    size_t children = cohort_prim_child_count(prim);
    for (size_t i = 0; i < children && !found; i++)
        found = co_walk_has_lights(a, cohort_prim_child(prim, i));
    if (shown)
        co_string_map_set(&a->lights_below, cohort_prim_path(shown), found);
    return found;
}

bool co_walk_lights(CoWalk *walk, CoPlace place)
{
    if (co_is_never_visible(walk->adapter, place.prim) || co_is_point_instancer(place.prim))
        return true;
    if (co_is_light_type(cohort_prim_type(place.prim)) && !co_walk_add_light(walk, place))
        return false;
    const CohortPrim *parent = place.prim;
    if (cohort_prim_is_instance(place.prim)) {
        if (!co_walk_has_lights(walk->adapter, place.prim))
            return true;
        CoPrototype unshared = {.is_native = true,
                                .root = cohort_prim_prototype(place.prim),
                                .anchor = place.prim,
                                .outer = place.prototype};
        parent = unshared.root;
        place.prototype = co_walk_add_prototype(walk, &unshared, NULL);
        if (place.prototype == COHORT_INVALID_ID)
            return false;
    }
    size_t children = cohort_prim_child_count(parent);
    for (size_t i = 0; i < children; i++)
        if (!co_walk_lights(walk, (CoPlace){cohort_prim_child(parent, i), place.prototype}))
            return false;
    return true;
}

void co_walk_report_lights(CohortAdapter *a, const CohortPrim *prim)
{
    if (co_is_never_visible(a, prim) || co_is_point_instancer(prim))
        return;
    if (co_is_light_type(cohort_prim_type(prim)))
        co_adapter_report(a, prim, cohort_prim_type(prim), "",
                          "a light in a PointInstancer's prototype: left out");
    if (cohort_prim_is_instance(prim)) {
        if (co_walk_has_lights(a, prim))
            co_adapter_report(a, prim, "instance", "",
                              "its lights are in a PointInstancer's prototype: left out");
        return;
    }
    size_t children = cohort_prim_child_count(prim);
    for (size_t i = 0; i < children; i++)
        co_walk_report_lights(a, cohort_prim_child(prim, i));
}
