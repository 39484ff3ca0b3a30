// Small meshes where a group puts them: trees of their own, over points that are transformed once
// in place of every ray.
//
// Most pieces of a set are placed once, by a transform that is not the identity. Taking a ray into
// the space of a wall of two triangles costs more than testing it. What is baked, and to which
// bits, depends on the mesh, its transform, on whether the group has it but once and on the least
// that stands in the group.

#ifndef CO_ACCEL_BAKE_H
#define CO_ACCEL_BAKE_H

#include "accel/node.h"

// The instances of a top that are placed are given trees of their own where that is worth it; those
// of before are destroyed. False when memory is out.
bool co_bake(CoTop *top, const CoInstance *instances, const CoObject *objects);
void co_bake_clear(CoTop *top);
size_t co_bake_bytes(const CoTop *top);

#endif
