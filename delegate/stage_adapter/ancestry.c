// What a prim has from those above it, through prototypes: transform, visibility.

#include "stage_adapter/adapter.h"

#include <math.h>
#include <string.h>

bool co_place_up(const CohortAdapter *adapter, CoPlace *place)
{
    const CohortPrim *parent = cohort_prim_parent(place->prim);
    if (!parent || !cohort_prim_parent(parent))
        return false; // the pseudo-root has nothing to inherit
    if (place->prototype != CO_WORLD) {
        const CoPrototype *p = &adapter->prototypes[place->prototype];
        if (p->is_native && parent == p->root) {
            place->prim = p->anchor;
            place->prototype = p->outer;
            return true;
        }
        // Above its target, the prims of a PointInstancer's prototype stand where the target does.
        if (!p->is_native && place->prim == p->root)
            place->prototype = p->outer;
    }
    place->prim = parent;
    return true;
}

bool co_place_left_native(const CohortAdapter *adapter, uint32_t inside, CoPlace place)
{
    return place.prototype != inside && adapter->prototypes[inside].is_native;
}

// Like co_place_up, but ends at the root of the prototype.
static bool up_within(const CohortAdapter *adapter, CoPlace *place)
{
    if (place->prototype != CO_WORLD) {
        const CoPrototype *p = &adapter->prototypes[place->prototype];
        if (!p->is_native && place->prim == p->root)
            return false;
    }
    uint32_t inside = place->prototype;
    return co_place_up(adapter, place) && place->prototype == inside;
}

typedef bool UpFn(const CohortAdapter *adapter, CoPlace *place);

static CoMat4d transform_to(const CohortAdapter *adapter, CoPlace place, UpFn *up)
{
    CoMat4d total = co_mat4d_identity();
    do {
        CoMat4d local;
        bool resets = false;
        if (cohort_prim_local_transform(place.prim, adapter->time, local.m, &resets))
            total = co_mat4d_mul(&total, &local);
        if (resets)
            break;
    } while (up(adapter, &place));
    return total;
}

CoMat4d co_place_transform(const CohortAdapter *adapter, CoPlace place)
{
    return transform_to(adapter, place, up_within);
}

CoMat4d co_place_world_transform(const CohortAdapter *adapter, CoPlace place)
{
    return transform_to(adapter, place, co_place_up);
}

bool co_is_imageable(const CohortPrim *prim)
{
    return cohort_prim_type(prim)[0] != '\0';
}

static bool is_visible_to(const CohortAdapter *adapter, CoPlace place, UpFn *up)
{
    do {
        if (co_is_imageable(place.prim) &&
            strcmp(cohort_prim_token(place.prim, "visibility", adapter->time, "inherited"),
                   "invisible") == 0)
            return false;
    } while (up(adapter, &place));
    return true;
}

bool co_place_is_visible(const CohortAdapter *adapter, CoPlace place)
{
    return is_visible_to(adapter, place, up_within);
}

bool co_place_is_visible_in_world(const CohortAdapter *adapter, CoPlace place)
{
    return is_visible_to(adapter, place, co_place_up);
}

bool co_place_varies(const CohortAdapter *adapter, CoPlace place, const char *prefix)
{
    do {
        size_t count = cohort_prim_property_count(place.prim);
        for (size_t i = 0; i < count; i++) {
            const char *name = cohort_prim_property_name(place.prim, i);
            const double *times;
            if (co_starts_with(name, prefix) && cohort_prim_time_samples(place.prim, name, &times))
                return true;
        }
    } while (co_place_up(adapter, &place));
    return false;
}
