// Meshes whose trees bench_build builds.

#ifndef BENCH_BUILD_MESHES_H
#define BENCH_BUILD_MESHES_H

#include "support/rays.h"

// A bumpy sheet of n x n quads rolled into a ball; triangles in rows.
CoMesh bench_mesh_ball(uint32_t tris);

// Triangles that share nothing, about as large as they are apart, stretched along one axis.
CoMesh bench_mesh_soup(uint32_t tris, float stretch, Random *random);

// The same mesh, its triangles in random order.
CoMesh bench_mesh_shuffled(CoMesh mesh, Random *random);

void bench_mesh_free(CoMesh *mesh);

#endif
