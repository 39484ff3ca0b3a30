#include "index/index.h"

#include "prims/dicing.h"

#include "base/clock.h"
#include "base/error.h"
#include "base/parallel.h"
#include "pass/render_thread.h"

#include <stdio.h>
#include <string.h>

enum {
    KEY_EXTRA = 16,
    MAX_PROTOTYPE = 1 << 24
};

// ---- Create and destroy ------------------------------------------------------------------------

CohortRenderIndex *cohort_render_index_create(CohortDelegate *delegate, CohortError *err)
{
    CO_CHECK_NULL(!delegate->index, err, COHORT_ERROR_ARGUMENT,
                  "the delegate has a render index already");
    CohortRenderIndex *index = co_alloc_zero(CO_MEMORY_DELEGATE, sizeof *index);
    CO_CHECK_NULL(index, err, COHORT_ERROR_OUT_OF_MEMORY, "out of memory");
    index->delegate = delegate;
    index->scene = cohort_scene_create(err);
    if (!index->scene || !co_grow(CO_MEMORY_DELEGATE, (void **)&index->containers, 0,
                                  &index->container_capacity, sizeof *index->containers)) {
        co_index_destroy(index);
        CO_FAIL(err, COHORT_ERROR_OUT_OF_MEMORY, "out of memory");
        return NULL;
    }
    index->containers[0] = (CoContainer){.owner = COHORT_INVALID_ID, .is_dirty = true};
    index->container_count = 1;
    delegate->index = index;
    return index;
}

static void free_prim(CoPrim *prim)
{
    co_free(CO_MEMORY_DELEGATE, prim->path, strlen(prim->path) + 1);
    co_free(CO_MEMORY_DELEGATE, prim, sizeof *prim);
}

void co_index_destroy(CohortRenderIndex *index)
{
    if (!index)
        return;
    for (size_t i = 0; i < index->prim_count; i++)
        if (index->prims[i])
            free_prim(index->prims[i]);
    co_free(CO_MEMORY_DELEGATE, index->prims, index->prim_capacity * sizeof *index->prims);
    co_free(CO_MEMORY_DELEGATE, index->containers,
            index->container_capacity * sizeof *index->containers);
    co_dicing_clear(&index->dicing);
    co_free(CO_MEMORY_DELEGATE, index->mesh_places,
            index->mesh_capacity * sizeof *index->mesh_places);
    co_string_map_clear(&index->paths);
    co_string_map_clear(&index->container_names);
    co_string_map_clear(&index->owners);
    co_string_map_clear(&index->missing);
    co_string_map_clear(&index->textures);
    if (index->scene)
        cohort_scene_destroy(index->scene);
    co_free(CO_MEMORY_DELEGATE, index, sizeof *index);
}

// ---- Containers --------------------------------------------------------------------------------

static char *container_key(const char *instancer, uint32_t prototype, size_t *size)
{
    *size = strlen(instancer) + KEY_EXTRA;
    char *key = co_alloc(CO_MEMORY_DELEGATE, *size);
    if (key)
        snprintf(key, *size, "%s\x1f%u", instancer, (unsigned)prototype);
    return key;
}

static uint32_t owner_number(CohortRenderIndex *index, const char *instancer)
{
    uint32_t number = co_string_map_find(&index->owners, instancer);
    if (number != COHORT_INVALID_ID)
        return number;
    number = (uint32_t)index->owners.used;
    return co_string_map_set(&index->owners, instancer, number) ? number : COHORT_INVALID_ID;
}

static uint32_t add_container(CohortRenderIndex *index, const char *key, const char *instancer,
                              uint32_t prototype)
{
    uint32_t owner = owner_number(index, instancer);
    if (!co_grow(CO_MEMORY_DELEGATE, (void **)&index->containers, index->container_count,
                 &index->container_capacity, sizeof *index->containers))
        return COHORT_INVALID_ID;
    uint32_t object = cohort_scene_new_object(index->scene, NULL);
    uint32_t place = (uint32_t)index->container_count;
    if (object == COHORT_INVALID_ID || owner == COHORT_INVALID_ID ||
        !co_string_map_set(&index->container_names, key, place))
        return COHORT_INVALID_ID;
    index->containers[index->container_count++] =
        (CoContainer){.object = object, .owner = owner, .prototype = prototype, .is_dirty = true};
    return place;
}

uint32_t co_index_container(CohortRenderIndex *index, const char *instancer, uint32_t prototype)
{
    if (!instancer)
        return 0;
    size_t size;
    char *key = container_key(instancer, prototype, &size);
    if (!key)
        return COHORT_INVALID_ID;
    uint32_t found = co_string_map_find(&index->container_names, key);
    if (found == COHORT_INVALID_ID)
        found = add_container(index, key, instancer, prototype);
    co_free(CO_MEMORY_DELEGATE, key, size);
    return found;
}

// ---- Prims -------------------------------------------------------------------------------------

CoPrim *co_index_find(const CohortRenderIndex *index, const char *path)
{
    uint32_t place = path ? co_string_map_find(&index->paths, path) : COHORT_INVALID_ID;
    return place == COHORT_INVALID_ID ? NULL : index->prims[place];
}

static uint32_t bits_of_type(CohortPrimType type)
{
    const uint32_t placed = COHORT_DIRTY_TRANSFORM | COHORT_DIRTY_VISIBILITY;
    switch (type) {
    case COHORT_PRIM_MESH:
        return placed | COHORT_DIRTY_MATERIAL_ID | COHORT_DIRTY_PRIMVAR | COHORT_DIRTY_POINTS |
               COHORT_DIRTY_TOPOLOGY | COHORT_DIRTY_SUBDIV_TAGS | COHORT_DIRTY_DISPLAY_STYLE;
    case COHORT_PRIM_INSTANCER:
        return placed | COHORT_DIRTY_INSTANCER | COHORT_DIRTY_INSTANCE_INDEX;
    case COHORT_PRIM_CAMERA:
        return COHORT_DIRTY_TRANSFORM | COHORT_DIRTY_PARAMS;
    case COHORT_PRIM_LIGHT:
        return placed | COHORT_DIRTY_PARAMS | COHORT_DIRTY_RESOURCE;
    case COHORT_PRIM_MATERIAL:
    case COHORT_PRIM_TYPE_COUNT:
        break;
    }
    return COHORT_DIRTY_PARAMS | COHORT_DIRTY_RESOURCE;
}

static CoPrim *new_prim(CohortPrimType type, const char *path, const CohortSceneDelegate *scene)
{
    size_t size = strlen(path) + 1;
    CoPrim *prim = co_alloc_zero(CO_MEMORY_DELEGATE, sizeof *prim);
    char *copy = co_alloc(CO_MEMORY_DELEGATE, size);
    if (!prim || !copy) {
        co_free(CO_MEMORY_DELEGATE, prim, sizeof *prim);
        co_free(CO_MEMORY_DELEGATE, copy, size);
        return NULL;
    }
    memcpy(copy, path, size);
    prim->type = type;
    prim->path = copy;
    prim->scene = scene;
    prim->dirty = bits_of_type(type);
    prim->id = COHORT_INVALID_ID;
    prim->prim_id = -1;
    for (int i = 0; i < 4; i++)
        prim->transform[i][i] = 1.0;
    return prim;
}

// Puts a new prim into the arrays; nothing has changed when it fails.
static bool add_prim(CohortRenderIndex *index, CoPrim *prim)
{
    if (!co_grow(CO_MEMORY_DELEGATE, (void **)&index->prims, index->prim_count,
                 &index->prim_capacity, sizeof *index->prims) ||
        !co_grow(CO_MEMORY_DELEGATE, (void **)&index->mesh_places, index->mesh_count,
                 &index->mesh_capacity, sizeof *index->mesh_places) ||
        !co_string_map_set(&index->paths, prim->path, (uint32_t)index->prim_count))
        return false;
    if (prim->type == COHORT_PRIM_MESH) {
        prim->prim_id = (int32_t)index->mesh_count;
        index->mesh_places[index->mesh_count++] = (uint32_t)index->prim_count;
    }
    index->prims[index->prim_count++] = prim;
    index->live_count[prim->type]++;
    return true;
}

bool cohort_render_index_insert(CohortRenderIndex *index, CohortPrimType type, const char *path,
                                const CohortSceneDelegate *scene, const char *instancer,
                                uint32_t prototype, CohortError *err)
{
    CO_CHECK(path && path[0] && scene && (unsigned)type < COHORT_PRIM_TYPE_COUNT, err,
             COHORT_ERROR_ARGUMENT, "a prim needs a type, a path and a scene delegate");
    CO_CHECK(!co_index_find(index, path), err, COHORT_ERROR_ARGUMENT,
             "there is a prim at %.180s already", path);
    CO_CHECK(prototype < MAX_PROTOTYPE, err, COHORT_ERROR_LIMIT, "prototype number %u is too large",
             (unsigned)prototype);
    CO_CHECK(index->prim_count < INT32_MAX, err, COHORT_ERROR_LIMIT, "too many prims");
    bool placed = type == COHORT_PRIM_MESH || type == COHORT_PRIM_INSTANCER;
    uint32_t container = placed ? co_index_container(index, instancer, prototype) : 0;
    CO_CHECK(container != COHORT_INVALID_ID, err, COHORT_ERROR_OUT_OF_MEMORY, "out of memory");
    CoPrim *prim = new_prim(type, path, scene);
    CO_CHECK_MEMORY(prim, err);
    prim->container = container;
    if (!add_prim(index, prim)) {
        free_prim(prim);
        return CO_FAIL(err, COHORT_ERROR_OUT_OF_MEMORY, "out of memory");
    }
    if (type == COHORT_PRIM_MATERIAL &&
        co_string_map_find(&index->missing, path) != COHORT_INVALID_ID)
        index->materials_changed = true;
    return true;
}

// Takes a prim out of the scene. The render must be down.
static void retire_prim(CohortRenderIndex *index, const CoPrim *prim)
{
    if (prim->type == COHORT_PRIM_MESH && prim->id != COHORT_INVALID_ID)
        cohort_scene_clear_object(index->scene, prim->id);
    if (prim->type == COHORT_PRIM_LIGHT && prim->id != COHORT_INVALID_ID) {
        CohortLightDesc gone = cohort_light_default(COHORT_LIGHT_SPHERE);
        gone.path = prim->path;
        gone.hidden = true;
        cohort_scene_set_light(index->scene, prim->id, &gone, NULL);
    }
    if (prim->type == COHORT_PRIM_MATERIAL)
        index->materials_changed = true;
    index->containers[prim->container].is_dirty = true;
    index->needs_commit = true;
}

void cohort_render_index_remove(CohortRenderIndex *index, const char *path)
{
    CoPrim *prim = co_index_find(index, path);
    if (!prim)
        return;
    co_render_thread_drop(index->delegate->thread);
    retire_prim(index, prim);
    index->prims[co_string_map_find(&index->paths, path)] = NULL;
    index->live_count[prim->type]--;
    co_string_map_remove(&index->paths, path);
    free_prim(prim);
}

void cohort_render_index_mark_dirty(CohortRenderIndex *index, const char *path, uint32_t bits)
{
    CoPrim *prim = co_index_find(index, path);
    if (prim)
        prim->dirty |= bits & bits_of_type(prim->type);
}

void cohort_render_index_mark_all_dirty(CohortRenderIndex *index, CohortPrimType type,
                                        uint32_t bits)
{
    for (size_t i = 0; i < index->prim_count; i++)
        if (index->prims[i] && index->prims[i]->type == type)
            index->prims[i]->dirty |= bits & bits_of_type(type);
}

uint32_t cohort_render_index_dirty_bits(const CohortRenderIndex *index, const char *path)
{
    const CoPrim *prim = co_index_find(index, path);
    return prim ? prim->dirty : 0;
}

size_t cohort_render_index_prim_count(const CohortRenderIndex *index, CohortPrimType type)
{
    return (unsigned)type < COHORT_PRIM_TYPE_COUNT ? index->live_count[type] : 0;
}

const char *cohort_render_index_prim_path(const CohortRenderIndex *index, int32_t prim_id)
{
    if (prim_id < 0 || (size_t)prim_id >= index->mesh_count)
        return NULL;
    const CoPrim *prim = index->prims[index->mesh_places[prim_id]];
    return prim ? prim->path : NULL;
}

// ---- Commit ------------------------------------------------------------------------------------

bool co_index_is_dirty(const CohortRenderIndex *index)
{
    if (index->needs_commit)
        return true;
    for (size_t i = 0; i < index->container_count; i++)
        if (index->containers[i].is_dirty)
            return true;
    for (size_t i = 0; i < index->prim_count; i++)
        if (index->prims[i] && index->prims[i]->dirty)
            return true;
    return false;
}

void co_index_setting_changed(CohortRenderIndex *index, CoSetting setting)
{
    if (!index)
        return;
    if (setting == CO_SETTING_COMPLEXITY || setting == CO_SETTING_EDGE_LENGTH)
        cohort_render_index_mark_all_dirty(index, COHORT_PRIM_MESH, COHORT_DIRTY_DISPLAY_STYLE);
    if (setting == CO_SETTING_ENABLE_SCENE_MATERIALS)
        cohort_render_index_mark_all_dirty(index, COHORT_PRIM_MESH, COHORT_DIRTY_MATERIAL_ID);
    if (setting == CO_SETTING_ENABLE_SCENE_LIGHTS || setting == CO_SETTING_ENABLE_SHADOWS)
        cohort_render_index_mark_all_dirty(index, COHORT_PRIM_LIGHT, COHORT_DIRTY_VISIBILITY);
    if (setting == CO_SETTING_RENDERING_COLOR_SPACE || setting == CO_SETTING_OCIO_CONFIG ||
        setting == CO_SETTING_PTEX_REDUCTIONS_AUTHORED)
        index->needs_commit = true;
}

// The renderer commits nothing without a camera; which one matters only when a pass begins.
static bool ensure_camera(CohortRenderIndex *index, CohortError *err)
{
    if (index->has_camera_set)
        return true;
    CohortCameraDesc *any = &index->camera_set;
    memset(any, 0, sizeof *any);
    for (int i = 0; i < 4; i++)
        any->transform[i][i] = 1.0;
    any->window[0] = any->window[2] = -1.0;
    any->window[1] = any->window[3] = 1.0;
    any->clip_near = 1.0;
    any->clip_far = 1e6;
    index->has_camera_set = cohort_scene_set_camera(index->scene, any, err);
    return index->has_camera_set;
}

bool co_index_commit(CohortRenderIndex *index, CohortError *err)
{
    if (!index->needs_commit)
        return true;
    if (!ensure_camera(index, err))
        return false;
    double start = co_clock_seconds();
    CohortSceneOptions options;
    co_settings_scene(&index->delegate->settings, &options);
    options.stop = index->delegate->stop;
    co_worker_count_set((uint32_t)index->delegate->settings.values[CO_SETTING_THREADS].integer);
    bool ok = cohort_scene_commit(index->scene, &options, err);
    index->load_seconds += co_clock_seconds() - start;
    if (ok) {
        index->needs_commit = false;
        index->counts.commits++;
    }
    return ok;
}

bool cohort_render_index_bounds(const CohortRenderIndex *index, double box[6])
{
    return cohort_scene_bounds(index->scene, box);
}

void cohort_render_index_counts(const CohortRenderIndex *index, CohortSyncCounts *out)
{
    *out = index->counts;
    cohort_scene_counts(index->scene, &out->scene);
}

size_t cohort_render_index_warnings(const CohortRenderIndex *index, const CohortDiagnostic **out)
{
    return cohort_scene_warnings(index->scene, out);
}
