// From the clips metadata of a prim to its clip sets.

#include "stage/clips.h"

#include "compose/fields.h"
#include "compose/list_op.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#define MAX_TEMPLATE_CLIPS 100000

// What one key of a set says: the strongest opinion that has it.
typedef struct CoClipEntry {
    const CoValue *value; // NULL: not said
    const CoSource *source;
    uint32_t line;
} CoClipEntry;

static const CoValue *dict_value(const CoDict *dict, const char *key)
{
    for (size_t i = 0; dict && i < dict->count; i++)
        if (!strcmp(dict->entries[i].key, key))
            return dict->entries[i].value;
    return NULL;
}

static CoClipEntry find_entry(const CohortPrim *prim, const char *set, const char *key)
{
    const char *clips = prim->data->stage->composer.names.clips;
    for (uint32_t i = 0; i < prim->data->opinion_count; i++) {
        const CoField *field = co_spec_field(prim->data->opinions[i].spec, clips);
        const CoValue *inner = field ? dict_value(co_value_dict(&field->value), set) : NULL;
        const CoValue *value = inner ? dict_value(co_value_dict(inner), key) : NULL;
        if (value)
            return (CoClipEntry){value, prim->data->opinions[i].source, field->line};
    }
    return (CoClipEntry){0};
}

static bool find_number(const CohortPrim *prim, const char *set, const char *key, double *out)
{
    CoClipEntry entry = find_entry(prim, set, key);
    return entry.value && co_value_double(entry.value, out) && isfinite(*out);
}

static bool is_array_of(const CoClipEntry *entry, CohortType type)
{
    return entry->value && entry->value->is_array && entry->value->type == type &&
           entry->value->count;
}

static const CoLayerFile *open_clip(CohortStage *stage, const CohortPrim *prim,
                                    const CoClipEntry *entry, const char *authored)
{
    CoComposer *c = &stage->composer;
    const char *why = NULL;
    const char *path = co_expression_evaluate(c, entry->source->stack->variables, authored, &why);
    CohortError err = {0};
    const CoLayerFile *file =
        path && *path ? co_composer_layer(c, co_asset_anchor(c, entry->source->file, path), &err)
                      : NULL;
    if (!file)
        co_composer_warn(c, COHORT_PROBLEM_CLIPS, entry->source->file, entry->line,
                         prim->data->path, "clip @%s@ is left out: %s", authored,
                         why ? why : err.message);
    return file;
}

// ---- Explicit sets ------------------------------------------------------------------------------
static void sort_clips(CoClip *clips, size_t count)
{
    for (size_t i = 1; i < count; i++)
        for (size_t j = i; j > 0 && clips[j].start < clips[j - 1].start; j--) {
            CoClip swap = clips[j];
            clips[j] = clips[j - 1];
            clips[j - 1] = swap;
        }
}

// Two entries at one time are a jump: the first of them ends a hair before it, on
// the line that leads there.
static void separate_jumps(CoClipTime *times, size_t count)
{
    static const double step = 1e6 * 0x1p-52 * 10 * 2; // the least that survives a time offset
    for (size_t i = 1; i < count; i++)
        for (size_t j = i; j > 0 && times[j].stage < times[j - 1].stage; j--) {
            CoClipTime swap = times[j];
            times[j] = times[j - 1];
            times[j - 1] = swap;
        }
    for (size_t i = 0; i + 1 < count; i++)
        if (times[i].stage >= times[i + 1].stage) {
            times[i].stage = times[i + 1].stage - step;
            if (i && times[i - 1].stage < times[i].stage)
                times[i].clip -= step * (times[i].clip - times[i - 1].clip) /
                                 (times[i + 1].stage - times[i - 1].stage);
            times[i].jumps = true;
        }
}

static const char *explicit_set(CohortStage *stage, const CohortPrim *prim, const char *name,
                                CoClipSet *set)
{
    CoClipEntry assets = find_entry(prim, name, "assetPaths");
    CoClipEntry active = find_entry(prim, name, "active");
    CoClipEntry times = find_entry(prim, name, "times");
    if (!is_array_of(&assets, COHORT_TYPE_ASSET))
        return "it names no files";
    if (!is_array_of(&active, COHORT_TYPE_DOUBLE2))
        return "it does not say when which clip is active";
    set->anchor = assets.source;
    set->clip_count = active.value->count;
    set->clips = co_composer_array(&stage->composer, set->clip_count, sizeof *set->clips);
    const double *pairs = active.value->data;
    const CohortString *paths = assets.value->data;
    for (size_t i = 0; i < set->clip_count; i++) {
        double index = pairs[2 * i + 1];
        if (!(index >= 0 && index < (double)assets.value->count) || !isfinite(pairs[2 * i]))
            return "an active clip has no file";
        set->clips[i].start = pairs[2 * i] * active.source->scale + active.source->offset;
        set->clips[i].file = open_clip(stage, prim, &assets, paths[(size_t)index].text);
    }
    sort_clips(set->clips, set->clip_count);
    if (!is_array_of(&times, COHORT_TYPE_DOUBLE2))
        return NULL;
    pairs = times.value->data;
    set->time_count = times.value->count;
    set->times = co_composer_array(&stage->composer, set->time_count, sizeof *set->times);
    for (size_t i = 0; i < set->time_count; i++) {
        if (!isfinite(pairs[2 * i]) || !isfinite(pairs[2 * i + 1]))
            return "its times are not finite";
        set->times[i].stage = pairs[2 * i] * times.source->scale + times.source->offset;
        set->times[i].clip = pairs[2 * i + 1];
    }
    separate_jumps(set->times, set->time_count);
    return NULL;
}

// ---- Template sets ------------------------------------------------------------------------------
// "dir/name.###.usd" or "name.##.##.usd": digits of a time, with those behind the point if there
// are two runs. False when the pattern is neither.
static bool expand(const char *pattern, double time, char *out, size_t size)
{
    const char *slash = strrchr(pattern, '/'), *start = strchr(slash ? slash : pattern, '#');
    if (!start)
        return false;
    int whole = (int)strspn(start, "#");
    const char *rest = start + whole;
    int decimals = rest[0] == '.' && rest[1] == '#' ? (int)strspn(rest + 1, "#") : 0;
    if (decimals)
        rest += decimals + 1;
    if (strchr(rest, '#') || whole > 32 || decimals > 15 || fabs(time) > 1e15)
        return false;
    char number[96];
    int width = decimals ? whole + 1 + decimals : whole;
    snprintf(number, sizeof number, "%0*.*f", width, decimals, decimals ? time : floor(time));
    int length = snprintf(out, size, "%.*s%s%s", (int)(start - pattern), pattern, number, rest);
    return length > 0 && (size_t)length < size;
}

static const char *template_set(CohortStage *stage, const CohortPrim *prim, const char *name,
                                CoClipSet *set, const CoClipEntry *pattern)
{
    CoComposer *c = &stage->composer;
    double start, end, stride, offset = 0;
    const CohortString *text = co_value_text(pattern->value);
    if (!text || !find_number(prim, name, "templateStartTime", &start) ||
        !find_number(prim, name, "templateEndTime", &end) ||
        !find_number(prim, name, "templateStride", &stride))
        return "its template lacks a start, an end or a stride";
    find_number(prim, name, "templateActiveOffset", &offset);
    if (!(stride > 0) || end < start || fabs(offset) > stride)
        return "the range of its template makes no sense";
    double steps = floor((end - start) / stride + 1e-6);
    if (steps >= MAX_TEMPLATE_CLIPS)
        return "its template means too many clips";
    const CoSource *source = set->anchor = pattern->source;
    size_t most = (size_t)steps + 1;
    set->clips = co_composer_array(c, most, sizeof *set->clips);
    set->times = co_composer_array(c, most + 2, sizeof *set->times);
    double reach = fabs(offset), last = start;
    if (reach > 0)
        set->times[set->time_count++] = (CoClipTime){start - reach, start - reach, false};
    for (size_t i = 0; i < most; i++) {
        char path[4096];
        double time = last = start + (double)i * stride;
        if (!expand(text->text, time, path, sizeof path))
            return "its template has no run of # in the file name";
        if (!co_asset_exists(c, co_asset_anchor(c, source->file, path)))
            continue;
        set->times[set->time_count++] = (CoClipTime){time, time, false};
        set->clips[set->clip_count++] =
            (CoClip){open_clip(stage, prim, pattern, path), time + offset};
    }
    if (reach > 0)
        set->times[set->time_count++] = (CoClipTime){last + reach, last + reach, false};
    for (size_t i = 0; i < set->time_count; i++)
        set->times[i].stage = set->times[i].stage * source->scale + source->offset;
    for (size_t i = 0; i < set->clip_count; i++)
        set->clips[i].start = set->clips[i].start * source->scale + source->offset;
    sort_clips(set->clips, set->clip_count);
    separate_jumps(set->times, set->time_count);
    return set->clip_count ? NULL : "its template matches no file";
}

// ---- All sets of a prim -------------------------------------------------------------------------
static bool add_set(CohortStage *stage, const CohortPrim *prim, const char *name, CoClipSet *set)
{
    *set = (CoClipSet){0};
    CoClipEntry path = find_entry(prim, name, "primPath");
    CoClipEntry pattern = find_entry(prim, name, "templateAssetPath");
    CoClipEntry assets = find_entry(prim, name, "assetPaths");
    const CohortString *text = path.value ? co_value_text(path.value) : NULL;
    const char *why = NULL;
    if (!text || text->text[0] != '/')
        why = "it has no absolute primPath";
    else if (pattern.value && !assets.value)
        why = template_set(stage, prim, name, set, &pattern);
    else
        why = explicit_set(stage, prim, name, set);
    if (why) {
        const CoSource *source = path.source ? path.source : prim->data->opinions[0].source;
        co_composer_warn(&stage->composer, COHORT_PROBLEM_CLIPS, source->file, path.line,
                         prim->data->path, "clip set \"%s\" is left out: %s", name, why);
        return false;
    }
    set->prim_path = text->text;
    CoClipEntry manifest = find_entry(prim, name, "manifestAssetPath");
    const CohortString *file = manifest.value ? co_value_text(manifest.value) : NULL;
    if (file && file->length)
        set->manifest = open_clip(stage, prim, &manifest, file->text);
    CoClipEntry missing = find_entry(prim, name, "interpolateMissingClipValues");
    if (missing.value)
        co_value_bool(missing.value, &set->interpolates_missing);
    const CoLayerFile *first = set->manifest;
    for (size_t i = 0; i < set->clip_count && !first; i++)
        first = set->clips[i].file;
    set->source = (CoSource){first ? first : set->anchor->file,
                             set->anchor->stack,
                             set->anchor->to_root,
                             0,
                             1,
                             set->anchor->arc};
    return true;
}

static bool has_name(const char *const *names, size_t count, const char *name)
{
    for (size_t i = 0; i < count; i++)
        if (!strcmp(names[i], name))
            return true;
    return false;
}

static size_t count_names(const CohortPrim *prim, const char **names)
{
    size_t count = 0;
    for (uint32_t i = 0; i < prim->data->opinion_count; i++) {
        const CoField *field =
            co_spec_field(prim->data->opinions[i].spec, prim->data->stage->composer.names.clips);
        const CoDict *dict = field ? co_value_dict(&field->value) : NULL;
        for (size_t j = 0; dict && j < dict->count; j++) {
            if (names && has_name(names, count, dict->entries[j].key))
                continue;
            if (names)
                names[count] = dict->entries[j].key;
            count++;
        }
    }
    return count;
}

typedef struct NameList {
    const char *const *names;
    size_t count;
} NameList;

static bool known_name(void *context, const CoListOp *op, CoListOpKind kind, size_t i,
                       CoListItem *out)
{
    const NameList *known = context;
    const CohortString *text = (const CohortString *)op->list[kind].items + i;
    for (size_t k = 0; k < known->count; k++)
        if (!strcmp(known->names[k], text->text)) {
            out->a = known->names[k];
            return true;
        }
    return false;
}

// All of them by name, edited by what every opinion of clipSets says.
static size_t order_names(CoComposer *c, const CohortPrim *prim, const char **names, size_t count)
{
    for (size_t i = 1; i < count; i++)
        for (size_t j = i; j > 0 && strcmp(names[j], names[j - 1]) < 0; j--) {
            const char *swap = names[j];
            names[j] = names[j - 1];
            names[j - 1] = swap;
        }
    NameList known = {names, count};
    CoList list = {0};
    for (size_t i = 0; i < count; i++)
        co_list_push(c, &list, (CoListItem){.a = names[i]});
    for (uint32_t i = prim->data->opinion_count; i-- > 0;) {
        const CoField *field = co_spec_field(prim->data->opinions[i].spec, c->names.clipSets);
        const CoListOp *op = field ? co_value_list_op(&field->value) : NULL;
        if (op)
            co_list_apply(c, &list, op, known_name, &known);
    }
    for (size_t i = 0; i < list.count; i++)
        names[i] = list.items[i].a;
    return list.count;
}

const CoClips *co_clips_compose(CohortStage *stage, const CohortPrim *prim)
{
    const CoClips *outer = prim->parent ? prim->parent->data->clips : NULL;
    size_t most = count_names(prim, NULL);
    if (!most)
        return outer;
    CoComposer *c = &stage->composer;
    const char **names = co_composer_array(c, most, sizeof *names);
    size_t count = order_names(c, prim, names, count_names(prim, names));
    CoClips *clips = co_composer_alloc(c, sizeof *clips);
    *clips = (CoClips){prim, outer, co_composer_array(c, count, sizeof *clips->sets), 0};
    for (size_t i = 0; i < count; i++)
        clips->count += add_set(stage, prim, names[i], &clips->sets[clips->count]);
    return clips;
}
