// Whether two layers say the same in one place.

#include "parse/layer.h"

#include <string.h>

static bool same_text(const char *a, const char *b)
{
    return a == b || (a && b && !strcmp(a, b));
}

static bool same_strings(const CohortString *a, const CohortString *b, size_t count)
{
    for (size_t i = 0; i < count; i++)
        if (a[i].length != b[i].length || memcmp(a[i].text, b[i].text, a[i].length) != 0)
            return false;
    return true;
}

// By their bits: what is not a number is itself, and zeros of two signs are two numbers.
static bool same_double(double a, double b)
{
    return memcmp(&a, &b, sizeof a) == 0;
}

// A zero offset says nothing, whatever its sign.
static bool same_offset(double a, double b)
{
    return a == b || same_double(a, b);
}

static bool same_pointed(const CoValue *a, const CoValue *b)
{
    return a == b || (a && b && co_value_equal(a, b));
}

static bool same_dicts(const CoDict *a, const CoDict *b)
{
    if (!a || !b || a->count != b->count)
        return a == b;
    for (size_t i = 0; i < a->count; i++)
        if (a->entries[i].key != b->entries[i].key ||
            !same_pointed(a->entries[i].value, b->entries[i].value))
            return false;
    return true;
}

static bool same_arcs(const CoArc *a, const CoArc *b, size_t count)
{
    for (size_t i = 0; i < count; i++)
        if (!same_text(a[i].asset, b[i].asset) || !same_text(a[i].prim, b[i].prim) ||
            !same_offset(a[i].offset, b[i].offset) || !same_double(a[i].scale, b[i].scale) ||
            !same_pointed(a[i].custom_data, b[i].custom_data))
            return false;
    return true;
}

static size_t item_size(CohortType type)
{
    switch ((int)type) {
    case COHORT_TYPE_INT_LIST_OP:
    case COHORT_TYPE_UINT_LIST_OP:
        return 4;
    case COHORT_TYPE_INT64_LIST_OP:
    case COHORT_TYPE_UINT64_LIST_OP:
        return 8;
    default:
        return 0;
    }
}

static bool same_list_ops(CohortType type, const CoListOp *a, const CoListOp *b)
{
    if (a->is_explicit != b->is_explicit)
        return false;
    for (int k = 0; k < CO_LIST_KIND_COUNT; k++) {
        size_t count = a->list[k].count;
        const void *x = a->list[k].items, *y = b->list[k].items;
        if (count != b->list[k].count)
            return false;
        if (!count)
            continue;
        bool same;
        if (type == COHORT_TYPE_REFERENCE_LIST_OP || type == COHORT_TYPE_PAYLOAD_LIST_OP)
            same = same_arcs(x, y, count);
        else if (item_size(type))
            same = !memcmp(x, y, count * item_size(type));
        else
            same = same_strings(x, y, count);
        if (!same)
            return false;
    }
    return true;
}

static bool same_samples(const CoTimeSamples *a, const CoTimeSamples *b)
{
    if (a->count != b->count)
        return false;
    for (size_t i = 0; i < a->count; i++)
        if (!same_double(a->times[i], b->times[i]) || !co_value_equal(&a->values[i], &b->values[i]))
            return false;
    return true;
}

static bool same_tangents(const CoSplineTangent *a, const CoSplineTangent *b)
{
    if (a->is_set != b->is_set)
        return false;
    return !a->is_set || (a->has_width == b->has_width && same_text(a->algorithm, b->algorithm) &&
                          same_double(a->width, b->width) && same_double(a->slope, b->slope));
}

static bool same_knots(const CoSplineKnot *a, const CoSplineKnot *b)
{
    return same_double(a->time, b->time) && same_double(a->value, b->value) &&
           a->has_pre_value == b->has_pre_value &&
           (!a->has_pre_value || same_double(a->pre_value, b->pre_value)) &&
           a->has_interp == b->has_interp && a->interp == b->interp &&
           same_tangents(&a->pre, &b->pre) && same_tangents(&a->post, &b->post) &&
           same_dicts(a->custom_data, b->custom_data);
}

static bool same_ends(const CoSplineExtrapolation *a, const CoSplineExtrapolation *b)
{
    return same_text(a->mode, b->mode) && same_double(a->slope, b->slope) &&
           a->has_boundary == b->has_boundary && same_double(a->boundary, b->boundary);
}

static bool same_splines(const CoSpline *a, const CoSpline *b)
{
    if (a->count != b->count || !same_text(a->curve, b->curve) || !same_ends(&a->pre, &b->pre) ||
        !same_ends(&a->post, &b->post) || a->has_loop != b->has_loop ||
        (a->has_loop && memcmp(a->loop, b->loop, sizeof a->loop) != 0))
        return false;
    for (size_t i = 0; i < a->count; i++)
        if (!same_knots(&a->knots[i], &b->knots[i]))
            return false;
    return true;
}

static bool same_edits(const CoArrayEdit *a, const CoArrayEdit *b)
{
    if (a->count != b->count)
        return false;
    for (size_t i = 0; i < a->count; i++) {
        const CoArrayEditItem *x = &a->items[i], *y = &b->items[i];
        if (x->kind != y->kind || x->source != y->source || x->at_or_size != y->at_or_size ||
            !same_pointed(x->literal, y->literal))
            return false;
    }
    return true;
}

static bool same_relocates(const CoRelocate *a, const CoRelocate *b, size_t count)
{
    for (size_t i = 0; i < count; i++)
        if (!same_text(a[i].source, b[i].source) || !same_text(a[i].target, b[i].target))
            return false;
    return true;
}

bool co_value_equal(const CoValue *a, const CoValue *b)
{
    if (a->type != b->type || a->is_array != b->is_array || a->count != b->count)
        return false;
    if (a->data == b->data)
        return true;
    if (!a->data || !b->data)
        return !a->count;
    switch ((int)a->type) {
    case COHORT_TYPE_STRING:
    case COHORT_TYPE_TOKEN:
    case COHORT_TYPE_ASSET:
    case COHORT_TYPE_PATH_EXPRESSION:
        return same_strings(a->data, b->data, a->count);
    case COHORT_TYPE_OPAQUE:
        return a->is_array ? same_list_ops(a->type, a->data, b->data)
                           : same_strings(a->data, b->data, 1);
    case COHORT_TYPE_DICTIONARY:
    case COHORT_TYPE_VARIANT_SELECTION:
        return same_dicts(a->data, b->data);
    case COHORT_TYPE_TIME_SAMPLES:
        return same_samples(a->data, b->data);
    case COHORT_TYPE_SUBLAYERS:
        return same_arcs(a->data, b->data, a->count);
    case COHORT_TYPE_RELOCATES:
        return same_relocates(a->data, b->data, a->count);
    case COHORT_TYPE_SPLINE:
        return same_splines(a->data, b->data);
    case COHORT_TYPE_ARRAY_EDIT:
        return same_edits(a->data, b->data);
    default:
        if (a->type >= COHORT_TYPE_TOKEN_LIST_OP && a->type <= COHORT_TYPE_PAYLOAD_LIST_OP)
            return same_list_ops(a->type, a->data, b->data);
        return !memcmp(a->data, b->data, a->count * co_type_size(a->type));
    }
}

static bool same_fields(const CoSpec *a, const CoSpec *b)
{
    if (a->field_count != b->field_count)
        return false;
    for (uint32_t i = 0; i < a->field_count; i++) {
        // Most often in the same order, which says nothing.
        const char *name = a->fields[i].name;
        const CoField *other = &b->fields[i];
        if (other->name != name)
            other = co_spec_field(b, name);
        if (!other || !co_value_equal(&a->fields[i].value, &other->value))
            return false;
    }
    return true;
}

bool co_spec_equal(const CoSpec *a, const CoSpec *b)
{
    if (a == b)
        return true;
    const CoContents *x = co_spec_contents(a), *y = co_spec_contents(b);
    if (a->name != b->name || a->kind != b->kind || a->specifier != b->specifier ||
        a->is_custom != b->is_custom || a->is_uniform != b->is_uniform ||
        !same_text(a->type_name, b->type_name) || x->property_count != y->property_count ||
        !same_fields(a, b))
        return false;
    for (uint32_t i = 0; i < x->property_count; i++)
        if (!co_spec_equal(x->properties[i], y->properties[i]))
            return false;
    return true;
}
