#include "compose/read_ahead.h"

#include "compose/fields.h"

#include "base/hash.h"
#include "base/parallel.h"

#include <string.h>

typedef struct CoMessage CoMessage;
struct CoMessage {
    CoMessage *next;
    CohortSeverity severity;
    uint32_t line, column;
    const char *file, *prim_path, *text;
};

struct CoReading {
    CoLayer *layer;
    CohortError err;
    CoArena arena; // of the messages
    CoMessage *first, **last;
    bool is_cut_short; // a message was lost: memory was at an end
};

// ---- Entries ------------------------------------------------------------------------------------
static CoLayerFile **find_slot(CoLayerFile **slots, size_t capacity, const char *path)
{
    size_t at = co_hash64((uint64_t)(uintptr_t)path) & (capacity - 1);
    while (slots[at] && slots[at]->path != path)
        at = (at + 1) & (capacity - 1);
    return &slots[at];
}

CoLayerFile *co_file_entry(CoComposer *c, const char *path)
{
    if (2 * c->entry_count >= c->entry_capacity) {
        size_t capacity = c->entry_capacity ? 2 * c->entry_capacity : 64;
        CoLayerFile **slots = co_composer_array(c, capacity, sizeof(CoLayerFile *));
        for (size_t i = 0; i < c->entry_capacity; i++)
            if (c->entries[i])
                *find_slot(slots, capacity, c->entries[i]->path) = c->entries[i];
        c->entries = slots;
        c->entry_capacity = capacity;
    }
    CoLayerFile **slot = find_slot(c->entries, c->entry_capacity, path);
    if (!*slot) {
        CoLayerFile *file = co_composer_alloc(c, sizeof *file);
        file->path = path;
        *slot = file;
        c->entry_count++;
    }
    return *slot;
}

// ---- Who is named -------------------------------------------------------------------------------
// Entries found in one round, and how many of them earlier rounds have dealt with.
typedef struct CoWanted {
    CoComposer *c;
    const CoLayerFile *from;
    CoLayerFile **items;
    size_t count, capacity;
} CoWanted;

static void want(CoWanted *wanted, const char *asset)
{
    CoComposer *c = wanted->c;
    // Expressions are for composition to evaluate, and what it cannot read is for it to say.
    if (!*asset || strchr(asset, '`') || c->entry_count >= c->options.max_layers)
        return;
    const char *path = co_asset_anchor(c, wanted->from, asset);
    size_t length = strlen(path), known = c->entry_count;
    bool is_materialx = length > 5 && !strcmp(path + length - 5, ".mtlx");
    if (is_materialx || co_composer_is_muted(c, path))
        return;
    CoLayerFile *file = co_file_entry(c, path);
    if (c->entry_count == known)
        return;
    wanted->items =
        co_composer_grow(c, wanted->items, wanted->count, &wanted->capacity, sizeof(CoLayerFile *));
    wanted->items[wanted->count++] = file;
}

static void want_arcs(CoWanted *wanted, const CoSpec *spec, const char *name)
{
    const CoField *field = co_spec_field(spec, name);
    const CoListOp *op = field ? co_value_list_op(&field->value) : NULL;
    static const CoListOpKind kinds[] = {CO_LIST_EXPLICIT, CO_LIST_PREPENDED, CO_LIST_ADDED,
                                         CO_LIST_APPENDED};
    for (size_t k = 0; op && k < sizeof kinds / sizeof *kinds; k++)
        for (size_t i = 0; i < op->list[kinds[k]].count; i++)
            want(wanted, ((const CoArc *)op->list[kinds[k]].items)[i].asset);
}

static bool is_inactive(const CoComposer *c, const CoSpec *spec)
{
    const CoField *field = co_spec_field(spec, c->names.active);
    bool active = true;
    return field && co_value_bool(&field->value, &active) && !active;
}

static void want_below(CoWanted *wanted, const CoSpec *spec);

// Only of variants that the prim itself selects is it likely that they are wanted.
static void want_variants(CoWanted *wanted, const CoSpec *spec)
{
    const CoField *field = co_spec_field(spec, wanted->c->names.variantSelection);
    const CoDict *dict = field ? co_value_dict(&field->value) : NULL;
    const CoContents *in = co_spec_contents(spec);
    for (size_t i = 0; dict && i < in->variant_set_count; i++)
        for (size_t j = 0; j < dict->count; j++) {
            const CohortString *text = co_value_text(dict->entries[j].value);
            if (dict->entries[j].key != in->variant_sets[i]->name || !text)
                continue;
            const char *name = co_composer_need(wanted->c, co_token(text->text, text->length));
            const CoSpec *variant = co_spec_child(in->variant_sets[i], name);
            if (variant)
                want_below(wanted, variant);
        }
}

static void want_below(CoWanted *wanted, const CoSpec *spec)
{
    const CoComposer *c = wanted->c;
    want_arcs(wanted, spec, c->names.references);
    if (!c->options.no_payloads && !c->options.unloads.count)
        want_arcs(wanted, spec, c->names.payload);
    want_variants(wanted, spec);
    if (is_inactive(c, spec))
        return;
    const CoContents *in = co_spec_contents(spec);
    for (size_t i = 0; i < in->child_count; i++)
        want_below(wanted, in->children[i]);
}

static void want_all(CoWanted *wanted, const CoLayerFile *from, const CoLayer *layer)
{
    wanted->from = from;
    const CoField *field = co_spec_field(layer->root, wanted->c->names.subLayers);
    bool has_sublayers = field && field->value.type == COHORT_TYPE_SUBLAYERS;
    for (size_t i = 0; has_sublayers && i < field->value.count; i++)
        want(wanted, ((const CoArc *)field->value.data)[i].asset);
    // A mask leaves out more than can be told here.
    if (!wanted->c->options.mask.count)
        want_below(wanted, layer->root);
}

// ---- Reading ------------------------------------------------------------------------------------
static const char *keep_text(CoReading *reading, const char *text)
{
    const char *kept = co_arena_string(&reading->arena, text, strlen(text));
    reading->is_cut_short |= !kept;
    return kept;
}

static void keep_message(void *cookie, CohortSeverity severity, const char *file, uint32_t line,
                         uint32_t column, const char *prim_path, const char *text)
{
    CoReading *reading = cookie;
    CoMessage *message = co_arena_alloc(&reading->arena, sizeof *message);
    if (!message) {
        reading->is_cut_short = true;
        return;
    }
    *message = (CoMessage){.severity = severity,
                           .line = line,
                           .column = column,
                           .file = keep_text(reading, file),
                           .prim_path = keep_text(reading, prim_path),
                           .text = keep_text(reading, text)};
    *reading->last = message;
    reading->last = &message->next;
}

static void read_some(void *context, size_t begin, size_t end, uint32_t worker)
{
    (void)worker;
    const CoWanted *wanted = context;
    for (size_t i = begin; i < end; i++) {
        CoReading *reading = wanted->items[i]->reading;
        reading->layer = co_layer_open(wanted->items[i]->path, &wanted->c->options, keep_message,
                                       reading, &reading->err);
    }
}

void co_read_ahead(CoComposer *c, const CoLayerFile *file)
{
    // Most of what a stage has read before it need not be read again.
    if (c->donor)
        return;
    uint32_t workers = co_worker_count(), asked = c->options.threads;
    if ((asked ? asked : workers) < 2)
        return;
    CoWanted wanted = {.c = c};
    want_all(&wanted, file, file->layer);
    while (wanted.count > 1) {
        for (size_t i = 0; i < wanted.count; i++) {
            CoReading *reading = co_composer_alloc(c, sizeof *reading);
            reading->arena.tag = CO_MEMORY_USDA;
            reading->last = &reading->first;
            wanted.items[i]->reading = reading;
        }
        co_worker_count_set(asked ? asked : workers);
        co_parallel_for(wanted.count, 1, read_some, &wanted);
        co_worker_count_set(workers);
        CoWanted next = {.c = c};
        for (size_t i = 0; i < wanted.count; i++)
            if (wanted.items[i]->reading->layer)
                want_all(&next, wanted.items[i], wanted.items[i]->reading->layer);
        wanted = next;
    }
}

static void forget(CoLayerFile *file)
{
    CoReading *reading = file->reading;
    file->reading = NULL;
    co_arena_clear(&reading->arena);
    co_layer_destroy(reading->layer);
}

CoLayer *co_read_ahead_take(CoComposer *c, CoLayerFile *file, CohortError *err)
{
    CohortDiagnosticFn *report = c->options.report;
    CoReading *reading = file->reading;
    bool is_lost =
        reading && (reading->is_cut_short || reading->err.code == COHORT_ERROR_OUT_OF_MEMORY);
    if (is_lost)
        forget(file);
    if (!reading || is_lost)
        return co_layer_open(file->path, &c->options, report, c->options.cookie, err);
    for (const CoMessage *m = reading->first; report && m; m = m->next)
        report(c->options.cookie, m->severity, m->file, m->line, m->column, m->prim_path, m->text);
    if (err->code == COHORT_OK)
        *err = reading->err;
    CoLayer *layer = reading->layer;
    reading->layer = NULL;
    forget(file);
    return layer;
}

void co_read_ahead_drop(CoComposer *c)
{
    for (size_t i = 0; i < c->entry_capacity; i++)
        if (c->entries[i] && c->entries[i]->reading)
            forget(c->entries[i]);
}
