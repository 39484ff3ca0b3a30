// Values and metadata on their way into a flat layer.

#include "compose/fields.h"
#include "stage/flatten.h"

#include <string.h>

void *co_flat_alloc(CoFlattener *flat, size_t count, size_t size)
{
    void *memory = co_arena_array(&flat->layer.arena, count, size);
    if (!memory)
        longjmp(flat->escape, 1);
    return memory;
}

// ---- Values -------------------------------------------------------------------------------------
static CohortString flat_asset(CoFlattener *flat, const CohortString *text, const CoSource *source)
{
    CohortStage *stage = flat->stage->self;
    CohortAsset asset;
    co_stage_lock(stage);
    bool ok = co_asset_locate(stage, source, text, &asset);
    co_stage_unlock(stage);
    if (!ok)
        longjmp(flat->escape, 1);
    const char *path = *asset.resolved ? asset.resolved : asset.anchored;
    return (CohortString){path, strlen(path)};
}

static CoDict *flat_dict(CoFlattener *flat, const CoDict *dict, const CoSource *source)
{
    CoDict *out = co_flat_alloc(flat, 1, sizeof *out);
    out->entries = co_flat_alloc(flat, dict->count, sizeof *out->entries);
    out->count = dict->count;
    for (size_t i = 0; i < dict->count; i++) {
        CoValue *value = co_flat_alloc(flat, 1, sizeof *value);
        *value = co_flat_value(flat, dict->entries[i].value, source);
        out->entries[i] = (CoDictEntry){dict->entries[i].key, value};
    }
    return out;
}

static CoTimeSamples *flat_samples(CoFlattener *flat, const CoTimeSamples *samples,
                                   const CoSource *source)
{
    size_t count = samples->count;
    CoTimeSamples *out = co_flat_alloc(flat, 1, sizeof *out);
    out->times = co_flat_alloc(flat, count, sizeof *out->times);
    out->values = co_flat_alloc(flat, count, sizeof *out->values);
    out->count = count;
    for (size_t i = 0; i < count; i++) {
        size_t to = source->scale < 0 ? count - 1 - i : i;
        out->times[to] = samples->times[i] * source->scale + source->offset;
        out->values[to] = co_flat_value(flat, &samples->values[i], source);
    }
    return out;
}

CoValue co_flat_value(CoFlattener *flat, const CoValue *value, const CoSource *source)
{
    CoValue out = *value;
    bool is_timed = source->offset != 0 || source->scale != 1;
    if (value->type == COHORT_TYPE_ASSET) {
        CohortString *paths = co_flat_alloc(flat, value->count, sizeof *paths);
        for (size_t i = 0; i < value->count; i++)
            paths[i] = flat_asset(flat, (const CohortString *)value->data + i, source);
        out.data = paths;
    } else if (value->type == COHORT_TYPE_TIMECODE && is_timed) {
        double *times = co_flat_alloc(flat, value->count, sizeof *times);
        for (size_t i = 0; i < value->count; i++)
            times[i] = ((const double *)value->data)[i] * source->scale + source->offset;
        out.data = times;
    } else if (value->type == COHORT_TYPE_DICTIONARY) {
        out.data = flat_dict(flat, value->data, source);
    } else if (value->type == COHORT_TYPE_TIME_SAMPLES) {
        out.data = flat_samples(flat, value->data, source);
    }
    return out;
}

CoValue co_flat_spline(CoFlattener *flat, const CoValueSource *from)
{
    const CoSource *source = from->source;
    CoSpline *out = co_flat_alloc(flat, 1, sizeof *out);
    *out = *(const CoSpline *)from->field->value.data;
    const CoSplineKnot *knots = out->knots;
    bool is_time = !strcmp(from->spec->type_name, "timecode");
    double scale = source->scale, rise = is_time ? scale : 1, offset = is_time ? source->offset : 0;
    out->knots = co_flat_alloc(flat, out->count, sizeof *out->knots);
    for (size_t i = 0; i < out->count; i++) {
        CoSplineKnot *knot = &out->knots[i];
        *knot = knots[i];
        knot->time = knot->time * scale + source->offset;
        knot->value = knot->value * rise + offset;
        knot->pre_value = knot->pre_value * rise + offset;
        knot->pre.width *= scale;
        knot->post.width *= scale;
        knot->pre.slope *= rise / scale;
        knot->post.slope *= rise / scale;
    }
    out->pre.slope *= rise / scale;
    out->post.slope *= rise / scale;
    for (int i = 0; i < 2; i++)
        out->loop[i] = out->loop[i] * scale + source->offset;
    out->loop[4] *= rise;
    return (CoValue){.type = COHORT_TYPE_SPLINE, .count = 1, .data = out};
}

CoValue co_flat_texts(CoFlattener *flat, CohortType type, const char *const *texts, size_t count)
{
    CoListOp *op = co_flat_alloc(flat, 1, sizeof *op);
    CohortString *items = co_flat_alloc(flat, count, sizeof *items);
    for (size_t i = 0; i < count; i++)
        items[i] = (CohortString){texts[i], strlen(texts[i])};
    op->is_explicit = true;
    op->list[CO_LIST_EXPLICIT].items = items;
    op->list[CO_LIST_EXPLICIT].count = count;
    return (CoValue){.type = type, .count = 1, .data = op};
}

// ---- Fields -------------------------------------------------------------------------------------
void co_flat_add_field(CoFlattener *flat, CoSpec *out, const char *name, CoValue value)
{
    CoField *fields = co_flat_alloc(flat, out->field_count + 1, sizeof *fields);
    if (out->field_count)
        memcpy(fields, out->fields, out->field_count * sizeof *fields);
    fields[out->field_count++] = (CoField){.name = name, .value = value};
    out->fields = fields;
}

// What composition has used up, or the flattener writes in its own way.
static bool is_consumed(const CoFieldNames *n, const char *name)
{
    return name == n->references || name == n->payload || name == n->inheritPaths ||
           name == n->specializes || name == n->variantSetNames || name == n->variantSelection ||
           name == n->relocates || name == n->clips || name == n->clipSets ||
           name == n->primOrder || name == n->instanceable || name == n->timeSamples ||
           name == n->spline || name == n->default_value || name == n->targetPaths ||
           name == n->connectionPaths;
}

static void add_list_op(CoFlattener *flat, CoSpec *out, const CohortPrim *prim,
                        const char *property, const CoField *field)
{
    CohortValue list;
    if (!co_prim_field(prim, property, field->name, &list))
        return;
    if (field->value.type > COHORT_TYPE_UINT64_LIST_OP)
        return;
    CoListOp *op = co_flat_alloc(flat, 1, sizeof *op);
    op->is_explicit = true;
    size_t bytes = list.count * co_type_size(list.type);
    void *items = co_flat_alloc(flat, bytes, 1);
    if (bytes)
        memcpy(items, list.data, bytes);
    op->list[CO_LIST_EXPLICIT].items = items;
    op->list[CO_LIST_EXPLICIT].count = list.count;
    co_flat_add_field(flat, out, field->name,
                      (CoValue){.type = field->value.type, .count = 1, .data = op});
}

static const CoSpec *next_spec(CoPropertyWalk *walk, const char *property, const CoSource **source)
{
    if (property) {
        if (!co_property_next(walk))
            return NULL;
        *source = walk->source;
        return walk->spec;
    }
    if (walk->next >= walk->prim->data->opinion_count)
        return NULL;
    const CoOpinion *opinion = &walk->prim->data->opinions[walk->next++];
    *source = opinion->source;
    return opinion->spec;
}

static void add_dict(CoFlattener *flat, CoSpec *out, CoPropertyWalk walk, const char *property,
                     const CoField *field, const CoSource *source)
{
    const CoDict *merged = co_flat_value(flat, &field->value, source).data;
    const CoSpec *spec;
    while ((spec = next_spec(&walk, property, &source))) {
        const CoField *weaker = co_spec_field(spec, field->name);
        if (!weaker || weaker->value.type != COHORT_TYPE_DICTIONARY)
            continue;
        const CoDict *weak = co_flat_value(flat, &weaker->value, source).data;
        co_stage_lock(flat->stage);
        merged = co_dict_merge(flat->stage, merged, weak);
        co_stage_unlock(flat->stage);
        if (!merged)
            longjmp(flat->escape, 1);
    }
    co_flat_add_field(flat, out, field->name,
                      (CoValue){.type = COHORT_TYPE_DICTIONARY, .count = 1, .data = merged});
}

void co_flat_fields(CoFlattener *flat, CoSpec *out, const CohortPrim *prim, const char *property)
{
    CoPropertyWalk walk = co_property_walk(prim, property);
    const CoSource *source;
    const CoSpec *spec;
    while ((spec = next_spec(&walk, property, &source))) {
        for (size_t i = 0; i < spec->field_count; i++) {
            const CoField *field = &spec->fields[i];
            if (is_consumed(&flat->stage->composer.names, field->name) ||
                co_spec_field(out, field->name))
                continue;
            if (field->value.type == COHORT_TYPE_DICTIONARY)
                add_dict(flat, out, walk, property, field, source);
            else if (co_value_list_op(&field->value))
                add_list_op(flat, out, prim, property, field);
            else
                co_flat_add_field(flat, out, field->name,
                                  co_flat_value(flat, &field->value, source));
        }
    }
}

// ---- Paths --------------------------------------------------------------------------------------
const char *co_flat_rename(CoFlattener *flat, const char *target)
{
    if (!flat->renaming)
        return target;
    size_t length = strcspn(target, ".[");
    bool malformed;
    const CoPath *path = co_path_parse(&flat->paths, target, length, &flat->paths.root, &malformed);
    const CoPath *renamed = path;
    for (const CoRenaming *r = flat->renaming; renamed && r; r = r->outer)
        if (co_path_has_prefix(renamed, r->from))
            renamed = co_path_replace_prefix(&flat->paths, renamed, r->from, r->to);
    if (!renamed || renamed == path)
        return target;
    size_t size = co_path_text(renamed, NULL, 0), rest = strlen(target + length);
    char *text = co_flat_alloc(flat, size + rest + 1, 1);
    co_path_text(renamed, text, size + 1);
    memcpy(text + size, target + length, rest + 1);
    return text;
}
