// Material binding (UsdShadeMaterialBindingAPI): for each purpose the nearest binding wins unless
// one above it is stronger; on one prim a collection binding beats the direct one.

#include "stage_adapter/adapter.h"

#include <stdio.h>
#include <string.h>

enum {
    LEAF_SIZE = 4096,
    MAX_PATH = 1024,
    MAX_COLLECTIONS = 64 // that include each other
};

typedef struct Binding {
    const char *material; // NULL = none
    bool is_strong;
} Binding;

static bool is_strong(const CohortPrim *prim, const char *relationship)
{
    // bindMaterialAs is metadata of the relationship.
    CohortValue value;
    return cohort_prim_attribute_metadata(prim, relationship, "bindMaterialAs", &value) &&
           strcmp(co_values_text(&value), "strongerThanDescendants") == 0;
}

// A binding has one target; of several none is meant.
static const char *only_target(const CohortAdapter *adapter, const CohortPrim *prim,
                               const char *relationship)
{
    const char *const *targets;
    size_t count = cohort_prim_targets(prim, relationship, &targets);
    if (count > 1)
        co_adapter_report(adapter, prim, relationship, targets[1], "more than one target: ignored");
    return count == 1 ? targets[0] : NULL;
}

// ---- Collections -------------------------------------------------------------------------------

static bool is_at_or_below(const char *path, const char *root)
{
    size_t length = strlen(root);
    if (strcmp(root, "/") == 0)
        return true;
    return strncmp(path, root, length) == 0 && (path[length] == '\0' || path[length] == '/');
}

// Where a query stands: the deepest entry so far that says anything about the path. A collection's
// entries are those of the collections it includes, then its own; a later one of equal depth wins.
typedef struct Membership {
    const CohortAdapter *adapter;
    const char *path;
    size_t depth; // length of that entry's path, 0 = none
    bool is_in;
    const char *visited[MAX_COLLECTIONS]; // each is asked once, so a cycle ends
    size_t visited_count;
} Membership;

static void gather(Membership *m, const char *collection);

static void note_entry(Membership *m, const char *entry, bool expands, bool is_in)
{
    bool holds = expands ? is_at_or_below(m->path, entry) : strcmp(m->path, entry) == 0;
    if (!holds || strlen(entry) < m->depth)
        return;
    m->depth = strlen(entry);
    m->is_in = is_in;
}

static void note_targets(Membership *m, const CohortPrim *prim, const char *relationship,
                         bool expands, bool is_in)
{
    const char *const *targets;
    size_t count = cohort_prim_targets(prim, relationship, &targets);
    for (size_t i = 0; i < count; i++)
        if (is_in && strstr(targets[i], ".collection:"))
            gather(m, targets[i]);
        else
            note_entry(m, targets[i], expands, is_in);
}

static bool visit(Membership *m, const CohortPrim *prim, const char *collection)
{
    for (size_t i = 0; i < m->visited_count; i++)
        if (strcmp(m->visited[i], collection) == 0)
            return false;
    if (m->visited_count == MAX_COLLECTIONS) {
        co_adapter_report(m->adapter, prim, collection, "",
                          "too many collections include each other: left out");
        return false;
    }
    m->visited[m->visited_count++] = collection;
    return true;
}

// Adds the entries of the collection at "/Prim.collection:name".
static void gather(Membership *m, const char *collection)
{
    const char *dot = strrchr(collection, '.');
    if (!dot || strlen(dot) > 200 || dot - collection >= MAX_PATH)
        return;
    char prim_path[MAX_PATH], name[256];
    memcpy(prim_path, collection, (size_t)(dot - collection));
    prim_path[dot - collection] = '\0';
    const CohortPrim *prim = cohort_stage_prim(m->adapter->stage, prim_path);
    if (!prim || !visit(m, prim, collection))
        return;
    size_t length = strlen(dot + 1);
    memcpy(name, dot + 1, length + 1);
    memcpy(name + length, ":expansionRule", sizeof ":expansionRule");
    double time = m->adapter->time;
    bool expands = strcmp(cohort_prim_token(prim, name, time, "expandPrims"), "explicitOnly") != 0;
    memcpy(name + length, ":includeRoot", sizeof ":includeRoot");
    if (cohort_prim_bool(prim, name, time, false))
        note_entry(m, "/", expands, true);
    memcpy(name + length, ":includes", sizeof ":includes");
    note_targets(m, prim, name, expands, true);
    memcpy(name + length, ":excludes", sizeof ":excludes");
    note_targets(m, prim, name, true, false);
}

static bool collection_holds(const CohortAdapter *adapter, const char *collection, const char *path)
{
    Membership m = {.adapter = adapter, .path = path};
    gather(&m, collection);
    return m.is_in;
}

// Puts the binding of the first of a prim's collections, in the order of their names, that holds
// the prim at `leaf` and is not weaker than what was found: a direct binding of the same prim is.
static void take_collection(const CohortAdapter *adapter, const CohortPrim *prim,
                            const char *prefix, const char *leaf, bool found_here, Binding *found)
{
    size_t count = cohort_prim_property_count(prim), length = strlen(prefix);
    for (size_t i = 0; i < count; i++) {
        const char *name = cohort_prim_property_name(prim, i);
        // The all-purpose prefix also begins the names of bindings with a purpose.
        if (!co_starts_with(name, prefix) || strchr(name + length, ':'))
            continue;
        const char *const *targets;
        if (cohort_prim_targets(prim, name, &targets) != 2 ||
            !collection_holds(adapter, targets[0], leaf))
            continue;
        bool strong = is_strong(prim, name);
        if (!found->material || found_here || strong) {
            *found = (Binding){.material = targets[1], .is_strong = strong};
            return;
        }
    }
}

static bool has_collections(const CohortPrim *prim)
{
    size_t count = cohort_prim_property_count(prim);
    for (size_t i = 0; i < count; i++)
        if (co_starts_with(cohort_prim_property_name(prim, i), "material:binding:collection:"))
            return true;
    return false;
}

// ---- Resolution --------------------------------------------------------------------------------

// One step of the climb from the prim at `leaf`: what this prim binds, in place of what was found
// below it where that is nothing or weaker.
static void take_bindings(const CohortAdapter *adapter, const CohortPrim *prim, bool full,
                          const char *leaf, Binding *found)
{
    const char *direct = full ? "material:binding:full" : "material:binding";
    const char *material = only_target(adapter, prim, direct);
    bool strong = material && is_strong(prim, direct);
    bool is_taken = material && (!found->material || strong);
    if (is_taken)
        *found = (Binding){.material = material, .is_strong = strong};
    take_collection(adapter, prim,
                    full ? "material:binding:collection:full:" : "material:binding:collection:",
                    leaf, is_taken, found);
}

// A climb from a prim up, through prototypes. What stands in a native prototype has the path of one
// place, and is many: where the climb leaves it, the leaf's path becomes that of the place climbed
// through, which collections outside name.
typedef struct Climb {
    CoPlace place;
    char leaf[LEAF_SIZE];
} Climb;

static void climb_begin(Climb *climb, CoPlace place)
{
    climb->place = place;
    snprintf(climb->leaf, sizeof climb->leaf, "%s", cohort_prim_path(place.prim));
}

static bool climb_up(const CohortAdapter *adapter, Climb *climb)
{
    uint32_t inside = climb->place.prototype;
    if (!co_place_up(adapter, &climb->place))
        return false;
    if (!co_place_left_native(adapter, inside, climb->place))
        return true;
    const char *root = cohort_prim_path(adapter->prototypes[inside].root);
    if (!is_at_or_below(climb->leaf, root))
        return true;
    char moved[LEAF_SIZE];
    int length = snprintf(moved, sizeof moved, "%s%s", cohort_prim_path(climb->place.prim),
                          climb->leaf + strlen(root));
    if (length > 0 && (size_t)length < sizeof moved)
        memcpy(climb->leaf, moved, (size_t)length + 1);
    return true;
}

static Binding resolve(const CohortAdapter *adapter, CoPlace place, bool full)
{
    Climb climb;
    Binding found = {0};
    climb_begin(&climb, place);
    do
        take_bindings(adapter, climb.place.prim, full, climb.leaf, &found);
    while (climb_up(adapter, &climb));
    return found;
}

const char *co_binding_resolve(const CohortAdapter *adapter, CoPlace place)
{
    const char *full = resolve(adapter, place, true).material;
    return full ? full : resolve(adapter, place, false).material;
}

bool co_binding_key(const CohortAdapter *adapter, CoPlace place, char *out, size_t size)
{
    Climb climb;
    bool has_any = false;
    climb_begin(&climb, place);
    do
        has_any = has_any || has_collections(climb.place.prim);
    while (climb_up(adapter, &climb));
    // Whether a collection holds a descendant depends on its path: such places share nothing.
    Binding full = resolve(adapter, place, true), all = resolve(adapter, place, false);
    int length =
        snprintf(out, size, "%s%d|%s%d|%s", full.material ? full.material : "", (int)full.is_strong,
                 all.material ? all.material : "", (int)all.is_strong, has_any ? climb.leaf : "");
    return length >= 0 && (size_t)length < size;
}
