// From a material network to the renderer's UsdPreviewSurface: which constant, primvar or texture
// feeds each input.

#ifndef CO_DELEGATE_MATERIAL_NETWORK_H
#define CO_DELEGATE_MATERIAL_NETWORK_H

#include "index/index.h"

enum {
    CO_MATERIAL_LOOKUPS = 16
};

// Everything the translation of one material needs and makes.
typedef struct CoNetwork {
    CohortRenderIndex *index;
    const CoPrim *prim;
    const CohortMaterialNetwork *source;
    CohortMaterialDesc desc;
    CohortLookupDesc lookups[CO_MATERIAL_LOOKUPS];
    int32_t lookup_nodes[CO_MATERIAL_LOOKUPS]; // which node each lookup came from
    CohortError *err;                          // out of memory only
} CoNetwork;

// Fills net->desc from the network. Returns false when there is no surface that can be rendered;
// the reason has then been reported.
bool co_network_translate(CoNetwork *net);

// The lookup of a texture node, made when it is new; COHORT_INVALID_ID when it cannot be
// (reported).
uint32_t co_network_lookup(CoNetwork *net, int32_t node);

// A hash of what displaces meshes with this material; 0 when nothing does.
uint64_t co_network_displacement(const CohortMaterialDesc *desc);

// True for the nodes that co_network_lookup takes.
bool co_network_is_texture(const CohortMaterialNode *node);

// True for a texture node whose file can be read, as far as can be known.
bool co_network_has_file(const CohortMaterialNode *node);

// True for a texture node without a file that can be read, whose fallback color, scaled and biased,
// is no normal that points out of the surface: normal maps that were lost.
bool co_network_is_lost_relief(const CohortMaterialNode *node);

// Reports a texture node that normals are read from as if it held colors.
void co_network_check_normals(CoNetwork *net, const CohortMaterialNode *node);

// An input of a node by name, NULL when it is not authored, or a constant that is not finite.
const CohortNodeInput *co_network_input(const CohortMaterialNode *node, const char *name);

// The node an input is connected to, NULL for constants.
const CohortMaterialNode *co_network_source(const CoNetwork *net, const CohortNodeInput *input);

void co_network_report(CoNetwork *net, const CohortMaterialNode *node, const char *name,
                       const char *value, const char *action);

#endif
