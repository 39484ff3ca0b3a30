// When an array changes that is made of edits over weaker opinions.

#include "stage/stage_data.h"

#include "compose/fields.h"

#include <stdlib.h>
#include <string.h>

bool co_source_has_edits(const CoValueSource *source)
{
    size_t length = source->field && source->spec ? strlen(source->spec->type_name) : 0;
    if (!length || source->spec->type_name[length - 1] != ']')
        return false;
    if (source->field->value.type == COHORT_TYPE_ARRAY_EDIT)
        return true;
    const CoTimeSamples *samples = co_value_samples(&source->field->value);
    for (size_t i = 0; samples && i < samples->count; i++)
        if (samples->values[i].type == COHORT_TYPE_ARRAY_EDIT)
            return true;
    return false;
}

// Of all sources up to the first without edits; out NULL: only counts.
static size_t gather(const CohortPrim *prim, const char *token, double *out)
{
    CoPropertyWalk walk = co_property_walk(prim, token);
    size_t count = 0;
    for (bool more = true; more;) {
        CoValueSource source = co_value_source_next(&walk, false);
        const CoTimeSamples *samples = source.field ? co_value_samples(&source.field->value) : NULL;
        for (size_t i = 0; samples && i < samples->count; i++, count++)
            if (out)
                out[count] = samples->times[i] * source.source->scale + source.source->offset;
        more = co_source_has_edits(&source);
    }
    return count;
}

static int compare(const void *a, const void *b)
{
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

size_t co_prim_edited_times(const CohortPrim *prim, const char *token, const double **times)
{
    const CohortStage *stage = prim->data->stage;
    CoQueryKey key = {prim, token, CO_QUERY_TIMES, 0};
    co_stage_lock(stage);
    const CoAnswer *known = co_stage_find_answer(stage, &key);
    CoAnswer answer = known ? *known : (CoAnswer){0};
    uint64_t refusals = stage->refusals;
    co_stage_unlock(stage);
    if (!known) {
        // Walking takes the lock where there are clips.
        size_t most = gather(prim, token, NULL);
        co_stage_lock(stage);
        double *all = co_stage_alloc(stage, most + 1, sizeof *all);
        co_stage_unlock(stage);
        if (!all)
            return 0;
        gather(prim, token, all);
        if (most > 1)
            qsort(all, most, sizeof *all, compare);
        for (size_t i = 0; i < most; i++)
            if (!answer.count || all[answer.count - 1] != all[i])
                all[answer.count++] = all[i];
        answer.data = all;
        co_stage_lock(stage);
        if (stage->refusals == refusals) // nor while it was walked
            co_stage_keep_answer(stage, &key, &answer);
        co_stage_unlock(stage);
    }
    *times = answer.data;
    return answer.count;
}
