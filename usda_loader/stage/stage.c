// Opening and closing a stage; what is known of all of it.

#include "stage/stage_data.h"

#include "compose/fields.h"
#include "compose/population.h"
#include "compose/read_ahead.h"

#include "base/error.h"
#include "base/hash.h"
#include "base/mapped_file.h"

#include <math.h>
#include <string.h>

// ---- Opening ------------------------------------------------------------------------------------
static bool open_root(CohortStage *stage, const char *path)
{
    CoComposer *c = &stage->composer;
    if (!co_population_init(c, path, c->err))
        return false;
    const CoLayerFile *root = co_composer_layer(c, co_asset_anchor(c, NULL, path), c->err);
    if (!root)
        return false;
    const CoLayerFile *session = NULL;
    const char *session_path = c->options.session;
    if (session_path && *session_path) {
        session = co_composer_layer(c, co_asset_anchor(c, NULL, session_path), c->err);
        if (!session)
            return false;
    }
    stage->stack = co_composer_root_stack(c, root, session);
    co_stage_compose(stage);
    co_read_ahead_drop(c);
    return !c->is_strict_failure;
}

// The one place that composition escapes to.
static bool open_guarded(CohortStage *stage, const char *path)
{
    return setjmp(stage->composer.escape) == 0 && open_root(stage, path);
}

CohortStage *co_stage_open(const char *path, const CohortStageOptions *options,
                           const CohortStage *before, CohortError *err)
{
    CohortError local = {0};
    if (!err)
        err = &local;
    CO_CHECK_NULL(path && *path, err, COHORT_ERROR_ARGUMENT, "no path given");
    CohortStage *stage = co_alloc_zero(CO_MEMORY_USDA, sizeof *stage);
    CO_CHECK_NULL(stage, err, COHORT_ERROR_OUT_OF_MEMORY, "out of memory");
    stage->self = stage;
    stage->answers_arena.tag = CO_MEMORY_USDA;
    stage->has_lock = pthread_mutex_init(&stage->lock, NULL) == 0;
    stage->composer.donor = before ? &before->composer : NULL;
    if (stage->has_lock && co_composer_init(&stage->composer, options, err) &&
        open_guarded(stage, path)) {
        stage->composer.err = NULL;
        stage->composer.donor = NULL;
        co_arena_clear(&stage->composer.scratch);
        return stage;
    }
    if (err->code == COHORT_OK)
        CO_FAIL(err, COHORT_ERROR_INTERNAL, "the stage could not be opened");
    cohort_stage_destroy(stage);
    return NULL;
}

CohortStage *cohort_stage_open(const char *path, const CohortStageOptions *options,
                               CohortError *err)
{
    return co_stage_open(path, options, NULL, err);
}

void cohort_stage_destroy(CohortStage *stage)
{
    if (!stage)
        return;
    co_composer_clear(&stage->composer);
    co_arena_clear(&stage->answers_arena);
    if (stage->has_lock)
        pthread_mutex_destroy(&stage->lock);
    co_free(CO_MEMORY_USDA, stage, sizeof *stage);
}

// ---- Stage metadata -----------------------------------------------------------------------------
static const CoField *stage_field(const CohortStage *stage, const char *name)
{
    const char *token = co_token(name, strlen(name));
    const CoStack *stack = stage->stack;
    // The default prim is the root layer's own.
    bool asks_session = stack->session && token != stage->composer.names.defaultPrim;
    const CoField *field = asks_session ? co_layer_field(stack->session, token) : NULL;
    return field ? field : co_layer_field(stack->root, token);
}

static const char *stage_text(const CohortStage *stage, const char *name, const char *fallback)
{
    const CoField *field = stage_field(stage, name);
    const CohortString *text = field ? co_value_text(&field->value) : NULL;
    return text ? text->text : fallback;
}

static bool stage_number(const CohortStage *stage, const char *name, double *out)
{
    const CoField *field = stage_field(stage, name);
    return field && co_value_double(&field->value, out);
}

// What was left out counts as well: it makes another stage of the same layers.
static uint64_t hash_options(const CohortStageOptions *o)
{
    const CohortPaths *lists[] = {&o->mask, &o->loads, &o->unloads, &o->muted};
    uint64_t hash = 0;
    for (size_t i = 0; i < sizeof lists / sizeof *lists; i++)
        for (size_t j = 0; j < lists[i]->count; j++)
            hash = co_hash_bytes(lists[i]->items[j], strlen(lists[i]->items[j]) + 1, hash + i + 1);
    return hash + o->no_payloads;
}

static uint64_t hash_layers(const CohortStage *stage)
{
    const CoComposer *c = &stage->composer;
    uint64_t hash = hash_options(&c->options);
    for (size_t i = 0; i < c->file_count; i++) {
        CoMappedFile file;
        CohortBytes bytes = {0};
        const CohortStageOptions *o = &c->options;
        if (!c->files[i]->layer)
            continue;
        if (o->open && o->open(o->open_cookie, c->files[i]->path, &bytes)) {
            hash = co_hash_bytes(bytes.data, bytes.size, hash);
            if (o->release)
                o->release(o->open_cookie, &bytes);
            continue;
        }
        if (!co_mapped_file_open(c->files[i]->path, &file, NULL))
            continue;
        hash = co_hash_bytes(file.data, file.size, hash);
        co_mapped_file_close(&file);
    }
    return hash;
}

void cohort_stage_info(const CohortStage *stage, CohortStageInfo *out)
{
    CohortStageInfo info = {
        .default_prim = stage_text(stage, "defaultPrim", ""),
        .up_axis = stage_text(stage, "upAxis", "Y"),
        .render_settings_prim_path = stage_text(stage, "renderSettingsPrimPath", ""),
        .meters_per_unit = 0.01,
        .frames_per_second = 24,
        .time_codes_per_second = stage->stack->time_codes_per_second,
        .prim_count = stage->prim_count,
    };
    stage_number(stage, "metersPerUnit", &info.meters_per_unit);
    stage_number(stage, "framesPerSecond", &info.frames_per_second);
    bool has_start = stage_number(stage, "startTimeCode", &info.start_time_code);
    info.has_time_range = stage_number(stage, "endTimeCode", &info.end_time_code) && has_start;
    for (size_t i = 0; i < stage->composer.file_count; i++)
        info.layer_count += stage->composer.files[i]->layer != NULL;
    CohortStage *own = stage->self;
    co_stage_lock(stage);
    if (!own->has_hash) {
        own->hash = hash_layers(stage);
        own->has_hash = true;
    }
    info.hash = own->hash;
    co_stage_unlock(stage);
    *out = info;
}

const char *cohort_stage_layer(const CohortStage *stage, size_t i)
{
    const CoComposer *c = &stage->composer;
    for (size_t j = 0; j < c->file_count; j++)
        if (c->files[j]->layer && i-- == 0)
            return c->files[j]->path;
    return NULL;
}

bool cohort_stage_met_muted(const CohortStage *stage, size_t i)
{
    return i < stage->composer.options.muted.count && stage->composer.muted[i].is_met;
}

static void note_earliest(const CohortPrim *prim, double *earliest, const CoFieldNames *names)
{
    for (uint32_t i = 0; i < prim->data->opinion_count; i++) {
        const CoOpinion *opinion = &prim->data->opinions[i];
        const CoContents *in = co_spec_contents(opinion->spec);
        for (size_t j = 0; j < in->property_count; j++) {
            const CoField *field = co_spec_field(in->properties[j], names->timeSamples);
            const CoTimeSamples *samples = field ? co_value_samples(&field->value) : NULL;
            if (!samples || !samples->count)
                continue;
            double scale = opinion->source->scale, offset = opinion->source->offset;
            double first = samples->times[0] * scale + offset;
            double last = samples->times[samples->count - 1] * scale + offset;
            *earliest = fmin(*earliest, fmin(first, last));
        }
    }
    bool is_shared = prim->data->prototype && prim->data->prototype != prim;
    for (uint32_t i = 0; !is_shared && i < prim->data->child_count; i++)
        note_earliest(&prim->children[i], earliest, names);
}

bool cohort_stage_earliest_time(const CohortStage *stage, double *out)
{
    CohortStage *own = stage->self;
    co_stage_lock(stage);
    if (!own->has_earliest) {
        double earliest = (double)INFINITY;
        note_earliest(&stage->root, &earliest, &stage->composer.names);
        own->varies = isfinite(earliest);
        own->earliest = earliest;
        own->has_earliest = true;
    }
    co_stage_unlock(stage);
    if (stage->varies)
        *out = stage->earliest;
    return stage->varies || stage_number(stage, "startTimeCode", out);
}

size_t cohort_stage_problem_count(const CohortStage *stage)
{
    return stage->composer.problem_count;
}

bool cohort_stage_problem(const CohortStage *stage, size_t i, CohortProblem *out)
{
    if (i >= stage->composer.problem_count)
        return false;
    *out = stage->composer.problems[i];
    return true;
}

const CohortPrim *cohort_stage_root(const CohortStage *stage)
{
    return &stage->root;
}
