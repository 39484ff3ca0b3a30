// Material binding (UsdShadeMaterialBindingAPI): for each purpose the nearest binding wins unless
// one above it is stronger; on one prim a collection binding beats the direct one.

#include "stage_adapter/adapter.h"

#include <stdio.h>
#include <string.h>

enum {
    MAX_CHAIN = 1024
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

static const char *first_target(const CohortPrim *prim, const char *relationship)
{
    const char *const *targets;
    return cohort_prim_targets(prim, relationship, &targets) ? targets[0] : NULL;
}

// ---- Collections -------------------------------------------------------------------------------

static bool is_at_or_below(const char *path, const char *root)
{
    size_t length = strlen(root);
    if (strcmp(root, "/") == 0)
        return true;
    return strncmp(path, root, length) == 0 && (path[length] == '\0' || path[length] == '/');
}

// Longest path of a relationship that holds `path`; 0 when none does.
static size_t longest_match(const CohortPrim *prim, const char *relationship, const char *path,
                            bool expands)
{
    const char *const *targets;
    size_t count = cohort_prim_targets(prim, relationship, &targets), best = 0;
    for (size_t i = 0; i < count; i++) {
        bool holds = expands ? is_at_or_below(path, targets[i]) : strcmp(path, targets[i]) == 0;
        if (holds && strlen(targets[i]) > best)
            best = strlen(targets[i]);
    }
    return best;
}

// Whether the collection at "/Prim.collection:name" includes a path.
static bool collection_holds(const CohortAdapter *adapter, const char *collection, const char *path)
{
    const char *dot = strrchr(collection, '.');
    if (!dot || strlen(dot) > 200 || (size_t)(dot - collection) >= 1024)
        return false;
    char prim_path[1024], name[256];
    memcpy(prim_path, collection, (size_t)(dot - collection));
    prim_path[dot - collection] = '\0';
    const CohortPrim *prim = cohort_stage_prim(adapter->stage, prim_path);
    if (!prim)
        return false;
    size_t length = strlen(dot + 1);
    memcpy(name, dot + 1, length + 1);
    memcpy(name + length, ":expansionRule", sizeof ":expansionRule");
    bool expands =
        strcmp(cohort_prim_token(prim, name, adapter->time, "expandPrims"), "explicitOnly") != 0;
    memcpy(name + length, ":includeRoot", sizeof ":includeRoot");
    bool root = cohort_prim_bool(prim, name, adapter->time, false);
    memcpy(name + length, ":includes", sizeof ":includes");
    size_t included = longest_match(prim, name, path, expands);
    memcpy(name + length, ":excludes", sizeof ":excludes");
    size_t excluded = longest_match(prim, name, path, true);
    return included ? included > excluded : root && !excluded;
}

// The binding of a prim's collections to the prim at `leaf`, in the order of their names.
static Binding collection_binding(const CohortAdapter *adapter, const CohortPrim *prim,
                                  const char *prefix, const char *leaf)
{
    size_t count = cohort_prim_property_count(prim), length = strlen(prefix);
    for (size_t i = 0; i < count; i++) {
        const char *name = cohort_prim_property_name(prim, i);
        // The all-purpose prefix also begins the names of bindings with a purpose.
        if (!co_starts_with(name, prefix) || strchr(name + length, ':'))
            continue;
        const char *const *targets;
        if (cohort_prim_targets(prim, name, &targets) == 2 &&
            collection_holds(adapter, targets[0], leaf))
            return (Binding){.material = targets[1], .is_strong = is_strong(prim, name)};
    }
    return (Binding){0};
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

static Binding own_binding(const CohortAdapter *adapter, const CohortPrim *prim, bool full,
                           const char *leaf)
{
    Binding found = collection_binding(
        adapter, prim,
        full ? "material:binding:collection:full:" : "material:binding:collection:", leaf);
    if (found.material)
        return found;
    const char *direct = full ? "material:binding:full" : "material:binding";
    found.material = first_target(prim, direct);
    found.is_strong = found.material && is_strong(prim, direct);
    return found;
}

typedef struct Chain {
    const CohortPrim *prims[MAX_CHAIN]; // from the prim up
    size_t depth;
} Chain;

static void climb(const CohortAdapter *adapter, CoPlace place, Chain *chain)
{
    chain->depth = 0;
    do
        chain->prims[chain->depth++] = place.prim;
    while (chain->depth < MAX_CHAIN && co_place_up(adapter, &place));
}

static Binding resolve(const CohortAdapter *adapter, const Chain *chain, bool full)
{
    const char *leaf = cohort_prim_path(chain->prims[0]);
    Binding binding = {0};
    for (size_t i = chain->depth; i-- > 0 && !binding.is_strong;) {
        Binding own = own_binding(adapter, chain->prims[i], full, leaf);
        if (own.material)
            binding = own;
    }
    return binding;
}

const char *co_binding_resolve(const CohortAdapter *adapter, CoPlace place)
{
    Chain chain;
    climb(adapter, place, &chain);
    const char *full = resolve(adapter, &chain, true).material;
    return full ? full : resolve(adapter, &chain, false).material;
}

bool co_binding_key(const CohortAdapter *adapter, CoPlace place, char *out, size_t size)
{
    Chain chain;
    climb(adapter, place, &chain);
    // Whether a collection holds a descendant depends on its path: such places share nothing.
    const char *alone = "";
    for (size_t i = 0; i < chain.depth && !alone[0]; i++)
        if (has_collections(chain.prims[i]))
            alone = cohort_prim_path(place.prim);
    Binding full = resolve(adapter, &chain, true), all = resolve(adapter, &chain, false);
    int length =
        snprintf(out, size, "%s%d|%s%d|%s", full.material ? full.material : "", (int)full.is_strong,
                 all.material ? all.material : "", (int)all.is_strong, alone);
    return length >= 0 && (size_t)length < size;
}
