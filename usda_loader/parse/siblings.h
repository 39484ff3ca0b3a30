// Prims that stand side by side in a big layer, read ahead by several threads.
//
// The text behind a prim is cut where further prims of the same parent seem to begin, told by
// braces alone (sibling_cuts.c). What stands between two cuts is then read as prims of that parent,
// each such range on its own, and put into the layer when the one loop over the text has come to
// its first character (siblings.c). A range counts only if it holds whole prims up to its last
// character and nothing to complain of. Any other is left to the loop, which alone reports. So
// neither layer nor errors depend on where the cuts are or how many threads there are: a wrong cut
// costs time only.

#ifndef CO_PARSE_SIBLINGS_H
#define CO_PARSE_SIBLINGS_H

#include "parse/parser.h"

// A place in the text and the line it stands on.
typedef struct CoCut {
    const char *at;
    uint32_t line;
} CoCut;

typedef struct CoCuts {
    CoCut *cuts; // ascending; the first is where the search began
    size_t count, capacity;
    const char *looked; // no cut stands before this place but those found
    bool is_closed;     // the parent seems to end there
} CoCuts;

enum {
    CO_CUT_BYTES = 16 << 10
};

// Looks for prims beside the one at `from`, one in every CO_CUT_BYTES, in the text up to `stop`.
// False when memory is at an end. The caller frees out->cuts.
bool co_cuts_find(CoCuts *out, CoCut from, const char *stop);

// For the text that p begins to read. NULL when there is but one thread, or memory is at an end.
CoSiblings *co_siblings_create(const CoParser *p);
// What was read belongs to the layer of p then.
void co_siblings_destroy(CoSiblings *siblings, CoParser *p);

#endif
