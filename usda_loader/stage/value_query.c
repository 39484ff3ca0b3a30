// Which opinion gives an attribute its value, and the value at a time.

#include "stage/stage_data.h"

#include "compose/fields.h"

#include <math.h>
#include <string.h>

CoValueSource co_prim_value_source(const CohortPrim *prim, const char *name, bool at_default)
{
    const CoFieldNames *names = &prim->stage->composer.names;
    CoPropertyWalk walk = co_property_walk(prim, co_token(name, strlen(name)));
    while (co_property_next(&walk)) {
        if (walk.kind != CO_SPEC_ATTRIBUTE)
            break;
        const CoField *field = NULL;
        if (!at_default)
            field = co_spec_field(walk.spec, names->timeSamples);
        if (!field && !at_default)
            field = co_spec_field(walk.spec, names->spline);
        if (!field)
            field = co_spec_field(walk.spec, names->default_value);
        if (field && field->value.type == COHORT_TYPE_TIME_SAMPLES &&
            !co_value_samples(&field->value)->count)
            field = NULL;
        if (field)
            return (CoValueSource){field, walk.source, walk.spec};
    }
    return (CoValueSource){0};
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

static bool sampled(const CohortStage *stage, const CoTimeSamples *samples, const CoSource *source,
                    double time, CohortValue *out)
{
    double local = (time - source->offset) / source->scale;
    size_t i = bracket(samples, local);
    bool is_between =
        i + 1 < samples->count && local > samples->times[i] && local < samples->times[i + 1];
    if (is_between && co_value_can_interpolate(&samples->values[i], &samples->values[i + 1]))
        return interpolated(stage, samples, i, local, out);
    return co_value_in_stage(stage, &samples->values[i], source, out);
}

bool cohort_prim_value(const CohortPrim *prim, const char *name, double time, CohortValue *out)
{
    bool at_default = isnan(time);
    CoValueSource from = co_prim_value_source(prim, name, at_default);
    if (!from.field)
        return false;
    const CoTimeSamples *samples = co_value_samples(&from.field->value);
    if (samples)
        return sampled(prim->stage, samples, from.source, time, out);
    if (from.field->value.type == COHORT_TYPE_SPLINE)
        return co_spline_value(prim->stage, from.spec, &from.field->value,
                               (time - from.source->offset) / from.source->scale, out);
    return co_value_in_stage(prim->stage, &from.field->value, from.source, out);
}

size_t cohort_prim_time_samples(const CohortPrim *prim, const char *name, const double **times)
{
    CoValueSource from = co_prim_value_source(prim, name, false);
    const CoTimeSamples *samples = from.field ? co_value_samples(&from.field->value) : NULL;
    if (!samples)
        return 0;
    if (has_identity_time(from.source)) {
        *times = samples->times;
        return samples->count;
    }
    CoQueryKey key = {samples, from.source, CO_QUERY_TIMES, 0};
    co_stage_lock(prim->stage);
    const CoAnswer *answer = co_stage_find_answer(prim->stage, &key);
    double *scaled = answer ? NULL : co_stage_alloc(prim->stage, samples->count, sizeof *scaled);
    if (scaled) {
        bool is_backwards = from.source->scale < 0;
        for (size_t i = 0; i < samples->count; i++)
            scaled[is_backwards ? samples->count - 1 - i : i] =
                samples->times[i] * from.source->scale + from.source->offset;
        answer = co_stage_keep_answer(prim->stage, &key, &(CoAnswer){.data = scaled});
    }
    if (answer)
        *times = answer->data;
    co_stage_unlock(prim->stage);
    return answer ? samples->count : 0;
}
