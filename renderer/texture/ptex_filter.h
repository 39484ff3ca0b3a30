// The separable Ptex filters: which texels of which faces a lookup adds up, and with what weights.
//
// Source: the filters of the reference Ptex library 2.4 (bilinear and box), in its order and its
// float32 arithmetic. A kernel is built on the lookup's face, cut at the edges, and its parts are
// carried over to the neighbors: across edges, round corners of any valence up to ten, between
// faces and sub-faces, with resolutions matched. Quad files only.

#ifndef CO_TEXTURE_PTEX_FILTER_H
#define CO_TEXTURE_PTEX_FILTER_H

#include "texture/ptex_block.h"
#include "texture/ptex_kernel.h"

typedef enum CoPtexFilterKind {
    CO_PTEX_FILTER_BILINEAR = 0,
    CO_PTEX_FILTER_BOX
} CoPtexFilterKind;

typedef struct CoPtexFilter {
    CoPtexFilterKind kind;
    bool no_edge_blend; // never looks at neighbors
} CoPtexFilter;

typedef struct CoPtexQuery {
    uint32_t face;
    float u, v;
    float uw1, vw1, uw2, vw2; // the footprint's two sides
    float width, blur;        // factor on the footprint, and addition to it
} CoPtexQuery;

// Receives one part: a kernel that lies wholly inside `face` at a resolution the face has.
typedef void CoPtexPartFn(void *context, uint32_t face, const CoPtexKernel *kernel);

// Cuts a query into parts and gives them to `fn` in a fixed order. Returns the weight by which the
// parts' sum is to be divided (times co_ptex_one); 0 when the result is black. Any adjacency,
// however senseless, ends: the number of parts is bounded.
float co_ptex_filter(const CoPtexFile *file, const CoPtexFilter *filter, const CoPtexQuery *query,
                     CoPtexPartFn *fn, void *context);

// Turns the first two channels of a part's sum back where the file's edge filter mode is tanvec.
void co_ptex_turn(const CoPtexFile *file, int rotation, uint32_t count, float *sum);

#endif
