// Meshes: set anew, or given other materials alone.

#include "base/error.h"
#include "base/hash.h"
#include "prims/dicing.h"
#include "prims/sync.h"

// What a change of makes the mesh itself new; the rest moves it, hides it or gives it other
// materials.
enum {
    SHAPE_BITS = COHORT_DIRTY_PRIMVAR | COHORT_DIRTY_POINTS | COHORT_DIRTY_TOPOLOGY |
                 COHORT_DIRTY_SUBDIV_TAGS | COHORT_DIRTY_DISPLAY_STYLE
};

static uint32_t material_id(CohortRenderIndex *index, const CoPrim *mesh, CohortPull *pull,
                            const char *path)
{
    if (!path || !path[0] ||
        !index->delegate->settings.values[CO_SETTING_ENABLE_SCENE_MATERIALS].boolean)
        return COHORT_INVALID_ID;
    const CoPrim *material = co_index_find(index, path);
    if (!material || material->type != COHORT_PRIM_MATERIAL) {
        if (!co_string_map_set(&index->missing, path, 0))
            pull->is_short = true;
        co_delegate_note(index->delegate, COHORT_SEVERITY_WARNING, mesh->path, "material:binding",
                         path, "no such material: Lambertian with displayColor");
        return COHORT_INVALID_ID;
    }
    return material->is_plain ? COHORT_INVALID_ID : material->id;
}

// Puts scene ids where the source names materials. NULL when out of memory.
static const CohortSubsetDesc *resolve_subsets(CohortRenderIndex *index, const CoPrim *prim,
                                               CohortPull *pull, const CohortMeshSource *source)
{
    CohortSubsetDesc *subsets = cohort_pull_array(pull, source->mesh.subset_count, sizeof *subsets);
    for (size_t i = 0; subsets && i < source->mesh.subset_count; i++) {
        subsets[i] = source->mesh.subsets[i];
        subsets[i].material = material_id(
            index, prim, pull, source->subset_materials ? source->subset_materials[i] : NULL);
    }
    return subsets;
}

// Uniform, or by size on screen.
static bool set_levels(const CohortRenderIndex *index, CoPrim *prim, CohortPull *pull,
                       CohortMeshDesc *desc)
{
    const CohortSettingValue *values = index->delegate->settings.values;
    if (values[CO_SETTING_EDGE_LENGTH].number > 0.0) {
        co_dicing_measure(prim, desc);
        return co_dicing_set_levels(index, prim, pull, desc);
    }
    uint32_t level = (uint32_t)values[CO_SETTING_COMPLEXITY].integer;
    desc->level = desc->level > level ? desc->level : level;
    return true;
}

static bool set_mesh(CohortRenderIndex *index, CoPrim *prim, CohortPull *pull,
                     const CohortMeshSource *source, CohortError *reason)
{
    CohortMeshDesc desc = source->mesh;
    desc.path = prim->path;
    desc.material = material_id(index, prim, pull, source->material);
    desc.points = NULL;
    if (source->points_sample_count)
        desc.points =
            source
                ->points[co_sync_nearest(&source->points[0].time, source->points_sample_count,
                                         sizeof *source->points)]
                .points;
    CO_CHECK(desc.points || desc.point_count == 0, reason, COHORT_ERROR_SCENE,
             "the mesh counts %zu points but gives none", desc.point_count);
    CO_CHECK(set_levels(index, prim, pull, &desc), reason, COHORT_ERROR_OUT_OF_MEMORY,
             "out of memory for %zu levels", desc.face_vertex_index_count);
    if (desc.subset_count) {
        desc.subsets = resolve_subsets(index, prim, pull, source);
        CO_CHECK_MEMORY(desc.subsets, reason);
    }
    return cohort_scene_set_mesh(index->scene, prim->id, &desc, reason);
}

static uint64_t displacement_of(const CohortRenderIndex *index, const char *path)
{
    const CoPrim *material = path && path[0] ? co_index_find(index, path) : NULL;
    bool is_used = material && material->type == COHORT_PRIM_MATERIAL && !material->is_plain &&
                   index->delegate->settings.values[CO_SETTING_ENABLE_SCENE_MATERIALS].boolean;
    return is_used ? material->displacement : 0;
}

// What the mesh's materials displace it by; 0 when none does.
static uint64_t mesh_displacement(const CohortRenderIndex *index, const CohortMeshSource *source)
{
    uint64_t hash = displacement_of(index, source->material);
    for (size_t i = 0; i < source->mesh.subset_count && source->subset_materials; i++) {
        uint64_t own = displacement_of(index, source->subset_materials[i]);
        if (hash || own)
            hash = co_hash_combine(co_hash_combine(hash, i), own);
    }
    return hash;
}

static void report_coarse(CohortRenderIndex *index, const CoPrim *prim,
                          const CohortMeshSource *source)
{
    if (prim->displacement && source->mesh.scheme == COHORT_SCHEME_NONE)
        co_delegate_note(index->delegate, COHORT_SEVERITY_INFO, prim->path, "subdivisionScheme",
                         "none", "displaced at the mesh's own points only");
}

static bool bind_materials(CohortRenderIndex *index, CoPrim *prim, CohortPull *pull,
                           const CohortMeshSource *source, CohortError *reason)
{
    size_t count = source->mesh.subset_count;
    uint32_t *ids = cohort_pull_array(pull, count + 1, sizeof *ids);
    CO_CHECK_MEMORY(ids, reason);
    for (size_t i = 0; i < count; i++)
        ids[i] = material_id(index, prim, pull,
                             source->subset_materials ? source->subset_materials[i] : NULL);
    index->counts.bindings_set++;
    return cohort_scene_set_mesh_materials(index->scene, prim->id,
                                           material_id(index, prim, pull, source->material), ids,
                                           count, reason);
}

// Other subsets are another mesh, whatever the host's bits say.
static bool apply(CohortRenderIndex *index, CoPrim *prim, CohortPull *pull,
                  const CohortMeshSource *source, CohortError *reason)
{
    uint64_t displacement = mesh_displacement(index, source);
    bool is_same_shape = !(prim->dirty & SHAPE_BITS) && prim->has_geometry &&
                         source->mesh.subset_count == prim->subset_count &&
                         displacement == prim->displacement;
    if (is_same_shape)
        return bind_materials(index, prim, pull, source, reason);
    index->counts.meshes_set++;
    prim->subset_count = source->mesh.subset_count;
    prim->displacement = displacement;
    report_coarse(index, prim, source);
    return set_mesh(index, prim, pull, source, reason);
}

static bool sync_mesh(CohortRenderIndex *index, CoPrim *prim, CohortPull *pull, CohortError *err)
{
    if (prim->id == COHORT_INVALID_ID)
        prim->id = cohort_scene_new_object(index->scene, err);
    if (prim->id == COHORT_INVALID_ID)
        return false;
    CohortError reason = {0};
    CohortMeshSource source = {0};
    source.mesh.material = COHORT_INVALID_ID;
    index->needs_commit = true;
    bool had_geometry = prim->has_geometry;
    prim->has_geometry =
        prim->scene->get_mesh &&
        prim->scene->get_mesh(prim->scene->cookie, pull, prim->path, &source, &reason) &&
        co_sync_is_whole(index, prim, pull, &reason) &&
        apply(index, prim, pull, &source, &reason) && co_sync_is_whole(index, prim, pull, &reason);
    bool is_seen_otherwise = prim->hidden_from != source.hidden_from;
    prim->hidden_from = source.hidden_from;
    if (prim->has_geometry != had_geometry || is_seen_otherwise)
        index->containers[prim->container].is_dirty = true;
    if (prim->has_geometry)
        return true;
    cohort_scene_clear_object(index->scene, prim->id);
    return co_sync_refuse(index, prim, pull, "Mesh", &reason, err);
}

bool co_sync_mesh(CohortRenderIndex *index, CoPrim *prim, CohortPull *pull, CohortError *err)
{
    bool moved = false;
    if (!co_sync_placement(index, prim, pull, &moved, err))
        return false;
    if (moved)
        index->containers[prim->container].is_dirty = true;
    bool is_changed = (prim->dirty & (SHAPE_BITS | COHORT_DIRTY_MATERIAL_ID)) != 0;
    return !is_changed || sync_mesh(index, prim, pull, err);
}
