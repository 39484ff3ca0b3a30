// The samples of an attribute over all clips of a set.

#include "stage/clips.h"

#include "compose/fields.h"

#include <math.h>
#include <string.h>

// ---- Where the attribute is in a clip -----------------------------------------------------------
static const CoSpec *descend(const CoSpec *spec, const CoPath *path, const CoPath *top)
{
    if (path == top || !path->parent)
        return spec;
    const CoSpec *parent = descend(spec, path->parent, top);
    return parent ? co_spec_child(parent, path->name) : NULL;
}

static const CoSpec *attribute_in(const CoLayerFile *file, const CoClipSet *set,
                                  const CohortPrim *holder, const CohortPrim *prim,
                                  const char *name)
{
    const CoSpec *spec = file && file->layer ? file->layer->root : NULL;
    for (const char *at = set->prim_path; spec && *at;) {
        at += *at == '/';
        size_t length = strcspn(at, "/");
        const char *token = length ? co_token(at, length) : NULL;
        spec = token ? co_spec_child(spec, token) : length ? NULL : spec;
        at += length;
    }
    spec = spec ? descend(spec, prim->data->path, holder->data->path) : NULL;
    spec = spec ? co_spec_property(spec, name) : NULL;
    return spec && spec->kind == CO_SPEC_ATTRIBUTE ? spec : NULL;
}

static const CoTimeSamples *samples_in(const CoLayerFile *file, const CoClipSet *set,
                                       const CohortPrim *holder, const CohortPrim *prim,
                                       const char *name)
{
    const CoSpec *spec = attribute_in(file, set, holder, prim, name);
    const CoField *field =
        spec ? co_spec_field(spec, prim->data->stage->composer.names.timeSamples) : NULL;
    const CoTimeSamples *samples = field ? co_value_samples(&field->value) : NULL;
    return samples && samples->count ? samples : NULL;
}

// ---- Times --------------------------------------------------------------------------------------
static double clip_time(const CoClipSet *set, double time)
{
    const CoClipTime *times = set->times;
    if (!set->time_count)
        return time;
    if (time <= times[0].stage)
        return times[0].clip;
    for (size_t i = 0; i + 1 < set->time_count; i++) {
        if (time >= times[i + 1].stage)
            continue;
        double u = (time - times[i].stage) / (times[i + 1].stage - times[i].stage);
        return times[i].clip + u * (times[i + 1].clip - times[i].clip);
    }
    return times[set->time_count - 1].clip;
}

// A list of samples being made. Times first, in any order; memory is the stage's.
typedef struct CoClipMerge {
    const CohortStage *stage;
    double *times;
    size_t count, capacity;
    double start, end; // only times in [start, end) are taken
    bool is_out_of_memory;
} CoClipMerge;

static void add_time(CoClipMerge *merge, double time)
{
    if (!(time >= merge->start && time < merge->end) || merge->is_out_of_memory)
        return;
    if (merge->count == merge->capacity) {
        size_t capacity = merge->capacity ? 2 * merge->capacity : 64;
        double *times = co_stage_alloc(merge->stage, capacity, sizeof *times);
        merge->is_out_of_memory = !times;
        if (!times)
            return;
        if (merge->count)
            memcpy(times, merge->times, merge->count * sizeof *times);
        merge->times = times;
        merge->capacity = capacity;
    }
    merge->times[merge->count++] = time;
}

// Stage times at which a piece of the mapping shows a sample of the clip.
static void add_piece(CoClipMerge *merge, const CoClipTime *piece, const CoTimeSamples *samples)
{
    double low = fmin(piece[0].clip, piece[1].clip), high = fmax(piece[0].clip, piece[1].clip);
    double span = piece[1].clip - piece[0].clip;
    for (size_t i = 0; span != 0 && !piece->jumps && i < samples->count; i++) {
        if (samples->times[i] < low || samples->times[i] > high)
            continue;
        double u = (samples->times[i] - piece[0].clip) / span;
        add_time(merge,
                 u == 1 ? piece[1].stage : piece[0].stage + u * (piece[1].stage - piece[0].stage));
    }
}

static void add_clip_times(CoClipMerge *merge, const CoClipSet *set, size_t i,
                           const CoTimeSamples *samples)
{
    merge->start = i ? set->clips[i].start : -(double)INFINITY;
    merge->end = i + 1 < set->clip_count ? set->clips[i + 1].start : (double)INFINITY;
    add_time(merge, set->clips[i].start);
    for (size_t j = 0; j < set->time_count; j++)
        add_time(merge, set->times[j].stage);
    for (size_t j = 0; samples && j + 1 < set->time_count; j++)
        add_piece(merge, &set->times[j], samples);
    for (size_t j = 0; samples && !set->time_count && j < samples->count; j++)
        add_time(merge, samples->times[j]);
}

static void sift(double *times, size_t at, size_t count)
{
    for (size_t child; (child = 2 * at + 1) < count; at = child) {
        if (child + 1 < count && times[child + 1] > times[child])
            child++;
        if (times[at] >= times[child])
            return;
        double swap = times[at];
        times[at] = times[child];
        times[child] = swap;
    }
}

// Ascending, each once.
static void sort_times(CoClipMerge *merge)
{
    for (size_t i = merge->count / 2; i-- > 0;)
        sift(merge->times, i, merge->count);
    for (size_t i = merge->count; i-- > 1;) {
        double swap = merge->times[0];
        merge->times[0] = merge->times[i];
        merge->times[i] = swap;
        sift(merge->times, 0, i);
    }
    size_t kept = 0;
    for (size_t i = 0; i < merge->count; i++)
        if (!kept || merge->times[i] > merge->times[kept - 1])
            merge->times[kept++] = merge->times[i];
    merge->count = kept;
}

// ---- Values -------------------------------------------------------------------------------------
static bool value_in_clip(const CohortStage *stage, const CoTimeSamples *samples, double time,
                          CoValue *out)
{
    size_t i = 0;
    for (size_t high = samples->count; high - i > 1;) {
        size_t middle = i + (high - i) / 2;
        if (samples->times[middle] <= time)
            i = middle;
        else
            high = middle;
    }
    const CoValue *a = &samples->values[i], *b = a + 1;
    *out = *a;
    if (i + 1 == samples->count || time <= samples->times[i] || !co_value_can_interpolate(a, b))
        return true;
    void *data = co_stage_alloc(stage, a->count, co_type_size(a->type));
    if (!data)
        return false;
    co_value_interpolate(
        a, b, (time - samples->times[i]) / (samples->times[i + 1] - samples->times[i]), data);
    out->data = data;
    return true;
}

typedef struct CoClipWork {
    const CohortPrim *prim;
    const CoClipSet *set;
    const CoTimeSamples **samples; // per clip; NULL: none there
    CoValue missing;               // what a clip without samples says
} CoClipWork;

static bool speaks(const CoClipWork *work, size_t clip)
{
    return work->samples[clip] || !work->set->interpolates_missing ||
           work->missing.type != COHORT_TYPE_BLOCK;
}

static bool fill_values(const CoClipWork *work, CoTimeSamples *out)
{
    const CohortStage *stage = work->prim->data->stage;
    const CoClipSet *set = work->set;
    size_t clip = 0;
    for (size_t i = 0; i < out->count; i++) {
        while (clip + 1 < set->clip_count && out->times[i] >= set->clips[clip + 1].start)
            clip++;
        out->values[i] = work->missing;
        if (work->samples[clip] && !value_in_clip(stage, work->samples[clip],
                                                  clip_time(set, out->times[i]), &out->values[i]))
            return false;
    }
    return true;
}

static CoField *merge_clips(const CoClipWork *work)
{
    const CohortStage *stage = work->prim->data->stage;
    CoClipMerge merge = {.stage = stage};
    for (size_t i = 0; i < work->set->clip_count; i++)
        if (speaks(work, i))
            add_clip_times(&merge, work->set, i, work->samples[i]);
    merge.start = -(double)INFINITY;
    merge.end = (double)INFINITY;
    if (!merge.count)
        add_time(&merge, work->set->clips[0].start);
    CoField *field = co_stage_alloc(stage, 1, sizeof *field);
    CoTimeSamples *out = co_stage_alloc(stage, 1, sizeof *out);
    if (!field || !out || merge.is_out_of_memory)
        return NULL;
    sort_times(&merge);
    out->times = merge.times;
    out->count = merge.count;
    out->values = co_stage_alloc(stage, out->count, sizeof *out->values);
    if (!out->values || !fill_values(work, out))
        return NULL;
    *field =
        (CoField){stage->composer.names.timeSamples, {COHORT_TYPE_TIME_SAMPLES, false, 1, out}, 0};
    return field;
}

// The merged samples, or NULL if the set does not speak of the attribute.
static const CoField *field_of_set(const CohortPrim *holder, const CoClipSet *set,
                                   const CohortPrim *prim, const char *name)
{
    const CohortStage *stage = prim->data->stage;
    CoClipWork work = {prim, set, NULL, {.type = COHORT_TYPE_BLOCK}};
    work.samples = co_stage_alloc(stage, set->clip_count, sizeof *work.samples);
    if (!work.samples)
        return NULL;
    bool is_spoken_of = false;
    for (size_t i = 0; i < set->clip_count; i++) {
        work.samples[i] = samples_in(set->clips[i].file, set, holder, prim, name);
        is_spoken_of |= work.samples[i] != NULL;
    }
    if (set->manifest) {
        const CoSpec *spec = attribute_in(set->manifest, set, holder, prim, name);
        is_spoken_of = spec && !spec->is_uniform;
        const CoField *field =
            spec ? co_spec_field(spec, stage->composer.names.default_value) : NULL;
        if (field)
            work.missing = field->value;
    }
    return is_spoken_of ? merge_clips(&work) : NULL;
}

// ---- Strength -----------------------------------------------------------------------------------
// Before which opinion on the prim the set stands: the first that comes from a source which is
// weaker than the set's where the clips are authored.
static uint32_t set_rank(const CohortPrim *holder, const CoClipSet *set, const CohortPrim *prim)
{
    uint32_t anchor = 0;
    while (anchor < holder->data->opinion_count &&
           holder->data->opinions[anchor].source != set->anchor)
        anchor++;
    while (anchor + 1 < holder->data->opinion_count &&
           holder->data->opinions[anchor + 1].source == set->anchor)
        anchor++;
    for (uint32_t i = 0; i < prim->data->opinion_count; i++)
        for (uint32_t j = anchor + 1; j < holder->data->opinion_count; j++)
            if (prim->data->opinions[i].source == holder->data->opinions[j].source)
                return i;
    return prim->data->opinion_count;
}

static const CoField *cached_field(const CohortPrim *holder, const CoClipSet *set,
                                   const CohortPrim *prim, const char *name)
{
    CoQueryKey key = {prim, name, CO_QUERY_CLIPS | (uint64_t)(uintptr_t)set << 8, 0};
    co_stage_lock(prim->data->stage);
    const CoAnswer *answer = co_stage_find_answer(prim->data->stage, &key);
    if (!answer)
        answer = co_stage_keep_answer(prim->data->stage, &key,
                                      &(CoAnswer){.data = field_of_set(holder, set, prim, name)});
    const CoField *field = answer ? answer->data : NULL;
    co_stage_unlock(prim->data->stage);
    return field;
}

CoValueSource co_clips_value_source(const CohortPrim *prim, const char *name, uint32_t first,
                                    uint32_t last)
{
    for (const CoClips *clips = prim->data->clips; clips; clips = clips->outer)
        for (size_t i = 0; i < clips->count; i++) {
            const CoClipSet *set = &clips->sets[i];
            uint32_t rank = set_rank(clips->prim, set, prim);
            const CoField *field =
                rank >= first && rank <= last ? cached_field(clips->prim, set, prim, name) : NULL;
            if (field)
                return (CoValueSource){field, &set->source, NULL};
        }
    return (CoValueSource){0};
}
