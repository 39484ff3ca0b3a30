#include "support/same_layer.h"

#include "parse/types.h"

#include <string.h>

static bool same_value(const CoValue *a, const CoValue *b);

static bool same_double(double a, double b)
{
    return memcmp(&a, &b, sizeof a) == 0;
}

static bool same_strings(const CohortString *a, const CohortString *b, size_t count)
{
    for (size_t i = 0; i < count; i++)
        if (a[i].length != b[i].length || memcmp(a[i].text, b[i].text, a[i].length) != 0)
            return false;
    return true;
}

static bool same_dict(const CoDict *a, const CoDict *b)
{
    if (!a || !b)
        return a == b;
    if (a->count != b->count)
        return false;
    for (size_t i = 0; i < a->count; i++)
        if (a->entries[i].key != b->entries[i].key ||
            !same_value(a->entries[i].value, b->entries[i].value))
            return false;
    return true;
}

// A zero offset is not written, whatever its sign.
static bool same_offset(double a, double b)
{
    return a == b || same_double(a, b);
}

static bool same_arcs(const CoArc *a, const CoArc *b, size_t count)
{
    for (size_t i = 0; i < count; i++) {
        if (strcmp(a[i].asset, b[i].asset) != 0 ||
            strcmp(a[i].prim ? a[i].prim : "", b[i].prim ? b[i].prim : "") != 0 ||
            !same_offset(a[i].offset, b[i].offset) || !same_double(a[i].scale, b[i].scale))
            return false;
        if (!a[i].custom_data != !b[i].custom_data ||
            (a[i].custom_data && !same_value(a[i].custom_data, b[i].custom_data)))
            return false;
    }
    return true;
}

static bool same_items(CohortType type, const void *a, const void *b, size_t count)
{
    if (type == COHORT_TYPE_REFERENCE_LIST_OP || type == COHORT_TYPE_PAYLOAD_LIST_OP)
        return same_arcs(a, b, count);
    if (type == COHORT_TYPE_INT_LIST_OP || type == COHORT_TYPE_UINT_LIST_OP)
        return memcmp(a, b, count * 4) == 0;
    if (type == COHORT_TYPE_INT64_LIST_OP || type == COHORT_TYPE_UINT64_LIST_OP)
        return memcmp(a, b, count * 8) == 0;
    return same_strings(a, b, count);
}

static bool same_list_op(CohortType type, const CoListOp *a, const CoListOp *b)
{
    if (a->is_explicit != b->is_explicit)
        return false;
    for (int i = 0; i < CO_LIST_KIND_COUNT; i++) {
        size_t count = a->list[i].count;
        if (count != b->list[i].count ||
            (count && !same_items(type, a->list[i].items, b->list[i].items, count)))
            return false;
    }
    return true;
}

static bool same_samples(const CoTimeSamples *a, const CoTimeSamples *b)
{
    if (a->count != b->count)
        return false;
    for (size_t i = 0; i < a->count; i++)
        if (!same_double(a->times[i], b->times[i]) || !same_value(&a->values[i], &b->values[i]))
            return false;
    return true;
}

static bool same_tangent(const CoSplineTangent *a, const CoSplineTangent *b)
{
    if (a->is_set != b->is_set)
        return false;
    return !a->is_set || (a->has_width == b->has_width && a->algorithm == b->algorithm &&
                          same_double(a->width, b->width) && same_double(a->slope, b->slope));
}

static bool same_knot(const CoSplineKnot *a, const CoSplineKnot *b)
{
    return same_double(a->time, b->time) && same_double(a->value, b->value) &&
           a->has_pre_value == b->has_pre_value &&
           (!a->has_pre_value || same_double(a->pre_value, b->pre_value)) &&
           a->has_interp == b->has_interp && a->interp == b->interp &&
           same_tangent(&a->pre, &b->pre) && same_tangent(&a->post, &b->post) &&
           same_dict(a->custom_data, b->custom_data);
}

static bool same_spline(const CoSpline *a, const CoSpline *b)
{
    if (a->curve != b->curve || a->count != b->count || a->has_loop != b->has_loop ||
        strcmp(a->pre.mode, b->pre.mode) != 0 || strcmp(a->post.mode, b->post.mode) != 0 ||
        !same_double(a->pre.slope, b->pre.slope) || !same_double(a->post.slope, b->post.slope))
        return false;
    for (int i = 0; a->has_loop && i < 5; i++)
        if (!same_double(a->loop[i], b->loop[i]))
            return false;
    for (size_t i = 0; i < a->count; i++)
        if (!same_knot(&a->knots[i], &b->knots[i]))
            return false;
    return true;
}

static bool same_edit(const CoArrayEdit *a, const CoArrayEdit *b)
{
    if (a->count != b->count)
        return false;
    for (size_t i = 0; i < a->count; i++) {
        const CoArrayEditItem *x = &a->items[i], *y = &b->items[i];
        if (x->kind != y->kind || x->source != y->source || x->at_or_size != y->at_or_size ||
            !x->literal != !y->literal || (x->literal && !same_value(x->literal, y->literal)))
            return false;
    }
    return true;
}

static bool same_relocates(const CoRelocate *a, const CoRelocate *b, size_t count)
{
    for (size_t i = 0; i < count; i++)
        if (strcmp(a[i].source, b[i].source) != 0 || strcmp(a[i].target, b[i].target) != 0)
            return false;
    return true;
}

static bool same_plain(const CoValue *a, const CoValue *b)
{
    const CoTypeInfo *info = co_type_info(a->type);
    if (a->type == COHORT_TYPE_OPAQUE)
        return a->is_array ? same_list_op(a->type, a->data, b->data)
                           : same_strings(a->data, b->data, a->count);
    if (info->scalar >= CO_SCALAR_STRING)
        return same_strings(a->data, b->data, a->count);
    return !info->scalar || !a->count ||
           memcmp(a->data, b->data, a->count * co_type_size(a->type)) == 0;
}

static bool same_value(const CoValue *a, const CoValue *b)
{
    if (a->type != b->type || a->is_array != b->is_array || a->count != b->count)
        return false;
    if (a->type >= COHORT_TYPE_TOKEN_LIST_OP && a->type <= COHORT_TYPE_PAYLOAD_LIST_OP)
        return same_list_op(a->type, a->data, b->data);
    if (a->type == COHORT_TYPE_DICTIONARY || a->type == COHORT_TYPE_VARIANT_SELECTION)
        return same_dict(a->data, b->data);
    if (a->type == COHORT_TYPE_TIME_SAMPLES)
        return same_samples(a->data, b->data);
    if (a->type == COHORT_TYPE_SPLINE)
        return same_spline(a->data, b->data);
    if (a->type == COHORT_TYPE_ARRAY_EDIT)
        return same_edit(a->data, b->data);
    if (a->type == COHORT_TYPE_SUBLAYERS)
        return same_arcs(a->data, b->data, a->count);
    if (a->type == COHORT_TYPE_RELOCATES)
        return same_relocates(a->data, b->data, a->count);
    return same_plain(a, b);
}

static bool same_spec(const CoSpec *a, const CoSpec *b);

static bool same_specs(CoSpec *const *a, size_t a_count, CoSpec *const *b, size_t b_count)
{
    bool same = a_count == b_count;
    for (size_t i = 0; same && i < a_count; i++)
        same = same_spec(a[i], b[i]);
    return same;
}

static bool same_spec(const CoSpec *a, const CoSpec *b)
{
    if (a->kind != b->kind || a->name != b->name || a->type_name != b->type_name ||
        a->specifier != b->specifier || a->is_custom != b->is_custom ||
        a->is_uniform != b->is_uniform || a->field_count != b->field_count)
        return false;
    for (size_t i = 0; i < a->field_count; i++) {
        const CoField *other = co_spec_field(b, a->fields[i].name);
        if (!other || !same_value(&a->fields[i].value, &other->value))
            return false;
    }
    const CoContents *in = co_spec_contents(a), *other = co_spec_contents(b);
    return same_specs(in->children, in->child_count, other->children, other->child_count) &&
           same_specs(in->properties, in->property_count, other->properties,
                      other->property_count) &&
           same_specs(in->variant_sets, in->variant_set_count, other->variant_sets,
                      other->variant_set_count);
}

bool same_layer(const CoLayer *a, const CoLayer *b)
{
    return same_spec(a->root, b->root);
}
