// Instance paths: the chain of placements from the root to one mesh, interned as a number.
//
// The number of a path is the sum, over its levels, of the paths below the earlier siblings. So
// numbers order like the paths themselves, need no table per path, and are dense from 0.
// Threads: read-only.

#ifndef CO_ACCEL_PATHS_H
#define CO_ACCEL_PATHS_H

#include "accel/accel.h"

// The object (a mesh) that a path ends in, without its transforms.
uint32_t co_accel_path_object(const CoAccelScene *scene, uint32_t instance);

#endif
