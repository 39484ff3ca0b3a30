// An array on its way in: its storage, and the fast readers of plain numbers (array_plain.c,
// array_bulk.c). array.c owns the grammar and judges whatever they leave.

#ifndef CO_PARSE_ARRAY_H
#define CO_PARSE_ARRAY_H

#include "parse/parser.h"

enum {
    CO_MAX_RANK = 16
};

typedef struct CoArray {
    const CoTypeInfo *info;
    size_t element; // bytes
    size_t count;
    unsigned char *data; // of `capacity` elements: the parser's scratch, or in the arena
    size_t capacity;
    bool is_final;             // data is in the arena
    const char *bulk_end;      // the text before it has been tried as a whole
    unsigned rank, leaf_rank;  // brackets open now; at the first element (0: none yet)
    size_t shape[CO_MAX_RANK]; // items of the first list at each rank, 0 until it closed
} CoArray;

// Room for one more element, within the limit.
bool co_array_reserve(CoParser *p, CoArray *array);

// A stretch of text read as plain elements: numbers and flat tuples of them with blanks, commas and
// line ends between, each followed by a comma.
typedef struct CoPlainRun {
    const char *at, *stop; // elements that begin before `stop`, which lies before CoScan.safe
    unsigned char *out;
    size_t most, count; // elements there is room for; that were read
} CoPlainRun;

// True for types whose elements can be read so.
bool co_plain_type(const CoTypeInfo *info);

// Moves run->at to the first element that is not plain or has no comma behind it.
void co_plain_read(const CoTypeInfo *info, const char *safe, CoPlainRun *run);

// Reads the plain elements of a long list, from the cursor on, in blocks by several threads. What
// it leaves and where the cursor then stands does not depend on how many.
bool co_parse_bulk(CoParser *p, CoArray *array);

#endif
