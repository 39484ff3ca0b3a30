// Meshes whose trees bench_build builds.

#ifndef BENCH_BUILD_MESHES_H
#define BENCH_BUILD_MESHES_H

#include "support/rays.h"

// A bumpy sheet of n x n quads rolled into a ball; triangles in rows.
CoMesh bench_mesh_ball(uint32_t tris);

// Triangles that share nothing, about as large as they are apart, stretched along one axis.
CoMesh bench_mesh_soup(uint32_t tris, float stretch, Random *random);

// The same, stretched each in its own direction.
CoMesh bench_mesh_turned(uint32_t tris, float stretch, Random *random);

// A house in [-1, 1], turned against the axes, in bays side by side and above each other. Each has
// a floor and two walls, boxes of 12 triangles; 16 steps, two strings and two handrails 100 times
// as long as thick, 32 balusters, 45 times, and 8 braces from corner to corner, 130 times, all bars
// of 12 triangles; and a ball of 1,152 small ones, 60% of all.
CoMesh bench_mesh_house(uint32_t tris);

// The same mesh, its triangles in random order.
CoMesh bench_mesh_shuffled(CoMesh mesh, Random *random);

void bench_mesh_free(CoMesh *mesh);

#endif
