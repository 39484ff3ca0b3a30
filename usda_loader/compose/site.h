// A site: one path in one layer stack, with the specs found there and the arcs they author.
//
// Sites are made once and shared by every prim index that visits them; arcs are composed over the
// stack's layers (list ops, weakest to strongest) at first need.

#ifndef CO_COMPOSE_SITE_H
#define CO_COMPOSE_SITE_H

#include "compose/composer.h"

enum {
    CO_SITE_REFERENCES = 1,
    CO_SITE_PAYLOADS = 2,
    CO_SITE_INHERITS = 4,
    CO_SITE_SPECIALIZES = 8,
    CO_SITE_VARIANT_SETS = 16,
    CO_SITE_SELECTIONS = 32,
    CO_SITE_RELOCATED = 64, // the target of a relocate of its stack
    CO_SITE_INSTANCEABLE = 128,
    CO_SITE_MOVED_AWAY = 256 // the source of a relocate of its stack
};

typedef struct CoSiteSpec {
    const CoSpec *spec;
    uint32_t layer; // in the stack
} CoSiteSpec;

// A reference or payload as the site has it.
typedef struct CoSiteArc {
    const char *authored; // asset path as written, expression evaluated; "" = internal
    const char *asset;    // token: absolute; "" = internal
    const char *prim;     // token: "" = the default prim
    double offset, scale; // as authored
    const CoStackLayer *layer;
    uint32_t line;
} CoSiteArc;

// An inherit, specialize or variant set name.
typedef struct CoSiteName {
    const char *text; // token
    const CoStackLayer *layer;
    uint32_t line;
} CoSiteName;

typedef struct CoSiteArcs {
    CoSiteArc *references, *payloads;
    CoSiteName *inherits, *specializes, *variant_sets;
    size_t reference_count, payload_count, inherit_count, specialize_count, variant_set_count;
} CoSiteArcs;

struct CoSite {
    CoStack *stack;
    const CoPath *path;
    const CoSiteSpec *specs; // strongest first
    uint32_t spec_count;
    uint32_t flags;
    const CoSiteArcs *arcs; // NULL until asked for
    const CoMap *moves;     // what the stack's relocates move at or below it; NULL until asked for
    struct CoArcMap *maps;  // of its arcs, where there are moves (index_map.c)
};

CoSite *co_site(CoComposer *c, CoStack *stack, const CoPath *path);
const CoSiteArcs *co_site_arcs(CoComposer *c, CoSite *site);

// The strongest selection of a variant set authored at a site; NULL for none.
const char *co_site_selection(CoComposer *c, const CoSite *site, const char *set);

#endif
