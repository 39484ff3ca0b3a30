// Writes the composed stage as one layer. Instances are written out in full, each under its own
// path.

#include "stage/flatten.h"

#include "compose/fields.h"
#include "parse/types.h"

#include "base/error.h"

#include <math.h>
#include <string.h>

// ---- Properties ---------------------------------------------------------------------------------
static void add_targets(CoFlattener *flat, CoSpec *out, const char *field,
                        const char *const *targets, size_t count)
{
    if (!count)
        return;
    const char **renamed = co_flat_alloc(flat, count, sizeof *renamed);
    for (size_t i = 0; i < count; i++)
        renamed[i] = co_flat_rename(flat, targets[i]);
    co_flat_add_field(flat, out, field,
                      co_flat_texts(flat, COHORT_TYPE_PATH_LIST_OP, renamed, count));
}

// Whether a value can stand in text behind another type's name.
static bool reads_as(const CoValue *value, const char *type_name)
{
    CohortType declared;
    bool is_array;
    if (!co_type_from_name(type_name, strlen(type_name), &declared, &is_array))
        return value->type == COHORT_TYPE_OPAQUE;
    if (value->type == declared)
        return value->is_array == is_array;
    const CoTypeInfo *a = co_type_info(value->type), *b = co_type_info(declared);
    bool is_real = b->scalar >= CO_SCALAR_HALF && b->scalar <= CO_SCALAR_DOUBLE;
    return value->is_array == is_array && is_real && a->scalar >= CO_SCALAR_INT &&
           a->scalar <= CO_SCALAR_DOUBLE && a->rows == b->rows && a->columns == b->columns &&
           a->is_quaternion == b->is_quaternion;
}

static bool field_reads_as(const CoField *field, const char *type_name)
{
    const CoValue *value = &field->value;
    if (value->type == COHORT_TYPE_BLOCK || value->type == COHORT_TYPE_ANIMATION_BLOCK)
        return true;
    if (value->type == COHORT_TYPE_SPLINE)
        return reads_as(&(CoValue){.type = COHORT_TYPE_DOUBLE, .count = 1}, type_name);
    if (value->type != COHORT_TYPE_TIME_SAMPLES)
        return reads_as(value, type_name);
    const CoTimeSamples *samples = value->data;
    for (size_t i = 0; i < samples->count; i++)
        if (samples->values[i].type != COHORT_TYPE_BLOCK &&
            !reads_as(&samples->values[i], type_name))
            return false;
    return true;
}

// An opinion may be of another type than the attribute. What text of that type cannot say takes its
// own type along; false when the attribute's is settled.
static bool fits(CoSpec *out, const CoValueSource *from, bool is_settled)
{
    if (!from->field || (from->spec && from->spec->type_name == out->type_name) ||
        field_reads_as(from->field, out->type_name))
        return true;
    // Samples of clips are of the attribute's type or of no use.
    if (is_settled || !from->spec)
        return false;
    out->type_name = from->spec->type_name;
    return true;
}

// What edits make of an array, time by time.
static void flatten_edited(CoFlattener *flat, CoSpec *out, const CohortPrim *prim)
{
    const double *times;
    size_t count = cohort_prim_time_samples(prim, out->name, &times);
    if (!count)
        return;
    CoTimeSamples *samples = co_flat_alloc(flat, 1, sizeof *samples);
    samples->times = co_flat_alloc(flat, count, sizeof *samples->times);
    samples->values = co_flat_alloc(flat, count, sizeof *samples->values);
    for (size_t i = 0; i < count; i++) {
        CohortValue value;
        CoValue *sample = &samples->values[i];
        samples->times[i] = times[i];
        *sample = (CoValue){.type = COHORT_TYPE_BLOCK};
        if (cohort_prim_value(prim, out->name, times[i], &value))
            *sample = (CoValue){value.type, value.is_array, (uint32_t)value.count, value.data};
    }
    samples->count = count;
    co_flat_add_field(flat, out, flat->stage->composer.names.timeSamples,
                      (CoValue){.type = COHORT_TYPE_TIME_SAMPLES, .count = 1, .data = samples});
}

static void flatten_attribute(CoFlattener *flat, CoSpec *out, const CohortPrim *prim)
{
    const CoFieldNames *names = &flat->stage->composer.names;
    CoValueSource at_default = co_prim_value_source(prim, out->name, true);
    CoValueSource timed = co_prim_value_source(prim, out->name, false);
    CohortValue edited;
    fits(out, &at_default, false);
    if (at_default.field && at_default.field->value.type == COHORT_TYPE_ARRAY_EDIT &&
        cohort_prim_value(prim, out->name, COHORT_TIME_DEFAULT, &edited))
        co_flat_add_field(flat, out, names->default_value,
                          (CoValue){edited.type, true, (uint32_t)edited.count, edited.data});
    else if (at_default.field)
        co_flat_add_field(flat, out, names->default_value,
                          co_flat_value(flat, &at_default.field->value, at_default.source));
    if (co_source_has_edits(&timed))
        flatten_edited(flat, out, prim);
    else if (timed.field && timed.field->name == names->spline &&
             fits(out, &timed, at_default.field != NULL))
        co_flat_add_field(flat, out, names->spline, co_flat_spline(flat, &timed));
    else if (timed.field && timed.field->name != names->default_value &&
             fits(out, &timed, at_default.field != NULL))
        co_flat_add_field(flat, out, timed.field->name,
                          co_flat_value(flat, &timed.field->value, timed.source));
    const char *const *targets;
    size_t count = cohort_prim_connections(prim, out->name, &targets);
    add_targets(flat, out, names->connectionPaths, targets, count);
}

static CoSpec *flatten_property(CoFlattener *flat, const CohortPrim *prim, const char *name)
{
    CoSpec *out = co_flat_alloc(flat, 1, sizeof *out);
    CoPropertyWalk walk = co_property_walk(prim, name);
    out->name = name;
    out->type_name = "";
    for (bool is_first = true; co_property_next(&walk); is_first = false) {
        if (is_first) {
            out->kind = walk.kind;
            out->is_custom = walk.spec->is_custom;
        }
        if (!*out->type_name && walk.spec->type_name)
            out->type_name = walk.spec->type_name;
    }
    // The weakest opinion says whether an attribute may vary; a relationship never does.
    for (uint32_t i = prim->data->opinion_count; i-- > 0;) {
        const CoSpec *spec = co_spec_property(prim->data->opinions[i].spec, name);
        if (!spec)
            continue;
        out->is_uniform = spec->is_uniform || spec->kind == CO_SPEC_RELATIONSHIP;
        break;
    }
    if (out->kind == CO_SPEC_ATTRIBUTE) {
        flatten_attribute(flat, out, prim);
    } else {
        const char *const *targets;
        size_t count = cohort_prim_targets(prim, name, &targets);
        add_targets(flat, out, flat->stage->composer.names.targetPaths, targets, count);
    }
    co_flat_fields(flat, out, prim, name);
    return out;
}

// ---- Prims --------------------------------------------------------------------------------------
static CoSpec *flatten_prim(CoFlattener *flat, const CohortPrim *prim, const CoPath *path);

static void flatten_children(CoFlattener *flat, CoSpec *out, const CohortPrim *prim,
                             const CoPath *path)
{
    CoContents *in = out->contents;
    in->children = co_flat_alloc(flat, prim->data->child_count, sizeof *in->children);
    for (uint32_t i = 0; i < prim->data->child_count; i++) {
        const CohortPrim *child = &prim->children[i];
        if (!(child->data->flags & CO_PRIM_ACTIVE))
            continue;
        const CoPath *child_path = co_path_child(&flat->paths, path, co_prim_name(child));
        if (!child_path)
            longjmp(flat->escape, 1);
        in->children[in->child_count++] = flatten_prim(flat, child, child_path);
    }
}

// The prim's path in the flattener's own table.
static const CoPath *own_path(CoFlattener *flat, const CohortPrim *prim)
{
    if (!prim->parent)
        return &flat->paths.root;
    const CoPath *own =
        co_path_child(&flat->paths, own_path(flat, prim->parent), co_prim_name(prim));
    if (!own)
        longjmp(flat->escape, 1);
    return own;
}

static void flatten_properties(CoFlattener *flat, CoSpec *out, const CohortPrim *prim)
{
    size_t count = cohort_prim_property_count(prim);
    CoContents *in = out->contents;
    in->properties = co_flat_alloc(flat, count, sizeof *in->properties);
    for (size_t i = 0; i < count; i++)
        in->properties[in->property_count++] =
            flatten_property(flat, prim, cohort_prim_property_name(prim, i));
}

static CoSpec *flatten_prim(CoFlattener *flat, const CohortPrim *prim, const CoPath *path)
{
    CoSpec *out = co_flat_alloc(flat, 1, sizeof *out);
    out->contents = co_flat_alloc(flat, 1, sizeof *out->contents);
    out->kind = CO_SPEC_PRIM;
    out->name = co_prim_name(prim);
    out->specifier = (CohortSpecifier)prim->data->specifier;
    out->type_name = prim->data->type;
    co_flat_fields(flat, out, prim, NULL);
    CohortValue instanceable;
    const char *field = flat->stage->composer.names.instanceable;
    if (!(prim->data->flags & CO_PRIM_INSTANCE) && co_prim_field(prim, NULL, field, &instanceable))
        co_flat_add_field(flat, out, field,
                          (CoValue){instanceable.type, false, 1, instanceable.data});
    flatten_properties(flat, out, prim);
    CoRenaming renaming = {NULL, path, flat->renaming};
    bool is_shared = prim->data->prototype && prim->data->prototype != prim;
    const CoRenaming *outer = flat->renaming;
    if (is_shared) {
        renaming.from = own_path(flat, prim->data->prototype);
        flat->renaming = &renaming;
    }
    flatten_children(flat, out, prim, path);
    flat->renaming = outer;
    return out;
}

static void flatten_root(CoFlattener *flat)
{
    const CohortStage *stage = flat->stage;
    const CoFieldNames *n = &stage->composer.names;
    CoSpec *root = co_flat_alloc(flat, 1, sizeof *root);
    root->contents = co_flat_alloc(flat, 1, sizeof *root->contents);
    root->kind = CO_SPEC_LAYER;
    root->name = root->type_name = "";
    flat->layer.root = root;
    const CoLayerFile *files[] = {stage->stack->session, stage->stack->root};
    for (int k = 0; k < 2; k++) {
        if (!files[k])
            continue;
        const CoSource source = {.file = files[k], .stack = stage->stack, .scale = 1};
        const CoSpec *from = files[k]->layer->root;
        for (size_t i = 0; i < from->field_count; i++) {
            const char *name = from->fields[i].name;
            if (name != n->subLayers && name != n->relocates && name != n->primOrder &&
                name != n->expressionVariables && !co_spec_field(root, name) &&
                !(k == 0 && name == n->defaultPrim))
                co_flat_add_field(flat, root, name,
                                  co_flat_value(flat, &from->fields[i].value, &source));
        }
    }
    flatten_children(flat, root, &stage->root, &flat->paths.root);
}

static bool flatten_guarded(CoFlattener *flat)
{
    if (setjmp(flat->escape) != 0)
        return false;
    flatten_root(flat);
    return true;
}

bool cohort_stage_flatten(const CohortStage *stage, const char *out, CohortError *err)
{
    CoFlattener flat = {.stage = stage, .layer.arena.tag = CO_MEMORY_USDA};
    flat.layer.path = "";
    co_path_table_init(&flat.paths, &flat.layer.arena);
    cohort_stage_ran_short(stage); // before: what counts is what it lacks from here on
    bool ok = flatten_guarded(&flat) && !cohort_stage_ran_short(stage);
    if (ok)
        ok = co_layer_write(&flat.layer, out, err);
    else
        CO_FAIL(err, COHORT_ERROR_OUT_OF_MEMORY, "out of memory");
    co_arena_clear(&flat.layer.arena);
    return ok;
}
