// Layers read once each, and the stacks that sublayers make of them.

#include "compose/fields.h"
#include "compose/read_ahead.h"

#include "base/error.h"

#include <math.h>
#include <string.h>

const CoField *co_layer_field(const CoLayerFile *file, const char *name)
{
    return file->layer ? co_spec_field(file->layer->root, name) : NULL;
}

static double layer_number(const CoLayerFile *file, const char *name)
{
    const CoField *field = co_layer_field(file, name);
    double number;
    return field && co_value_double(&field->value, &number) && number > 0 ? number : 0;
}

static double time_codes_per_second(const CoComposer *c, const CoLayerFile *file)
{
    double rate = layer_number(file, c->names.timeCodesPerSecond);
    if (rate == 0)
        rate = layer_number(file, c->names.framesPerSecond);
    return rate == 0 ? 24 : rate;
}

// A layer that an earlier stage has read, if its file is still the same.
static CoLayer *known_layer(const CoComposer *c, const char *path)
{
    const CoComposer *donor = c->donor;
    for (size_t i = 0; donor && i < donor->file_count; i++)
        if (donor->files[i]->path == path && donor->files[i]->layer)
            return co_layer_is_current(donor->files[i]->layer)
                       ? co_layer_share(donor->files[i]->layer)
                       : NULL;
    return NULL;
}

const CoLayerFile *co_composer_layer(CoComposer *c, const char *path, CohortError *err)
{
    CoLayerFile *file = co_file_entry(c, path);
    if (file->is_used) {
        if (!file->layer)
            CO_FAIL(err, COHORT_ERROR_FILE_READ, "%s", file->why);
        return file->layer ? file : NULL;
    }
    if (c->file_count >= c->options.max_layers)
        co_composer_limit(c, NULL, NULL, "more layers", c->options.max_layers, "max_layers");
    c->files =
        co_composer_grow(c, c->files, c->file_count, &c->file_capacity, sizeof(CoLayerFile *));
    file->index = c->file_count;
    file->is_used = true;
    bool is_new = !file->reading;
    size_t length = strlen(path);
    bool is_foreign = length > 5 && !strcmp(path + length - 5, ".mtlx");
    if (is_foreign)
        CO_FAIL(err, COHORT_ERROR_FILE_READ, "MaterialX documents are not supported");
    else
        file->layer = known_layer(c, path);
    if (!file->layer && !is_foreign)
        file->layer = co_read_ahead_take(c, file, err);
    c->files[c->file_count++] = file;
    if (!file->layer) {
        if (err->code == COHORT_ERROR_OUT_OF_MEMORY || err->code == COHORT_ERROR_CANCELLED)
            co_composer_fail(c, err->code, err->message);
        size_t size = strlen(err->message) + 1;
        file->why = memcpy(co_composer_alloc(c, size), err->message, size);
        return NULL;
    }
    file->time_codes_per_second = time_codes_per_second(c, file);
    // Of one that was itself read ahead, so has been all that it leads to.
    if (is_new)
        co_read_ahead(c, file);
    return file;
}

// ---- Variables --------------------------------------------------------------------------------
// Equal variables are one object, so that a layer which refers to itself meets its own stack again.
static const CoVariables *known_variables(const CoComposer *c, const CoVariable *items,
                                          size_t count)
{
    for (size_t i = 0; i < c->stack_count; i++) {
        const CoVariables *known = c->stacks[i]->variables;
        if (known && known->count == count && !memcmp(known->items, items, count * sizeof *items))
            return known;
    }
    return NULL;
}

static const CoVariables *stack_variables(CoComposer *c, const CoLayerFile *root,
                                          const CoVariables *overrides)
{
    const CoField *field = co_layer_field(root, c->names.expressionVariables);
    const CoDict *own = field ? co_value_dict(&field->value) : NULL;
    if (!own || !own->count)
        return overrides;
    size_t most = own->count + (overrides ? overrides->count : 0);
    CoVariable *items = co_composer_array(c, most, sizeof *items);
    size_t count = 0;
    for (size_t i = 0; overrides && i < overrides->count; i++)
        items[count++] = overrides->items[i];
    size_t fixed = count;
    for (size_t i = 0; i < own->count; i++) {
        bool is_new = true;
        for (size_t j = 0; j < fixed && is_new; j++)
            is_new = items[j].name != own->entries[i].key;
        if (is_new)
            items[count++] = (CoVariable){own->entries[i].key, own->entries[i].value};
    }
    if (count == fixed)
        return overrides;
    const CoVariables *known = known_variables(c, items, count);
    if (known)
        return known;
    CoVariables *out = co_composer_alloc(c, sizeof *out);
    *out = (CoVariables){items, count};
    return out;
}

// ---- Sublayers --------------------------------------------------------------------------------
typedef struct CoStackWalk {
    const CoLayerFile *file;
    uint64_t depth;
    const struct CoStackWalk *parent;
    double offset, scale;
} CoStackWalk;

static void walk_layers(CoComposer *c, CoStack *stack, size_t *capacity, const CoStackWalk *walk);

static bool is_open_above(const CoStackWalk *walk, const CoLayerFile *file)
{
    for (; walk; walk = walk->parent)
        if (walk->file == file)
            return true;
    return false;
}

static void walk_sublayer(CoComposer *c, CoStack *stack, size_t *capacity, const CoStackWalk *walk,
                          const CoArc *sublayer)
{
    const char *why = NULL;
    const char *asset = co_expression_evaluate(c, stack->variables, sublayer->asset, &why);
    if (!asset) {
        co_composer_warn(c, COHORT_PROBLEM_VARIABLE_EXPRESSION, walk->file, sublayer->line, NULL,
                         "sublayer @%s@: %s", sublayer->asset, why);
        return;
    }
    if (!*asset)
        return;
    const char *path = co_asset_anchor(c, walk->file, asset);
    if (co_composer_is_muted(c, path))
        return;
    CohortError err = {0};
    const CoLayerFile *file = co_composer_layer(c, path, &err);
    if (!file) {
        co_composer_warn(c, COHORT_PROBLEM_INVALID_SUBLAYER_PATH, walk->file, sublayer->line, NULL,
                         "sublayer @%s@ is left out: %s", asset, err.message);
        return;
    }
    if (is_open_above(walk, file)) {
        co_composer_warn(c, COHORT_PROBLEM_SUBLAYER_CYCLE, walk->file, sublayer->line, NULL,
                         "sublayer @%s@ is left out: it leads back to itself", asset);
        return;
    }
    double offset = sublayer->offset, scale = sublayer->scale;
    if (!isfinite(offset) || !isfinite(scale) || !(scale > 0)) {
        co_composer_warn(c, COHORT_PROBLEM_INVALID_SUBLAYER_OFFSET, walk->file, sublayer->line,
                         NULL, "sublayer @%s@: its offset is not usable and is ignored", asset);
        offset = 0;
        scale = 1;
    }
    scale *= walk->file->time_codes_per_second / file->time_codes_per_second;
    CoStackWalk next = {file, walk->depth + 1, walk, walk->scale * offset + walk->offset,
                        walk->scale * scale};
    walk_layers(c, stack, capacity, &next);
}

static void walk_layers(CoComposer *c, CoStack *stack, size_t *capacity, const CoStackWalk *walk)
{
    if (stack->layer_count >= c->options.max_layers)
        co_composer_limit(c, stack->root, NULL, "more sublayers", c->options.max_layers,
                          "max_layers");
    if (walk->depth >= c->options.max_depth)
        co_composer_limit(c, walk->file, NULL, "sublayers nested deeper", c->options.max_depth,
                          "max_depth");
    stack->layers =
        co_composer_grow(c, stack->layers, stack->layer_count, capacity, sizeof(CoStackLayer));
    stack->layers[stack->layer_count++] = (CoStackLayer){walk->file, walk->offset, walk->scale};
    const CoField *field = co_layer_field(walk->file, c->names.subLayers);
    bool has_sublayers = field && field->value.type == COHORT_TYPE_SUBLAYERS;
    for (size_t i = 0; has_sublayers && i < field->value.count; i++) {
        CoArc sublayer = ((const CoArc *)field->value.data)[i];
        if (!sublayer.line)
            sublayer.line = field->line;
        walk_sublayer(c, stack, capacity, walk, &sublayer);
    }
}

static CoStack *make_stack(CoComposer *c, const CoLayerFile *root, const CoLayerFile *session,
                           const CoVariables *overrides)
{
    CoStack *stack = co_composer_alloc(c, sizeof *stack);
    stack->root = root;
    stack->session = session;
    stack->overrides = overrides;
    stack->variables = stack_variables(c, root, overrides);
    size_t capacity = 0;
    double rate = root->time_codes_per_second;
    if (session) {
        // The session's rate, if it has one, is the stage's.
        if (layer_number(session, c->names.timeCodesPerSecond) > 0)
            rate = session->time_codes_per_second;
        CoStackWalk walk = {session, 0, NULL, 0, 1};
        walk_layers(c, stack, &capacity, &walk);
    }
    CoStackWalk walk = {root, 0, NULL, 0, rate / root->time_codes_per_second};
    stack->time_codes_per_second = rate;
    walk_layers(c, stack, &capacity, &walk);
    co_stack_relocates(c, stack);
    c->stacks =
        co_composer_grow(c, c->stacks, c->stack_count, &c->stack_capacity, sizeof(CoStack *));
    c->stacks[c->stack_count++] = stack;
    return stack;
}

CoStack *co_composer_root_stack(CoComposer *c, const CoLayerFile *root, const CoLayerFile *session)
{
    const CoVariables *overrides = session ? stack_variables(c, session, NULL) : NULL;
    CoStack *stack = make_stack(c, root, session, overrides);
    stack->is_stage = true;
    return stack;
}

CoStack *co_composer_stack(CoComposer *c, const CoLayerFile *root, const CoVariables *overrides)
{
    for (size_t i = 0; i < c->stack_count; i++)
        if (c->stacks[i]->root == root && c->stacks[i]->overrides == overrides &&
            !c->stacks[i]->is_stage)
            return c->stacks[i];
    return make_stack(c, root, NULL, overrides);
}
