// Which opinion gives an attribute its value, and the value at a time.

#include "stage/clips.h"

#include "compose/fields.h"

#include <math.h>
#include <string.h>

// The strongest source that the walk has not passed yet.
CoValueSource co_value_source_next(CoPropertyWalk *walk, bool at_default)
{
    const CoFieldNames *names = &walk->prim->data->stage->composer.names;
    for (bool more = true; more;) {
        uint32_t first = walk->next, opinions = walk->prim->data->opinion_count;
        more = co_property_next(walk) && walk->kind == CO_SPEC_ATTRIBUTE;
        if (walk->name && walk->prim->data->clips && !at_default) {
            uint32_t last = more ? walk->next - 1 : opinions;
            CoValueSource clips = co_clips_value_source(walk->prim, walk->name, first, last);
            // Past the end, so that no set is asked twice.
            walk->next = more ? walk->next : opinions + 1;
            if (clips.field)
                return clips;
        }
        if (!more)
            break;
        const CoField *field = NULL;
        if (!at_default)
            field = co_spec_field(walk->spec, names->timeSamples);
        if (field && (!co_value_samples(&field->value) || !co_value_samples(&field->value)->count))
            field = NULL;
        if (!field && !at_default)
            field = co_spec_field(walk->spec, names->spline);
        if (!field)
            field = co_spec_field(walk->spec, names->default_value);
        // An animation block hides what weaker layers animate, not what they say by default.
        if (field && field->value.type == COHORT_TYPE_ANIMATION_BLOCK)
            at_default = true;
        else if (field)
            return (CoValueSource){field, walk->source, walk->spec};
    }
    return (CoValueSource){0};
}

CoValueSource co_prim_value_source(const CohortPrim *prim, const char *name, bool at_default)
{
    CoPropertyWalk walk = co_property_walk(prim, co_property_token(prim, name));
    return co_value_source_next(&walk, at_default);
}

static bool has_identity_time(const CoSource *source)
{
    return source->offset == 0 && source->scale == 1;
}

bool co_value_in_stage(const CohortStage *stage, const CoValue *value, const CoSource *source,
                       CohortValue *out)
{
    if (value->type == COHORT_TYPE_BLOCK || value->type == COHORT_TYPE_ANIMATION_BLOCK ||
        value->type == COHORT_TYPE_NONE)
        return false;
    *out = (CohortValue){value->type, value->is_array, value->count, value->data};
    if (value->type != COHORT_TYPE_TIMECODE || has_identity_time(source) || !value->count)
        return true;
    CoQueryKey key = {value, source, CO_QUERY_VALUE, 0};
    co_stage_lock(stage);
    const CoAnswer *answer = co_stage_find_answer(stage, &key);
    double *times = answer ? NULL : co_stage_alloc(stage, value->count, sizeof *times);
    if (times) {
        for (size_t i = 0; i < value->count; i++)
            times[i] = ((const double *)value->data)[i] * source->scale + source->offset;
        answer = co_stage_keep_answer(stage, &key, &(CoAnswer){.data = times});
    }
    if (answer)
        out->data = answer->data;
    co_stage_unlock(stage);
    return answer != NULL;
}

static bool interpolated(const CohortStage *stage, const CoTimeSamples *samples, size_t i,
                         double time, CohortValue *out)
{
    const CoValue *a = &samples->values[i], *b = &samples->values[i + 1];
    double u = (time - samples->times[i]) / (samples->times[i + 1] - samples->times[i]);
    CoQueryKey key = {a, NULL, CO_QUERY_VALUE, time};
    co_stage_lock(stage);
    const CoAnswer *answer = co_stage_find_answer(stage, &key);
    void *data = answer ? NULL : co_stage_alloc(stage, a->count, co_type_size(a->type));
    if (data) {
        co_value_interpolate(a, b, u, data);
        answer = co_stage_keep_answer(stage, &key, &(CoAnswer){.data = data});
    }
    if (answer)
        *out = (CohortValue){a->type, a->is_array, a->count, answer->data};
    co_stage_unlock(stage);
    return answer != NULL;
}

// The last sample at or before `time`, or the first.
static size_t bracket(const CoTimeSamples *samples, double time)
{
    size_t low = 0, high = samples->count;
    while (high - low > 1) {
        size_t middle = low + (high - low) / 2;
        if (samples->times[middle] <= time)
            low = middle;
        else
            high = middle;
    }
    return low;
}

static bool value_at(CoPropertyWalk *walk, double time, CohortValue *out);

// A value that is not between samples.
static bool plain_value(CoPropertyWalk *walk, const CoValueSource *from, const CoValue *value,
                        double time, CohortValue *out)
{
    const CohortStage *stage = walk->prim->data->stage;
    if (value->type != COHORT_TYPE_ARRAY_EDIT)
        return co_value_in_stage(stage, value, from->source, out);
    CohortType type;
    bool is_array;
    const char *name = from->spec ? from->spec->type_name : "";
    if (!co_type_from_name(name, strlen(name), &type, &is_array) || !is_array)
        return false;
    CohortValue base = {0};
    if (!value_at(walk, time, &base) || base.type != type || !base.is_array)
        base = (CohortValue){0};
    return co_value_edited(stage, value->data, type, &base, time, out);
}

static bool value_at(CoPropertyWalk *walk, double time, CohortValue *out)
{
    const CohortStage *stage = walk->prim->data->stage;
    CoValueSource from = co_value_source_next(walk, isnan(time));
    if (!from.field)
        return false;
    double local = (time - from.source->offset) / from.source->scale;
    if (from.field->value.type == COHORT_TYPE_SPLINE)
        return co_spline_value(stage, &from, local, out);
    const CoTimeSamples *samples = co_value_samples(&from.field->value);
    if (!samples)
        return plain_value(walk, &from, &from.field->value, time, out);
    size_t i = bracket(samples, local);
    bool is_between =
        i + 1 < samples->count && local > samples->times[i] && local < samples->times[i + 1];
    if (is_between && co_value_can_interpolate(&samples->values[i], &samples->values[i + 1]))
        return interpolated(stage, samples, i, local, out);
    return plain_value(walk, &from, &samples->values[i], time, out);
}

bool co_prim_value(const CohortPrim *prim, const char *token, double time, CohortValue *out)
{
    CoPropertyWalk walk = co_property_walk(prim, token);
    return value_at(&walk, time, out);
}

bool cohort_prim_value(const CohortPrim *prim, const char *name, double time, CohortValue *out)
{
    return co_prim_value(prim, co_property_token(prim, name), time, out);
}

size_t cohort_prim_time_samples(const CohortPrim *prim, const char *name, const double **times)
{
    CoValueSource from = co_prim_value_source(prim, name, false);
    if (co_source_has_edits(&from))
        return co_prim_edited_times(prim, co_property_token(prim, name), times);
    const CoTimeSamples *samples = from.field ? co_value_samples(&from.field->value) : NULL;
    if (!samples)
        return 0;
    if (has_identity_time(from.source)) {
        *times = samples->times;
        return samples->count;
    }
    CoQueryKey key = {samples, from.source, CO_QUERY_TIMES, 0};
    co_stage_lock(prim->data->stage);
    const CoAnswer *answer = co_stage_find_answer(prim->data->stage, &key);
    double *scaled =
        answer ? NULL : co_stage_alloc(prim->data->stage, samples->count, sizeof *scaled);
    if (scaled) {
        bool is_backwards = from.source->scale < 0;
        for (size_t i = 0; i < samples->count; i++)
            scaled[is_backwards ? samples->count - 1 - i : i] =
                samples->times[i] * from.source->scale + from.source->offset;
        answer = co_stage_keep_answer(prim->data->stage, &key, &(CoAnswer){.data = scaled});
    }
    if (answer)
        *times = answer->data;
    co_stage_unlock(prim->data->stage);
    return answer ? samples->count : 0;
}
