// Hit sort: hits in the order of meshes and, within a mesh, of faces, so that shading touches each
// mesh and each block of texels once.
//
// Source: Eisenacher et al. 2013, 3.2; Satish, Harris, Garland 2009.

#ifndef CO_SORT_HIT_SORT_H
#define CO_SORT_HIT_SORT_H

#include "sort/radix.h"

// Sorts `order`, a list of `count` indices of hits, by (mesh[hit], tri[hit]); equal ones keep their
// order.
//   mesh, tri  indexed by hit; triangles are numbered in face order, so tri sorts faces
//   order      in/out; the caller leaves out misses and light rays; every index below 2^32
// False with COHORT_ERROR_OUT_OF_MEMORY: order is then unchanged. Threads: parallel inside; the
// result is the same for any number of them.
bool co_sort_hits(const uint32_t *mesh, const uint32_t *tri, uint32_t *order, size_t count,
                  CoSortScratch *scratch, CohortError *err);

#endif
