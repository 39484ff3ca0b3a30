// Containers as groups of the scene: which meshes and instancers stand in the world or a prototype.

#include "base/error.h"
#include "math/vec.h"
#include "prims/sync.h"

#include <string.h>

// A growing list of instances.
typedef struct InstanceList {
    CohortInstanceDesc *items;
    size_t count, capacity;
} InstanceList;

static bool reserve(InstanceList *list, size_t more)
{
    if (list->capacity - list->count >= more)
        return true;
    size_t capacity =
        list->capacity * 2 > list->count + more ? list->capacity * 2 : list->count + more;
    size_t bytes;
    if (capacity < more || !co_size_mul(capacity, sizeof *list->items, &bytes))
        return false;
    CohortInstanceDesc *items =
        co_realloc(CO_MEMORY_DELEGATE, list->items, list->capacity * sizeof *items, bytes);
    if (!items)
        return false;
    list->items = items;
    list->capacity = capacity;
    return true;
}

static bool add_mesh(InstanceList *list, const CoPrim *prim)
{
    if (!prim->has_geometry || prim->is_nowhere)
        return true;
    if (!reserve(list, 1))
        return false;
    CohortInstanceDesc *d = &list->items[list->count++];
    *d = (CohortInstanceDesc){.object = prim->id,
                              .prim_id = prim->prim_id,
                              .hidden = !prim->is_visible,
                              .hidden_from = prim->hidden_from};
    memcpy(d->transform, prim->transform, sizeof d->transform);
    return true;
}

// The object of each prototype of an owner by number, INVALID where there is none. Never NULL
// unless out of memory.
static uint32_t *prototype_objects(const CohortRenderIndex *index, const char *owner_path,
                                   CohortPull *pull, size_t *count)
{
    uint32_t owner = co_string_map_find(&index->owners, owner_path);
    *count = 0;
    for (size_t c = 1; c < index->container_count; c++) // after the world
        if (index->containers[c].owner == owner && index->containers[c].prototype >= *count)
            *count = (size_t)index->containers[c].prototype + 1;
    uint32_t *objects = cohort_pull_array(pull, *count + 1, sizeof *objects);
    for (size_t i = 0; objects && i < *count; i++)
        objects[i] = COHORT_INVALID_ID;
    for (size_t c = 1; objects && c < index->container_count; c++)
        if (index->containers[c].owner == owner)
            objects[index->containers[c].prototype] = index->containers[c].object;
    return objects;
}

static void place(CohortInstanceDesc *d, const CoPrim *prim, const CohortInstancerSource *source,
                  size_t i, const double (*transform)[4])
{
    CoMat4d local, outer;
    memcpy(local.m, transform, sizeof local.m);
    memcpy(outer.m, prim->transform, sizeof outer.m);
    CoMat4d world = co_mat4d_mul(&local, &outer);
    bool has_color = source->display_colors && (!source->colored || source->colored[i]);
    *d = (CohortInstanceDesc){.prim_id = -1,
                              .hidden = !prim->is_visible || (source->hidden && source->hidden[i]),
                              .display_color = has_color ? source->display_colors + 3 * i : NULL,
                              .color_yields = source->colors_yield};
    memcpy(d->transform, world.m, sizeof d->transform);
}

static bool add_placements(const CohortRenderIndex *index, InstanceList *list, const CoPrim *prim,
                           CohortPull *pull, const CohortInstancerSource *source, CohortError *err)
{
    if (source->instance_count == 0)
        return true;
    CO_CHECK(source->sample_count && source->samples[0].transforms, err, COHORT_ERROR_SCENE,
             "the instancer counts %zu instances but gives no transforms", source->instance_count);
    size_t prototype_count;
    const char *owner = source->prototype_owner ? source->prototype_owner : prim->path;
    uint32_t *objects = prototype_objects(index, owner, pull, &prototype_count);
    CO_CHECK(objects && reserve(list, source->instance_count), err, COHORT_ERROR_OUT_OF_MEMORY,
             "out of memory");
    const CohortInstancesSample *sample = &source->samples[co_sync_nearest(
        &source->samples[0].time, source->sample_count, sizeof *source->samples)];
    for (size_t i = 0; i < source->instance_count; i++) {
        uint32_t prototype = source->prototypes ? source->prototypes[i] : 0;
        uint32_t object = prototype < prototype_count ? objects[prototype] : COHORT_INVALID_ID;
        if (object == COHORT_INVALID_ID)
            continue;
        CohortInstanceDesc *d = &list->items[list->count++];
        place(d, prim, source, i, sample->transforms[i]);
        d->object = object;
    }
    return true;
}

static bool add_instancer(CohortRenderIndex *index, InstanceList *list, const CoPrim *prim,
                          CohortPull *pull, CohortError *err)
{
    CohortError reason = {0};
    CohortInstancerSource source = {0};
    co_sync_begin(index, prim);
    if (prim->scene->get_instancer &&
        prim->scene->get_instancer(prim->scene->cookie, pull, prim->path, &source, &reason) &&
        add_placements(index, list, prim, pull, &source, &reason))
        return co_sync_is_whole(index, prim, pull, err);
    return co_sync_refuse(index, prim, pull, "PointInstancer", &reason, err);
}

// Collects what stands in a container and sets its group. The pull's memory holds the instances'
// colors until the group is set.
static bool set_group(CohortRenderIndex *index, CoContainer *container, CoPrim *const *members,
                      InstanceList *list, CohortError *err)
{
    CohortPull pull = {.arena = {.tag = CO_MEMORY_DELEGATE}};
    list->count = 0;
    co_report_begin(&index->delegate->report);
    bool ok = true;
    for (size_t i = 0; ok && i < container->member_count; i++) {
        const CoPrim *prim = members[container->member_begin + i];
        if (prim->type == COHORT_PRIM_MESH)
            ok = add_mesh(list, prim) || CO_FAIL(err, COHORT_ERROR_OUT_OF_MEMORY, "out of memory");
        else if (!prim->is_nowhere)
            ok = add_instancer(index, list, prim, &pull, err);
    }
    CohortError reason = {0};
    if (ok && !cohort_scene_set_group(index->scene, container->object, list->items, list->count,
                                      &reason)) {
        const CoPrim *first = members[container->member_begin];
        ok = co_sync_refuse(index, first, &pull, "group", &reason, err);
        cohort_scene_clear_object(index->scene, container->object);
    }
    co_arena_clear(&pull.arena);
    co_report_end(&index->delegate->report, ok);
    index->counts.groups_set++;
    index->needs_commit = true;
    container->is_dirty = !ok;
    return ok;
}

// Sorts meshes and instancers by container, in order of insertion within each.
static CoPrim **list_members(CohortRenderIndex *index, size_t *bytes)
{
    size_t total = 0;
    for (size_t c = 0; c < index->container_count; c++)
        index->containers[c].member_count = 0;
    for (size_t i = 0; i < index->prim_count; i++) {
        const CoPrim *prim = index->prims[i];
        if (prim && (prim->type == COHORT_PRIM_MESH || prim->type == COHORT_PRIM_INSTANCER)) {
            index->containers[prim->container].member_count++;
            total++;
        }
    }
    size_t begin = 0;
    for (size_t c = 0; c < index->container_count; c++) {
        index->containers[c].member_begin = begin;
        begin += index->containers[c].member_count;
        index->containers[c].member_count = 0;
    }
    *bytes = (total + 1) * sizeof(CoPrim *);
    CoPrim **members = co_alloc(CO_MEMORY_DELEGATE, *bytes);
    for (size_t i = 0; members && i < index->prim_count; i++) {
        CoPrim *prim = index->prims[i];
        if (!prim || (prim->type != COHORT_PRIM_MESH && prim->type != COHORT_PRIM_INSTANCER))
            continue;
        CoContainer *c = &index->containers[prim->container];
        members[c->member_begin + c->member_count++] = prim;
    }
    return members;
}

bool co_sync_groups(CohortRenderIndex *index, CohortError *err)
{
    bool any = false;
    for (size_t c = 0; c < index->container_count; c++)
        any = any || index->containers[c].is_dirty;
    if (!any)
        return true;
    size_t bytes;
    CoPrim **members = list_members(index, &bytes);
    CO_CHECK_MEMORY(members, err);
    InstanceList list = {0};
    bool ok = true;
    for (size_t c = 0; ok && c < index->container_count; c++)
        if (index->containers[c].is_dirty)
            ok = set_group(index, &index->containers[c], members, &list, err);
    co_free(CO_MEMORY_DELEGATE, list.items, list.capacity * sizeof *list.items);
    co_free(CO_MEMORY_DELEGATE, members, bytes);
    return ok;
}
