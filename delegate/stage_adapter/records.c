// Which stage prims are in the index, and what is said of them.

#include "stage_adapter/adapter.h"

#include "base/error.h"
#include "index/index.h"

#include <stdio.h>
#include <string.h>

void co_adapter_report(const CohortAdapter *adapter, const CohortPrim *prim, const char *name,
                       const char *value, const char *action)
{
    co_delegate_note(adapter->delegate, COHORT_SEVERITY_WARNING, prim ? cohort_prim_path(prim) : "",
                     name, value, action);
}

// The path, or the first of "path@2", "path@3" ... that is free: prims of a shared prototype that
// inherits differently in several places come to the index once for each.
static const char *free_path(CohortAdapter *adapter, const char *path)
{
    if (co_string_map_find(&adapter->paths, path) == COHORT_INVALID_ID)
        return path;
    size_t size = strlen(path) + 16;
    char *longer = co_arena_alloc(&adapter->arena, size);
    for (unsigned i = 2; longer; i++) {
        snprintf(longer, size, "%s@%u", path, i);
        if (co_string_map_find(&adapter->paths, longer) == COHORT_INVALID_ID)
            break;
    }
    return longer;
}

CoRecord *co_record_add(CohortAdapter *adapter, const CoRecord *record, CohortPrimType type,
                        CohortError *err)
{
    const char *path = free_path(adapter, record->path);
    uint32_t place = (uint32_t)adapter->record_count;
    bool ok = path &&
              co_grow(CO_MEMORY_DELEGATE, (void **)&adapter->records, adapter->record_count,
                      &adapter->record_capacity, sizeof *adapter->records) &&
              co_string_map_set(&adapter->paths, path, place);
    CO_CHECK_NULL(ok, err, COHORT_ERROR_OUT_OF_MEMORY, "out of memory");
    bool is_placed = type == COHORT_PRIM_MESH || type == COHORT_PRIM_INSTANCER;
    bool in_prototype = is_placed && record->prototype != CO_WORLD;
    if (!cohort_render_index_insert(adapter->index, type, path, &adapter->scene,
                                    in_prototype ? CO_PROTOTYPES_PATH : NULL,
                                    in_prototype ? record->prototype : 0, err)) {
        co_string_map_remove(&adapter->paths, path);
        return NULL;
    }
    CoRecord *added = &adapter->records[adapter->record_count++];
    *added = *record;
    added->path = path;
    return added;
}

const CoRecord *co_record_find(const CohortAdapter *adapter, const char *path)
{
    uint32_t place = co_string_map_find(&adapter->paths, path);
    return place == COHORT_INVALID_ID ? NULL : &adapter->records[place];
}

const char *co_record_material(CohortAdapter *adapter, CoPlace from, const char *path,
                               CohortError *err)
{
    if (!path)
        return NULL;
    const CoRecord *known = co_record_find(adapter, path);
    if (known)
        return known->kind == CO_RECORD_MATERIAL ? known->path : NULL;
    const CohortPrim *prim = cohort_stage_prim(adapter->stage, path);
    if (!prim || strcmp(cohort_prim_type(prim), "Material") != 0) {
        co_adapter_report(adapter, from.prim, "material:binding", path,
                          "no such material: Lambertian with displayColor");
        return NULL;
    }
    CoRecord record = {.kind = CO_RECORD_MATERIAL,
                       .path = cohort_prim_path(prim),
                       .prim = prim,
                       .prototype = CO_WORLD};
    const CoRecord *added = co_record_add(adapter, &record, COHORT_PRIM_MATERIAL, err);
    return added ? added->path : NULL;
}
