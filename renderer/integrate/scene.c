// The scene as its user edits it: objects, groups, textures, lights, camera.

#include "integrate/scene_data.h"

#include "base/error.h"

#include <string.h>

#define TAG CO_MEMORY_SCENE

bool co_scene_grow(void **array, uint32_t *capacity, uint32_t count, size_t element_size)
{
    if (count < *capacity)
        return true;
    if (*capacity > UINT32_MAX / 4)
        return false;
    uint32_t wanted = *capacity ? *capacity * 2 : 16;
    void *moved = co_realloc(TAG, *array, *capacity * element_size, wanted * element_size);
    if (!moved)
        return false;
    *array = moved;
    *capacity = wanted;
    return true;
}

const char *co_scene_string(CohortScene *scene, const char *text)
{
    return text ? co_arena_string(&scene->names, text, strlen(text)) : NULL;
}

void co_scene_warn(CohortScene *scene, CohortSeverity severity, const char *place, const char *text)
{
    if (!place)
        place = "";
    for (uint32_t i = 0; i < scene->warning_count; i++) {
        CoWarning *w = &scene->warnings[i];
        if (!strcmp(w->place, place) && !strcmp(w->text, text)) {
            w->count++;
            return;
        }
    }
    if (!co_scene_grow((void **)&scene->warnings, &scene->warning_capacity, scene->warning_count,
                       sizeof(CoWarning)))
        return;
    char *kept_place = co_arena_string(&scene->names, place, strlen(place));
    char *kept_text = co_arena_string(&scene->names, text, strlen(text));
    if (kept_place && kept_text)
        scene->warnings[scene->warning_count++] = (CoWarning){kept_place, kept_text, 1, severity};
}

size_t cohort_scene_warnings(const CohortScene *scene, const CohortDiagnostic **out)
{
    *out = scene->diagnostics;
    return scene->diagnostics ? scene->diagnostic_capacity : 0; // edits may have warned since
}

CohortScene *cohort_scene_create(CohortError *err)
{
    CohortScene *scene = co_alloc_zero(TAG, sizeof *scene);
    CO_CHECK_NULL(scene, err, COHORT_ERROR_OUT_OF_MEMORY, "out of memory for a scene");
    scene->names.tag = TAG;
    if (cohort_scene_new_object(scene, err) == COHORT_INVALID_ID) {
        cohort_scene_destroy(scene);
        return NULL;
    }
    scene->objects[0].kind = CO_OBJECT_GROUP;
    return scene;
}

void co_scene_object_release(CoSceneObject *object)
{
    co_bvh_destroy(object->bvh);
    object->bvh = NULL;
    co_top_destroy(object->top);
    object->top = NULL;
    co_free(TAG, object->instances, object->instance_capacity * sizeof *object->instances);
    object->instances = NULL;
    co_free(TAG, object->edit_of, object->instance_capacity * sizeof *object->edit_of);
    object->edit_of = NULL;
    object->instance_count = object->instance_capacity = 0;
    if (object->parts)
        co_free(TAG, object->parts, object->part_count * sizeof *object->parts);
    object->parts = NULL;
    object->part_count = 0;
}

static void object_clear(CoSceneObject *object)
{
    co_scene_object_release(object);
    if (object->kind == CO_OBJECT_MESH)
        co_mesh_destroy(&object->mesh);
    co_free(TAG, object->materials, object->material_slots * sizeof *object->materials);
    co_free(TAG, object->edits, object->edit_count * sizeof *object->edits);
    co_free(TAG, object->edit_colors, object->edit_count * 3 * sizeof(float));
    memset(object, 0, sizeof *object);
    object->is_dirty = true;
}

void cohort_scene_destroy(CohortScene *scene)
{
    if (!scene)
        return;
    for (uint32_t i = 0; i < scene->object_count; i++)
        object_clear(&scene->objects[i]);
    for (uint32_t i = 0; i < scene->material_count; i++)
        co_arena_clear(&scene->materials[i].arena);
    co_lights_destroy(scene->lights);
    for (uint32_t i = 0; i < scene->light_image_count; i++)
        co_image_free((float *)(uintptr_t)scene->light_images[i].pixels,
                      scene->light_images[i].width, scene->light_images[i].height);
    co_textures_destroy(scene->textures);
    co_color_destroy(scene->color);
    co_free(TAG, scene->light_images, scene->light_image_count * sizeof *scene->light_images);
    co_free(TAG, scene->texture_ids, scene->texture_id_capacity * sizeof *scene->texture_ids);
    co_free(TAG, scene->accel_objects, scene->accel_object_count * sizeof *scene->accel_objects);
    co_free(TAG, scene->objects, scene->object_capacity * sizeof *scene->objects);
    co_free(TAG, scene->texture_descs, scene->texture_capacity * sizeof *scene->texture_descs);
    co_free(TAG, scene->materials, scene->material_capacity * sizeof *scene->materials);
    co_free(TAG, scene->light_descs, scene->light_capacity * sizeof *scene->light_descs);
    co_free(TAG, scene->warnings, scene->warning_capacity * sizeof *scene->warnings);
    co_free(TAG, scene->diagnostics, scene->diagnostic_capacity * sizeof *scene->diagnostics);
    co_arena_clear(&scene->names);
    co_free(TAG, scene, sizeof *scene);
}

uint32_t cohort_scene_new_object(CohortScene *scene, CohortError *err)
{
    if (!co_scene_grow((void **)&scene->objects, &scene->object_capacity, scene->object_count,
                       sizeof(CoSceneObject))) {
        CO_FAIL(err, COHORT_ERROR_OUT_OF_MEMORY, "out of memory for %u objects",
                scene->object_count);
        return COHORT_INVALID_ID;
    }
    memset(&scene->objects[scene->object_count], 0, sizeof(CoSceneObject));
    scene->objects[scene->object_count].is_dirty = true;
    return scene->object_count++;
}

void cohort_scene_clear_object(CohortScene *scene, uint32_t object)
{
    if (object >= scene->object_count)
        return;
    object_clear(&scene->objects[object]);
    if (object == 0)
        scene->objects[0].kind = CO_OBJECT_GROUP;
    scene->is_committed = false;
}

static bool check_object(const CohortScene *scene, uint32_t object, CohortError *err)
{
    CO_CHECK(object < scene->object_count, err, COHORT_ERROR_ARGUMENT,
             "there is no object %u in this scene", object);
    return true;
}

// Points far from their own origin lose bits when rays are brought to them: such a mesh is moved by
// a power-of-two multiple, which its instances' transforms, kept in double, take back.
static void choose_origin(const CohortMeshDesc *desc, double origin[3])
{
    double lo[3] = {HUGE_VAL, HUGE_VAL, HUGE_VAL}, hi[3] = {-HUGE_VAL, -HUGE_VAL, -HUGE_VAL};
    for (size_t i = 0; i < desc->point_count * 3; i++) {
        double x = (double)desc->points[i];
        if (isfinite(x)) {
            lo[i % 3] = x < lo[i % 3] ? x : lo[i % 3];
            hi[i % 3] = x > hi[i % 3] ? x : hi[i % 3];
        }
    }
    double size = fmax(fmax(hi[0] - lo[0], hi[1] - lo[1]), hi[2] - lo[2]);
    for (int k = 0; k < 3; k++) {
        double center = 0.5 * (lo[k] + hi[k]);
        bool far = size > 0.0 && isfinite(size) && fabs(center) > 8.0 * size;
        double grid = far ? ldexp(1.0, ilogb(size)) : 1.0;
        origin[k] = far ? grid * round(center / grid) : 0.0;
    }
}

typedef struct MeshWarning {
    CohortScene *scene;
    const char *path;
} MeshWarning;

static void mesh_warn(void *cookie, const char *text)
{
    const MeshWarning *w = cookie;
    co_scene_warn(w->scene, COHORT_SEVERITY_WARNING, w->path, text);
}

// The mesh keeps a slot by face and the object the material by slot, so that other materials need
// no other mesh. Gives the description with slots; its subsets are scratch.
static bool make_slots(CoSceneObject *o, const CohortMeshDesc *desc, CohortMeshDesc *slotted,
                       CohortError *err)
{
    size_t count = desc->subset_count;
    CO_CHECK(count < UINT32_MAX, err, COHORT_ERROR_LIMIT, "%zu subsets in one mesh", count);
    CO_CHECK(desc->subsets || count == 0, err, COHORT_ERROR_ARGUMENT, "subsets are missing");
    *slotted = *desc;
    slotted->material = 0;
    CohortSubsetDesc *subsets = co_alloc(TAG, (count + 1) * sizeof *subsets);
    o->materials = co_alloc(TAG, (count + 1) * sizeof *o->materials);
    slotted->subsets = subsets;
    o->material_slots = o->materials ? (uint32_t)count + 1 : 0;
    CO_CHECK(subsets && o->materials, err, COHORT_ERROR_OUT_OF_MEMORY,
             "out of memory for %zu subsets", count);
    o->materials[0] = desc->material;
    for (size_t i = 0; i < count; i++) {
        o->materials[i + 1] = desc->subsets[i].material;
        subsets[i] = desc->subsets[i];
        subsets[i].material = (uint32_t)i + 1;
    }
    return true;
}

static bool moved_mesh_create(const CohortMeshDesc *desc, CoSceneObject *object,
                              MeshWarning *warning, CohortError *err)
{
    CohortMeshDesc moved = *desc;
    size_t bytes;
    CO_CHECK(co_size_mul(desc->point_count, 3 * sizeof(float), &bytes), err, COHORT_ERROR_LIMIT,
             "%s: too many points", desc->path ? desc->path : "mesh");
    float *points = co_alloc(TAG, bytes);
    CO_CHECK_MEMORY(points, err);
    for (size_t i = 0; i < desc->point_count * 3; i++)
        points[i] = (float)((double)desc->points[i] - object->origin[i % 3]);
    moved.points = points;
    bool ok = co_mesh_create(&moved, &object->mesh, mesh_warn, warning, err);
    co_free(TAG, points, bytes);
    return ok;
}

static bool make_mesh(CohortScene *scene, CoSceneObject *o, const CohortMeshDesc *desc,
                      CohortError *err)
{
    MeshWarning warning = {scene, desc->path};
    choose_origin(desc, o->origin);
    bool is_moved = o->origin[0] != 0.0 || o->origin[1] != 0.0 || o->origin[2] != 0.0;
    CohortMeshDesc slotted = {.subsets = NULL};
    bool ok = make_slots(o, desc, &slotted, err);
    if (ok)
        ok = is_moved ? moved_mesh_create(&slotted, o, &warning, err)
                      : co_mesh_create(&slotted, &o->mesh, mesh_warn, &warning, err);
    co_free(TAG, (void *)(uintptr_t)slotted.subsets,
            (desc->subset_count + 1) * sizeof *slotted.subsets);
    if (ok)
        o->kind = CO_OBJECT_MESH;
    return ok;
}

bool cohort_scene_set_mesh(CohortScene *scene, uint32_t object, const CohortMeshDesc *desc,
                           CohortError *err)
{
    if (!check_object(scene, object, err))
        return false;
    CO_CHECK(object != 0, err, COHORT_ERROR_ARGUMENT, "object 0 is the root group, not a mesh");
    CoSceneObject *o = &scene->objects[object], before = {.kind = CO_OBJECT_EMPTY};
    if (o->bvh) { // kept until it is known whether only the points have moved
        before.mesh = o->mesh;
        before.bvh = o->bvh;
        o->bvh = NULL;
        memset(&o->mesh, 0, sizeof o->mesh);
    }
    object_clear(o);
    scene->is_committed = false;
    scene->counts.mesh_builds++;
    bool ok = make_mesh(scene, o, desc, err);
    if (ok && before.bvh && co_mesh_same_topology(&before.mesh, &o->mesh)) {
        o->bvh = before.bvh;
        o->is_deformed = true;
        before.bvh = NULL;
    }
    co_bvh_destroy(before.bvh);
    co_mesh_destroy(&before.mesh);
    return ok;
}

bool cohort_scene_set_mesh_materials(CohortScene *scene, uint32_t object, uint32_t material,
                                     const uint32_t *subset_materials, size_t subset_count,
                                     CohortError *err)
{
    if (!check_object(scene, object, err))
        return false;
    CoSceneObject *o = &scene->objects[object];
    CO_CHECK(o->kind == CO_OBJECT_MESH && o->material_slots == subset_count + 1, err,
             COHORT_ERROR_ARGUMENT, "object %u is no mesh of %zu subsets", object, subset_count);
    o->materials[0] = material;
    for (size_t i = 0; i < subset_count; i++)
        o->materials[i + 1] = subset_materials[i];
    scene->counts.material_binds++;
    scene->is_committed = false;
    return true;
}

bool cohort_scene_set_group(CohortScene *scene, uint32_t object,
                            const CohortInstanceDesc *instances, size_t count, CohortError *err)
{
    if (!check_object(scene, object, err))
        return false;
    CO_CHECK(count < UINT32_MAX / 2, err, COHORT_ERROR_LIMIT, "%zu instances in one group", count);
    for (size_t i = 0; i < count; i++)
        if (!check_object(scene, instances[i].object, err))
            return false;
    CoSceneObject *o = &scene->objects[object];
    CoTop *kept = o->top; // the commit may refit it
    o->top = NULL;
    object_clear(o);
    o->top = kept;
    o->kind = CO_OBJECT_GROUP;
    scene->is_committed = false;
    if (count == 0)
        return true;
    o->edits = co_alloc(TAG, count * sizeof *o->edits);
    o->edit_colors = co_alloc_zero(TAG, count * 3 * sizeof(float));
    o->edit_count = (uint32_t)count;
    if (!o->edits || !o->edit_colors) {
        cohort_scene_clear_object(scene, object);
        return CO_FAIL(err, COHORT_ERROR_OUT_OF_MEMORY, "out of memory for %zu instances", count);
    }
    memcpy(o->edits, instances, count * sizeof *o->edits);
    for (size_t i = 0; i < count; i++) {
        if (!instances[i].display_color)
            continue;
        memcpy(&o->edit_colors[3 * i], instances[i].display_color, 3 * sizeof(float));
        o->edits[i].display_color = &o->edit_colors[3 * i];
    }
    return true;
}

bool cohort_scene_set_camera(CohortScene *scene, const CohortCameraDesc *desc, CohortError *err)
{
    bool ok = true;
    for (int i = 0; i < 16; i++)
        ok = ok && isfinite(desc->transform[i / 4][i % 4]);
    for (int i = 0; i < 4; i++)
        ok = ok && isfinite(desc->window[i]);
    CO_CHECK(ok && desc->window[0] != desc->window[1] && desc->window[2] != desc->window[3], err,
             COHORT_ERROR_SCENE, "the camera's transform or window is degenerate or not finite");
    scene->camera_desc = *desc;
    scene->has_camera = scene->camera_dirty = true;
    scene->is_committed = false;
    return true;
}

CohortLightDesc cohort_light_default(CohortLightType type)
{
    CohortLightDesc desc = {.type = type,
                            .color = {1.0f, 1.0f, 1.0f},
                            .intensity = type == COHORT_LIGHT_DISTANT ? 50000.0f : 1.0f,
                            .color_temperature = 6500.0f,
                            .diffuse = 1.0f,
                            .specular = 1.0f,
                            .width = 1.0f,
                            .height = 1.0f,
                            .radius = 0.5f,
                            .angle_degrees = 0.53f,
                            .shaping_cone_angle_degrees = 90.0f};
    for (int i = 0; i < 4; i++)
        desc.transform[i][i] = 1.0;
    return desc;
}

uint32_t cohort_scene_new_light(CohortScene *scene, CohortError *err)
{
    if (!co_scene_grow((void **)&scene->light_descs, &scene->light_capacity, scene->light_count,
                       sizeof(CohortLightDesc))) {
        CO_FAIL(err, COHORT_ERROR_OUT_OF_MEMORY, "out of memory for a light");
        return COHORT_INVALID_ID;
    }
    scene->light_descs[scene->light_count] = cohort_light_default(COHORT_LIGHT_RECT);
    scene->light_descs[scene->light_count].hidden = true;
    scene->lights_dirty = true;
    return scene->light_count++;
}

// Copies a text, which may be NULL, into the scene. False when out of memory.
static bool keep_string(CohortScene *scene, const char *text, const char **out)
{
    *out = co_scene_string(scene, text);
    return *out || !text;
}

bool cohort_scene_set_light(CohortScene *scene, uint32_t light, const CohortLightDesc *desc,
                            CohortError *err)
{
    CO_CHECK(light < scene->light_count, err, COHORT_ERROR_ARGUMENT,
             "there is no light %u in this scene", light);
    CohortLightDesc kept = *desc;
    bool is_kept =
        keep_string(scene, desc->path ? desc->path : "", &kept.path) &&
        keep_string(scene, desc->texture_file, &kept.texture_file) &&
        keep_string(scene, desc->texture_asset, &kept.texture_asset) &&
        keep_string(scene, desc->texture_color_space_name, &kept.texture_color_space_name);
    CO_CHECK(is_kept, err, COHORT_ERROR_OUT_OF_MEMORY, "out of memory for a light");
    scene->light_descs[light] = kept;
    scene->lights_dirty = true;
    scene->is_committed = false;
    return true;
}

uint32_t cohort_scene_new_texture(CohortScene *scene, const CohortTextureDesc *desc,
                                  CohortError *err)
{
    uint32_t id = scene->texture_count;
    CohortTextureDesc kept = *desc;
    bool is_kept = co_scene_grow((void **)&scene->texture_descs, &scene->texture_capacity, id,
                                 sizeof *scene->texture_descs) &&
                   co_scene_grow((void **)&scene->texture_ids, &scene->texture_id_capacity, id,
                                 sizeof *scene->texture_ids) &&
                   keep_string(scene, desc->path ? desc->path : "", &kept.path) &&
                   keep_string(scene, desc->asset ? desc->asset : desc->path, &kept.asset) &&
                   keep_string(scene, desc->color_space_name, &kept.color_space_name);
    if (!is_kept) {
        CO_FAIL(err, COHORT_ERROR_OUT_OF_MEMORY, "out of memory for a texture");
        return COHORT_INVALID_ID;
    }
    scene->texture_descs[id] = kept;
    scene->texture_count++;
    scene->is_committed = false;
    return id;
}
