#include "fake_renderer.h"

#include "base/error.h"

#include <stdatomic.h>
#include <stdio.h>
#include <string.h>
#include <time.h>

FakeRenderer fake;
static atomic_bool cancelled;

struct CohortScene {
    int unused;
};
struct CohortRender {
    _Atomic uint64_t rounds; // progress is asked for from any thread
};
static struct CohortScene the_scene;
static struct CohortRender the_render;

void fake_reset(void)
{
    memset(&fake, 0, sizeof fake);
    fake.object_count = 1; // the root group
    fake.rounds_to_do = 3;
    atomic_store(&cancelled, false);
}

static void note_edit(void)
{
    if (fake.renders_live)
        fake.edits_during_render++;
}

// What comes after the first FAKE_MAX is not kept apart.
static uint32_t slot(uint32_t id)
{
    return id < FAKE_MAX ? id : FAKE_MAX - 1;
}

static FakeObject *object_at(uint32_t id)
{
    return &fake.objects[slot(id)];
}

static void copy_path(char out[FAKE_PATH], const char *path)
{
    strncpy(out, path ? path : "", FAKE_PATH - 1);
}

// ---- Scene -------------------------------------------------------------------------------------

CohortScene *cohort_scene_create(CohortError *err)
{
    (void)err;
    return &the_scene;
}

void cohort_scene_destroy(CohortScene *scene)
{
    (void)scene;
}

uint32_t cohort_scene_new_object(CohortScene *scene, CohortError *err)
{
    (void)scene, (void)err;
    return fake.object_count++;
}

static void record_primvar(const CohortPrimvarDesc *desc, FakePrimvar *out)
{
    *out = (FakePrimvar){.interpolation = desc->interpolation,
                         .components = desc->components,
                         .value_count = desc->value_count,
                         .index_count = desc->index_count};
    snprintf(out->name, sizeof out->name, "%s", desc->name);
    memcpy(out->first, desc->values, desc->components * sizeof *out->first);
}

bool cohort_scene_set_mesh(CohortScene *scene, uint32_t object, const CohortMeshDesc *desc,
                           CohortError *err)
{
    (void)scene;
    note_edit();
    fake.set_mesh_calls++;
    CO_CHECK(!fake.fail_set_mesh, err, COHORT_ERROR_SCENE, "refused on purpose");
    FakeObject *o = object_at(object);
    *o = (FakeObject){.is_mesh = true,
                      .level = desc->level,
                      .material = desc->material,
                      .ptex_face_offset = desc->ptex_face_offset,
                      .scheme = desc->scheme,
                      .point_count = desc->point_count,
                      .primvar_count = desc->primvar_count};
    for (size_t i = 0; desc->edge_levels && i < desc->face_vertex_index_count; i++)
        o->level = desc->edge_levels[i] > o->level ? desc->edge_levels[i] : o->level;
    copy_path(o->path, desc->path);
    if (desc->subset_count) {
        o->subset_material = desc->subsets[0].material;
        o->subset_faces = desc->subsets[0].face_count;
    }
    for (size_t i = 0; i < desc->primvar_count; i++) {
        const CohortPrimvarDesc *p = &desc->primvars[i];
        if (strcmp(p->name, "displayColor") == 0)
            memcpy(o->first_color, p->values, sizeof o->first_color);
        if (i < sizeof o->primvars / sizeof *o->primvars)
            record_primvar(p, &o->primvars[i]);
    }
    if (desc->point_count)
        memcpy(o->first_point, desc->points, sizeof o->first_point);
    fake.counts.mesh_builds++;
    return true;
}

bool cohort_scene_set_mesh_materials(CohortScene *scene, uint32_t object, uint32_t material,
                                     const uint32_t *subset_materials, size_t subset_count,
                                     CohortError *err)
{
    (void)scene;
    (void)err;
    note_edit();
    FakeObject *o = object_at(object);
    o->material = material;
    if (subset_count)
        o->subset_material = subset_materials[0];
    fake.counts.material_binds++;
    return true;
}

bool cohort_scene_set_group(CohortScene *scene, uint32_t object,
                            const CohortInstanceDesc *instances, size_t count, CohortError *err)
{
    (void)scene, (void)err;
    note_edit();
    fake.set_group_calls++;
    FakeObject *o = object_at(object);
    *o = (FakeObject){.is_group = true, .instance_count = count};
    for (size_t i = 0; i < count && i < 64; i++) {
        o->instances[i] = instances[i];
        if (instances[i].display_color)
            memcpy(o->colors[i], instances[i].display_color, sizeof o->colors[i]);
    }
    fake.counts.group_builds++;
    return true;
}

void cohort_scene_placements(const CohortScene *scene, CohortPlacementFn *fn, void *cookie)
{
    (void)scene;
    const FakeObject *root = &fake.objects[0];
    for (size_t i = 0; i < root->instance_count && i < 64; i++)
        fn(cookie, root->instances[i].object, (const double(*)[4])root->instances[i].transform);
}

void cohort_scene_clear_object(CohortScene *scene, uint32_t object)
{
    (void)scene;
    note_edit();
    *object_at(object) = (FakeObject){0};
}

CohortMaterialDesc cohort_material_default(void)
{
    return (CohortMaterialDesc){.diffuse_color = {.value = {0.18f, 0.18f, 0.18f, 1.0f}},
                                .roughness = {.value = {0.5f}},
                                .opacity = {.value = {1.0f}},
                                .ior = {.value = {1.5f}}};
}

uint32_t cohort_scene_new_texture(CohortScene *scene, const CohortTextureDesc *desc,
                                  CohortError *err)
{
    (void)scene, (void)err;
    note_edit();
    fake.textures[slot(fake.texture_count)] = *desc;
    copy_path(fake.texture_paths[slot(fake.texture_count)], desc->path);
    return fake.texture_count++;
}

uint32_t cohort_scene_new_material(CohortScene *scene, CohortError *err)
{
    (void)scene, (void)err;
    return fake.material_count++;
}

bool cohort_scene_set_material(CohortScene *scene, uint32_t material,
                               const CohortMaterialDesc *desc, CohortError *err)
{
    (void)scene, (void)err;
    note_edit();
    fake.set_material_calls++;
    fake.materials[slot(material)] = *desc;
    if (desc->lookup_count)
        memcpy(fake.lookups[slot(material)], desc->lookups,
               desc->lookup_count * sizeof *desc->lookups);
    return true;
}

CohortLightDesc cohort_light_default(CohortLightType type)
{
    return (CohortLightDesc){.type = type, .intensity = 1.0f};
}

uint32_t cohort_scene_new_light(CohortScene *scene, CohortError *err)
{
    (void)scene, (void)err;
    return fake.light_count++;
}

bool cohort_scene_set_light(CohortScene *scene, uint32_t light, const CohortLightDesc *desc,
                            CohortError *err)
{
    (void)scene, (void)err;
    note_edit();
    fake.set_light_calls++;
    fake.lights[slot(light)] = *desc;
    return true;
}

bool cohort_scene_set_camera(CohortScene *scene, const CohortCameraDesc *desc, CohortError *err)
{
    (void)scene, (void)err;
    note_edit();
    fake.set_camera_calls++;
    fake.camera = *desc;
    return true;
}

bool cohort_scene_commit(CohortScene *scene, const CohortSceneOptions *options, CohortError *err)
{
    (void)scene, (void)options;
    note_edit();
    fake.commits++;
    CO_CHECK(!fake.fail_commit, err, COHORT_ERROR_SCENE, "commit refused on purpose");
    return true;
}

void cohort_scene_counts(const CohortScene *scene, CohortSceneCounts *out)
{
    (void)scene;
    *out = fake.counts;
}

bool cohort_scene_bounds(const CohortScene *scene, double box[6])
{
    (void)scene;
    const double unit[6] = {-1, -2, -3, 1, 2, 3};
    memcpy(box, unit, sizeof unit);
    return true;
}

size_t cohort_scene_warnings(const CohortScene *scene, const CohortDiagnostic **out)
{
    (void)scene;
    *out = NULL;
    return 0;
}

// ---- Render ------------------------------------------------------------------------------------

CohortRender *cohort_render_create(const CohortScene *scene, const CohortRenderSettings *settings,
                                   CohortError *err)
{
    (void)scene;
    CO_CHECK_NULL(!fake.fail_create, err, COHORT_ERROR_LIMIT, "create refused on purpose");
    fake.settings = *settings;
    fake.renders_made++;
    fake.renders_live++;
    the_render.rounds = 0;
    return &the_render;
}

void cohort_render_destroy(CohortRender *render)
{
    (void)render;
    fake.renders_live--;
}

bool cohort_render_round(CohortRender *render, CohortError *err)
{
    const long step = 1000000;
    if (fake.renders_live == 0)
        fake.rounds_of_the_dead++;
    for (long passed = 0; passed < fake.round_nanoseconds; passed += step) {
        struct timespec pause = {.tv_nsec = step};
        nanosleep(&pause, NULL);
        CO_CHECK(!atomic_exchange(&cancelled, false), err, COHORT_ERROR_CANCELLED, "cancelled");
    }
    CO_CHECK(!fake.fail_round, err, COHORT_ERROR_FILE_WRITE, "disk full on purpose");
    render->rounds++;
    return true;
}

bool cohort_render_is_done(const CohortRender *render)
{
    return render->rounds >= fake.rounds_to_do;
}

void cohort_render_cancel(CohortRender *render)
{
    (void)render;
    atomic_store(&cancelled, true);
}

double cohort_render_progress(const CohortRender *render)
{
    return (double)render->rounds / (double)fake.rounds_to_do;
}

void cohort_render_stats(const CohortRender *render, CohortRenderStats *out)
{
    *out = (CohortRenderStats){.rounds = render->rounds, .samples_per_pixel = render->rounds};
}

uint32_t cohort_aov_components(CohortAov aov)
{
    return aov == COHORT_AOV_COLOR                                ? 4
           : aov == COHORT_AOV_NORMAL || aov == COHORT_AOV_ALBEDO ? 3
                                                                  : 1;
}

// Every component is the row counted from the top, plus the rounds times 100.
bool cohort_render_aov(const CohortRender *render, CohortAov aov, void *out)
{
    uint32_t width = fake.settings.width, n = cohort_aov_components(aov);
    for (uint32_t y = 0; y < fake.settings.height; y++)
        for (uint32_t i = 0; i < width * n; i++) {
            float value = (float)y + 100.0f * (float)render->rounds;
            int32_t id = (int32_t)y;
            bool is_id = aov == COHORT_AOV_PRIM_ID || aov == COHORT_AOV_ELEMENT_ID;
            memcpy((char *)out + 4 * ((size_t)y * width * n + i), is_id ? (void *)&id : &value, 4);
        }
    return true;
}

bool cohort_render_save(const CohortRender *render, const char *path, uint64_t stage_hash,
                        CohortError *err)
{
    (void)render;
    CO_CHECK(path[0] == '/', err, COHORT_ERROR_FILE_WRITE, "cannot write there");
    fake.saves++;
    fake.saved_hash = stage_hash;
    return true;
}

bool cohort_render_resume(CohortRender *render, const char *path, uint64_t stage_hash,
                          CohortError *err)
{
    (void)path;
    CO_CHECK(stage_hash == fake.saved_hash, err, COHORT_ERROR_SCENE, "another stage");
    fake.resumes++;
    render->rounds = 1;
    return true;
}
