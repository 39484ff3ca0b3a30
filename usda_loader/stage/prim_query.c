// Prims: by path, their relatives, kinds, variants and opinions.

#include "stage/stage_data.h"

#include "compose/fields.h"

#include "base/hash.h"

#include <string.h>

// ---- Finding ------------------------------------------------------------------------------------
#define WIDE 16 // with fewer children, looking at each is as fast

// Positions of children by name, plus 1, open addressing; 0 is empty.
typedef struct CoChildTable {
    size_t capacity;
    uint32_t slots[];
} CoChildTable;

// Where the name is, or would go.
static size_t child_slot(const CoChildTable *table, const CohortPrim *children, const char *name)
{
    size_t at = co_hash64((uint64_t)(uintptr_t)name) & (table->capacity - 1);
    while (table->slots[at] && co_prim_name(&children[table->slots[at] - 1]) != name)
        at = (at + 1) & (table->capacity - 1);
    return at;
}

static const CoChildTable *make_child_table(const CohortPrim *prim)
{
    size_t capacity = 64, count = prim->data->child_count;
    while (capacity < 2 * count)
        capacity *= 2;
    size_t words = sizeof(CoChildTable) / sizeof(uint32_t) + capacity;
    CoChildTable *table = co_stage_alloc(prim->data->stage, words, sizeof(uint32_t));
    if (!table)
        return NULL;
    table->capacity = capacity;
    for (uint32_t i = 0; i < count; i++)
        table->slots[child_slot(table, prim->children, co_prim_name(&prim->children[i]))] = i + 1;
    return table;
}

static const CohortPrim *find_in_table(const CohortPrim *prim, const char *name)
{
    const CohortStage *stage = prim->data->stage;
    CoQueryKey key = {prim->children, NULL, CO_QUERY_CHILDREN, 0};
    co_stage_lock(stage);
    const CoAnswer *answer = co_stage_find_answer(stage, &key);
    const CoChildTable *table = answer ? answer->data : make_child_table(prim);
    if (table && !answer)
        co_stage_keep_answer(stage, &key, &(CoAnswer){.data = table});
    co_stage_unlock(stage);
    uint32_t at = table ? table->slots[child_slot(table, prim->children, name)] : 0;
    return at ? &prim->children[at - 1] : NULL;
}

const CohortPrim *co_prim_find_child(const CohortPrim *prim, const char *name)
{
    if (prim->data->child_count > WIDE)
        return find_in_table(prim, name);
    for (uint32_t i = 0; i < prim->data->child_count; i++)
        if (co_prim_name(&prim->children[i]) == name)
            return &prim->children[i];
    return NULL;
}

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

// ---- What it is ---------------------------------------------------------------------------------
const char *cohort_prim_name(const CohortPrim *prim)
{
    return co_prim_name(prim);
}

static void put_path(const CohortPrim *prim, char *out, size_t size, size_t *length)
{
    if (prim->parent->parent)
        put_path(prim->parent, out, size, length);
    const char *name = co_prim_name(prim);
    for (char c = '/'; c; c = *name++, ++*length)
        if (*length < size)
            out[*length] = c;
}

size_t co_prim_path_text(const CohortPrim *prim, char *out, size_t size)
{
    size_t length = 0;
    if (!prim->parent)
        return co_path_text(prim->data->path, out, size);
    put_path(prim, out, size, &length);
    if (size)
        out[length < size ? length : size - 1] = 0;
    return length;
}

void co_prim_renaming(const CohortPrim *prim, const CoPath **from, const CohortPrim **to)
{
    *from = prim->data->path;
    *to = prim;
    while ((*to)->parent && (*from)->parent && (*from)->name == co_prim_name(*to)) {
        *from = (*from)->parent;
        *to = (*to)->parent;
    }
}

const char *cohort_prim_path(const CohortPrim *prim)
{
    const CohortStage *stage = prim->data->stage;
    CoQueryKey key = {prim, NULL, CO_QUERY_PATH, 0};
    co_stage_lock(stage);
    const CoAnswer *answer = co_stage_find_answer(stage, &key);
    if (!answer) {
        size_t length = co_prim_path_text(prim, NULL, 0);
        char *text = co_stage_alloc(stage, length + 1, 1);
        if (text) {
            co_prim_path_text(prim, text, length + 1);
            answer = co_stage_keep_answer(stage, &key, &(CoAnswer){.data = text});
        }
    }
    const char *text = answer ? answer->data : "";
    co_stage_unlock(stage);
    return text;
}

const char *cohort_prim_type(const CohortPrim *prim)
{
    return prim->data->type;
}

CohortSpecifier cohort_prim_specifier(const CohortPrim *prim)
{
    return (CohortSpecifier)prim->data->specifier;
}

const CohortPrim *cohort_prim_parent(const CohortPrim *prim)
{
    return prim->parent;
}

size_t cohort_prim_child_count(const CohortPrim *prim)
{
    return prim->data->shown_count;
}

const CohortPrim *cohort_prim_child(const CohortPrim *prim, size_t i)
{
    if (i >= prim->data->shown_count)
        return NULL;
    return &prim->children[prim->data->shown ? prim->data->shown[i] : i];
}

bool cohort_prim_is_active(const CohortPrim *prim)
{
    return prim->data->flags & CO_PRIM_ACTIVE;
}

bool cohort_prim_is_defined(const CohortPrim *prim)
{
    return prim->data->flags & CO_PRIM_DEFINED;
}

bool cohort_prim_is_abstract(const CohortPrim *prim)
{
    return prim->data->flags & CO_PRIM_ABSTRACT;
}

bool cohort_prim_is_instance(const CohortPrim *prim)
{
    return prim->data->flags & CO_PRIM_INSTANCE;
}

const CohortPrim *cohort_prim_prototype(const CohortPrim *prim)
{
    return prim->data->prototype;
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
    const char *field_name = prim->data->stage->composer.names.variantSetNames;
    size_t most = 0;
    for (uint32_t i = 0; i < prim->data->opinion_count; i++) {
        const CoSpec *spec = prim->data->opinions[i].spec;
        const CoField *field = co_spec_field(spec, field_name);
        const CoListOp *op = field ? co_value_list_op(&field->value) : NULL;
        for (int k = 0; op && k < CO_LIST_KIND_COUNT; k++)
            most += op->list[k].count;
    }
    const char **names = co_stage_alloc(prim->data->stage, most, sizeof *names);
    size_t count = 0;
    static const CoListOpKind kinds[] = {CO_LIST_EXPLICIT, CO_LIST_PREPENDED, CO_LIST_ADDED,
                                         CO_LIST_APPENDED};
    for (uint32_t i = 0; names && i < prim->data->opinion_count; i++) {
        const CoField *field = co_spec_field(prim->data->opinions[i].spec, field_name);
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
        if (pass && !(names = co_stage_alloc(prim->data->stage, most, sizeof *names)))
            break;
        for (uint32_t i = 0; i < prim->data->opinion_count; i++) {
            const CoContents *in = co_spec_contents(prim->data->opinions[i].spec);
            for (size_t j = 0; j < in->variant_set_count; j++) {
                if (in->variant_sets[j]->name != set)
                    continue;
                const CoContents *variants = co_spec_contents(in->variant_sets[j]);
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
    const CohortStage *stage = prim->data->stage;
    CoQueryKey key = {prim->data, set, set ? CO_QUERY_VARIANTS : CO_QUERY_VARIANT_SETS, 0};
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
    for (uint32_t i = 0; i < prim->data->opinion_count; i++) {
        const CoSpec *spec = prim->data->opinions[i].spec;
        if (spec->kind == CO_SPEC_VARIANT && !strcmp(co_spec_contents(spec)->set, set))
            return spec->name;
    }
    const char *field_name = prim->data->stage->composer.names.variantSelection;
    for (uint32_t i = 0; i < prim->data->opinion_count; i++) {
        const CoField *field = co_spec_field(prim->data->opinions[i].spec, field_name);
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
