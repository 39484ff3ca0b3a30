// Materials: networks to the renderer, and who displaces by them.

#include "base/error.h"
#include "prims/material_network.h"
#include "prims/sync.h"

#include <stdio.h>
#include <string.h>

static const char *text(const char *s)
{
    return s ? s : "";
}

uint32_t co_sync_texture(CohortRenderIndex *index, const CohortTextureDesc *desc, CohortError *err)
{
    const char *path = text(desc->path), *space = text(desc->color_space_name);
    size_t size = strlen(path) + strlen(space) + 256;
    char *key = co_alloc(CO_MEMORY_DELEGATE, size);
    if (!key) {
        CO_FAIL(err, COHORT_ERROR_OUT_OF_MEMORY, "out of memory");
        return COHORT_INVALID_ID;
    }
    snprintf(key, size, "%s\x1f%s\x1f%d %d %d %d %d %.9g %.9g %.9g %.9g", path, space,
             (int)desc->is_ptex, (int)desc->color_space, (int)desc->wrap_s, (int)desc->wrap_t,
             (int)desc->ptex_filter, (double)desc->fallback[0], (double)desc->fallback[1],
             (double)desc->fallback[2], (double)desc->fallback[3]);
    uint32_t id = co_string_map_find(&index->textures, key);
    if (id == COHORT_INVALID_ID) {
        // Its place first, so that no texture is made that is not found again.
        if (co_string_map_set(&index->textures, key, id))
            id = cohort_scene_new_texture(index->scene, desc, err);
        else
            CO_FAIL(err, COHORT_ERROR_OUT_OF_MEMORY, "out of memory");
        if (id != COHORT_INVALID_ID)
            co_string_map_set(&index->textures, key, id);
    }
    co_free(CO_MEMORY_DELEGATE, key, size);
    return id;
}

// Meshes are displaced when they are set: they must look whether they are set anew.
static void set_displacement(CohortRenderIndex *index, CoPrim *prim, uint64_t displacement,
                             bool is_first)
{
    if (!is_first && prim->displacement != displacement)
        cohort_render_index_mark_all_dirty(index, COHORT_PRIM_MESH, COHORT_DIRTY_MATERIAL_ID);
    prim->displacement = displacement;
}

// Meshes hold "no material" instead of a plain one: they must look again when that turns.
static void set_plain(CohortRenderIndex *index, CoPrim *prim, bool is_plain, bool is_first)
{
    if (!is_first && prim->is_plain != is_plain)
        cohort_render_index_mark_all_dirty(index, COHORT_PRIM_MESH, COHORT_DIRTY_MATERIAL_ID);
    prim->is_plain = is_plain;
}

bool co_sync_material(CohortRenderIndex *index, CoPrim *prim, CohortPull *pull, CohortError *err)
{
    bool is_first = prim->id == COHORT_INVALID_ID;
    if (is_first)
        prim->id = cohort_scene_new_material(index->scene, err);
    if (prim->id == COHORT_INVALID_ID)
        return false;
    index->counts.materials_set++;
    index->needs_commit = true;
    CohortError reason = {0}, memory = {0};
    CohortMaterialNetwork source = {.surface = -1, .displacement = -1};
    if (!prim->scene->get_material ||
        !prim->scene->get_material(prim->scene->cookie, pull, prim->path, &source, &reason)) {
        set_plain(index, prim, true, is_first);
        return co_sync_refuse(index, prim, pull, "Material", &reason, err);
    }
    CoNetwork net = {.index = index, .prim = prim, .source = &source, .err = &memory};
    bool usable = co_network_translate(&net);
    net.desc.lookups = net.lookups;
    if (memory.code != COHORT_OK) {
        set_plain(index, prim, true, is_first);
        return co_sync_refuse(index, prim, pull, "Material", &memory, err);
    }
    if (usable && !cohort_scene_set_material(index->scene, prim->id, &net.desc, &reason)) {
        set_plain(index, prim, true, is_first);
        return co_sync_refuse(index, prim, pull, "Material", &reason, err);
    }
    set_plain(index, prim, !usable, is_first);
    set_displacement(index, prim, usable ? co_network_displacement(&net.desc) : 0, is_first);
    return true;
}
