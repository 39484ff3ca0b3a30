// Scenes of the traversal benchmark: made by code, the same everywhere, or read from a stage.

#ifndef TRAVERSAL_SCENE_H
#define TRAVERSAL_SCENE_H

#include "accel/accel.h"

typedef struct BenchScene {
    const char *name;
    CoMesh *meshes; // own; NULL when they belong to a stage
    uint32_t mesh_count;
    CoObject *objects; // meshes, then the root
    CoInstance *instances;
    CoAccelScene accel;
    uint64_t path_count;
    uint64_t triangles;     // over all placements
    uint64_t own_triangles; // each mesh once
    size_t mesh_bytes;      // points and indices
    CoVec3 eye, target, up;
    CoVec3 light_low, light_high; // box that light samples are drawn from
} BenchScene;

// "room_1m", "city_10m", "city_50m" or "small", above a square ground of that size if it is not 0.
// False for another name. Trees are not built.
bool bench_scene_make(const char *name, double ground, BenchScene *out);

// Any of those, or "shaderball", every mesh of a stage through the loader (NULL: the shader ball).
// Trees are built. False with a sentence on stderr.
bool bench_scene_open(const char *name, const char *stage, double ground, BenchScene *out);

// Builds the trees of a made scene as a commit does, with co_worker_count() threads; drops them.
bool bench_scene_build(BenchScene *scene);
void bench_scene_unbuild(BenchScene *scene);

// Seconds of building all trees of any scene anew; a stage keeps its old ones.
double bench_scene_rebuild(BenchScene *scene);

size_t bench_scene_tree_bytes(const BenchScene *scene);
void bench_scene_destroy(BenchScene *scene);

#endif
