#include "stage_adapter/adapter.h"

#include "base/error.h"
#include "index/index.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

// ---- Callbacks ---------------------------------------------------------------------------------

// USD's domes have their pole at +Y; one with its pole at +Z is turned so that longitude 0 is -Y.
static CoMat4d pole_turn(bool z_pole)
{
    CoMat4d m = co_mat4d_identity();
    if (z_pole) {
        m.m[1][1] = m.m[2][2] = 0.0;
        m.m[1][2] = 1.0;
        m.m[2][1] = -1.0;
    }
    return m;
}

static CoMat4d light_transform(const CohortAdapter *a, const CoRecord *record)
{
    CoMat4d world = co_place_world_transform(a, (CoPlace){record->prim, record->prototype});
    if (strcmp(cohort_prim_type(record->prim), "DomeLight_1") != 0)
        return world;
    const char *axis = cohort_prim_token(record->prim, "poleAxis", a->time, "scene");
    if (strcmp(axis, "scene") == 0)
        axis = a->info.up_axis;
    CoMat4d turn = pole_turn(strcmp(axis, "Z") == 0);
    return co_mat4d_mul(&turn, &world);
}

static CoMat4d camera_transform(const CohortAdapter *a)
{
    const CoRecord *camera = co_record_find(a, a->resolved.camera);
    if (camera->kind == CO_RECORD_FRAMING_CAMERA)
        return co_frame_transform(a);
    return co_place_world_transform(a, (CoPlace){camera->prim, camera->prototype});
}

static CoMat4d transform_of(const CohortAdapter *a, const CoRecord *record)
{
    switch (record->kind) {
    case CO_RECORD_MESH:
    case CO_RECORD_POINT_INSTANCER:
        return co_place_transform(a, (CoPlace){record->prim, record->prototype});
    case CO_RECORD_LIGHT:
        return light_transform(a, record);
    case CO_RECORD_CAMERA:
        return co_place_world_transform(a, (CoPlace){record->prim, record->prototype});
    case CO_RECORD_FRAMING_CAMERA:
        return co_frame_transform(a);
    case CO_RECORD_HEADLIGHT:
        return camera_transform(a);
    case CO_RECORD_ENV:
        return pole_turn(strcmp(a->info.up_axis, "Z") == 0);
    case CO_RECORD_NATIVE_INSTANCES:
    case CO_RECORD_MATERIAL:
        break;
    }
    return co_mat4d_identity();
}

static bool pull_transform(void *cookie, CohortPull *pull, const char *path,
                           const CohortTransformSample **out, size_t *count, CohortError *err)
{
    CohortAdapter *a = cookie;
    const CoRecord *record = co_record_find(a, path);
    CohortTransformSample *sample = cohort_pull_array(pull, 1, sizeof *sample);
    CO_CHECK_MEMORY(sample, err);
    CO_CHECK(record, err, COHORT_ERROR_INTERNAL, "the adapter knows no prim at %.180s", path);
    CoMat4d m = transform_of(a, record);
    memcpy(sample->matrix, m.m, sizeof m.m);
    *out = sample;
    *count = 1;
    return true;
}

static bool pull_visible(void *cookie, const char *path)
{
    CohortAdapter *a = cookie;
    const CoRecord *record = co_record_find(a, path);
    if (!record || !record->prim)
        return true;
    CoPlace place = {record->prim, record->prototype};
    return record->kind == CO_RECORD_LIGHT ? co_place_is_visible_in_world(a, place)
                                           : co_place_is_visible(a, place);
}

// ---- Open and destroy --------------------------------------------------------------------------

static const char *copy_text(CohortAdapter *a, const char *text)
{
    return text ? co_arena_string(&a->arena, text, strlen(text)) : NULL;
}

static bool copy_options(CohortAdapter *a, const CohortAdapterOptions *options, CohortError *err)
{
    if (!options)
        return true;
    a->options = *options;
    const char **texts[] = {&a->options.camera, &a->options.render_settings, &a->options.env};
    for (size_t i = 0; i < sizeof texts / sizeof texts[0]; i++) {
        const char *given = *texts[i];
        *texts[i] = copy_text(a, given);
        CO_CHECK(!given || *texts[i], err, COHORT_ERROR_OUT_OF_MEMORY, "out of memory");
    }
    return true;
}

static bool ran_short(void *cookie)
{
    const CohortAdapter *a = cookie;
    return cohort_stage_ran_short(a->stage);
}

// Forgets what was lost for want of memory before: that was another's.
static void begin(const CohortAdapter *a)
{
    co_report_begin(&a->delegate->report);
    co_delegate_has_lost(a->delegate);
    if (a->stage)
        cohort_stage_ran_short(a->stage);
}

// Whether it was done, the stage said all there is since then, and the report got it. What was said
// where memory ended may be untrue, and what was made of it as well.
static bool end(const CohortAdapter *a, bool ok, const CohortError *why, CohortError *err)
{
    CohortError said = *why;
    bool has_lost = co_delegate_has_lost(a->delegate);
    if (has_lost || (a->stage && cohort_stage_ran_short(a->stage))) {
        said = (CohortError){0};
        ok = CO_FAIL(&said, COHORT_ERROR_OUT_OF_MEMORY, "out of memory");
    }
    co_report_end(&a->delegate->report, said.code != COHORT_ERROR_OUT_OF_MEMORY);
    if (!ok && err && err->code == COHORT_OK)
        *err = said;
    return ok;
}

// What composition leaves out is part of the one report, besides going to the client's callback.
static void report_composition(void *cookie, CohortSeverity severity, const char *file,
                               uint32_t line, uint32_t column, const char *prim_path,
                               const char *text)
{
    const CohortAdapter *a = cookie;
    const CohortStageOptions *client = &a->options.stage;
    if (client->report)
        client->report(client->cookie, severity, file, line, column, prim_path, text);
    if (severity > COHORT_SEVERITY_WARNING)
        return;
    char place[512];
    snprintf(place, sizeof place, line ? "%s:%u" : "%s", file ? file : "", line);
    co_delegate_note(a->delegate, severity, prim_path ? prim_path : "", "composition", place, text);
}

static CohortStage *open_stage(CohortAdapter *a, const char *path, CohortError *err)
{
    CohortStageOptions options = a->options.stage;
    options.report = report_composition;
    options.cookie = a;
    return cohort_stage_open(path, &options, err);
}

static double choose_time(const CohortAdapter *a)
{
    double earliest;
    if (a->options.time_choice == COHORT_TIME_AT)
        return a->options.time;
    if (a->options.time_choice == COHORT_TIME_DEFAULTS ||
        !cohort_stage_earliest_time(a->stage, &earliest))
        return (double)NAN;
    return earliest;
}

CohortAdapter *cohort_adapter_open(CohortDelegate *delegate, const char *path,
                                   const CohortAdapterOptions *options, CohortError *err)
{
    CO_CHECK_NULL(delegate->index, err, COHORT_ERROR_ARGUMENT, "the delegate has no render index");
    CohortAdapter *a = co_alloc_zero(CO_MEMORY_DELEGATE, sizeof *a);
    CO_CHECK_NULL(a, err, COHORT_ERROR_OUT_OF_MEMORY, "out of memory");
    a->delegate = delegate;
    a->index = delegate->index;
    a->arena.tag = CO_MEMORY_DELEGATE;
    a->scene = (CohortSceneDelegate){.cookie = a,
                                     .get_mesh = co_pull_mesh,
                                     .get_instancer = co_pull_instancer,
                                     .get_transform = pull_transform,
                                     .get_visible = pull_visible,
                                     .get_light = co_pull_light,
                                     .get_camera = co_pull_camera,
                                     .get_material = co_pull_material,
                                     .ran_short = ran_short};
    CohortError why = {0};
    begin(a);
    if (copy_options(a, options, &why))
        a->stage = open_stage(a, path, &why);
    if (a->stage) {
        cohort_stage_info(a->stage, &a->info);
        a->time = choose_time(a);
    }
    if (!end(a, a->stage != NULL, &why, err)) {
        cohort_adapter_destroy(a);
        return NULL;
    }
    return a;
}

void cohort_adapter_destroy(CohortAdapter *a)
{
    if (!a)
        return;
    for (size_t i = 0; i < a->record_count; i++)
        cohort_render_index_remove(a->index, a->records[i].path);
    if (a->env_is_made)
        close(a->env_descriptor);
    if (a->stage)
        cohort_stage_destroy(a->stage);
    co_free(CO_MEMORY_DELEGATE, a->records, a->record_capacity * sizeof *a->records);
    co_free(CO_MEMORY_DELEGATE, a->prototypes, a->prototype_capacity * sizeof *a->prototypes);
    co_free(CO_MEMORY_DELEGATE, a->placements, a->placement_capacity * sizeof *a->placements);
    co_free(CO_MEMORY_DELEGATE, a->cameras, a->camera_capacity * sizeof *a->cameras);
    co_string_map_clear(&a->paths);
    co_string_map_clear(&a->prototype_keys);
    co_string_map_clear(&a->lights_below);
    co_string_map_clear(&a->primvars);
    co_arena_clear(&a->arena);
    co_free(CO_MEMORY_DELEGATE, a, sizeof *a);
}

// ---- Populate ----------------------------------------------------------------------------------

// The built-in sky goes through a file, as every dome texture does: one without a name, so that
// nothing stays of it however the process ends.
static bool make_sky(CohortAdapter *a, CohortError *err)
{
    const char *folder = getenv("TMPDIR");
    char path[512];
    folder = folder && folder[0] ? folder : "/tmp";
    int n = snprintf(path, sizeof path, "%s/cohort-sky-XXXXXX", folder);
    int file = n > 0 && (size_t)n < sizeof path ? mkstemp(path) : -1;
    CO_CHECK(file >= 0, err, COHORT_ERROR_FILE_WRITE,
             "cannot make a temporary file for the sky, %.150s; TMPDIR names another folder", path);
    unlink(path);
    a->env_is_made = true;
    a->env_descriptor = file;
    snprintf(path, sizeof path, "/proc/self/fd/%d", file);
    a->env_file = copy_text(a, path);
    CO_CHECK_MEMORY(a->env_file, err);
    CO_CHECK(co_sky_write(path, NULL), err, COHORT_ERROR_FILE_WRITE,
             "the sky, half a megabyte, does not fit into %.150s; TMPDIR names another folder",
             folder);
    return true;
}

static bool add_own_lights(CohortAdapter *a, CohortError *err)
{
    CoRecord env = {.kind = CO_RECORD_ENV, .path = CO_ENV_PATH, .prototype = CO_WORLD};
    CoRecord head = {.kind = CO_RECORD_HEADLIGHT, .path = CO_HEADLIGHT_PATH, .prototype = CO_WORLD};
    if (a->options.env && a->options.env[0]) {
        a->env_file = a->options.env;
        if (strcmp(a->options.env, "sky") == 0 && !make_sky(a, err))
            return false;
        if (!co_record_add(a, &env, COHORT_PRIM_LIGHT, err))
            return false;
    }
    return !a->options.headlight || co_record_add(a, &head, COHORT_PRIM_LIGHT, err) != NULL;
}

static bool set_color_space(CohortAdapter *a, CohortError *err)
{
    CohortSettingValue value;
    const char *key = "cohort:renderingColorSpace";
    if (!a->resolved.rendering_color_space[0] ||
        (cohort_delegate_get(a->delegate, key, &value) && value.string[0]))
        return true;
    return cohort_delegate_set_string(a->delegate, key, a->resolved.rendering_color_space, err);
}

bool cohort_adapter_populate(CohortAdapter *a, CohortError *err)
{
    CO_CHECK(a->record_count == 0, err, COHORT_ERROR_ARGUMENT, "the stage is in the index already");
    CohortError why = {0};
    begin(a);
    bool ok = co_resolve_settings(a, &why) && set_color_space(a, &why) && co_walk_stage(a, &why) &&
              co_resolve_camera(a, &why) && add_own_lights(a, &why);
    if (ok)
        co_resolve_size(a);
    return end(a, ok, &why, err);
}

// ---- Time --------------------------------------------------------------------------------------

static bool is_one_of(const char *name, const char *const *names)
{
    for (; *names; names++)
        if (strcmp(name, *names) == 0)
            return true;
    return false;
}

// Which dirty bits a sampled attribute of a mesh, instancer, light or camera stands for.
static uint32_t bits_of(const char *name)
{
    static const char *const tags[] = {"creaseIndices", "creaseLengths",     "creaseSharpnesses",
                                       "cornerIndices", "cornerSharpnesses", NULL};
    static const char *const faces[] = {"faceVertexCounts", "faceVertexIndices", "holeIndices",
                                        NULL};
    static const char *const places[] = {"positions",    "orientations", "orientationsf", "scales",
                                         "protoIndices", "ids",          "invisibleIds",  NULL};
    if (strcmp(name, "visibility") == 0 || co_starts_with(name, "xformOp:"))
        return 0; // inherited: looked at along all ancestors
    if (co_starts_with(name, "primvars:") || strcmp(name, "normals") == 0)
        return COHORT_DIRTY_PRIMVAR | COHORT_DIRTY_INSTANCER;
    if (is_one_of(name, tags))
        return COHORT_DIRTY_SUBDIV_TAGS;
    if (is_one_of(name, faces))
        return COHORT_DIRTY_TOPOLOGY;
    if (is_one_of(name, places))
        return COHORT_DIRTY_INSTANCER;
    return COHORT_DIRTY_POINTS | COHORT_DIRTY_PARAMS;
}

static uint32_t sampled_bits(const CohortPrim *prim)
{
    uint32_t bits = 0;
    size_t count = cohort_prim_property_count(prim);
    for (size_t i = 0; i < count; i++) {
        const char *name = cohort_prim_property_name(prim, i);
        const double *times;
        if (cohort_prim_time_samples(prim, name, &times))
            bits |= bits_of(name);
    }
    return bits;
}

static bool is_sampled_below(const CohortPrim *prim)
{
    size_t count = cohort_prim_child_count(prim);
    bool found = sampled_bits(prim) != 0;
    for (size_t i = 0; i < count && !found; i++)
        found = is_sampled_below(cohort_prim_child(prim, i));
    return found;
}

static bool subsets_vary(const CohortPrim *mesh)
{
    size_t count = cohort_prim_child_count(mesh);
    for (size_t i = 0; i < count; i++) {
        const CohortPrim *child = cohort_prim_child(mesh, i);
        if (strcmp(cohort_prim_type(child), "GeomSubset") == 0 && sampled_bits(child))
            return true;
    }
    return false;
}

// Whether where native instances stand, are seen or what color they hand down changes.
static bool instances_vary(const CohortAdapter *a, uint32_t within)
{
    for (size_t i = 0; i < a->placement_count; i++) {
        CoPlace place = {a->placements[i].prim, a->placements[i].within};
        if (place.prototype == within &&
            (co_place_varies(a, place, "xformOp:") || co_place_varies(a, place, "visibility") ||
             co_place_varies(a, place, "primvars:")))
            return true;
    }
    return false;
}

static uint32_t varying_bits(const CohortAdapter *a, const CoRecord *record)
{
    if (record->kind == CO_RECORD_MATERIAL)
        return is_sampled_below(record->prim) ? COHORT_DIRTY_RESOURCE : 0;
    if (record->kind == CO_RECORD_HEADLIGHT)
        return COHORT_DIRTY_TRANSFORM;
    if (record->kind == CO_RECORD_NATIVE_INSTANCES)
        return instances_vary(a, record->prototype) ? COHORT_DIRTY_INSTANCER : 0;
    if (!record->prim)
        return 0;
    CoPlace place = {record->prim, record->prototype};
    uint32_t bits = sampled_bits(record->prim);
    if (record->kind == CO_RECORD_MESH) {
        bits |= co_place_varies(a, place, "primvars:") ? COHORT_DIRTY_PRIMVAR : 0;
        bits |= subsets_vary(record->prim) ? COHORT_DIRTY_TOPOLOGY : 0;
    }
    if (co_place_varies(a, place, "xformOp:"))
        bits |= COHORT_DIRTY_TRANSFORM;
    if (co_place_varies(a, place, "visibility"))
        bits |= COHORT_DIRTY_VISIBILITY;
    return bits;
}

bool cohort_adapter_set_time(CohortAdapter *a, double time, CohortError *err)
{
    CO_CHECK(a->record_count, err, COHORT_ERROR_ARGUMENT, "the stage is not in the index yet");
    if (time == a->time || (isnan(time) && isnan(a->time)))
        return true;
    const double before = a->time;
    begin(a);
    a->time = time;
    a->resolved.time = time;
    for (size_t i = 0; i < a->record_count; i++) {
        uint32_t bits = varying_bits(a, &a->records[i]);
        if (bits)
            cohort_render_index_mark_dirty(a->index, a->records[i].path, bits);
    }
    co_resolve_size(a);
    bool ok = end(a, true, &(CohortError){0}, err);
    if (!ok) // not all that varies may be marked: the same time is another still
        a->time = a->resolved.time = before;
    return ok;
}

// ---- Queries -----------------------------------------------------------------------------------

void cohort_adapter_settings(const CohortAdapter *a, CohortResolvedSettings *out)
{
    *out = a->resolved;
}

CohortRenderPassState cohort_adapter_pass_state(const CohortAdapter *a)
{
    return (CohortRenderPassState){.camera = a->resolved.camera,
                                   .conform = a->resolved.conform,
                                   .pixel_aspect_ratio = a->resolved.pixel_aspect_ratio,
                                   .disable_depth_of_field = a->resolved.disable_depth_of_field,
                                   .stage_hash = a->resolved.stage_hash};
}

const char *cohort_adapter_camera(const CohortAdapter *a, size_t i)
{
    return i < a->camera_count ? a->cameras[i] : NULL;
}

const CohortStage *cohort_adapter_stage(const CohortAdapter *a)
{
    return a->stage;
}

size_t cohort_adapter_report(CohortAdapter *a, const CohortReportEntry **out)
{
    return cohort_delegate_report(a->delegate, out);
}
