// Relationship targets and connections, carried from each layer's namespace to the stage's.

#include "stage/stage_data.h"

#include "compose/fields.h"

#include <string.h>

typedef struct CoTargetContext {
    const CohortPrim *prim;
    const CoSource *source;
} CoTargetContext;

// Prim part of "/A/B.attr" or "/A/B.rel[/C].x".
static size_t prim_length(const CohortString *path)
{
    size_t i = 0;
    while (i < path->length && path->text[i] != '.' && path->text[i] != '[')
        i++;
    return i;
}

// Adds the elements of `path` below `top` to the `length` bytes written so far.
static size_t put_below(const CoPath *path, const CoPath *top, char *out, size_t length)
{
    if (path == top || !path->parent)
        return length;
    length = put_below(path->parent, top, out, length);
    size_t size = strlen(path->name);
    out[length++] = '/';
    memcpy(out + length, path->name, size);
    return length + size;
}

static bool translate(void *context, const CohortString *in, CohortString *out)
{
    const CoTargetContext *at = context;
    if (co_map_is_identity(at->source->to_root)) {
        *out = *in;
        return true;
    }
    CohortStage *stage = at->prim->data->stage;
    CoPathTable *paths = &stage->composer.paths;
    size_t length = prim_length(in);
    bool malformed;
    const CoPath *path = co_path_parse(paths, in->text, length, &paths->root, &malformed);
    path = path ? co_map_to_target(paths, at->source->to_root, path) : NULL;
    if (!path && paths->is_short)
        stage->refusals++;
    paths->is_short = false;
    if (!path)
        return false;
    // The map leads to where the data was composed; from there to this prim.
    const CoPath *from;
    const CohortPrim *to;
    co_prim_renaming(at->prim, &from, &to);
    size_t start = to->parent ? co_prim_path_text(to, NULL, 0) : 0;
    size_t size = co_path_text(path, NULL, 0), rest = in->length - length;
    char *text = co_stage_alloc(stage, start + size + rest + 1, 1);
    if (!text)
        return false;
    if (start) {
        co_prim_path_text(to, text, start + 1);
        size = put_below(path, from, text, start);
    } else {
        co_path_text(path, text, size + 1);
    }
    memcpy(text + size, in->text + length, rest);
    *out = (CohortString){text, size + rest};
    return true;
}

static CoAnswer compose_targets(const CohortPrim *prim, const char *name, const char *field_name,
                                CoSpecKind kind)
{
    const CohortStage *stage = prim->data->stage;
    CoEditList list = {.stage = stage, .item_size = sizeof(CohortString), .is_text = true};
    CoPropertyWalk walk = co_property_walk(prim, name);
    const CoField **fields =
        co_stage_alloc(stage, (size_t)prim->data->opinion_count + 1, sizeof *fields);
    const CoSource **sources =
        co_stage_alloc(stage, (size_t)prim->data->opinion_count + 1, sizeof *sources);
    size_t count = 0;
    if (!fields || !sources)
        return (CoAnswer){0};
    while (co_property_next(&walk)) {
        const CoField *field = co_spec_field(walk.spec, field_name);
        if (walk.kind != kind || !field || !co_value_list_op(&field->value))
            continue;
        fields[count] = field;
        sources[count++] = walk.source;
        if (co_value_list_op(&field->value)->is_explicit)
            break;
    }
    for (size_t i = count; i-- > 0;) {
        CoTargetContext context = {prim, sources[i]};
        CoEditTranslate via = {translate, &context};
        if (!co_edit_list_apply(&list, co_value_list_op(&fields[i]->value), &via))
            return (CoAnswer){0};
    }
    const char **texts = co_stage_alloc(stage, list.count, sizeof *texts);
    for (size_t i = 0; texts && i < list.count; i++)
        texts[i] = ((const CohortString *)list.items)[i].text;
    return (CoAnswer){.data = texts, .count = texts ? list.count : 0};
}

static size_t query(const CohortPrim *prim, const char *name, CoSpecKind kind,
                    const char *const **out)
{
    const CohortStage *stage = prim->data->stage;
    const CoFieldNames *names = &stage->composer.names;
    const char *field = kind == CO_SPEC_ATTRIBUTE ? names->connectionPaths : names->targetPaths;
    CoQueryKey key = {prim, co_property_token(prim, name), CO_QUERY_TARGETS | (uint64_t)kind << 8,
                      0};
    if (!key.detail)
        return 0;
    co_stage_lock(stage);
    const CoAnswer *known = co_stage_find_answer(stage, &key);
    CoAnswer answer = known ? *known : compose_targets(prim, key.detail, field, kind);
    if (!known && answer.data)
        co_stage_keep_answer(stage, &key, &answer);
    co_stage_unlock(stage);
    *out = answer.data;
    return answer.count;
}

size_t cohort_prim_targets(const CohortPrim *prim, const char *name, const char *const **out)
{
    return query(prim, name, CO_SPEC_RELATIONSHIP, out);
}

size_t cohort_prim_connections(const CohortPrim *prim, const char *name, const char *const **out)
{
    return query(prim, name, CO_SPEC_ATTRIBUTE, out);
}
