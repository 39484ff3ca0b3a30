#include "stage/stage_data.h"

#include "compose/fields.h"

#include <string.h>

// ---- Finding
// --------------------------------------------------------------------------------------
const CohortPrim *cohort_stage_prim(const CohortStage *stage, const char *path)
{
    if (!path || *path != '/')
        return NULL;
    const CohortPrim *prim = &stage->root;
    const char *at = path + 1;
    while (prim && *at) {
        size_t length = strcspn(at, "/");
        const char *name = length ? co_token(at, length) : NULL;
        prim = name ? co_prim_find_child(prim, name) : NULL;
        at += length;
        if (*at && !*++at)
            return NULL;
    }
    return prim;
}

// ---- What it is
// -------------------------------------------------------------------------------------
const char *cohort_prim_name(const CohortPrim *prim)
{
    return prim->path->name;
}

const char *cohort_prim_path(const CohortPrim *prim)
{
    const CohortStage *stage = prim->stage;
    CoQueryKey key = {prim->path, NULL, CO_QUERY_PATH, 0};
    co_stage_lock(stage);
    const CoAnswer *answer = co_stage_find_answer(stage, &key);
    if (!answer) {
        size_t length = co_path_text(prim->path, NULL, 0);
        char *text = co_stage_alloc(stage, length + 1, 1);
        if (text) {
            co_path_text(prim->path, text, length + 1);
            answer = co_stage_keep_answer(stage, &key, &(CoAnswer){.data = text});
        }
    }
    const char *text = answer ? answer->data : "";
    co_stage_unlock(stage);
    return text;
}

const char *cohort_prim_type(const CohortPrim *prim)
{
    return prim->type;
}

CohortSpecifier cohort_prim_specifier(const CohortPrim *prim)
{
    return (CohortSpecifier)prim->specifier;
}

const CohortPrim *cohort_prim_parent(const CohortPrim *prim)
{
    return prim->parent;
}

size_t cohort_prim_child_count(const CohortPrim *prim)
{
    return prim->shown_count;
}

const CohortPrim *cohort_prim_child(const CohortPrim *prim, size_t i)
{
    if (i >= prim->shown_count)
        return NULL;
    return &prim->children[prim->shown ? prim->shown[i] : i];
}

bool cohort_prim_is_active(const CohortPrim *prim)
{
    return prim->flags & CO_PRIM_ACTIVE;
}

bool cohort_prim_is_defined(const CohortPrim *prim)
{
    return prim->flags & CO_PRIM_DEFINED;
}

bool cohort_prim_is_abstract(const CohortPrim *prim)
{
    return prim->flags & CO_PRIM_ABSTRACT;
}

bool cohort_prim_is_instance(const CohortPrim *prim)
{
    return prim->flags & CO_PRIM_INSTANCE;
}

const CohortPrim *cohort_prim_prototype(const CohortPrim *prim)
{
    return prim->prototype;
}

bool cohort_prim_has_api(const CohortPrim *prim, const char *schema)
{
    CohortValue value;
    if (!co_prim_field(prim, NULL, "apiSchemas", &value) || value.type != COHORT_TYPE_TOKEN)
        return false;
    const CohortString *names = value.data;
    for (size_t i = 0; i < value.count; i++)
        if (!strcmp(names[i].text, schema))
            return true;
    return false;
}

const char *cohort_prim_kind(const CohortPrim *prim)
{
    CohortValue value;
    return co_prim_field(prim, NULL, "kind", &value) && value.type == COHORT_TYPE_TOKEN &&
                   value.count
               ? ((const CohortString *)value.data)->text
               : "";
}

// ---- Variants
// --------------------------------------------------------------------------------------- Adds the
// items of one of a list op's lists that are not there yet.
static size_t add_names(const char **names, size_t count, const CohortString *items, size_t n)
{
    for (size_t i = 0; i < n; i++) {
        const char *name = co_token(items[i].text, items[i].length);
        bool is_new = name != NULL;
        for (size_t j = 0; j < count && is_new; j++)
            is_new = names[j] != name;
        if (is_new)
            names[count++] = name;
    }
    return count;
}

static CoAnswer find_variant_sets(const CohortPrim *prim)
{
    const char *field_name = prim->stage->composer.names.variantSetNames;
    size_t most = 0;
    for (uint32_t i = 0; i < prim->opinion_count; i++) {
        const CoSpec *spec = prim->opinions[i].spec;
        const CoField *field = co_spec_field(spec, field_name);
        const CoListOp *op = field ? co_value_list_op(&field->value) : NULL;
        for (int k = 0; op && k < CO_LIST_KIND_COUNT; k++)
            most += op->list[k].count;
    }
    const char **names = co_stage_alloc(prim->stage, most, sizeof *names);
    size_t count = 0;
    static const CoListOpKind kinds[] = {CO_LIST_EXPLICIT, CO_LIST_PREPENDED, CO_LIST_ADDED,
                                         CO_LIST_APPENDED};
    for (uint32_t i = 0; names && i < prim->opinion_count; i++) {
        const CoField *field = co_spec_field(prim->opinions[i].spec, field_name);
        const CoListOp *op = field ? co_value_list_op(&field->value) : NULL;
        for (size_t k = 0; op && k < 4; k++)
            count = add_names(names, count, op->list[kinds[k]].items, op->list[kinds[k]].count);
    }
    return (CoAnswer){.data = names, .count = count};
}

static CoAnswer find_variants(const CohortPrim *prim, const char *set)
{
    size_t most = 0, count = 0;
    const char **names = NULL;
    for (int pass = 0; pass < 2; pass++) {
        if (pass && !(names = co_stage_alloc(prim->stage, most, sizeof *names)))
            break;
        for (uint32_t i = 0; i < prim->opinion_count; i++) {
            const CoSpec *spec = prim->opinions[i].spec;
            for (size_t j = 0; j < spec->variant_set_count; j++) {
                const CoSpec *variants = spec->variant_sets[j];
                if (variants->name != set)
                    continue;
                if (!pass)
                    most += variants->child_count;
                for (size_t k = 0; pass && k < variants->child_count; k++) {
                    CohortString name = {variants->children[k]->name,
                                         strlen(variants->children[k]->name)};
                    count = add_names(names, count, &name, 1);
                }
            }
        }
    }
    for (size_t i = 1; i < count; i++)
        for (size_t j = i; j > 0 && strcmp(names[j], names[j - 1]) < 0; j--) {
            const char *swap = names[j];
            names[j] = names[j - 1];
            names[j - 1] = swap;
        }
    return (CoAnswer){.data = names, .count = count};
}

static CoAnswer variant_answer(const CohortPrim *prim, const char *set)
{
    const CohortStage *stage = prim->stage;
    CoQueryKey key = {prim, set, set ? CO_QUERY_VARIANTS : CO_QUERY_VARIANT_SETS, 0};
    co_stage_lock(stage);
    const CoAnswer *known = co_stage_find_answer(stage, &key);
    CoAnswer answer = known ? *known : set ? find_variants(prim, set) : find_variant_sets(prim);
    if (!known && answer.data)
        co_stage_keep_answer(stage, &key, &answer);
    co_stage_unlock(stage);
    return answer;
}

size_t cohort_prim_variant_set_count(const CohortPrim *prim)
{
    return variant_answer(prim, NULL).count;
}

const char *cohort_prim_variant_set(const CohortPrim *prim, size_t i)
{
    CoAnswer answer = variant_answer(prim, NULL);
    return i < answer.count ? ((const char *const *)answer.data)[i] : NULL;
}

const char *cohort_prim_variant_selection(const CohortPrim *prim, const char *set)
{
    // The variants that take part say best what was selected.
    for (uint32_t i = 0; i < prim->opinion_count; i++) {
        const CoSpec *spec = prim->opinions[i].spec;
        if (spec->kind == CO_SPEC_VARIANT && spec->parent && !strcmp(spec->parent->name, set))
            return spec->name;
    }
    const char *field_name = prim->stage->composer.names.variantSelection;
    for (uint32_t i = 0; i < prim->opinion_count; i++) {
        const CoField *field = co_spec_field(prim->opinions[i].spec, field_name);
        const CoDict *dict = field ? co_value_dict(&field->value) : NULL;
        for (size_t j = 0; dict && j < dict->count; j++) {
            const CohortString *text = co_value_text(dict->entries[j].value);
            if (text && !strcmp(dict->entries[j].key, set))
                return text->text;
        }
    }
    return "";
}

size_t cohort_prim_variant_count(const CohortPrim *prim, const char *set)
{
    const char *token = co_token(set, strlen(set));
    return token ? variant_answer(prim, token).count : 0;
}

const char *cohort_prim_variant(const CohortPrim *prim, const char *set, size_t i)
{
    const char *token = co_token(set, strlen(set));
    CoAnswer answer = token ? variant_answer(prim, token) : (CoAnswer){0};
    return i < answer.count ? ((const char *const *)answer.data)[i] : NULL;
}
