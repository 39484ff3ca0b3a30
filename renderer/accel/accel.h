// Acceleration structures: a wide SIMD BVH per mesh and per group, and traversal of sorted batches.
//
// Canonical hit (docs/architecture.md): watertight test (Woop, Benthin, Wald 2013) with a double
// fallback on edges; t clamped into the canonical slab interval of the triangle's own box and of
// the boxes of the instances around it; equal t broken by (instance path, tri), the smaller wins.
// The hit of a ray never depends on kernel, ISA, tree or packet. Both sides of a triangle are hit.
// Threads: what is built is read-only; traversal may run on any number of threads, each with stats
// of its own, and allocates nothing.

#ifndef CO_ACCEL_ACCEL_H
#define CO_ACCEL_ACCEL_H

#include "geometry/mesh.h"
#include "rays/ray.h"

typedef struct CoBvh CoBvh; // bottom level: triangles of one mesh

// Builds over the triangles of `mesh`, whose points and indices must outlive it. An empty mesh
// gives an empty BVH. Deterministic for any number of threads.
CoBvh *co_bvh_create(const CoMesh *mesh, CohortError *err);
void co_bvh_destroy(CoBvh *bvh);
size_t co_bvh_bytes(const CoBvh *bvh);
size_t co_bvh_leaf_bytes(const CoBvh *bvh); // of these; the rest are nodes

// Brings a BVH to the points of `mesh`, which takes the place of the one it was built over and
// differs from it in nothing but points (co_mesh_same_topology). False when the BVH would be a bad
// one or cannot follow: it must then be destroyed. Hits are those of a BVH built anew.
bool co_bvh_refit(CoBvh *bvh, const CoMesh *mesh);

// Blocks in large pages that BVHs of small meshes share: a walk goes from one to the next as rays
// happen to, and small pages cost it a look into the page table each time. {0} is none yet. Of one
// thread.
typedef struct CoBvhBlocks {
    struct CoBvhBlock *open; // with room left
    size_t seen;             // bytes of small BVHs
} CoBvhBlocks;

// Moves a BVH that nothing refers to yet into a block, if it is small and there is memory. Those
// that come before a block's worth was seen stay where they are: so few have no need of one, and a
// large page takes longer to get than they take to build. A block lives until all BVHs in it are
// destroyed, and their room is not used again: for many at once.
void co_bvh_pack(CoBvh *bvh, CoBvhBlocks *blocks);

// No more are to come. BVHs stay where they are.
void co_bvh_blocks_close(CoBvhBlocks *blocks);

// One placement, object -> group, in the group's float frame.
typedef struct CoInstance {
    uint32_t object;
    CoAffine to_group, to_object;
    uint32_t hidden_from; // CohortHidden bits
} CoInstance;

typedef struct CoTop CoTop; // BVH over the instances of one group

enum {
    CO_GROUP_DEPTH_MAX = 8
}; // groups within groups, the root counted

// What an object id stands for; arrays indexed by object id.
typedef struct CoObject {
    const CoMesh *mesh; // NULL for groups
    const CoBvh *bvh;
    const CoTop *top;            // NULL for meshes
    const CoInstance *instances; // of a group
    uint32_t instance_count;
    CoVec3 box_min, box_max; // object space; min > max when empty
} CoObject;

// Builds over the instances. `objects` gives the boxes and the trees of meshes, and of nested
// groups the tops: build the innermost groups first, and refit when one of these is replaced.
// Objects with an empty box, and transforms that are not finite, take their place among the paths
// but are never hit. The arrays must outlive the top. At most CO_GROUP_DEPTH_MAX groups may nest
// (COHORT_ERROR_LIMIT).
CoTop *co_top_create(const CoInstance *instances, uint32_t count, const CoObject *objects,
                     CohortError *err);
void co_top_destroy(CoTop *top);
size_t co_top_bytes(const CoTop *top);

// Brings a top to where the instances are now, which may be other ones but as many. False when the
// top would be a bad one or cannot follow: it must then be destroyed. Hits are those of a top made
// anew.
bool co_top_refit(CoTop *top, const CoInstance *instances, uint32_t count, const CoObject *objects);

// Instance paths are interned as numbers: the sum, over the levels of the path, of the number of
// mesh paths below the instance's earlier siblings. The sums are made by co_top_create; there is
// nothing to prepare. See accel/paths.h.
typedef struct CoAccelScene {
    const CoObject *objects;
    uint32_t object_count;
    uint32_t root; // object id of the root group
} CoAccelScene;

// Counters of a traversal; each worker has its own, summed by the caller.
typedef struct CoTraverseStats {
    uint64_t groups;            // of up to 64 rays
    uint64_t top_nodes_grouped; // node fetches of all tops, each counted once per group
    uint64_t top_nodes_single;  // the same, as if every active ray had fetched for itself
    uint64_t bottom_nodes, triangles;
    uint64_t invalid; // rays rejected, see CoTraverseFn
} CoTraverseStats;

enum {
    CO_TRAVERSE_OCCLUSION = 1
};

// Traverses rays [begin, end) of a batch as groups of 64 and fills hits [begin, end).
// A hit lies strictly inside the ray: tnear < t < tfar. hit.t is in units of the length of dir,
// which need not be 1; u and v are the barycentrics of corners 1 and 2. A miss has t = INFINITY and
// COHORT_INVALID_ID for both ids.
// flags: per ray, the CohortHidden bit of what it is, and
// CO_TRAVERSE_OCCLUSION: only whether anything blocks it matters: a blocked ray gets t = 0 and
// COHORT_INVALID_ID for both ids (which blocker is met first is no property of the ray); NULL =
// none, and nothing is hidden. grouped: false = ray by ray. Same hits either way, bit for bit. Rays
// with a NaN anywhere, an infinite origin or direction or a zero direction are invalid: t = NAN.
typedef void CoTraverseFn(const CoAccelScene *scene, const CoRayBatch *rays, const uint8_t *flags,
                          CoHitBatch *hits, size_t begin, size_t end, bool grouped,
                          CoTraverseStats *stats);

// A hit of one ray, as the arrays of a batch have it.
typedef struct CoRayHit {
    float t, u, v;
    uint32_t instance, tri;
} CoRayHit;

// Goes from a hit of a ray to the next in the order of (instance path, tri) that lies at the very
// distance of it, hit->t: what coincides with a cut-out that the ray has passed. False where there
// is none; the hit is then left as it is. `flags`: the CohortHidden bit of what the ray is.
typedef bool CoNextFn(const CoAccelScene *scene, CoVec3 org, CoVec3 dir, uint8_t flags,
                      CoRayHit *hit);

// Table of the kernels of one instruction set; NULL if this machine lacks it or it is masked off.
typedef struct CoAccelKernels {
    const char *isa; // "scalar", "sse42", "avx2", "avx512"
    CoTraverseFn *traverse;
    CoNextFn *next;
} CoAccelKernels;

// isa NULL or "" = the best that co_isa_flags() allows (simd/isa.h).
const CoAccelKernels *co_accel_kernels(const char *isa);

// An instance path resolved: the mesh and the transforms along the way.
typedef struct CoPlacement {
    uint32_t object;                    // the mesh's object id
    CoAffine to_world, to_object;       // product over the path (render frame)
    uint32_t chain[CO_GROUP_DEPTH_MAX]; // instance index at each level, root first
    uint32_t chain_length;
    bool is_baked; // rays meet its points where they are rounded to in the group's space
} CoPlacement;

// Number of instance paths that end in a mesh, i.e. one above the largest hit.instance. The ids
// order like the paths themselves. False when there are more than 2^32 - 2.
bool co_accel_path_count(const CoAccelScene *scene, uint64_t *out);
void co_accel_placement(const CoAccelScene *scene, uint32_t instance, CoPlacement *out);

#endif
