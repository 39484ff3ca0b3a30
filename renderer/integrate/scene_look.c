// Commit of what a scene looks like: color, textures, materials' needs, lights.

#include "integrate/scene_data.h"

#include "base/error.h"
#include "base/stop.h"

#include <string.h>

#define TAG CO_MEMORY_SCENE

static void texture_warn(void *cookie, const char *place, const char *text)
{
    co_scene_warn(cookie, COHORT_SEVERITY_WARNING, place, text);
}

static bool open_textures(CohortScene *scene, const CohortSceneOptions *options, CohortError *err)
{
    CoTexturesOptions t = {.converted_folder = options->converted_folder,
                           .ptex_reductions_authored = options->ptex_reductions_authored,
                           .resident_bytes = options->texture_memory,
                           .to_rendering = co_color_to_rendering,
                           .space_of_file = co_color_space_of_file,
                           .cookie = scene->color,
                           .warn = texture_warn,
                           .warn_cookie = scene};
    scene->textures = co_textures_create(&t, err);
    return scene->textures != NULL;
}

// A mesh whose Ptex faces are not those of the file it is textured with shows missing colors there.
static void check_ptex(CohortScene *scene, uint32_t object, uint32_t slot)
{
    const CoMaterial *m = co_scene_material(scene, object, slot);
    if (!m)
        return;
    const CoMesh *mesh = &scene->objects[object].mesh;
    for (uint32_t i = 0; i < m->lookup_count; i++) {
        if (!m->lookups[i].is_ptex)
            continue;
        const CohortTextureDesc *desc = &scene->texture_descs[m->lookups[i].texture];
        bool is_triangle = false;
        uint32_t faces = co_texture_ptex_faces(
            scene->textures, scene->texture_ids[m->lookups[i].texture], &is_triangle);
        if (faces == 0 || faces == mesh->ptex_face_count)
            continue;
        char text[256];
        snprintf(text, sizeof text,
                 "Ptex file has %u faces, the mesh it textures has %u: faces it lacks are magenta",
                 faces, mesh->ptex_face_count);
        co_scene_warn(scene, COHORT_SEVERITY_WARNING, desc->asset, text);
    }
}

// Colors of materials and meshes are authored in linear Rec.709, as USD has them.
static void survey_colors(CohortScene *scene)
{
    co_color_rec709_matrix(scene->color, scene->rec709);
    scene->converts = false;
    for (int i = 0; i < 9; i++)
        scene->converts = scene->converts || scene->rec709[i] != (i % 4 == 0 ? 1.0f : 0.0f);
    for (uint32_t i = 0; i < scene->material_count; i++)
        scene->materials[i].rec709 = scene->converts ? scene->rec709 : NULL;
}

static bool has_display_opacity(const CohortScene *scene)
{
    bool found = false;
    for (uint32_t i = 0; i < scene->object_count && !found; i++)
        found = scene->objects[i].kind == CO_OBJECT_MESH &&
                co_mesh_primvar_find(&scene->objects[i].mesh, "displayOpacity") >= 0;
    return found;
}

static void survey_materials(CohortScene *scene)
{
    scene->has_lookups = false;
    scene->has_cutouts = has_display_opacity(scene);
    for (uint32_t i = 0; i < scene->material_count; i++) {
        scene->has_cutouts = scene->has_cutouts || scene->materials[i].may_pass;
        scene->has_lookups = scene->has_lookups || scene->materials[i].lookup_count > 0;
    }
    for (uint32_t i = 0; scene->has_lookups && i < scene->object_count; i++) {
        if (scene->objects[i].kind != CO_OBJECT_MESH)
            continue;
        const CoMesh *mesh = &scene->objects[i].mesh;
        uint32_t last = COHORT_INVALID_ID;
        for (uint32_t face = 0; face < mesh->face_count; face++) {
            uint32_t slot = co_mesh_face_material(mesh, face);
            if (slot != last)
                check_ptex(scene, i, slot);
            last = slot;
        }
    }
}

bool co_scene_commit_textures(CohortScene *scene, const CohortSceneOptions *options,
                              CohortError *err)
{
    if (!scene->color) {
        scene->color = co_color_create(options->ocio_config, options->rendering_color_space, err);
        if (!scene->color)
            return false;
    }
    if (!scene->textures && !open_textures(scene, options, err))
        return false;
    for (; scene->textures_added < scene->texture_count; scene->textures_added++) {
        CO_CHECK_STOP(options->stop, err);
        uint32_t id =
            co_textures_add(scene->textures, &scene->texture_descs[scene->textures_added], err);
        if (id == COHORT_INVALID_ID)
            return false;
        scene->texture_ids[scene->textures_added] = id;
        scene->counts.texture_opens++;
    }
    survey_colors(scene);
    survey_materials(scene);
    return true;
}

static void release_lights(CohortScene *scene)
{
    co_lights_destroy(scene->lights);
    scene->lights = NULL;
    for (uint32_t i = 0; i < scene->light_image_count; i++)
        co_image_free((float *)(uintptr_t)scene->light_images[i].pixels,
                      scene->light_images[i].width, scene->light_images[i].height);
    co_free(TAG, scene->light_images, scene->light_image_count * sizeof *scene->light_images);
    scene->light_images = NULL;
    scene->light_image_count = 0;
}

static bool read_light_image(CohortScene *scene, const CohortLightDesc *desc, CoLightImage *out,
                             CohortError *err)
{
    CohortTextureDesc image = {.path = desc->texture_file,
                               .asset =
                                   desc->texture_asset ? desc->texture_asset : desc->texture_file,
                               .color_space = desc->texture_color_space,
                               .color_space_name = desc->texture_color_space_name};
    CohortError why = {0};
    float *pixels = NULL;
    if (co_image_read(scene->textures, &image, &pixels, &out->width, &out->height, &why)) {
        out->pixels = pixels;
        return true;
    }
    if (co_texture_may_lack(&why))
        co_scene_warn(scene, COHORT_SEVERITY_WARNING, desc->path, why.message);
    else if (err && err->code == COHORT_OK)
        *err = why;
    return co_texture_may_lack(&why);
}

// A light whose image cannot be read goes dark rather than shine in an invented color.
static bool build_lights(CohortScene *scene, CohortLightDesc *descs, CohortError *err)
{
    for (uint32_t i = 0; i < scene->light_count; i++) {
        descs[i] = scene->light_descs[i];
        const char *problem = descs[i].hidden ? NULL : co_light_problem(&descs[i]);
        if (problem)
            co_scene_warn(scene, COHORT_SEVERITY_WARNING, descs[i].path, problem);
        if (descs[i].hidden || !descs[i].texture_file)
            continue;
        if (!read_light_image(scene, &descs[i], &scene->light_images[i], err))
            return false;
        descs[i].hidden = scene->light_images[i].pixels == NULL;
    }
    float radius = 1.0f;
    if (scene->has_box) {
        const double *b = scene->box;
        double dx = b[3] - b[0], dy = b[4] - b[1], dz = b[5] - b[2];
        radius = (float)(0.5 * sqrt(dx * dx + dy * dy + dz * dz));
    }
    scene->lights = co_lights_create(descs, scene->light_images, scene->light_count, scene->frame,
                                     scene->rec709, radius, err);
    scene->counts.light_builds++;
    return scene->lights != NULL;
}

bool co_scene_commit_lights(CohortScene *scene, CohortError *err)
{
    uint32_t n = scene->light_count;
    // Built in the render frame, which other edits may move; else the images need no second
    // reading.
    if (scene->lights && !scene->lights_dirty &&
        memcmp(scene->lights_frame, scene->frame, sizeof scene->frame) == 0)
        return true;
    release_lights(scene);
    memcpy(scene->lights_frame, scene->frame, sizeof scene->frame);
    CohortLightDesc *descs = co_alloc(TAG, (n + 1) * sizeof *descs);
    scene->light_images = co_alloc_zero(TAG, (n + 1) * sizeof *scene->light_images);
    scene->light_image_count = scene->light_images ? n + 1 : 0;
    bool ok = descs && scene->light_images;
    if (ok)
        ok = build_lights(scene, descs, err);
    else
        CO_FAIL(err, COHORT_ERROR_OUT_OF_MEMORY, "out of memory for %u lights", n);
    co_free(TAG, descs, (n + 1) * sizeof *descs);
    scene->lights_dirty = false;
    return ok;
}
