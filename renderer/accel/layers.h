// Layers: what of a group lies close together in much more space than it takes.
//
// Boxes are padded by what a ray may be off by at the far side of the tree it walks. On a ground of
// a thousand kilometers, or with one stray mesh that far away, that is more than most things are
// large: every ray would meet all of them. So a group is a tree of layers. Things that are small
// for it and stand close together get a tree of their own, which stands in the group's as one box,
// and rays are prepared anew when they enter that. Nothing is transformed: hits and paths are those
// of the group. Most groups have none.

#ifndef CO_ACCEL_LAYERS_H
#define CO_ACCEL_LAYERS_H

#include "accel/node.h"

// Finds the layers of instances that are placed, in a top that has none yet, gives each instance
// its layer, and settles which stand in place. What is found depends on the boxes and triangle
// counts alone. False when memory is out: then there are none.
bool co_layers_plan(CoTop *top, const CoInstance *instances, const CoObject *objects);

// By layer + 1, so that the group's own tree is the first: where its list in `members` begins, of
// instances and then layers as numbers in `placed`, ascending. `starts` has layer_count + 2.
typedef struct CoLayerLists {
    uint32_t *starts, *members;
    size_t start_count, member_count;
} CoLayerLists;

// Lists what has a box. False when memory is out; co_layer_lists_clear() in any case.
bool co_layers_list(const CoTop *top, CoLayerLists *out);
void co_layer_lists_clear(CoLayerLists *lists);

void co_layers_clear(CoTop *top);
size_t co_layers_bytes(const CoTop *top);

#endif
