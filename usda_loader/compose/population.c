#include "compose/population.h"

#include "base/error.h"

#include <string.h>

// ---- Options are copied -------------------------------------------------------------------------
static const char *copy_text(CoComposer *c, const char *text)
{
    return text ? co_composer_need(c, co_arena_string(&c->arena, text, strlen(text))) : NULL;
}

static void copy_paths(CoComposer *c, CohortPaths *paths)
{
    const char **items = co_composer_array(c, paths->count, sizeof *items);
    for (size_t i = 0; i < paths->count; i++)
        items[i] = copy_text(c, paths->items[i]);
    paths->items = items;
}

static void copy_choices(CoComposer *c, CohortStageOptions *o)
{
    CohortVariantChoice *choices = co_composer_array(c, o->variant_count, sizeof *choices);
    for (size_t i = 0; i < o->variant_count; i++)
        choices[i] = (CohortVariantChoice){copy_text(c, o->variants[i].prim),
                                           copy_text(c, o->variants[i].set),
                                           copy_text(c, o->variants[i].selection)};
    o->variants = choices;
    CohortVariantFallback *fallbacks = co_composer_array(c, o->fallback_count, sizeof *fallbacks);
    for (size_t i = 0; i < o->fallback_count; i++)
        fallbacks[i] = (CohortVariantFallback){copy_text(c, o->fallbacks[i].set),
                                               copy_text(c, o->fallbacks[i].selection)};
    o->fallbacks = fallbacks;
}

static bool read_prims(CoComposer *c, const CohortPaths *texts, CoPathList *out, const char *what,
                       CohortError *err)
{
    out->items = co_composer_array(c, texts->count, sizeof *out->items);
    for (size_t i = 0; i < texts->count; i++) {
        bool malformed = true;
        const char *text = texts->items[i];
        const CoPath *path = NULL;
        if (text && *text == '/')
            path = co_path_parse(&c->paths, text, strlen(text), &c->paths.root, &malformed);
        CO_CHECK(!malformed, err, COHORT_ERROR_ARGUMENT, "the %s path \"%.200s\" is no prim path",
                 what, text ? text : "");
        out->items[out->count++] = co_composer_need(c, path);
    }
    return true;
}

// A relative path begins where the root layer lies, as for MuteLayer of the reference's stages, or
// at the current folder, where shells complete it. (usdview's --mute, a pattern that is looked for
// in whole paths, takes both.)
static void read_muted(CoComposer *c, const char *root)
{
    const CohortPaths *texts = &c->options.muted;
    CoLayerFile beside = {.path = co_asset_anchor(c, NULL, root)};
    c->muted = co_composer_array(c, texts->count, sizeof *c->muted);
    for (size_t i = 0; i < texts->count; i++) {
        if (!texts->items[i])
            continue;
        c->muted[i].beside_root = co_asset_anchor(c, &beside, texts->items[i]);
        c->muted[i].from_here = co_asset_anchor(c, NULL, texts->items[i]);
    }
}

bool co_population_init(CoComposer *c, const char *root, CohortError *err)
{
    CohortStageOptions *o = &c->options;
    CohortPaths *lists[] = {&o->loads, &o->unloads, &o->mask, &o->muted, &o->search_paths};
    for (size_t i = 0; i < sizeof lists / sizeof *lists; i++)
        copy_paths(c, lists[i]);
    copy_choices(c, o);
    o->session = copy_text(c, o->session);
    read_muted(c, root);
    return read_prims(c, &o->loads, &c->loads, "load", err) &&
           read_prims(c, &o->unloads, &c->unloads, "unload", err) &&
           read_prims(c, &o->mask, &c->mask, "mask", err);
}

// ---- What is in ---------------------------------------------------------------------------------
bool co_composer_is_muted(CoComposer *c, const char *path)
{
    bool is_muted = false;
    for (size_t i = 0; i < c->options.muted.count; i++) {
        if (c->muted[i].beside_root != path && c->muted[i].from_here != path)
            continue;
        c->muted[i].is_met = is_muted = true;
    }
    return is_muted;
}

static bool is_whole(const CoComposer *c, const CoPath *path)
{
    for (size_t i = 0; i < c->mask.count; i++)
        if (co_path_has_prefix(path, c->mask.items[i]))
            return true;
    return !c->mask.count;
}

bool co_population_includes(const CoComposer *c, const CoPath *path)
{
    for (size_t i = 0; i < c->mask.count; i++)
        if (co_path_has_prefix(c->mask.items[i], path))
            return true;
    return is_whole(c, path);
}

bool co_population_loads(const CoComposer *c, const CoPath *path)
{
    bool loads = !c->options.no_payloads;
    uint32_t length = 0;
    for (size_t i = 0; i < c->unloads.count; i++) {
        const CoPath *rule = c->unloads.items[i];
        if (rule->length >= length && co_path_has_prefix(path, rule)) {
            loads = false;
            length = rule->length;
        }
    }
    for (size_t i = 0; i < c->loads.count; i++) {
        const CoPath *rule = c->loads.items[i];
        // What is wanted can only be reached through what is above it.
        if (co_path_has_prefix(rule, path))
            return true;
        loads |= rule->length >= length && co_path_has_prefix(path, rule);
    }
    return loads;
}

static bool has_rule_below(const CoPathList *rules, const CoPath *path)
{
    for (size_t i = 0; i < rules->count; i++)
        if (co_path_has_prefix(rules->items[i], path))
            return true;
    return false;
}

uint64_t co_population_key(const CoComposer *c, const CoPath *path)
{
    bool is_own =
        !is_whole(c, path) || has_rule_below(&c->loads, path) || has_rule_below(&c->unloads, path);
    return is_own ? (uint64_t)(uintptr_t)path : co_population_loads(c, path);
}
