// Composed metadata: the strongest opinion, but dictionaries merge and list ops apply in turn.

#include "stage/stage_data.h"

#include "compose/fields.h"

#include <string.h>

// The fields of one name over all opinions, strongest first.
typedef struct CoFieldStack {
    const CoField **fields;
    size_t count;
} CoFieldStack;

static bool gather(const CohortPrim *prim, const char *property, const char *key, CoFieldStack *out)
{
    out->fields = co_stage_alloc(prim->data->stage, (size_t)prim->data->opinion_count + 1,
                                 sizeof *out->fields);
    if (!out->fields)
        return false;
    if (property) {
        CoPropertyWalk walk = co_property_walk(prim, property);
        while (co_property_next(&walk)) {
            const CoField *field = co_spec_field(walk.spec, key);
            if (field)
                out->fields[out->count++] = field;
        }
        return true;
    }
    for (uint32_t i = 0; i < prim->data->opinion_count; i++) {
        const CoField *field = co_spec_field(prim->data->opinions[i].spec, key);
        if (field)
            out->fields[out->count++] = field;
    }
    return true;
}

// ---- Dictionaries -------------------------------------------------------------------------------
const CoDict *co_dict_merge(const CohortStage *stage, const CoDict *strong, const CoDict *weak)
{
    CoDict *out = co_stage_alloc(stage, 1, sizeof *out);
    CoDictEntry *entries = co_stage_alloc(stage, strong->count + weak->count, sizeof *entries);
    if (!out || !entries)
        return NULL;
    out->entries = entries;
    size_t i = 0, j = 0;
    while (i < strong->count || j < weak->count) {
        int order = i == strong->count ? 1
                    : j == weak->count ? -1
                                       : strcmp(strong->entries[i].key, weak->entries[j].key);
        if (order > 0) {
            entries[out->count++] = weak->entries[j++];
            continue;
        }
        CoDictEntry entry = strong->entries[i++];
        if (order == 0) {
            const CoDict *a = co_value_dict(entry.value),
                         *b = co_value_dict(weak->entries[j].value);
            if (a && b) {
                CoValue *merged = co_stage_alloc(stage, 1, sizeof *merged);
                if (!merged)
                    return NULL;
                *merged = *entry.value;
                merged->data = co_dict_merge(stage, a, b);
                if (!merged->data)
                    return NULL;
                entry.value = merged;
            }
            j++;
        }
        entries[out->count++] = entry;
    }
    return out;
}

static CoAnswer merge_all(const CohortStage *stage, const CoFieldStack *stack)
{
    const CoDict *dict = co_value_dict(&stack->fields[0]->value);
    for (size_t i = 1; dict && i < stack->count; i++) {
        const CoDict *weak = co_value_dict(&stack->fields[i]->value);
        if (weak)
            dict = co_dict_merge(stage, dict, weak);
    }
    return (CoAnswer){.data = dict, .count = 1, .type = COHORT_TYPE_DICTIONARY};
}

// ---- List ops -----------------------------------------------------------------------------------
static CohortType item_type(CohortType list_op)
{
    switch ((int)list_op) {
    case COHORT_TYPE_TOKEN_LIST_OP:
        return COHORT_TYPE_TOKEN;
    case COHORT_TYPE_STRING_LIST_OP:
    case COHORT_TYPE_PATH_LIST_OP:
        return COHORT_TYPE_STRING;
    case COHORT_TYPE_INT_LIST_OP:
        return COHORT_TYPE_INT;
    case COHORT_TYPE_UINT_LIST_OP:
        return COHORT_TYPE_UINT;
    case COHORT_TYPE_INT64_LIST_OP:
        return COHORT_TYPE_INT64;
    case COHORT_TYPE_UINT64_LIST_OP:
        return COHORT_TYPE_UINT64;
    default:
        return COHORT_TYPE_NONE;
    }
}

static CoAnswer apply_all(const CohortStage *stage, const CoFieldStack *stack)
{
    CohortType list_type = stack->fields[0]->value.type, type = item_type(list_type);
    CoEditList list = {.stage = stage,
                       .item_size = co_type_size(type),
                       .is_text = type == COHORT_TYPE_TOKEN || type == COHORT_TYPE_STRING};
    for (size_t i = stack->count; i-- > 0;)
        if (stack->fields[i]->value.type == list_type &&
            !co_edit_list_apply(&list, co_value_list_op(&stack->fields[i]->value), NULL))
            return (CoAnswer){0};
    return (CoAnswer){list.items ? list.items : "", list.count, type, true};
}

bool co_prim_field(const CohortPrim *prim, const char *property, const char *key, CohortValue *out)
{
    const CohortStage *stage = prim->data->stage;
    const char *token = co_token(key, strlen(key));
    if (property)
        property = co_property_token(prim, property);
    if (!token)
        return false;
    // The common case needs no memory: one opinion, and of a plain kind.
    CoPropertyWalk walk = co_property_walk(prim, property);
    const CoField *strongest = NULL;
    for (uint32_t i = 0; !property && i < prim->data->opinion_count && !strongest; i++)
        strongest = co_spec_field(prim->data->opinions[i].spec, token);
    while (property && !strongest && co_property_next(&walk))
        strongest = co_spec_field(walk.spec, token);
    if (!strongest || strongest->value.type == COHORT_TYPE_BLOCK)
        return false;
    const CoValue *value = &strongest->value;
    bool is_list = item_type(value->type) != COHORT_TYPE_NONE;
    if (value->type != COHORT_TYPE_DICTIONARY && !is_list) {
        *out = (CohortValue){value->type, value->is_array, value->count, value->data};
        return true;
    }
    CoQueryKey query = {prim->data, token, CO_QUERY_METADATA, 0};
    memcpy(&query.time, &property,
           sizeof query.time < sizeof property ? sizeof query.time : sizeof property);
    co_stage_lock(stage);
    const CoAnswer *known = co_stage_find_answer(stage, &query);
    CoAnswer answer = known ? *known : (CoAnswer){0};
    CoFieldStack stack = {0};
    if (!known && gather(prim, property, token, &stack)) {
        answer = is_list ? apply_all(stage, &stack) : merge_all(stage, &stack);
        if (answer.data)
            co_stage_keep_answer(stage, &query, &answer);
    }
    co_stage_unlock(stage);
    if (answer.data)
        *out = (CohortValue){answer.type, answer.is_array, answer.count, answer.data};
    return answer.data != NULL;
}

bool cohort_prim_metadata(const CohortPrim *prim, const char *key, CohortValue *out)
{
    return co_prim_field(prim, NULL, key, out);
}

bool cohort_prim_attribute_metadata(const CohortPrim *prim, const char *name, const char *key,
                                    CohortValue *out)
{
    return co_prim_field(prim, name, key, out);
}
